// `lacuna conceal`: a case that stands for itself, says nothing of what it hides, and is sealed.
#include <cmath>
#include <fstream>

#include "scenarios/scenario.h"
#include "scenarios/sha256.h"
#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> conceal(const Arm& arm, const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> line{"conceal", arm.scenario(), "-o", out.string(), "--engine", "featherstone"};
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST(Conceal, MakesACaseThatStandsForItself) {
  const Arm arm;
  const fs::path out = arm.folder() / "case";
  const auto record = json_of(lacuna(conceal(arm, out, {"--effect", "coulomb_friction:elbow:3", "--json"})));
  const auto label = json_file(out / "label.json");
  EXPECT_EQ(label.at("effects")[0].at("effect"), "coulomb_friction");
  EXPECT_EQ(label.at("effects")[0].at("location"), "elbow");
  EXPECT_EQ(label.at("effects")[0].at("strength"), 3.0);
  EXPECT_GT(label.at("left_rms_over_noise"), 1.0);
  EXPECT_GE(label.at("raw_rms_over_noise"), label.at("left_rms_over_noise"));
  EXPECT_EQ(sha256(text_of(out / "label.json")), record.at("label_sha256"));
  EXPECT_EQ(text_of(out / "label.sha256"), record.at("label_sha256").get<std::string>() + "  label.json\n");
  for (const auto& [file, hash] : label.at("recordings").items()) EXPECT_EQ(sha256(text_of(out / file)), hash) << file;
  const fs::path elsewhere = arm.folder() / "elsewhere";
  fs::rename(out, elsewhere);
  const Scenario scenario = load_scenario(elsewhere / "scenario.yaml");
  EXPECT_TRUE(scenario.effects.empty());
  EXPECT_EQ(scenario.actuators[0].parameters.at("gain"), 20.0) << "the start value, not the true one";
  EXPECT_EQ(scenario.recordings.size(), 3u);
  EXPECT_EQ(scenario.recordings[1].role, Role::validate);
}

TEST(Conceal, ScenarioAndOutputSayNothingOfTheEffect) {
  const Arm arm;
  const fs::path out = arm.folder() / "case";
  const auto record = json_of(lacuna(conceal(arm, out, {"--effect", "valve_deadband:elbow", "--json"})));
  EXPECT_EQ(record.dump().find("deadband"), std::string::npos);
  EXPECT_EQ(text_of(out / "scenario.yaml").find("deadband"), std::string::npos);
}

TEST(Conceal, WithoutAnEffectThePlainModelExplainsEverything) {
  const Arm arm;
  const fs::path out = arm.folder() / "case";
  ASSERT_EQ(lacuna(conceal(arm, out)).code, 0);
  const auto label = json_file(out / "label.json");
  EXPECT_TRUE(label.at("effects").empty());
  EXPECT_LT(label.at("left_rms_over_noise"), 0.1) << "what two integrators differ by";
  for (const auto& [name, value] : label.at("truth").items()) {
    const double start = name == "elbow.gain" ? 20.0 : 1.0, moved = std::fabs(value.get<double>() / start - 1.0);
    EXPECT_GE(moved, 0.1 - 1e-9) << name;
    EXPECT_LE(moved, 0.3 + 1e-9) << name;
  }
}

TEST(Conceal, TheSameSeedMakesTheSameCaseOnAnyNumberOfThreads) {
  const Arm arm;
  const auto make = [&](const std::string& name, const std::string& threads, const std::string& seed) {
    const fs::path out = arm.folder() / name / "case";
    EXPECT_EQ(lacuna(conceal(arm, out, {"--effect", "backlash:elbow", "--threads", threads, "--seed", seed})).code, 0);
    return text_of(out / "label.json") + text_of(out / "train.csv");
  };
  const std::string one = make("one", "1", "5");
  EXPECT_EQ(make("two", "3", "5"), one);
  EXPECT_NE(make("other", "1", "6"), one);
}

