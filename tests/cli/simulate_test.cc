#include <cmath>

#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = a.size() == b.size() && !a.empty() ? 0.0 : HUGE_VAL;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) worst = std::max(worst, std::fabs(a[i] - b[i]));
  return worst;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

TEST(Simulate, KeepsTheRecordingsColumnsAndUnits) {
  const Arm arm;
  const Outcome outcome = lacuna({"simulate", arm.scenario(), "--set", "elbow.gain=25", "--set", "elbow.damping=1.4"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(first_line(outcome.out), "t,u,degrees");  // in the recording's order; its other column is left out
  auto simulated = columns_of(outcome.out);
  auto recorded = columns_of(std::string(arm_commands()));
  EXPECT_EQ(simulated["t"], recorded["t"]);
  EXPECT_EQ(simulated["u"], recorded["u"]);
  const auto measured = columns_of([&] {
    std::ifstream in(arm.folder() / "train.csv");
    return std::string(std::istreambuf_iterator<char>(in), {});
  }());
  // Started from noisy samples, so within a few times their noise of 0.03 degrees.
  EXPECT_LT(largest_difference(simulated["degrees"], measured.at("degrees")), 0.5);
  auto other = columns_of(lacuna({"simulate", arm.scenario()}).out);
  EXPECT_GT(largest_difference(other["degrees"], measured.at("degrees")), 1.0);
}

TEST(Simulate, NeedsCommandsOnly) {
  const Arm arm;
  const std::string commands = (arm.folder() / "commands_train.csv").string();
  const Outcome outcome = lacuna({"simulate", arm.scenario(), "--recording", commands});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(first_line(outcome.out), "t,u,degrees");
  // At rest at zero: 0 = scale * degrees + offset.
  EXPECT_NEAR(columns_of(outcome.out)["degrees"].front(), -0.1 / 0.017453292519943295, 1e-9);
  // From the working directory, and from the scenario's folder.
  EXPECT_EQ(lacuna({"simulate", "scenario.yaml", "--recording", "commands_train.csv"}, arm.folder()).out, outcome.out);
  EXPECT_EQ(lacuna({"simulate", arm.scenario(), "--recording", "commands_train.csv"}).out, outcome.out);
}

TEST(Simulate, AnyNumberOfThreadsGivesTheSameBytes) {
  const Arm arm;
  const Outcome one = lacuna({"simulate", arm.scenario(), "--threads", "1"});
  EXPECT_EQ(one.code, 0);
  EXPECT_EQ(lacuna({"simulate", arm.scenario(), "--threads", "2"}).out, one.out);
}

TEST(Simulate, AllEnginesAgree) {
  const Arm arm;
  auto reference = columns_of(lacuna({"simulate", arm.scenario()}).out);
  for (const auto& engine : engine_records()) {
    if (!engine.at("available")) continue;
    auto other = columns_of(lacuna({"simulate", arm.scenario(), "--engine", engine.at("name")}).out);
    EXPECT_LT(largest_difference(other["degrees"], reference["degrees"]), 1e-3) << engine.at("name");
  }
}

TEST(Simulate, WritesEveryRecordingBelowTheOutputFolder) {
  const Arm arm;
  const auto out = arm.folder() / "simulated";
  const auto record = json_of(lacuna({"simulate", arm.scenario(), "-o", out.string(), "--json"}));
  ASSERT_EQ(record.at("recordings").size(), 3u);
  EXPECT_EQ(record.at("recordings")[1].at("samples"), 200);
  for (const char* name : {"train.csv", "validate.csv", "test.csv"}) EXPECT_TRUE(std::filesystem::exists(out / name));
  const auto on_output = json_of(lacuna({"simulate", arm.scenario(), "--json"}));
  EXPECT_EQ(on_output.at("recordings")[0].at("data").at("degrees").size(), 200u);
}

TEST(Simulate, NeverOverwritesARecording) {
  const Arm arm;
  expect_refused(lacuna({"simulate", arm.scenario(), "-o", arm.folder().string()}), kBadInput, "train.csv");
}

TEST(Simulate, AnEffectIsAddedByItsName) {
  const Arm arm;
  auto plain = columns_of(lacuna({"simulate", arm.scenario()}).out);
  auto neutral = columns_of(lacuna({"simulate", arm.scenario(), "--set", "elbow.coulomb_friction.Fc=0"}).out);
  auto rough = columns_of(lacuna({"simulate", arm.scenario(), "--set", "elbow.coulomb_friction.Fc=10"}).out);
  EXPECT_EQ(plain["degrees"], neutral["degrees"]);
  EXPECT_GT(largest_difference(plain["degrees"], rough["degrees"]), 1.0);
}

TEST(Simulate, SettingsAreChecked) {
  const Arm arm;
  const auto refused = [&](const std::string& setting, const std::string& part) {
    expect_refused(lacuna({"simulate", arm.scenario(), "--set", setting}), kBadInput, part);
  };
  refused("elbow.gian=3", "elbow.gain");
  refused("gain=3", "elbow.gain");
  refused("elbow.gain", "NAME=NUMBER");
  refused("elbow.gain=", "a number");
  refused("elbow.gain=3x", "a number");
  refused("elbow.gain=nan", "a number");
  refused("elbow.damping=-1", "from 0");
  refused("wrist.coulomb_friction.Fc=1", "wrist");
  expect_refused(lacuna({"simulate", arm.scenario(), "--recording", "none.csv"}), kBadInput, "train.csv");
  expect_refused(lacuna({"simulate", arm.scenario(), "--step", "0"}), kBadInput, "--step");
}

TEST(Simulate, ADivergingModelSaysWhere) {
  const Arm arm;
  const Outcome outcome = lacuna({"simulate", arm.scenario(), "--set", "elbow.gain=1e9", "--set", "beam.mass=1e-9"});
  if (outcome.code != 0) expect_refused(outcome, 3, "train.csv");
}

}  // namespace
}  // namespace lacuna::test
