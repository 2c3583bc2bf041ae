// Efforts by inverse dynamics of a measured motion, against motions that another integrator made.
#include "physics/inverse_dynamics.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/physics/efforts.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kPushPeriod = 0.002;  // s
constexpr double kPushSeconds = 8.0;
constexpr double kPushCutoff = 15.0;  // Hz
constexpr double kPush = 6.0;         // N m, of the commands
/// Of an effort's rms: what the filter makes of products of signals, and half a period by which a command that is held
/// comes late (0.002 pi times 2 Hz: 1.2 % of its fastest part, a third of the whole).
constexpr double kLeft = 0.015;

void measure_drive_side(Scenario& scenario) {
  for (const char* joint : {"shoulder", "elbow"})
    scenario.channels.of[ChannelKind::motor_position][joint] = {std::string("m_") + joint, 1.0, 0.0, ""};
}

/// Intervals of 0.5 to 1.5 periods.
std::vector<double> shaken_clock() {
  Noise random(5);
  std::vector<double> time{0.0};
  while (time.back() < kPushSeconds) time.push_back(time.back() + kPushPeriod * (0.5 + random.uniform()));
  return time;
}

Drive push(double amplitude = kPush) { return sines_at(clock(kPushSeconds, kPushPeriod), amplitude); }

/// The scenario with one recording of itself.
Scenario recorded_truth(Scenario truth, const Drive& drive) {
  add_recording(truth, truth_recording(truth, drive, "run.csv"));
  truth.prediction = InverseDynamics{kPushCutoff};
  return truth;
}

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) out[k] = a[k] - b[k];
  return out;
}

/// Largest rms over channels of predicted minus measured, over the measured signal's rms.
double share_left(const Scenario& scenario) {
  const Experiment experiment = make_experiment(scenario);
  const auto predicted = predict_one(PlantModel(scenario), experiment, on("featherstone", 0.005)).front();
  double worst = 0.0;
  for (std::size_t c = 0; c < predicted.size(); ++c) {
    const std::vector<double>& measured = experiment.segments[0].measured[c];
    worst = std::max(worst, rms_of(difference(predicted[c], measured)) / rms_of(measured));
  }
  return worst;
}

TEST(NeededEffort, IsTheMeasuredOneAtTheTrueNumbers) {
  const Scenario scenario = recorded_truth(pushed_rods(), push());
  const Experiment experiment = make_experiment(scenario);
  ASSERT_EQ(experiment.channels.size(), 2u);
  for (const Channel& channel : experiment.channels) EXPECT_EQ(channel.kind, ChannelKind::effort);
  EXPECT_LT(share_left(scenario), kLeft);
  Scenario wrong = scenario;
  wrong.actuators[0].parameters["damping"] = 1.0;
  EXPECT_GT(share_left(wrong), 3.0 * kLeft) << "a wrong damping must show";
}

TEST(NeededEffort, IsTheMeasuredOneOnAnIrregularClockToo) {
  const std::vector<double> time = shaken_clock();
  ASSERT_FALSE(is_even(time));
  EXPECT_LT(share_left(recorded_truth(pushed_rods(), sines_at(time, kPush))), kLeft);
}

/// Rotor inertias by least squares on what a model without them leaves, kg m^2: efforts are linear in them.
Eigen::Vector2d regressed_armatures(const Scenario& scenario) {
  const Experiment experiment = make_experiment(scenario);
  Scenario bare = scenario;
  bare.effects = {effect("armature", "shoulder", {{"J", 0.0}}), effect("armature", "elbow", {{"J", 0.0}})};
  const PlantModel model(bare);
  std::vector<std::vector<double>> values(3, model.values());
  values[1][model.find("shoulder.armature.J")] = 1.0;
  values[2][model.find("elbow.armature.J")] = 1.0;
  const Predictions predicted = predict(model, experiment, values, on("featherstone", 0.005));
  const auto n = static_cast<Eigen::Index>(experiment.segments[0].compared.size());
  Eigen::MatrixXd slopes(2 * n, 2);
  Eigen::VectorXd rest(2 * n);
  for (Eigen::Index c = 0; c < 2; ++c)
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto at = [&](std::size_t i) { return predicted[i][0][c][k]; };
      slopes.row(c * n + k) << at(1) - at(0), at(2) - at(0);
      rest(c * n + k) = experiment.segments[0].measured[c][k] - at(0);
    }
  return slopes.colPivHouseholderQr().solve(rest);
}

