// Everything that the program reads, one entry a format: what mutants are tried on, what the guided fuzzer is turned
// on, and what the inputs that it found worth keeping (corpus/) are tried on again.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace lacuna::test {

inline const std::filesystem::path kRoot = LACUNA_SOURCE_DIR;

struct Loader {
  std::string name;                 ///< and that of its folder below corpus/
  std::vector<std::string> tokens;  ///< of the format, worth putting in
  std::vector<std::string> (*seeds)();
  /// Loads `bytes`; `folder` is for files. Throws what the loader throws, and std::logic_error where what it took is
  /// not what its contract says.
  void (*load)(const std::filesystem::path& folder, const std::string& bytes);
  void (*prepare)(const std::filesystem::path& folder) = nullptr;  ///< what must stand beside the file
};

const std::vector<Loader>& loaders();
const Loader& loader(std::string_view name);

/// Loads with one of the loaders, in a folder that this process keeps for it until it ends.
void loads(const Loader& loader, const std::string& bytes);
/// What is wrong with how some work took its input: any exception but InputError, a message of more than one line. Else
/// "".
std::string fault_of(const std::function<void()>& work);
std::string fault_of(const Loader& loader, const std::string& bytes);

std::string read(const std::filesystem::path& file);
void write(const std::filesystem::path& file, const std::string& text);

}  // namespace lacuna::test
