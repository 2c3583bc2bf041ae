// `lacuna conceal`: a case that stands for itself, says nothing of what it hides, and is sealed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

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

const std::vector<std::string> kOutside{"position_ripple", "external_push", "command_dropout", "counterbalance_spring",
                                        "tight_spot",      "valve_notch",   "cable_drag",      "repeated_samples"};

/// Two level links, each joint driven, on clocks that begin at 10 s.
class TwoLinks {
 public:
  TwoLinks() {
    files_.write("arm.urdf", R"(<?xml version='1.0'?>
<robot name='arm'>
  <link name='base'/>
  <link name='upper'><inertial><origin xyz='0.2 0 0'/><mass value='2'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.1'/></inertial></link>
  <link name='lower'><inertial><origin xyz='0.2 0 0'/><mass value='1'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.05' iyz='0' izz='0.05'/></inertial></link>
  <joint name='shoulder' type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' effort='100' velocity='9'/></joint>
  <joint name='elbow' type='revolute'><parent link='upper'/><child link='lower'/><origin xyz='0.4 0 0'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' effort='100' velocity='9'/></joint>
</robot>
)");
    files_.write("scenario.yaml", R"(format: lacuna-scenario/1
name: arm
robot: arm.urdf
actuators:
  shoulder: {model: torque_source, gain: 9, damping: 3, stiffness: 9, rest: 0.1}
  elbow: {model: torque_source, gain: 6, damping: 1, stiffness: 4, rest: -0.2}
identify:
  gain: {relative_bounds: [0.25, 4]}
channels: {time: t, command: {shoulder: u1, elbow: u2}, position: {shoulder: q1, elbow: q2}}
noise: {position: 0.002}
recordings:
  - {file: train.csv, role: train}
  - {file: test.csv, role: test}
)");
    for (const std::string name : {"train", "test"}) {
      std::ofstream out(files_.path() / (name + ".csv"));
      out << "t,u1,u2,q1,q2\n";
      for (int k = 0; k <= 200; ++k) {
        const double t = 0.02 * k + (name == "test" ? 3.0 : 0.0);
        out << 10.0 + 0.02 * k << ',' << std::sin(2.1 * t) << ',' << std::sin(2.9 * t + 1.0) << ",0,0\n";
      }
    }
  }
  const fs::path& folder() const { return files_.path(); }
  /// The label of a case, or how that was refused.
  nlohmann::json label(const std::string& name, std::vector<std::string> more) const {
    std::vector<std::string> line{
        "conceal", (folder() / "scenario.yaml").string(), "-o", (folder() / name).string(), "--engine", "featherstone"};
    line.insert(line.end(), more.begin(), more.end());
    const Outcome outcome = lacuna(line);
    EXPECT_EQ(outcome.code, 0) << name << ": " << outcome.err;
    return outcome.code == 0 ? json_file(folder() / name / "label.json") : nlohmann::json();
  }

 private:
  TemporaryFolder files_;
};

TEST(ConcealOutside, EveryKindIsHiddenAndDescribed) {
  const TwoLinks arm;
  const std::map<std::string, std::pair<std::string, std::vector<std::string>>> told{
      {"position_ripple", {"link", {"q"}}},     {"external_push", {"link", {"t"}}},
      {"command_dropout", {"command", {"t"}}},  {"counterbalance_spring", {"link", {"q"}}},
      {"tight_spot", {"link", {"q", "v"}}},     {"valve_notch", {"command", {"u"}}},
      {"cable_drag", {"link", {"shoulder.q"}}}, {"repeated_samples", {"reading", {"t"}}}};
  for (const std::string& kind : kOutside) {
    const auto label = arm.label(kind + "/case", {"--effect", kind + ":elbow", "--visibility", "4"});
    const auto& hidden = label.at("effects")[0];
    // Samples repeat as wholes.
    EXPECT_NEAR(label.at("left_rms_over_noise").get<double>(), 4.0, kind == "repeated_samples" ? 4.0 : 0.21) << kind;
    EXPECT_EQ(hidden.at("stage"), told.at(kind).first) << kind;
    EXPECT_EQ(hidden.at("over"), told.at(kind).second) << kind;
    if (told.at(kind).second.front() == "t") {
      EXPECT_FALSE(hidden.contains("curve")) << kind;
      ASSERT_EQ(hidden.at("events").size(), 6u) << kind << ": three a recording";
      EXPECT_EQ(hidden.at("events")[5].at("recording"), "test.csv");
      for (const auto& event : hidden.at("events")) {
        EXPECT_GT(event.at("from"), 10.0) << "the recording's own clock";
        EXPECT_GT(event.at("to"), event.at("from"));
        EXPECT_LE(event.at("to"), 14.0 + 1e-9);
      }
    } else {
      EXPECT_FALSE(hidden.contains("events")) << kind;
      EXPECT_EQ(hidden.at("curve").size(), kind == "tight_spot" ? 120u : 60u) << kind;
    }
    EXPECT_EQ(text_of(arm.folder() / kind / "case/scenario.yaml").find(kind), std::string::npos);
  }
}

