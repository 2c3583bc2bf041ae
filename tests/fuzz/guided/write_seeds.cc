// Writes what the fuzzer begins with: FOLDER/LOADER/seed_K, and the tokens as FOLDER/LOADER.dict. Without a folder, the
// loaders' names.
#include <cstdio>

#include "tests/fuzz/loaders.h"

namespace {

/// As libFuzzer's dictionaries have it: whatever is not plain is \xNN.
std::string dictionary_line(const std::string& token) {
  std::string out = "\"";
  for (const unsigned char c : token) {
    char hex[5];
    std::snprintf(hex, sizeof hex, "\\x%02x", c);
    const bool plain = c >= 0x20 && c < 0x7f && c != '"' && c != '\\';
    out += plain ? std::string(1, static_cast<char>(c)) : hex;
  }
  return out + "\"\n";
}

}  // namespace

int main(int argc, char** argv) {
  using namespace lacuna::test;
  for (const Loader& loader : loaders()) {
    if (argc < 2) {
      std::puts(loader.name.c_str());
      continue;
    }
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / loader.name;
    std::filesystem::create_directories(folder);
    int k = 0;
    for (const std::string& seed : loader.seeds()) write(folder / ("seed_" + std::to_string(k++)), seed);
    std::string dictionary;
    for (const std::string& token : loader.tokens)
      if (!token.empty()) dictionary += dictionary_line(token);
    write(folder.string() + ".dict", dictionary);
  }
}
