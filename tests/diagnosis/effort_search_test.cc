// Whole diagnoses of measured efforts: what was left out is named, what was not is not.
#include "diagnosis/effort_search.h"

#include <gtest/gtest.h>

#include <set>

#include "physics/effects/table.h"
#include "tests/physics/efforts.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kEffortNoise = 0.5;  // N m at 1 kHz: .06 after the filter, of efforts of 4
// N m, Coulomb's, shoulder and elbow. At turning points the predicted corner is filtered once, the measured one twice:
// that leaves a tenth of the friction, here less than the noise.
constexpr double kRubbing[] = {0.4, 0.25};
constexpr double kCarried = 0.4;  // kg, by rods of 1.5 and 0.8

/// Damped so much that nothing swings faster than the filter lets pass.
const std::map<std::string, double> kDamped{{"gain", 1.0}, {"damping", 1.2}};

DiagnoseOptions quick() {
  DiagnoseOptions options;
  options.identify.optimizer = Optimizer::lsq;
  options.identify.simulator.threads = 2;
  options.other_engines = false;
  return options;
}

std::vector<EffectSpec> rubbing() {
  return {effect("coulomb_friction", "shoulder", {{"Fc", kRubbing[0]}}),
          effect("coulomb_friction", "elbow", {{"Fc", kRubbing[1]}})};
}

/// A recording's file, role and what was concealed in it.
struct Filmed {
  std::string file;
  Role role;
  std::vector<EffectSpec> effects;
};

/// The rods with dampings that are searched, and recordings of them.
Scenario examined(const std::vector<Filmed>& recordings) {
  Scenario out = pushed_rods({}, "direct_effort", kDamped);
  out.prediction = InverseDynamics{8.0};
  out.identify = {{"damping", true, 0.2, 5.0, "test: identify"}};
  int k = 0;
  for (const Filmed& each : recordings) {
    const Drive drive = sines_at(clock(10.0, 0.001), 6.0, 7.3 * k);
    add_recording(out,
                  truth_recording(pushed_rods(each.effects, "direct_effort", kDamped), drive, each.file, kEffortNoise,
                                  static_cast<std::uint64_t>(++k)),
                  each.role);
  }
  return out;
}
Scenario examined(const std::vector<EffectSpec>& effects) {
  return examined({{"train.csv", Role::train, effects},
                   {"validate.csv", Role::validate, effects},
                   {"test.csv", Role::test, effects}});
}

std::string names_of(const Diagnosis& d) {
  std::string out;
  for (const Finding& f : d.findings) out += f.effect + "@" + f.place + " ";
  return out;
}

/// Made once for all tests of it.
const Scenario& rubbing_scenario() {
  static const Scenario scenario = examined(rubbing());
  return scenario;
}
const Diagnosis& rubbing_diagnosis() {
  static const Diagnosis d = diagnose(rubbing_scenario(), quick());
  return d;
}

TEST(EffortSearch, NamesCoulombFrictionAtEachJointAndNothingOfTheCommandsWay) {
  const Diagnosis& d = rubbing_diagnosis();
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  std::set<std::string> joints;
  for (const Finding& f : d.findings) {
    if (f.effect == "coulomb_friction") joints.insert(f.place);
    const Stage stage = effect_table()[find_effect(f.effect)].stage;
    EXPECT_TRUE(stage != Stage::command && stage != Stage::valve && stage != Stage::flow) << f.effect;
  }
  EXPECT_EQ(joints, (std::set<std::string>{"shoulder", "elbow"})) << names_of(d);
  EXPECT_EQ(d.findings.size(), 2u) << names_of(d);
  for (const Finding& f : d.findings) {
    for (const Rival& rival : f.rivals) EXPECT_LE(rival.probability, f.probability) << rival.effect;
    if (f.effect != "coulomb_friction") continue;
    const double truth = kRubbing[f.place == "elbow"];
    for (const Estimate& e : f.parameters) {
      if (e.name != "Fc") continue;
      // The scale of measured efforts is known to a tenth only, and every effort with it.
      EXPECT_NEAR(e.value, truth, 0.1 * truth) << f.place;
      EXPECT_GT(e.upper95, truth) << f.place;
      EXPECT_LT(e.lower95, truth) << f.place;
    }
    EXPECT_GT(f.probability, 0.5) << f.place;
    EXPECT_GT(f.heldout_gain, 0.0) << f.place;
  }
}

TEST(EffortSearch, ReportsTheTestRmsThatItsTracesShow) {
  const Diagnosis& d = rubbing_diagnosis();
  ASSERT_EQ(d.traces.size(), 2u);
  for (const auto& [fit, after] : {std::pair{&d.before, false}, std::pair{&d.after, true}}) {
    ASSERT_EQ(fit->rms.back().first, Role::test);
    const JointRms& rms = fit->rms.back().second;
    ASSERT_EQ(rms.size(), 2u);
    for (std::size_t j = 0; j < 2; ++j) {
      const Trace& trace = d.traces[j];
      EXPECT_EQ(trace.recording, "test.csv");
      std::vector<double> rest = after ? trace.after : trace.before;
      for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= trace.measured[k];
      EXPECT_NEAR(rms[j].second / rms_of(rest), 1.0, 1e-6) << rms[j].first << (after ? " after" : " before");
    }
  }
}

