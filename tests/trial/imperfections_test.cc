// Machines unlike any model: each imperfection does what its name says, and no more.
#include "trial/imperfections.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "physics/catalogue.h"
#include "physics/truth.h"
#include "scenarios/error.h"
#include "tests/physics/plants.h"
#include "trial/conceal.h"
#include "trial/true_machine.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kNoise = 1e-3;  // rad

/// Two rods on springs; one recording to train on, one to validate with.
Scenario two_rods(const Drive& drive) {
  const std::map<std::string, double> p{{"gain", 4.0}, {"damping", 1.0}, {"stiffness", 8.0}, {"rest", 0.2}};
  Scenario out = driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                                 {actuator("shoulder", "torque_source", p), actuator("elbow", "torque_source", p)},
                                 drive, {{0.1, 0.1}, {0.0, 0.0}, false});
  add_recording(out, recording_of(*out.robot, drive, {{0.1, 0.1}, {0.0, 0.0}, false}, "second.csv"), Role::validate);
  for (const char* joint : {"shoulder", "elbow"}) out.noise[ChannelKind::position][joint] = kNoise;
  for (const char* name : {"gain", "damping", "stiffness"}) out.identify.push_back({name, true, 0.2, 5.0, "test"});
  return out;
}

/// Nothing moved from its start value, so that only what is asked for differs.
ConcealOptions unmoved() {
  ConcealOptions out;
  out.engine = "featherstone";
  out.perturb_least = out.perturb_most = 0.0;
  return out;
}

std::vector<double> column(const Scenario& scenario, std::size_t recording, const std::string& name) {
  const Recording& data = *scenario.recordings[recording].data;
  return data.columns[data.find(name)];
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a);
  for (std::size_t i = 0; i < a.size(); ++i) out[i] -= b[i];
  return root_mean_square(out);
}

TEST(Uneven, DampingThatChangesWithThePlaceSlowsABlockAsItsIntegralSays) {
  // m dv/dt = -D(x) v, so dv/dx = -D(x)/m: the speed falls by the integral of D over the way.
  const double damping = 0.8, share = 0.6, width = 0.7, centre = 0.2;
  Scenario scenario = driven_scenario(block_robot(), {}, constant_drive(1, 2.0, 0.01, 0.0), {{0.0}, {1.5}});
  scenario.effects = {effect("viscous_friction", "slide", {{"D", damping}})};
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, {{0.0}, {1.5}});
  TruthOptions options;
  options.engine = "featherstone";
  options.settle = false;
  options.tolerance = 1e-10;
  options.uneven = {{model.find("slide.viscous_friction.D"), 0, false, share, centre, width}};
  const auto moved = simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
  const std::vector<double>&x = moved[0], &v = moved[1];
  ASSERT_GT(x.back(), 2.0 * width);
  const double turn = 2.0 * std::numbers::pi / width;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double integral =
        damping * (x[k] - share / turn * (std::cos(turn * (x[k] - centre)) - std::cos(turn * (0.0 - centre))));
    EXPECT_NEAR(v[k], 1.5 - integral / kBlockMass, 1e-6) << k;
  }
}

TEST(Uneven, ADeadbandThatChangesWithTheCommandLetsThroughWhatItsLawSays) {
  // A force against a spring, at rest: stiffness q = gain (u - d (1 + share sin(2 pi (u - centre) / width))).
  const double gain = 3.0, stiffness = 20.0, d = 0.4, share = 0.5, centre = 0.3, width = 1.7;
  for (const double u : {0.8, 1.1, 1.9}) {
    Scenario scenario = driven_scenario(
        block_robot(),
        {actuator("slide", "torque_source", {{"gain", gain}, {"damping", 4.0}, {"stiffness", stiffness}})},
        constant_drive(1, 0.5, 0.02, u), {{0.0}, {0.0}});
    scenario.effects = {effect("valve_deadband", "slide", {{"d", d}})};
    const PlantModel model(scenario);
    const Experiment experiment = started_experiment(scenario, {{0.0}, {0.0}});
    TruthOptions options;
    options.engine = "featherstone";
    options.uneven = {{model.find("slide.valve_deadband.d"), 0, true, share, centre, width}};
    const auto moved = simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
    const double there = d * (1.0 + share * std::sin(2.0 * std::numbers::pi * (u - centre) / width));
    for (const double q : moved[0]) EXPECT_NEAR(q, gain * (u - there) / stiffness, 1e-8) << u;
  }
}

