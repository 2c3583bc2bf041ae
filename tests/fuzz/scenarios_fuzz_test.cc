// Mutated inputs: whatever a file holds, loading it succeeds or throws InputError, and says so in one line.
//
// Deterministic: the same mutants every time. Meant for the sanitized build, useful in any.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/mesh.h"
#include "scenarios/yaml_reader.h"
#include "tests/fuzz/mutants.h"

namespace lacuna {
namespace {

using test::Fuzz;
using test::kFileMutants;
using test::kMutants;
using test::kRoot;
using test::Loader;
using test::loader;
using test::Mutator;
using test::read;
using test::survives;
using test::write;

/// Of each format, and the bytes at its beginning that stay: what says which format it is. Bags' databases and MATLAB
/// 7.3 have tests of their own.
const std::vector<std::pair<const char*, std::size_t>> kFormats{{"scenario", 0},
                                                                {"urdf", 0},
                                                                {"mjcf", 0},
                                                                {"csv", 0},
                                                                {"mat", 128},
                                                                {"mcap", 8},
                                                                {"message", 0},
                                                                {"mesh", 1},
                                                                {"verdict", 0},
                                                                {"label", 0},
                                                                {"comparison", 0},
                                                                {"bag_metadata", 0},
                                                                {"draft", 0},
                                                                {"search_checkpoint", 0},
                                                                {"study_checkpoint", 0},
                                                                {"diagnosis_checkpoint", 0}};

class Mutants : public testing::TestWithParam<std::pair<const char*, std::size_t>> {};

TEST_P(Mutants, AreTakenOrRefusedInOneLine) {
  const auto [name, kept] = GetParam();
  const Loader& one = loader(name);
  const std::vector<std::string> valid = one.seeds();
  Mutator mutate(one.tokens, 1);
  const bool slow = one.name == "draft" || one.name == "bag_metadata";
  const int mutants = slow ? kFileMutants / 3 : one.name == "message" ? 10 * kMutants : kMutants;
  for (int i = 0; i < mutants; ++i) {
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    if (!survives(one, origin.substr(0, kept) + mutate(origin.substr(kept)))) break;
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, Mutants, testing::ValuesIn(kFormats),
                         [](const auto& one) { return std::string(one.param.first); });

TEST_F(Fuzz, YamlTexts) {
  const std::string valid = read(kRoot / "scenarios/hydrolek/scenario.yaml");
  Mutator mutate(loader("scenario").tokens, 2);
  for (int i = 0; i < kMutants; ++i) {
    const std::string mutant = mutate(valid);
    if (!survives([&] { parse_yaml(mutant, "s.yaml"); }, mutant)) break;
  }
}

/// Whatever a name says, what is found lies below one of the folders.
TEST_F(Fuzz, MeshNames) {
  write(folder_ / "outside.stl", "x");
  std::filesystem::create_directories(folder_ / "robot/deep");
  std::filesystem::create_directories(folder_ / "share/arm/deep");
  write(folder_ / "robot/deep/x.stl", "x");
  write(folder_ / "share/arm/deep/x.stl", "x");
  std::filesystem::create_symlink(folder_ / "outside.stl", folder_ / "robot/link.stl");
  const MeshFolders folders{folder_ / "robot", {folder_ / "share"}};
  const std::vector<std::string> tokens{"..",
                                        "../",
                                        "/",
                                        "//",
                                        "./",
                                        "package://",
                                        "file://",
                                        "arm",
                                        "deep",
                                        "x.stl",
                                        "outside.stl",
                                        "link.stl",
                                        folder_.string(),
                                        "%2e%2e",
                                        std::string(1, '\0')};
  Mutator mutate(tokens, 9);
  int found = 0;
  for (int i = 0; i < kMutants; ++i) {
    const std::string valid[] = {"deep/x.stl", "package://arm/deep/x.stl",
                                 "file://" + (folder_ / "robot/deep/x.stl").string()};
    const std::string mutant = mutate(valid[i % 3]);
    const auto work = [&] {
      std::string why;
      const auto file = find_mesh(mutant, folders, "m", why);
      ASSERT_NE(file.has_value(), !why.empty());
      if (!file) return;
      ++found;
      const std::string whole = std::filesystem::canonical(*file).string();
      const std::string root = std::filesystem::canonical(folder_).string();
      ASSERT_TRUE(whole.starts_with(root + "/robot") || whole.starts_with(root + "/share")) << whole;
    };
    if (!survives(work, mutant)) break;
  }
  EXPECT_GT(found, 0) << "no mutant names a file: nothing was tried";
}

/// Columns' names are a small part of a recording: they get mutants of their own.
TEST_F(Fuzz, DraftsOfAnyNames) {
  const Loader& one = loader("draft");
  const std::string valid = one.seeds().front();
  const std::size_t body = valid.find('\n');
  Mutator mutate(one.tokens, 6);
  for (int i = 0; i < kFileMutants / 3; ++i)
    if (!survives(one, mutate(valid.substr(0, body)) + valid.substr(body))) break;
}

}  // namespace
}  // namespace lacuna
