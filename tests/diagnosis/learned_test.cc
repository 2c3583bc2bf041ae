// From end to end: a law outside the catalogue is learned as a curve, and nothing is where nothing can be or is.
#include "diagnosis/learned.h"

#include <gtest/gtest.h>

#include "tests/diagnosis/outside.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kRippled = 0.2;          // N m, beside 9 N m of the drive and 4.9 N m of the rod's weight
constexpr double kRipplesARadian = 24.0;  // of OutsidePhysics::Kind::position_ripple

/// The plain pendulum, from wrong numbers, on recordings of a rippled one.
Scenario rippled_pendulum(double strength, const std::vector<Role>& roles = kEveryRole) {
  const OutsidePhysics ripple{OutsidePhysics::Kind::position_ripple, 0, strength, {}};
  return guessed_pendulum([&](Role) { return std::vector<OutsidePhysics>{ripple}; }, roles);
}

/// Made once for all tests of it.
const Diagnosis& rippled_diagnosis() {
  static const Diagnosis d = diagnosed(rippled_pendulum(kRippled));
  return d;
}

TEST(LearnedLaws, StandWhereTheCatalogueHasNoName) {
  const Diagnosis& d = rippled_diagnosis();
  EXPECT_EQ(d.verdict, Verdict::unknown_physics);
  EXPECT_TRUE(d.findings.empty()) << d.findings.front().effect;
  ASSERT_EQ(d.learned.size(), 1u);
  const LearnedLaw& law = d.learned.front();
  EXPECT_EQ(law.place, "swing");
  ASSERT_EQ(law.over.size(), 1u);
  EXPECT_EQ(law.over.front().name, "q");
  EXPECT_EQ(law.unit, "N m");
  EXPECT_EQ(law.over.front().unit, "rad");
  EXPECT_EQ(law.resembles, "gear ripple");
  EXPECT_GT(law.probability, 0.99);
  ASSERT_EQ(d.added.size(), 1u);
  EXPECT_EQ(d.added.front().effect, "learned_effort");
  EXPECT_EQ(d.added.front().place, "swing");
  // What was learned is no name: the rest is said as if it were not there.
  ASSERT_EQ(d.unexplained.per_joint.size(), 1u);
  EXPECT_GT(d.unexplained.per_joint.front().over_noise, 3.0);
  EXPECT_EQ(d.unexplained.per_joint.front().probability, 1.0) << "nothing was found to explain any of it";
}

TEST(LearnedLaws, LeaveTheNoiseOnRecordingsThatWereNotFitted) {
  const Diagnosis& d = rippled_diagnosis();
  EXPECT_GT(rms_in_role(d.before, Role::test), 3.0 * kTransducerNoise);
  // Of a thousand samples the noise's own rms is good to 2 %, and what some twenty numbers cost is less.
  EXPECT_LT(rms_in_role(d.after, Role::test), 1.15 * kTransducerNoise);
  ASSERT_EQ(d.learned.size(), 1u);
  // All but the noise's own: of three times its rms a ninth.
  EXPECT_GT(d.learned.front().heldout_share, 0.85);
  EXPECT_GT(d.learned.front().heldout_gain, 0.0);
  EXPECT_TRUE(d.worse.empty());
}

TEST(LearnedLaws, AreTheCurveThatWasConcealed) {
  const Diagnosis& d = rippled_diagnosis();
  ASSERT_EQ(d.learned.size(), 1u);
  const LearnedLaw& law = d.learned.front();
  const double period = 2.0 * std::numbers::pi / kRipplesARadian;
  EXPECT_NEAR(law.period, period, 0.01 * period);
  EXPECT_GT(law.over.front().to - law.over.front().from, 4.0 * period) << "nothing was tested";
  EXPECT_NEAR(law.height, kRippled, 0.1 * kRippled);
  // One percent of the period is a quarter of a radian where some four periods end: of the curve 2 %.
  double missed = 0.0, all = 0.0, mean = 0.0;
  const auto truth = [](double q) { return kRippled * std::sin(kRipplesARadian * q); };
  for (const LearnedLaw::Point& p : law.curve) mean += p.value - truth(p.at);
  mean /= static_cast<double>(law.curve.size());  // an effort throughout, which a spring at another place is as well
  for (const LearnedLaw::Point& p : law.curve) {
    missed += std::pow(p.value - mean - truth(p.at), 2), all += std::pow(truth(p.at), 2);
    EXPECT_LT(p.lower95, p.value);
    EXPECT_GT(p.upper95, p.value);
  }
  EXPECT_LT(missed, 0.05 * all);
}

TEST(LearnedLaws, ExplainTheRecordingsOnceTheyAreInTheScenario) {
  const Scenario scenario = rippled_pendulum(kRippled);
  const Scenario again = saved_and_read(diagnosed_scenario(scenario, rippled_diagnosis()));
  ASSERT_EQ(again.effects.size(), 1u);
  EXPECT_EQ(again.effects.front().effect, "learned_effort");
  const Diagnosis d = diagnosed(again);
  EXPECT_EQ(d.verdict, Verdict::consistent) << (d.findings.empty() ? "" : d.findings.front().effect);
  EXPECT_TRUE(d.learned.empty());
  EXPECT_FALSE(d.unexplained.present);
  EXPECT_LT(rms_in_role(d.after, Role::test), 1.15 * kTransducerNoise);
}

