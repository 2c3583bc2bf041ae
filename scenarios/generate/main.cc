// lacuna_generate_scenarios FOLDER          writes the bundled scenarios below FOLDER (scenarios/ of the source tree)
// lacuna_generate_scenarios --check FOLDER  changes nothing; fails where a file there differs from what would be
// written
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "scenarios/files.h"
#include "scenarios/generate/bundle.h"

namespace {

bool holds(const std::filesystem::path& file, const std::string& text) {
  std::ifstream in(file, std::ios::binary);
  return in && std::string(std::istreambuf_iterator<char>(in), {}) == text;
}

}  // namespace

int main(int argc, char** argv) {
  const bool check = argc == 3 && std::string(argv[1]) == "--check";
  if ((argc != 2 && !check) || argv[argc - 1][0] == '-') {
    std::cerr << "usage: lacuna_generate_scenarios [--check] FOLDER\n";
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[argc - 1];
    lacuna::generate::Files files;
    lacuna::generate::add_robots(files);
    lacuna::generate::add_scenarios(files);
    lacuna::generate::add_commands(files);
    lacuna::generate::add_comparison(files);
    int different = 0;
    for (const auto& [name, text] : files) {
      if (holds(folder / name, text)) continue;
      ++different;
      std::cout << (check ? "differs: " : "written: ") << name << '\n';
      if (!check) lacuna::write_file_atomically(folder / name, text);
    }
    std::cout << files.size() << " files, " << different << (check ? " differ\n" : " written\n");
    return check && different > 0 ? 1 : 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
}