TEST(Conceal, StrengthFollowsTheVisibilityAskedFor) {
  const Arm arm;
  for (const char* effect : {"coulomb_friction:elbow", "end_stop:elbow", "joint_compliance:elbow"}) {
    const fs::path out = arm.folder() / std::string(effect).substr(0, 6);
    const Outcome outcome = lacuna(conceal(arm, out, {"--effect", effect, "--visibility", "2"}));
    ASSERT_EQ(outcome.code, 0) << effect << ": " << outcome.err;
    const double left = json_file(out / "label.json").at("left_rms_over_noise").get<double>();
    if (std::string(effect) == "joint_compliance:elbow") {
      EXPECT_GT(left, 2.2) << "2 beside the inertia behind the spring, which shows too";
      continue;
    }
    EXPECT_NEAR(left, 2.0, 0.1) << effect;
  }
}

/// Of two cases that differ by their noise alone, the difference of what was measured.
std::vector<double> noise_difference(const Arm& arm, const std::string& kind) {
  std::vector<double> columns[2];
  for (const int seed : {0, 1}) {
    const fs::path out = arm.folder() / (kind + std::to_string(seed));
    EXPECT_EQ(lacuna(conceal(arm, out, {"--noise", kind, "--perturb", "0", "--seed", std::to_string(seed)})).code, 0);
    columns[seed] = columns_of(text_of(out / "train.csv")).at("degrees");
  }
  for (std::size_t i = 0; i < columns[0].size(); ++i) columns[0][i] -= columns[1][i];
  return columns[0];
}

TEST(Conceal, NoiseIsOfTheKindAndSizeAskedFor) {
  const Arm arm;
  const double rms = 3e-4 / 0.017453292519943295;  // degrees, as the scenario states it
  for (const std::string kind : {"white", "coloured", "quantised"}) {
    const std::vector<double> d = noise_difference(arm, kind);
    double squares = 0.0, products = 0.0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      squares += d[i] * d[i];
      if (i > 0) products += d[i] * d[i - 1];
    }
    // 200 samples: 5 % standard error; coloured ones are worth a tenth of them.
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(d.size()) / 2.0) / rms, 1.0, 0.35) << kind;
    // exp(-1/5) = 0.82 from sample to sample.
    EXPECT_NEAR(products / squares, kind == "coloured" ? 0.82 : 0.0, 0.25) << kind;
    const double step = 0.8 * rms * std::sqrt(12.0);
    if (kind != "quantised") continue;
    for (const double x : d) EXPECT_NEAR(x / step, std::round(x / step), 1e-6);
  }
}

TEST(Conceal, ASealedCaseIsNeverOverwritten) {
  const Arm arm;
  const fs::path out = arm.folder() / "case";
  ASSERT_EQ(lacuna(conceal(arm, out)).code, 0);
  expect_refused(lacuna(conceal(arm, out, {"--seed", "2"})), 2, "sealed");
  expect_refused(lacuna(conceal(arm, arm.folder())), 2, "which this command reads");
}

TEST(Conceal, RefusesWhatItDoesNotKnow) {
  const Arm arm;
  const fs::path out = arm.folder() / "case";
  const std::vector<std::pair<std::vector<std::string>, std::string>> lines{
      {{"--effect", "coulomb:elbow"}, "coulomb_friction"},
      {{"--effect", "coulomb_friction:knee"}, "elbow"},
      {{"--effect", "coulomb_friction:elbow:much"}, "NAME:WHERE"},
      {{"--effect", "coulomb_friction:elbow:Fx=1"}, "Fc"},
      {{"--effect", "coulomb_friction:elbow:-1"}, "from 0"},
      {{"--effect", "payload:elbow"}, "arm"},
      {{"--effect", "payload:arm", "--recordings", "none.csv"}, "train.csv"},
      {{"--recordings", "train.csv"}, "payload"},
      {{"--noise", "pink"}, "white"},
      {{"--perturb", "0.3..0.1"}, "LEAST..MOST"}};
  for (const auto& [more, part] : lines) expect_refused(lacuna(conceal(arm, out, more)), 2, part);
  expect_refused(lacuna({"conceal", arm.scenario()}), 2, "--output");
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace lacuna::test