TEST(LearnedLaws, HaveTheSameBitsOnOneThreadAndOnTwo) {
  const Diagnosis one = diagnosed(rippled_pendulum(kRippled), 1), &two = rippled_diagnosis();
  ASSERT_EQ(one.learned.size(), 1u);
  ASSERT_EQ(two.learned.size(), 1u);
  const auto values = [](const LearnedLaw& law) {
    std::vector<double> out{law.over.front().from, law.over.front().to, law.period, law.evidence, law.heldout_gain};
    for (const LearnedLaw::Point& p : law.curve) out.insert(out.end(), {p.value, p.lower95, p.upper95});
    return out;
  };
  EXPECT_TRUE(same_bits(values(one.learned[0]), values(two.learned[0])));
}

TEST(LearnedLaws, NeedRecordingsToBeConfirmedOn) {
  const Diagnosis d = diagnosed(rippled_pendulum(kRippled, {Role::train, Role::test}));
  EXPECT_TRUE(d.learned.empty());
  EXPECT_TRUE(d.added.empty());
  EXPECT_EQ(d.verdict, Verdict::unknown_physics) << "that something is missing is seen all the same";
}

TEST(LearnedLaws, AreNoneWhereTheModelIsExact) {
  const Diagnosis d = diagnosed(rippled_pendulum(0.0));
  EXPECT_EQ(d.verdict, Verdict::consistent);
  EXPECT_TRUE(d.learned.empty());
  EXPECT_TRUE(d.added.empty());
}

/// The plain pendulum, from wrong numbers, on recordings with one thing outside the catalogue.
Diagnosis diagnosed_with(OutsidePhysics::Kind kind, double strength, const OutsidePhysics::Form& form) {
  const OutsidePhysics physics{kind, 0, strength, {}, form};
  return diagnosed(guessed_pendulum([&](Role) { return std::vector<OutsidePhysics>{physics}; }));
}
std::vector<std::string> variables(const LearnedLaw& law) {
  std::vector<std::string> out;
  for (const LearnedLaw::Variable& v : law.over) out.push_back(v.name);
  return out;
}

TEST(LearnedLaws, OfAValvesNotchAreOnItsCommand) {
  OutsidePhysics::Form form;
  form.centre = 0.6, form.width = 0.25;
  const Diagnosis d = diagnosed_with(OutsidePhysics::Kind::valve_notch, 0.4, form);
  EXPECT_EQ(d.verdict, Verdict::unknown_physics);
  ASSERT_EQ(d.learned.size(), 1u);
  EXPECT_EQ(d.learned.front().stage, Stage::command);
  EXPECT_EQ(variables(d.learned.front()), std::vector<std::string>{"u"});
  EXPECT_LT(rms_in_role(d.after, Role::test), 1.3 * kTransducerNoise) << d.learned.front().description;
  ASSERT_EQ(d.added.size(), 1u);
  EXPECT_EQ(d.added.front().effect, "learned_command");
}

/// The plain pendulum, from wrong numbers, on recordings of one with an effect, whose strength may change along its
/// way.
Diagnosis diagnosed_from(const EffectSpec& effect, const std::vector<Unevenness>& uneven = {}) {
  Scenario truth = pendulum_scenario({}), scenario = pendulum_scenario(kGuessed);
  truth.effects = {effect};
  for (const Role role : kEveryRole) {
    const auto k = static_cast<std::uint64_t>(role);
    const std::string file = std::string(to_string(role)) + ".csv";
    const Drive drive = rested_drive(kRecordedFor, 7.3 * static_cast<double>(k));
    add_recording(scenario, recording_with({}, truth, drive, file, 11 + k, uneven), role);
  }
  search_plain_numbers(scenario);
  return diagnosed(scenario);
}

/// A pendulum whose transducer turns about another centre than its track: read wrong by a law of the angle.
TEST(LearnedLaws, OfATransducerAreOnItsReading) {
  constexpr double kWrong = 0.01, kTurns = 9.0;  // rad; per rad
  EffectSpec ring{
      "learned_reading", "swing", {{"over", 0.0}, {"from", -3.0}, {"to", 3.0}, {"knots", 256.0}}, {}, "test"};
  for (int k = 0; k < 256; ++k)
    ring.parameters["value_" + std::to_string(k + 1)] = kWrong * std::sin(kTurns * (-3.0 + 6.0 * k / 255.0));
  const Diagnosis d = diagnosed_from(ring);
  EXPECT_EQ(d.verdict, Verdict::unknown_physics);
  ASSERT_EQ(d.learned.size(), 1u);
  EXPECT_EQ(d.learned.front().stage, Stage::reading) << d.learned.front().description;
  EXPECT_EQ(variables(d.learned.front()), std::vector<std::string>{"q"});
  EXPECT_LT(rms_in_role(d.after, Role::test), 1.15 * kTransducerNoise);
}

