#include "backends/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "backends/missing_engine.h"
#include "scenarios/error.h"
#include "tests/reference/pendulum.h"

namespace lacuna::test {
namespace {

TEST(Registry, ListsEveryEnginesFolderOnceAndFeatherstoneFirst) {
  std::vector<std::string> names, folders;
  for (const Engine* engine : engines()) names.push_back(engine->info().name);
  for (const auto& entry : std::filesystem::directory_iterator(LACUNA_SOURCE_DIR "/backends")) {
    if (entry.is_directory()) folders.push_back(entry.path().filename());
  }
  EXPECT_EQ(names.front(), "featherstone");
  EXPECT_THAT(names, testing::UnorderedElementsAreArray(folders));
}

TEST(Registry, FindsByNameAndListsTheNamesForAnUnknownOne) {
  for (const Engine* engine : engines()) EXPECT_EQ(&find_engine(engine->info().name), engine);
  try {
    find_engine("imaginary\n");
    FAIL() << "an unknown engine was found";
  } catch (const InputError& error) {
    const std::string line = error.what();
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    for (const Engine* engine : engines()) EXPECT_NE(line.find(engine->info().name), std::string::npos) << line;
  }
}

TEST(Registry, EveryEngineSaysWhatItIsOrWhyItIsMissing) {
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    if (!info.available) {
      EXPECT_FALSE(info.reason.empty()) << info.name;
      EXPECT_THROW(engine->build(Pendulum{}.robot(), {0, 0, -9.81}), WorkError) << info.name;
      continue;
    }
    EXPECT_FALSE(info.version.empty()) << info.name;
    EXPECT_TRUE(info.reason.empty()) << info.name;
    EXPECT_FALSE(info.native_integrators.empty()) << info.name;
    std::set<std::string> known;
    for (const Capability& capability : info.capabilities) {
      EXPECT_TRUE(known.insert(capability.name).second) << info.name << " says " << capability.name << " twice";
      EXPECT_FALSE(capability.words.empty()) << info.name << ", " << capability.name;
    }
    for (const char* asked : {"forward_dynamics", "inverse_dynamics", "mass_matrix", "inertials_in_place"}) {
      EXPECT_TRUE(known.contains(asked)) << info.name << " does not say how it does " << asked;
    }
  }
}

TEST(MissingEngine, SaysWhyAndRefusesToBuild) {
  const MissingEngine engine("imaginary", "libimaginary-dev", "LACUNA_WITH_IMAGINARY");
  EXPECT_FALSE(engine.info().available);
  EXPECT_NE(engine.info().reason.find("libimaginary-dev"), std::string::npos);
  try {
    engine.build(Pendulum{}.robot(), {0, 0, -9.81});
    FAIL() << "a missing engine built something";
  } catch (const WorkError& error) {
    EXPECT_NE(std::string(error.what()).find("imaginary"), std::string::npos);
  }
}

}  // namespace
}  // namespace lacuna::test