TEST(Uneven, IsDrawnWithinWhatTheLawGoesOver) {
  const Travel travel{{{0.0, 1.0}}, {{-2.0, 4.0}}, {1.0}}, still{{{1.0, 1.0}}, {{-2.0, 4.0}}, {1.0}};
  const UnevenLaw law = drawn_unevenness(0.5, 0, Stage::valve, travel, {1, 2, 3});
  EXPECT_TRUE(law.over_command);
  EXPECT_EQ(law.share, 0.5);
  EXPECT_GE(law.width, 6.0 / 1.5);
  EXPECT_LE(law.width, 6.0 / 0.5);
  EXPECT_GE(law.centre, -2.0);
  EXPECT_LE(law.centre, 4.0);
  EXPECT_FALSE(drawn_unevenness(0.5, 0, Stage::link, travel, {1, 2, 3}).over_command);
  EXPECT_EQ(drawn_unevenness(0.5, 0, Stage::link, still, {1, 2, 3}).share, 0.0)
      << "a joint that never moves has no way along which to change";
}

TEST(Background, LeavesWhatIsAskedForAfterAPlainRefit) {
  for (const double beta : {0.7, 1.5}) {
    ConcealOptions options = unmoved();
    options.imperfections.background = beta;
    const Concealment made = conceal(two_rods(sine_drive(2, 8.0, 0.02, 2.0)), options);
    EXPECT_NEAR(made.left_rms_over_noise, beta, 0.06 * beta);
    EXPECT_GT(made.raw_rms_over_noise, made.left_rms_over_noise);
    EXPECT_TRUE(made.effects.empty());
  }
}

TEST(Background, PushesDifferFromRecordingToRecordingAndMoveEveryJoint) {
  const Scenario scenario = two_rods(sine_drive(2, 4.0, 0.02, 2.0));
  const Experiment experiment = make_experiment(scenario);
  const std::vector<double> sizes{0.3, 0.1};
  const Background background(sizes, {{{-1.0, 1.0}, {-1.0, 1.0}}, {}, {}}, 7);
  Segment first = experiment.segments[0], second = experiment.segments[1];
  std::vector<OutsidePhysics> outside;
  background.act(first, outside);
  background.act(second, outside);
  ASSERT_EQ(outside.size(), 4u);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_NEAR(outside[j].strength, std::sqrt(2.0) * sizes[j], 1e-12);
    EXPECT_GT(root_mean_square((*first.pushes)[j]), 0.2 * sizes[j]);
    EXPECT_LT(root_mean_square((*first.pushes)[j]), 2.5 * sizes[j]);
    EXPECT_GT(rms_difference((*first.pushes)[j], (*second.pushes)[j]), 0.2 * sizes[j]);
  }
  Segment again = experiment.segments[0];
  background.act(again, outside);
  EXPECT_EQ(*again.pushes, *first.pushes) << "the same seed, the same push";
  background.act(again, outside);
  for (std::size_t k = 0; k < (*again.pushes)[0].size(); ++k)
    EXPECT_NEAR((*again.pushes)[0][k], 2.0 * (*first.pushes)[0][k], 1e-12) << "what already acts stays";
  const Background one = background.only(1).times(3.0);
  std::vector<OutsidePhysics> alone;
  one.act(second, alone);
  EXPECT_EQ(alone[0].strength, 0.0);
  EXPECT_NEAR(alone[1].strength, 3.0 * outside[1].strength, 1e-12);
}

TEST(Background, PushesHaveTheirRmsOverALongTime) {
  // Sines of up to 20 s over 2000 s: two of nearly one period beat for as long as they differ little.
  constexpr double kBeats = 0.1;
  const Experiment experiment = make_experiment(two_rods(constant_drive(2, 2000.0, 0.5, 0.0)));
  const std::vector<double> sizes{0.3, 0.1};
  const Background background(sizes, {{{-1.0, 1.0}, {-1.0, 1.0}}, {}, {}}, 7);
  Segment segment = experiment.segments[0];
  std::vector<OutsidePhysics> outside;
  background.act(segment, outside);
  for (std::size_t j = 0; j < 2; ++j) EXPECT_NEAR(root_mean_square((*segment.pushes)[j]) / sizes[j], 1.0, kBeats) << j;
}

TEST(Drift, AnOffsetDiffersBetweenRecordingsByTheShareAtMost) {
  // At rest the rods stand where the offset puts them; gravity bends that by less than a twentieth.
  constexpr double kShare = 0.5, kBent = 0.05;
  const Scenario scenario = two_rods(constant_drive(2, 1.0, 0.02, 0.0));
  const auto stands_at = [&](double offset, double drift, std::size_t recording) {
    ConcealOptions options = unmoved();
    if (offset != 0.0) options.effects = {parse_hidden_effect("valve_offset:elbow:" + std::to_string(offset))};
    options.imperfections.drift = drift;
    const std::vector<double> q = column(conceal(scenario, options).scenario, recording, "q_elbow");
    return std::accumulate(q.begin(), q.end(), 0.0) / static_cast<double>(q.size());
  };
  const double none = stands_at(0.0, 0.0, 0), even = stands_at(0.4, 0.0, 0) - none;
  ASSERT_GT(std::fabs(even), 30.0 * kNoise);
  EXPECT_NEAR(stands_at(0.4, 0.0, 1) - none, even, kNoise);
  const double first = (stands_at(0.4, kShare, 0) - none) / even, second = (stands_at(0.4, kShare, 1) - none) / even;
  for (const double share : {first, second}) {
    EXPECT_GE(share, 1.0 - kShare - kBent);
    EXPECT_LE(share, 1.0 + kShare + kBent);
  }
  EXPECT_GT(std::fabs(first - second), 0.02);
}