TEST(NeededEffort, GivesInertiasAlikeFromEvenAndIrregularClocks) {
  const Eigen::Vector2d truth(0.2, 0.05);  // kg m^2
  constexpr double kShare = 0.02;          // accelerations that an uneven clock spoils cost 8 to 33 %
  const Scenario model =
      pushed_rods({effect("armature", "shoulder", {{"J", truth(0)}}), effect("armature", "elbow", {{"J", truth(1)}})});
  for (const bool speeds : {true, false}) {
    for (const std::vector<double>& time : {clock(kPushSeconds, kPushPeriod), shaken_clock()}) {
      Scenario scenario = recorded_truth(model, sines_at(time, kPush));
      if (!speeds) scenario.channels.of.erase(ChannelKind::velocity);
      const Eigen::Vector2d found = regressed_armatures(scenario);
      for (Eigen::Index j = 0; j < 2; ++j)
        EXPECT_NEAR(found(j) / truth(j), 1.0, kShare) << "joint " << j << (is_even(time) ? ", even" : ", irregular");
    }
  }
}

/// An oil spring that a rod's weight bends by some tenths of a radian.
const std::map<std::string, double> kOil{{"gain", 0.4}, {"stiffness", 60.0}, {"damping", 3.0}};

TEST(OilSpring, IsCarriedAlongTheMotion) {
  // Told by flow: what the drive gives is known only with what has flowed. Both signals, the effort and the command.
  Scenario scenario = recorded_truth(pushed_rods({}, "flow_source", kOil), push(2.0));
  EXPECT_LT(share_left(scenario), kLeft) << "efforts";
  scenario.channels.of.erase(ChannelKind::effort);
  const Experiment experiment = make_experiment(scenario);
  for (const Channel& channel : experiment.channels) ASSERT_EQ(channel.kind, ChannelKind::command);
  EXPECT_LT(share_left(scenario), 0.05) << "commands: efforts of 10 N m over a gain of 0.4";
  Scenario stiffer = scenario;
  for (ActuatorSpec& drive : stiffer.actuators) drive.parameters["stiffness"] *= 1.5;
  EXPECT_GT(share_left(stiffer), 0.5) << "the spring must matter";
}

TEST(Cylinder, GivesTheEffortThatItsMotionNeeds) {
  // Whatever the pressures carried along the motion come to: measured behind them, the effort is the motion's own.
  const std::map<std::string, double> cylinder{
      {"gain", 2e-9},          {"full_command", 2.0}, {"area_a", 2e-4},
      {"area_b", 1.5e-4},      {"ratio", 0.02},       {"dead_volume_a", 1e-6},
      {"dead_volume_b", 1e-6}, {"stroke", 0.2},       {"supply_pressure", 1.6e7},
      {"return_pressure", 5e5}};
  const Scenario scenario = recorded_truth(pushed_rods({}, "hydraulic", cylinder), push(2.0));
  EXPECT_LT(share_left(scenario), kLeft);
}