TEST(ConcealOutside, FormsAreDrawnFromTheSeed) {
  const TwoLinks arm;
  for (const std::string& kind : kOutside) {
    const auto make = [&](const std::string& name, const std::string& seed) {
      const auto label =
          arm.label(name + kind + "/case", {"--effect", kind + ":shoulder", "--seed", seed, "--perturb", "0"});
      return label.dump() + text_of(arm.folder() / (name + kind) / "case/train.csv");
    };
    const auto form = [](const std::string& text) {
      const auto effect = nlohmann::json::parse(text.substr(0, text.rfind('}') + 1)).at("effects")[0];
      return effect.contains("curve") ? effect.at("curve") : effect.at("events");
    };
    const std::string one = make("one", "5");
    EXPECT_EQ(make("again", "5"), one) << kind;
    EXPECT_NE(form(make("other", "6")), form(one)) << kind;
  }
}

TEST(ConcealOutside, ARepeatedSampleIsTheLastOneAndNoOtherChannelKnows) {
  const TwoLinks arm;
  const auto label = arm.label("held", {"--effect", "repeated_samples:elbow:0.3", "--seed", "3"});
  arm.label("free", {"--seed", "3"});
  auto held = columns_of(text_of(arm.folder() / "held/train.csv"));
  auto free = columns_of(text_of(arm.folder() / "free/train.csv"));
  int repeated = 0;
  for (std::size_t k = 0; k < held["t"].size(); ++k) {
    bool inside = false;
    for (const auto& event : label.at("effects")[0].at("events"))
      inside =
          inside || (event.at("recording") == "train.csv" && held["t"][k] >= event.at("from").get<double>() - 1e-9 &&
                     held["t"][k] < event.at("to").get<double>() - 1e-9);
    repeated += inside;
    EXPECT_EQ(held["q2"][k], inside ? held["q2"][k - 1] : free["q2"][k]) << "at " << held["t"][k];
  }
  EXPECT_EQ(repeated, 3 * 15);
  for (const char* other : {"t", "u1", "u2", "q1"}) EXPECT_EQ(held[other], free[other]) << other;
  // Samples repeat as wholes, and one at least.
  for (const auto& [asked, seconds] : {std::pair("0.001", 0.02), {"0.049", 0.04}}) {
    const auto other =
        arm.label(std::string("held") + asked, {"--effect", std::string("repeated_samples:elbow:") + asked});
    EXPECT_NEAR(other.at("effects")[0].at("strength").get<double>(), seconds, 1e-9) << asked;
  }
}

