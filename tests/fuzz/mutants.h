// Mutants of files, and what a reader may do with them: succeed, or throw an InputError of one line, in good time.
//
// Deterministic: the same mutants every time. Meant for the sanitized build, useful in any.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/loaders.h"

namespace lacuna::test {

/// Mutants a text; each is independent of the others. Sanitized they take a few seconds.
inline constexpr int kMutants = 3000;
inline constexpr int kFileMutants = 1500;
/// A mutant that takes longer than this has found a hole, even under sanitizers on a busy machine.
inline constexpr auto kPatience = std::chrono::seconds(20);

/// Changes one to eight places of a text: bytes, chunks, numbers, and the tokens of its format.
class Mutator {
 public:
  Mutator(std::vector<std::string> tokens, std::uint64_t seed) : tokens_(std::move(tokens)), random_(seed) {}

  std::string operator()(const std::string& valid) {
    std::string text = valid;
    for (int i = static_cast<int>(pick(8)) + 1; i > 0; --i) change(text);
    return text;
  }

 private:
  std::size_t pick(std::size_t count) { return count == 0 ? 0 : random_() % count; }

  void change(std::string& text) {
    const std::size_t at = pick(text.size() + 1);
    const std::size_t length = std::min(pick(24), text.size() - at);
    switch (pick(8)) {
      case 0: text.insert(at, 1, static_cast<char>(pick(256))); break;
      case 1: text.erase(at, length); break;
      case 2: text.insert(at, text.substr(pick(text.size() + 1), pick(64))); break;
      case 3: text.insert(at, tokens_[pick(tokens_.size())]); break;
      case 4: text.replace(at, length, tokens_[pick(tokens_.size())]); break;
      case 5: text.resize(at); break;
      case 6: text.insert(at, pick(200), at < text.size() ? text[at] : ' '); break;
      default:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << pick(8)));
    }
  }

  std::vector<std::string> tokens_;
  std::mt19937_64 random_;
};

/// Loads the mutant; fails on any exception but InputError, on messages of more than one line, and on slowness.
inline bool survives(const std::function<void()>& work, const std::string& mutant) {
  const auto start = std::chrono::steady_clock::now();
  std::string wrong = fault_of(work);
  if (std::chrono::steady_clock::now() - start > kPatience) wrong = "too slow";
  EXPECT_TRUE(wrong.empty()) << wrong << "\nfrom the input:\n" << mutant;
  return wrong.empty();
}

inline bool survives(const Loader& loader, const std::string& mutant) {
  return survives([&] { loads(loader, mutant); }, mutant);
}

inline std::filesystem::path scratch_folder() {
  auto folder = std::filesystem::temp_directory_path() / ("lacuna_fuzz_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  return folder;
}

class Fuzz : public testing::Test {
 protected:
  ~Fuzz() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::filesystem::path folder_ = scratch_folder();
};

}  // namespace lacuna::test