TEST(DriveSide, LeadsTheLinkByTheEffortThatBendsTheJoint) {
  constexpr double kSpringRate = 200.0;  // N m/rad
  Scenario model = pushed_rods(
      {effect("joint_compliance", "shoulder", {{"k", kSpringRate}, {"J", 0.002}, {"c", 0.3}}),
       effect("viscous_friction", "shoulder", {{"D", 1.0}}), effect("viscous_friction", "elbow", {{"D", 0.8}})},
      "direct_effort", {{"gain", 1.0}});
  measure_drive_side(model);
  const Scenario scenario = recorded_truth(model, push());
  const Experiment experiment = make_experiment(scenario);
  ASSERT_EQ(experiment.channels.size(), 4u);
  const auto predicted = predict_one(PlantModel(scenario), experiment, on("featherstone", 0.005)).front();
  const Segment& segment = experiment.segments[0];
  const ZeroPhaseLowPass filter(kPushCutoff, segment.motion->rate);
  for (int joint = 0; joint < 2; ++joint) {
    std::vector<double> q = segment.motion->q[joint];
    filter.apply(q);
    std::size_t effort = 0, side = 0;
    for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
      if (experiment.channels[c].joint != joint) continue;
      (experiment.channels[c].kind == ChannelKind::effort ? effort : side) = c;
    }
    ASSERT_EQ(experiment.channels[side].kind, ChannelKind::motor_position);
    std::vector<double> lead, expected, measured;
    for (std::size_t k = 0; k < segment.compared.size(); ++k) {
      lead.push_back(predicted[side][k] - q[segment.compared[k]]);
      measured.push_back(segment.measured[side][k] - q[segment.compared[k]]);
      expected.push_back(joint == 0 ? segment.measured[effort][k] / kSpringRate : 0.0);
    }
    if (joint == 1) {
      EXPECT_LT(rms_of(lead), 1e-12) << "no transmission: the link's own";
      continue;
    }
    // Between spring and drive stand the rotor's inertia and the spring's damper: J a and c e' over k, some percent.
    constexpr double kBetween = 0.1;
    EXPECT_LT(rms_of(difference(lead, expected)), kBetween * rms_of(expected));
    EXPECT_LT(rms_of(difference(lead, measured)), kBetween * rms_of(measured));
  }
}

/// The effect where it may stand, at the first of its starting sizes (over sizes of 1).
EffectSpec at_its_start(const EffectInfo& info, const Robot& robot) {
  const bool arm = info.where == Where::arm;
  EffectSpec out = effect(info.name, arm ? "arm" : "shoulder", {});
  for (const EffectParameter& p : effect_parameters(info, robot, arm ? -1 : 0))
    if (!p.info->optional && !p.info->starts.empty()) out.parameters[p.key] = p.info->starts.front();
  return out;
}

TEST(MeasuredSignals, AreWhatTheyAreWhateverTheModelHolds) {
  const Scenario scenario = recorded_truth(pushed_rods(), sines_at(shaken_clock(), kPush));
  const Experiment bare = make_experiment(scenario);
  for (const EffectInfo& info : effect_table()) {
    Scenario holds = with_drives_for(info, scenario);
    holds.effects = {at_its_start(info, *holds.robot)};
    const PlantModel model(holds);
    const Experiment with = make_experiment(holds);
    predict_one(model, with, on("featherstone", 0.005));
    EXPECT_TRUE(same_bits(with.segments[0].measured, bare.segments[0].measured)) << info.name;
    EXPECT_TRUE(same_bits(with.segments[0].motion->q, bare.segments[0].motion->q)) << info.name;
    EXPECT_TRUE(same_bits(with.segments[0].motion->a, bare.segments[0].motion->a)) << info.name;
  }
}

TEST(NeededEffort, AsksForThePositionOfEveryJoint) {
  Scenario scenario = recorded_truth(pushed_rods(), push());
  scenario.channels.of[ChannelKind::position].erase("elbow");
  const std::string error = input_error([&] { make_experiment(scenario); });
  EXPECT_NE(error.find("elbow"), std::string::npos) << error;
  EXPECT_NE(error.find("position"), std::string::npos) << error;
}

}  // namespace
}  // namespace lacuna
