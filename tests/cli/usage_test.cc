// Every kind of failure: its exit code and its one line.
#include <unistd.h>

#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;

TEST(Usage, HelpAndVersionAreNoFailures) {
  EXPECT_THAT(lacuna({"--version"}).out, HasSubstr("lacuna "));
  const Outcome help = lacuna({"--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_EQ(help.err, "");
  for (const char* command : {"init", "engines", "effects", "simulate", "compare", "identify", "diagnose", "diff",
                              "conceal", "blind", "render", "export"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    const Outcome of_command = lacuna({command, "--help"});
    EXPECT_EQ(of_command.code, 0);
    for (const char* shared : {"--json", "--threads", "--seed", "--output", "Example:"})
      EXPECT_THAT(of_command.out, HasSubstr(shared)) << command;
  }
}

TEST(Usage, BadCommandLinesAreRefusedInOneLine) {
  expect_refused(lacuna({}), kBadInput, "subcommand");
  expect_refused(lacuna({"diagnoze"}), kBadInput, "diagnose");
  expect_refused(lacuna({"simulate"}), kBadInput, "SCENARIO");
  expect_refused(lacuna({"engines", "--frobnicate"}), kBadInput, "--frobnicate");
  expect_refused(lacuna({"engines", "--threads", "0"}), kBadInput, "--threads");
  expect_refused(lacuna({"engines", "--threads", "two"}), kBadInput, "--threads");
  expect_refused(lacuna({"engines", "--seed", "-1"}), kBadInput, "--seed");
  expect_refused(lacuna({"engines", "two\nlines"}), kBadInput, "two");
}

TEST(Usage, BadInputIsRefusedWithFileAndReason) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& text) { return folder.write("scenario.yaml", text).string(); };
  expect_refused(lacuna({"identify", (folder.path() / "none.yaml").string()}), kBadInput, "none.yaml");
  expect_refused(lacuna({"diagnose", folder.path().string()}), kBadInput, "expected");
  expect_refused(lacuna({"simulate", write("")}), kBadInput, "scenario.yaml");
  expect_refused(lacuna({"simulate", write("format: lacuna-scenario/1\nnoise: [\n")}), kBadInput, "scenario.yaml");
  expect_refused(lacuna({"render", write("format: lacuna-scenario/1\nname: x\nrobot: none.urdf\n")}), kBadInput,
                 "none.urdf");
}

TEST(Usage, PhysicsThatDoesNotExistIsBadInput) {
  const Arm arm;
  const auto with = [&](const std::string& from, const std::string& to) {
    return arm.files().write("other.yaml", replaced(kArmScenario, from, to)).string();
  };
  const auto refused = [](const std::string& scenario, const std::string& part) {
    for (const char* command : {"simulate", "identify", "diagnose"})
      expect_refused(lacuna({command, scenario}), kBadInput, part);
  };
  refused(with("torque_source", "magic"), "magic");
  refused(with("gain: 20,", "gian: 20,"), "gian");
  refused(with("damping: 1,", "damping: -1,"), "damping");
  refused(with("recordings:", "effects:\n  - {effect: gremlins, where: elbow}\nrecordings:"), "gremlins");
  refused(with("file: train.csv", "file: lost.csv"), "lost.csv");
  expect_refused(lacuna({"identify", with("  gain: {", "  gian: {")}), kBadInput, "gian");
  expect_refused(lacuna({"identify", with("role: train", "role: test")}), kBadInput, "train");
}

TEST(Usage, OptionsOfTheSearchAreChecked) {
  const Arm arm;
  const auto refused = [&](const std::vector<std::string>& options, const std::string& part) {
    std::vector<std::string> line{"identify", arm.scenario(), "-o", (arm.folder() / "out").string()};
    line.insert(line.end(), options.begin(), options.end());
    expect_refused(lacuna(line), kBadInput, part);
  };
  refused({"--engine", "imaginary"}, "imaginary");
  refused({"--engine", "featherstone,featherstone"}, "twice");
  refused({"--optimizer", "magic"}, "ga+lsq");
  refused({"--population", "1"}, "population");
  refused({"--population", "many"}, "--population");
  refused({"--generations", "0"}, "generations");
  refused({"--fitness", "norm_3"}, "norm_2");
  refused({"--coding", "gray"}, "mvbs");
  refused({"--crossover", "none"}, "pointwise");
  refused({"--mutation", "none"}, "per_gene");
  refused({"--selection", "none"}, "roulette");
  refused({"--coding", "integer", "--mutation", "per_bit"}, "per_bit");
  expect_refused(lacuna({"diagnose", arm.scenario(), "--engine", "all"}), kBadInput, "all");
}

TEST(Usage, WorkThatCannotBeDoneHasACodeOfItsOwn) {
  const Arm arm;
  expect_refused(lacuna({"identify", arm.scenario(), "-o", "/proc/none"}), kNotDone, "/proc/none");
  // No engine missing in a complete build: then there is nothing to see here.
  for (const auto& engine : engine_records()) {
    if (engine.at("available")) continue;
    const std::string name = engine.at("name");
    expect_refused(lacuna({"simulate", arm.scenario(), "--engine", name}), kNotDone, name);
    expect_refused(lacuna({"diagnose", arm.scenario(), "--engine", name}), kNotDone, name);
  }
}

TEST(Usage, EnginesAndEffectsAreListed) {
  const auto engines = json_of(lacuna({"engines", "--json"}));
  ASSERT_EQ(engines.at("engines").size(), 6u);
  EXPECT_EQ(engines.at("engines")[0].at("name"), "featherstone");
  EXPECT_TRUE(engines.at("engines")[0].at("available"));
  for (const auto& engine : engines.at("engines"))
    EXPECT_NE(engine.contains("reason"), engine.at("available").get<bool>()) << engine;
  EXPECT_GE(engines.at("lanes").at("width"), 2);
  const auto effects = json_of(lacuna({"effects", "--json"}));
  EXPECT_GE(effects.at("effects").size(), 7u);
  for (const auto& effect : effects.at("effects"))
    for (const char* key : {"name", "where", "stage", "equation", "parameters", "shows_as", "hidden_by"})
      EXPECT_FALSE(effect.at(key).empty()) << effect;
  EXPECT_THAT(lacuna({"engines"}).out, HasSubstr("featherstone"));
  EXPECT_THAT(lacuna({"effects"}).out, HasSubstr("coulomb_friction"));
}

}  // namespace
}  // namespace lacuna::test