TEST(ConcealOutside, ACableNeedsTwoJoints) {
  const Arm arm;
  expect_refused(lacuna(conceal(arm, arm.folder() / "case", {"--effect", "cable_drag:elbow"})), 2, "two joints");
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

/// From a motion and its efforts nobody knows the commands that another machine would have to be given.
TEST(Conceal, KeepsThePressuresOfAHydraulicDriveAndTheyDriveTheCase) {
  const Arm arm;
  std::string pressed = "t,u,degrees,head,rod\n";
  for (int k = 0; k < 300; ++k)
    pressed += fmt::format("{},{},10,1.76e6,2e6\n", 0.01 * k, k < 20 ? 0.0 : 3.0 * std::sin(0.05 * (k - 20)));
  for (const char* role : {"train", "validate", "test"}) arm.files().write(std::string(role) + ".csv", pressed);
  std::string scenario = replaced(
      kArmScenario, "{model: torque_source, gain: 20, damping: 1, stiffness: 30, rest: 0.2616}",
      "{model: hydraulic, gain: 1e-9, full_command: 10, area_a: 1e-3, area_b: 8e-4, ratio: 0.05, dead_volume_a: 1e-4, "
      "dead_volume_b: 1e-4, stroke: 0.3, supply_pressure: 1.6e7, return_pressure: 5e5, bulk_modulus: 1e8, leakage: "
      "1e-11}");
  scenario = replaced(scenario, "  damping: {relative_bounds: [0.25, 4]}\n", "");
  scenario = replaced(
      scenario, "noise:\n",
      "  pressure_a: {elbow: head}\n  pressure_b: {elbow: rod}\nnoise:\n  pressure_a: 5000\n  pressure_b: 5000\n");
  arm.files().write("scenario.yaml", scenario);
  const fs::path out = arm.folder() / "case";
  ASSERT_EQ(lacuna(conceal(arm, out)).code, 0);
  const std::string text = text_of(out / "scenario.yaml");
  EXPECT_NE(text.find("pressure_a"), std::string::npos);
  const Scenario whole = load_scenario(out / "scenario.yaml");
  const Recording& data = *whole.recordings[0].data;
  const auto& head = data.columns[data.find("head")];
  const auto [low, high] = std::minmax_element(head.begin(), head.end());
  EXPECT_GT(*low, 0.0);
  EXPECT_LT(*high, 1.6e7);
  EXPECT_GT(*high - *low, 5e4) << "ten times their noise: as the true machine's oil had it";
  // Nothing is hidden: over four tenths of a second its pressures move it as the case says.
  ASSERT_EQ(text.find("prediction: {"), std::string::npos);
  const std::string driven = replaced(replaced(text, "prediction: free_run\n", ""), "  gain:", "  area_a:");
  std::ofstream(out / "driven.yaml") << driven << "prediction: {pressure_driven: {horizon: 0.1}}\n";
  const auto moved =
      columns_of(lacuna({"simulate", (out / "driven.yaml").string(), "--recording", (out / "test.csv").string()}).out);
  const Recording& test = *whole.recordings[2].data;
  const auto& measured = test.columns[test.find("degrees")];
  ASSERT_EQ(moved.at("degrees").size(), measured.size());
  constexpr std::size_t kLooked = 40;
  EXPECT_GT(std::fabs(measured[kLooked - 1] - measured[0]), 0.6) << "degrees: it moves by more than is asked";
  // Errors of 100 Hz pressures grow with the square of the time; at rest, or without them, it falls further.
  for (std::size_t k = 0; k < kLooked; ++k) EXPECT_NEAR(moved.at("degrees")[k], measured[k], 0.3) << k;
}

TEST(Conceal, TheLabelSaysWhatElseTheMachineHas) {
  const Arm arm;
  const fs::path out = arm.folder() / "case";
  ASSERT_EQ(lacuna(conceal(arm, out,
                           {"--effect", "coulomb_friction:elbow:3", "--background", "0.7", "--uneven", "0.3", "--drift",
                            "0.2", "--misplaced", "0.01", "--seconds", "3", "--alone", "elbow"}))
                .code,
            0);
  const auto conditions = json_file(out / "label.json").at("conditions");
  EXPECT_EQ(conditions, nlohmann::json::parse(R"({"background": 0.7, "uneven": 0.3, "drift": 0.2, "misplaced": 0.01,
                                                  "seconds": 3.0, "alone": "elbow"})"));
  // What was drawn stands in the label, too.
  const auto label = json_file(out / "label.json");
  const auto& effect = label.at("effects")[0];
  EXPECT_EQ(effect.at("uneven").at("over"), "q");
  EXPECT_EQ(effect.at("uneven").at("share"), 0.3);
  EXPECT_GT(effect.at("uneven").at("width"), 0.0);
  std::set<double> strengths;
  for (const char* file : {"train.csv", "validate.csv", "test.csv"}) {
    const double strength = effect.at("strength_by_recording").at(file);
    EXPECT_NEAR(strength, 3.0, 0.2 * 3.0 + 1e-12);
    strengths.insert(strength);
  }
  EXPECT_EQ(strengths.size(), 3u);
  for (const double metres : label.at("misplaced").at("elbow")) EXPECT_LE(std::fabs(metres), 0.01);
  EXPECT_LE(columns_of(text_of(out / "train.csv")).at("t").back(), 3.0 + 1e-9);
  const std::string scenario = text_of(out / "scenario.yaml");
  for (const char* word : {"background", "uneven", "com_shift"}) EXPECT_EQ(scenario.find(word), std::string::npos);
  expect_refused(lacuna(conceal(arm, arm.folder() / "other", {"--alone", "wrist"})), kBadInput, "--alone");
  expect_refused(lacuna(conceal(arm, arm.folder() / "other", {"--uneven", "1.5"})), kBadInput, "--uneven");
  // Nothing given is ignored in silence.
  for (const char* option : {"--uneven", "--drift"})
    expect_refused(lacuna(conceal(arm, arm.folder() / "other", {option, "0.3"})), kBadInput, option);
  for (const char* even : {"com_shift:elbow", "sensor_offset:elbow", "end_stop:elbow", "input_delay:elbow"})
    expect_refused(lacuna(conceal(arm, arm.folder() / "other", {"--effect", even, "--uneven", "0.3"})), kBadInput,
                   "--uneven");
}

TEST(Conceal, RefusesMeasuredEffortsWithoutACommand) {
  const Arm arm;
  const std::string measured = replaced(kArmScenario, "  command: {elbow: u}\n", "  effort: {elbow: u}\n") +
                               "prediction: {inverse_dynamics: {cutoff_hz: 4}}\n";
  const std::string file = arm.files().write("efforts.yaml", measured).string();
  expect_refused(lacuna({"conceal", file, "-o", (arm.folder() / "case").string()}), 2, "no command");
  EXPECT_FALSE(fs::exists(arm.folder() / "case"));
}

}  // namespace
}  // namespace lacuna::test