/// Coulomb friction but for the shoulder's break-away effort of .9 N m, which falls to .3 as speeds pass `vs` (rad/s).
Diagnosis diagnosis_of_a_drop(double vs) {
  return diagnose(examined({effect("stribeck_friction", "shoulder", {{"Fc", 0.3}, {"Fs", 0.9}, {"vs", vs}}),
                            effect("coulomb_friction", "elbow", {{"Fc", kRubbing[1]}})}),
                  quick());
}
/// What is claimed of the shoulder's friction.
const Finding* dry_friction_of_the_shoulder(const Diagnosis& d) {
  for (const Finding& f : d.findings)
    if (f.place == "shoulder" && (f.effect == "coulomb_friction" || f.effect == "stribeck_friction")) return &f;
  return nullptr;
}

TEST(EffortSearch, ClaimsTheRivalThatIsMoreProbableAndFitsBetter) {
  const Diagnosis d = diagnosis_of_a_drop(0.1);  // the linear look promises too little for the search to fit it
  const Finding* f = dry_friction_of_the_shoulder(d);
  ASSERT_NE(f, nullptr) << names_of(d);
  EXPECT_EQ(f->effect, "stribeck_friction");
  EXPECT_GT(f->probability, 0.5);
}

TEST(EffortSearch, KeepsARivalInTheClassThatDoesNoWorseAtTheEndOfItsRange) {
  const Diagnosis d = diagnosis_of_a_drop(1.2);  // faster than most of the motion: the drop has no end to be seen
  const Finding* f = dry_friction_of_the_shoulder(d);
  ASSERT_NE(f, nullptr) << names_of(d);
  EXPECT_NE(std::ranges::find(f->members, "stribeck_friction"), f->members.end());
}

TEST(EffortSearch, FindsNothingMoreInWhatItDiagnosed) {
  const Diagnosis again = diagnose(diagnosed_scenario(rubbing_scenario(), rubbing_diagnosis()), quick());
  EXPECT_TRUE(again.findings.empty()) << names_of(again);
}

TEST(EffortSearch, FindsNothingWhereNothingIsMissing) {
  const Diagnosis d = diagnose(examined(std::vector<EffectSpec>{}), quick());
  EXPECT_TRUE(d.findings.empty()) << names_of(d);
  EXPECT_TRUE(d.learned.empty());
  EXPECT_NE(d.verdict, Verdict::missing_physics);
}

TEST(EffortSearch, FindsALoadInTheRecordingThatCarriesIt) {
  const std::vector<EffectSpec> load{effect("payload", "arm", {{"m", kCarried}})};
  const Diagnosis d = diagnose(examined({{"bare.csv", Role::train, {}},
                                         {"loaded.csv", Role::train, load},
                                         {"validate.csv", Role::validate, {}},
                                         {"test.csv", Role::test, {}}}),
                               quick());
  const auto found =
      std::find_if(d.findings.begin(), d.findings.end(), [](const Finding& f) { return f.effect == "payload"; });
  ASSERT_NE(found, d.findings.end()) << names_of(d);
  EXPECT_EQ(d.findings.size(), 1u) << names_of(d);
  EXPECT_EQ(found->recordings, std::vector<std::string>{"loaded.csv"});
  const auto mass =
      std::find_if(found->parameters.begin(), found->parameters.end(), [](const Estimate& e) { return e.name == "m"; });
  ASSERT_NE(mass, found->parameters.end());
  EXPECT_LT(mass->lower95, kCarried);
  EXPECT_GT(mass->upper95, kCarried);
  EXPECT_LT(mass->upper95 - mass->lower95, kCarried) << "an interval that says something";
}

/// The weight of one link is carried by all before it: its errors are found together or not at all.
TEST(EffortSearch, LeavesNoMoreThanTheRegressionWhereLinksAreNotAsDrawn) {
  std::vector<EffectSpec> real = rubbing();
  real.push_back(effect("rigid_body", "shoulder", {{"alpha", 0.15}, {"t1", 0.03}, {"t2", -0.04}, {"d1", 0.2}}));
  real.push_back(effect("rigid_body", "elbow", {{"alpha", -0.1}, {"t1", -0.02}, {"t2", 0.03}, {"d2", -0.2}}));
  const Diagnosis d = diagnose(examined(real), quick());
  ASSERT_TRUE(d.idim.has_value());
  const auto& [role, after] = d.after.rms.back();
  ASSERT_EQ(role, Role::test);
  const JointRms& regression = d.idim->rms.back().second;
  ASSERT_EQ(after.size(), regression.size());
  for (std::size_t j = 0; j < after.size(); ++j) {
    EXPECT_LT(after[j].second, 1.05 * regression[j].second) << after[j].first;
    EXPECT_GT(d.before.rms.back().second[j].second, 2.0 * after[j].second) << after[j].first << ": nothing was wrong";
  }
}