constexpr double kUneven = 0.3;  // of an effect's strength, either way

/// No machine's law is quite the textbook's: a name that says most of it stays, and what it leaves is learned.
TEST(LearnedLaws, LeaveTheNameOfAnUnevenFrictionStanding) {
  const EffectSpec friction{"coulomb_friction", "swing", {{"Fc", 0.4}}, {}, "test"};
  const Diagnosis d = diagnosed_from(friction, {{"swing.coulomb_friction.Fc", {0, 0, false, kUneven, 0.2, 2.0}}});
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings.front().effect, "coulomb_friction");
  ASSERT_EQ(d.findings.front().parameters.size(), 1u);
  EXPECT_NEAR(d.findings.front().parameters.front().value, 0.4, kUneven * 0.4);
  ASSERT_EQ(d.learned.size(), 1u);
  EXPECT_EQ(variables(d.learned.front()), (std::vector<std::string>{"q", "v"}));
  EXPECT_LT(rms_in_role(d.after, Role::test), 1.15 * kTransducerNoise);
}

/// Several names at once come nearer to it than its own alone, and a curve nearer than they: its own says most of that.
TEST(LearnedLaws, LeaveTheNameOfAnUnevenAsymmetryStanding) {
  constexpr double kAsymmetry = 0.1;
  const EffectSpec weaker{"valve_asymmetry", "swing", {{"a", kAsymmetry}}, {}, "test"};
  const Diagnosis d = diagnosed_from(weaker, {{"swing.valve_asymmetry.a", {0, 0, true, kUneven, 0.3, 5.0}}});
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  ASSERT_EQ(d.findings.size(), 1u) << d.findings[1].effect;
  EXPECT_EQ(d.findings.front().effect, "valve_asymmetry");
  ASSERT_EQ(d.findings.front().parameters.size(), 1u);
  EXPECT_NEAR(d.findings.front().parameters.front().value, kAsymmetry, kUneven * kAsymmetry);
  EXPECT_LT(rms_in_role(d.after, Role::test), 1.15 * kTransducerNoise);
}

/// Whatever comes after learning rebuilds models from the findings: these must be what the model has, in its order.
TEST(LearnedLaws, MakeFindingsOfTheNamesThatTheModelHas) {
  Scenario scenario = guessed_pendulum([](Role) { return std::vector<OutsidePhysics>{}; });
  const PlantModel plain(scenario);
  const EffectSpec stribeck{"stribeck_friction", "swing", {}, {}, ""},
      coulomb{"coulomb_friction", "swing", {{"v0", 0.0}}, {}, ""}, offset{"valve_offset", "swing", {}, {}, ""};
  const CurrentModel named{plain.with_effects({offset, coulomb}), SearchSpace(plain, scenario), {}, {}};
  const LearnedLaws learned{named, {}, {{"com_shift", "swing"}}, {{stribeck, coulomb, {0.1, 0.2, 0.3}, 1.0}}, named};
  std::vector<Finding> findings(3);
  for (Finding& f : findings) f.place = "swing";
  findings[0].effect = "stribeck_friction", findings[0].probability = 0.6;
  findings[0].rivals = {{"coulomb_friction", "swing", 0.3, {}, {0.1}, {}}, {"backlash", "swing", 0.1, {}, {0.1}, {}}};
  findings[1].effect = "com_shift", findings[2].effect = "valve_offset";
  learned.follow(findings);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].effect, "valve_offset");
  const Finding& friction = findings[1];
  EXPECT_EQ(friction.effect, "coulomb_friction");
  EXPECT_EQ(friction.fixed, coulomb.parameters);
  EXPECT_NEAR(friction.probability, 0.9 / (1.0 + std::exp(-1.0)), 1e-12);
  ASSERT_EQ(friction.rivals.size(), 2u);
  EXPECT_EQ(friction.rivals[0].effect, "stribeck_friction");
  EXPECT_EQ(friction.rivals[0].own.size(), 3u);
  EXPECT_NEAR(friction.probability + friction.rivals[0].probability, 0.9, 1e-12);
  EXPECT_EQ(friction.members, (std::vector<std::string>{"coulomb_friction", "stribeck_friction"})) << "odds of e to 1";
}

TEST(LearnedLaws, OfATightSpotHaveACurveForEitherWay) {
  OutsidePhysics::Form form;
  form.centre = 0.1, form.width = 0.25, form.slow = 0.02;
  const Diagnosis d = diagnosed_with(OutsidePhysics::Kind::tight_spot, 0.5, form);
  EXPECT_EQ(d.verdict, Verdict::unknown_physics);
  ASSERT_EQ(d.learned.size(), 1u);
  const LearnedLaw& law = d.learned.front();
  EXPECT_EQ(law.stage, Stage::link);
  EXPECT_EQ(variables(law), (std::vector<std::string>{"q", "v"}));
  EXPECT_EQ(law.over[1].knots, 2u);
  EXPECT_EQ(law.resembles, "friction that depends on the position");
  EXPECT_LT(rms_in_role(d.after, Role::test), 1.3 * kTransducerNoise);
}

}  // namespace
}  // namespace lacuna