TEST(Misplaced, EveryCentreOfMassIsOffByAtMostWhatIsSaid) {
  const Scenario scenario = two_rods(constant_drive(2, 1.0, 0.02, 0.0));
  const PlantModel plain(scenario);
  const auto shifts = misplaced_centres(0.05, plain, {}, 3);
  ASSERT_EQ(shifts.size(), 2u);
  std::set<double> values;
  for (const EffectSpec& shift : shifts) {
    EXPECT_EQ(shift.effect, "com_shift");
    EXPECT_EQ(shift.parameters.size(), 3u);
    for (const auto& [axis, value] : shift.parameters) {
      EXPECT_LE(std::fabs(value), 0.05);
      values.insert(value);
    }
  }
  EXPECT_EQ(values.size(), 6u) << "each is drawn";
  const std::vector<HiddenEffect> hidden{parse_hidden_effect("com_shift:elbow")};
  EXPECT_EQ(misplaced_centres(0.05, plain, hidden, 3).size(), 1u) << "the hidden one stays as it was asked for";
  ConcealOptions options = unmoved();
  options.imperfections.misplaced = 0.05;
  const Concealment made = conceal(two_rods(sine_drive(2, 4.0, 0.02, 2.0)), options);
  EXPECT_GT(made.raw_rms_over_noise, 3.0);
  EXPECT_TRUE(made.effects.empty());
}

TEST(Shortened, RecordingsEndAndOtherJointsStandStill) {
  const Scenario scenario = two_rods(sine_drive(2, 4.0, 0.02, 2.0));
  ConcealOptions options = unmoved();
  options.imperfections.seconds = 1.5;
  options.imperfections.alone = "elbow";
  const Concealment made = conceal(scenario, options);
  for (std::size_t r = 0; r < 2; ++r) {
    EXPECT_NEAR(column(made.scenario, r, "t").back(), 1.5, 1e-9);
    const std::vector<double> still = column(made.scenario, r, "u_shoulder"),
                              moved = column(made.scenario, r, "u_elbow");
    EXPECT_EQ(std::set<double>(still.begin(), still.end()).size(), 1u);
    EXPECT_EQ(still.front(), column(scenario, r, "u_shoulder").front());
    for (std::size_t k = 0; k < moved.size(); ++k) EXPECT_EQ(moved[k], column(scenario, r, "u_elbow")[k]);
  }
  options.imperfections.alone = "wrist";
  EXPECT_THROW(conceal(scenario, options), InputError);
}

TEST(Imperfections, EveryLawOfAJointMovesDifferentlyWhereItIsUnevenOrDrifts) {
  const Scenario scenario =
      conceal(two_rods(sine_drive(2, 3.0, 0.02, 2.0)), unmoved()).scenario;  // typical is of motion
  std::set<std::string> even, steady;
  for (const EffectInfo& info : effect_table()) {
    if (info.where != Where::joint || info.learned) continue;
    SCOPED_TRACE(info.name);
    ConcealOptions options = unmoved();
    options.effects = {parse_hidden_effect(std::string(info.name) + ":elbow")};
    const auto motion = [&](double uneven, double drift) -> std::vector<double> {
      options.imperfections.uneven = uneven, options.imperfections.drift = drift;
      try {
        return column(conceal(with_drives_for(info, scenario), options).scenario, 0, "q_elbow");
      } catch (const InputError&) {
        return {};  // refused
      }
    };
    const std::vector<double> exact = motion(0.0, 0.0), uneven = motion(0.5, 0.0), drifting = motion(0.0, 0.5);
    for (const auto* moved : {&exact, &uneven, &drifting})
      for (const double q : *moved) ASSERT_TRUE(std::isfinite(q));
    if (uneven.empty()) even.insert(info.name);
    if (drifting.empty()) steady.insert(info.name);
    // Relief valves of the typical size never open here, and a scale of efforts moves nothing.
    if (info.name == std::string("relief") || info.name == std::string("effort_scale")) continue;
    EXPECT_TRUE(uneven.empty() || rms_difference(exact, uneven) > 0.0);
    EXPECT_TRUE(drifting.empty() || rms_difference(exact, drifting) > 0.0);
  }
  for (const char* law :
       {"coulomb_friction", "valve_deadband", "actuator_saturation", "valve_offset", "lever_arm_variation"})
    EXPECT_FALSE(even.contains(law) || steady.contains(law)) << law;
  for (const char* law : {"com_shift", "armature", "input_delay", "sensor_offset", "end_stop"})
    EXPECT_TRUE(even.contains(law)) << law;
  EXPECT_TRUE(steady.contains("end_stop"));
}

}  // namespace
}  // namespace lacuna