/// n of a ripple is told from another within the inverse of the angle travelled: no list of starts would hit it.
TEST(EffortSearch, FindsTheNumberOfARipple) {
  constexpr double kNumber = 17.83, kHigh = 0.4;  // 1/rad, N m
  const Diagnosis d =
      diagnose(examined({effect("gear_ripple", "elbow", {{"a", kHigh}, {"b", 0.5 * kHigh}, {"n", kNumber}})}), quick());
  ASSERT_EQ(d.findings.size(), 1u) << names_of(d);
  const Finding& found = d.findings.front();
  EXPECT_EQ(found.effect, "gear_ripple");
  EXPECT_EQ(found.place, "elbow");
  EXPECT_GT(found.probability, 0.5);
  EXPECT_TRUE(d.learned.empty());
  for (const Estimate& e : found.parameters) {
    const double truth = e.name == "n" ? kNumber : e.name == "a" ? kHigh : 0.5 * kHigh;
    EXPECT_NEAR(e.value, truth, 0.1 * truth) << e.name;
  }
}

/// One turns once with the joint, the other many times: both are sines of its angle, and neither stands for the other.
TEST(EffortSearch, FindsARippleBesideACounterbalance) {
  const Diagnosis d = diagnose(examined({effect("gear_ripple", "elbow", {{"a", 0.4}, {"b", 0.2}, {"n", 17.83}}),
                                         effect("gravity_spring", "elbow", {{"a", 3.0}, {"b", 2.0}})}),
                               quick());
  std::set<std::string> found;
  for (const Finding& f : d.findings) found.insert(f.effect + "@" + f.place);
  EXPECT_EQ(found, (std::set<std::string>{"gear_ripple@elbow", "gravity_spring@elbow"}));
  EXPECT_TRUE(d.learned.empty());
}

constexpr double kHump = 1.5;        // N m, of an effort over the shoulder's angle that has no name
constexpr double kHumpAt = 0.15;     // rad
constexpr double kHumpWidth = 0.04;  // rad
double hump(double q) { return kHump * std::exp(-0.5 * std::pow((q - kHumpAt) / kHumpWidth, 2)); }

/// On knots finer than any that are learned.
EffectSpec humped() {
  constexpr int kKnots = 200;
  std::map<std::string, double> p{{"over", 0}, {"of", 0}, {"from", -1.0}, {"to", 1.0}, {"knots", kKnots}};
  for (int k = 0; k < kKnots; ++k) p["value_" + std::to_string(k + 1)] = hump(-1.0 + 2.0 * k / (kKnots - 1));
  return effect("learned_effort", "shoulder", p);
}
const Diagnosis& humped_diagnosis() {
  static const Diagnosis d = diagnose(examined({humped()}), quick());
  return d;
}

TEST(EffortSearch, LearnsALawThatTheCatalogueHasNoNameFor) {
  const Diagnosis& d = humped_diagnosis();
  EXPECT_TRUE(d.findings.empty()) << names_of(d);
  EXPECT_EQ(d.verdict, Verdict::unknown_physics);
  ASSERT_EQ(d.learned.size(), 1u);
  const LearnedLaw& law = d.learned.front();
  EXPECT_EQ(law.place, "shoulder");
  ASSERT_EQ(law.over.size(), 1u);
  EXPECT_EQ(law.over.front().name, "q");
  EXPECT_EQ(law.unit, "N m");
  EXPECT_GT(law.heldout_share, 0.5);
  // Measured is the drive's effort, which gives what the hump does not. A constant is a rod's weight elsewhere as well.
  double missed = 0.0, all = 0.0, mean = 0.0, middle = 0.0;
  const auto n = static_cast<double>(law.curve.size());
  for (const LearnedLaw::Point& p : law.curve) mean += (p.value - hump(p.at)) / n, middle += hump(p.at) / n;
  for (const LearnedLaw::Point& p : law.curve)
    missed += std::pow(p.value - mean - hump(p.at), 2), all += std::pow(hump(p.at) - middle, 2);
  EXPECT_LT(missed, 0.05 * all);
  ASSERT_FALSE(law.cloud.empty());
  double off = 0.0;
  for (const auto& [x, effort] : law.cloud) off += std::pow(effort - mean - hump(x), 2);
  EXPECT_LT(std::sqrt(off / static_cast<double>(law.cloud.size())), 0.2 * kHump) << "what the plot shows";
  const auto& [role, rms] = d.after.rms.back();
  ASSERT_EQ(role, Role::test);
  EXPECT_LT(rms.front().second, 0.5 * d.before.rms.back().second.front().second);
}

TEST(EffortSearch, SimulatesWithTheLawThatItLearned) {
  const Diagnosis again = diagnose(diagnosed_scenario(examined({humped()}), humped_diagnosis()), quick());
  EXPECT_TRUE(again.learned.empty());
  EXPECT_TRUE(again.findings.empty()) << names_of(again);
  EXPECT_EQ(again.verdict, Verdict::consistent);
}

}  // namespace
}  // namespace lacuna
