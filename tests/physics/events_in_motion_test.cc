// Events in motion: what they do in closed form, in windows and packs, on every engine and by both integrators.
#include <gtest/gtest.h>

#include "physics/truth.h"
#include "tests/physics/event_plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kRoundingOfAPush = 1e-11;  // rad, rad/s, m: of some hundred exact steps
constexpr double kOfAMotion = 1e-8;         // engines' agreement, relative
constexpr double kOfOdesMotion = 1e-3;      // of it: accelerations good to 1e-5 of theirs, added up over 2 s

TEST(Push, GivesAFreeRodItsImpulseOverTheInertiaOnEveryEngine) {
  const FreeRod rod;
  const Experiment experiment = started_experiment(rod.scenario, rod.start);
  const Segment& segment = experiment.segments[0];
  for (const Event& push : {push_on(0, 0.5, 0.9, 2.0), push_on(0, 0.513, 0.897, -1.5), push_on(0, 0.504, 0.515, 8.0),
                            push_on(0, 0.5, 0.9, 2.0, 0.2), push_on(0, 0.503, 0.931, 2.0, 0.11)}) {
    const double speed = push.value * (push.end - push.begin - push.rise) / FreeRod::kInertia;
    for (const std::string& engine : available_engines()) {
      const auto moved = rod.moved(experiment, push, engine).front();
      const double close = (engine == "ode" ? kOfOdesMotion : kOfAMotion) * std::fabs(speed);
      for (std::size_t k = 0; k < segment.count; ++k) {
        const double t = segment.time(k);
        if (t > push.begin && t < push.end) continue;
        EXPECT_NEAR(moved[1][k], t < push.end ? 0.0 : speed, close) << engine << " at " << t << " s";
      }
    }
  }
}

TEST(Push, MovesAFreeRodAsAConstantAccelerationDoes) {
  const FreeRod rod;
  const Experiment experiment = started_experiment(rod.scenario, rod.start);
  const auto moved = rod.moved(experiment, push_on(0, 0.5, 0.9, 2.0)).front();
  const double a = 2.0 / FreeRod::kInertia;
  for (std::size_t k = 0; k < experiment.segments[0].count; ++k) {
    const double t = experiment.segments[0].time(k), in = std::clamp(t - 0.5, 0.0, 0.4), out = std::max(t - 0.9, 0.0);
    EXPECT_NEAR(moved[0][k], 0.3 + 0.5 * a * in * in + a * in * out, kRoundingOfAPush) << k;
    EXPECT_NEAR(moved[1][k], a * in, kRoundingOfAPush) << k;
  }
}

TEST(Push, TearsABlockLooseWhereItOutdoesTheFrictionOnly) {
  constexpr double kHolds = 5.0;  // N
  const Start start{{0.0}, {0.0}};
  const Scenario scenario =
      driven_scenario(block_robot(), {actuator("slide", "direct_effort", {{"gain", 1.0}, {"damping", 0.0}})},
                      constant_drive(1, 2.0, 0.01, 0.0), start);
  const PlantModel model = PlantModel(scenario).with_effects({effect("coulomb_friction", "slide", {{"Fc", kHolds}})});
  const auto speed_under = [&](double effort) {
    Experiment experiment = started_experiment(scenario, start);
    add_event(experiment.segments[0], push_on(0, 0.5, 1.0, effort));
    return predict_one(model, experiment, on("featherstone", 0.005)).front()[1];
  };
  for (const double v : speed_under(0.8 * kHolds)) EXPECT_EQ(v, 0.0);
  const std::vector<double> v = speed_under(7.0), time = clock(2.0, 0.01);
  for (std::size_t k = 0; k < v.size(); ++k) {
    // Up at (7 - 5) / 2, down at 5 / 2 m/s^2.
    const double up = (7.0 - kHolds) / kBlockMass * std::clamp(time[k] - 0.5, 0.0, 0.5);
    const double down = kHolds / kBlockMass * std::max(time[k] - 1.0, 0.0);
    EXPECT_NEAR(v[k], std::max(up - down, 0.0), 1e-9) << "sample " << k;
  }
}

/// The block's scenario, but that other commands were recorded from sample `first` to before `end`.
Scenario recorded_otherwise(const Scenario& scenario, std::size_t first, std::size_t end, double value) {
  Scenario out = scenario;
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  std::vector<double>& u = data->columns[data->find("u_slide")];
  for (std::size_t k = first; k < end; ++k) u[k] = value;
  out.recordings[0].data = data;
  return out;
}

/// Whether an event moves the block as if that command had been recorded.
void expect_as_if_recorded(const Prediction& prediction, std::size_t first, std::size_t end, double value,
                           const std::vector<EffectSpec>& effects) {
  SprungBlock block;
  block.scenario.prediction = prediction;
  const Scenario otherwise = recorded_otherwise(block.scenario, first, end, value);
  const PlantModel model = PlantModel(block.scenario).with_effects(effects);
  Experiment experiment = started_experiment(block.scenario, block.start);
  const auto plain = predict_one(model, experiment, on("featherstone", 0.005));
  const double begin = block.drive.time[first], stop = block.drive.time[end];
  for (Segment& segment : experiment.segments) add_event(segment, command_of(0, begin, stop, value));
  const auto moved = predict_one(model, experiment, on("featherstone", 0.005));
  const auto expected = predict_one(model, started_experiment(otherwise, block.start), on("featherstone", 0.005));
  ASSERT_EQ(moved.size(), expected.size());
  for (std::size_t s = 0; s < moved.size(); ++s) EXPECT_TRUE(same_bits(moved[s], expected[s])) << "segment " << s;
  EXPECT_FALSE(same_bits(moved, plain)) << "nothing was tested";
}

const EffectSpec kLateCommand = effect("input_delay", "slide", {{"T", 0.013}});

TEST(CommandEvent, IsAsIfNothingOrTheLastOneHadBeenRecorded) {
  const double last = SprungBlock().drive.u[0][119];
  for (const double value : {0.0, last}) {
    expect_as_if_recorded(FreeRun{}, 120, 150, value, {});
    expect_as_if_recorded(FreeRun{}, 120, 150, value, {kLateCommand});
  }
}

TEST(CommandEvent, ActsInEveryWindowThatItReachesInto) {
  expect_as_if_recorded(Windows{1.0}, 180, 220, 0.0, {});
  expect_as_if_recorded(Windows{1.0}, 180, 220, 0.0, {kLateCommand});
}

TEST(CommandEvent, IsStillOnItsWayWhenTheNextWindowBegins) {
  expect_as_if_recorded(Windows{1.0}, 180, 200, 0.0, {kLateCommand});
}

TEST(Push, ActsInEveryWindowThatItReachesInto) {
  FreeRod rod;
  rod.scenario.prediction = Windows{0.5};
  const Experiment experiment = started_experiment(rod.scenario, rod.start);
  ASSERT_EQ(experiment.segments.size(), 4u);
  const auto moved = rod.moved(experiment, push_on(0, 0.9, 1.3, 2.0, 0.1));
  // Each starts at rest: the second one has the rise, the third one the rest of the 2 (0.4 - 0.1) N m s.
  const double gained[] = {0.0, 0.1, 0.5, 0.0};
  for (std::size_t s = 0; s < 4; ++s)
    EXPECT_NEAR(moved[s][1].back(), gained[s] / FreeRod::kInertia, kRoundingOfAPush) << "window " << s;
}

TEST(Slip, ShiftsTheStartOfWindowsThatBeginInIt) {
  FreeRod rod;
  rod.scenario.prediction = Windows{0.5};
  const Experiment plain = make_experiment(rod.scenario);
  rod.scenario.events = {event_spec(EventSpec::Kind::reading, "swing", 0.75, 1.25, 0.02)};
  const Experiment with = make_experiment(rod.scenario);
  ASSERT_EQ(with.segments.size(), 4u);
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_EQ(with.segments[s].q0[0], plain.segments[s].q0[0] - (s == 2 ? 0.02 : 0.0)) << "window " << s;
    EXPECT_EQ(with.segments[s].slips != nullptr, s == 1 || s == 2) << "window " << s;
    EXPECT_TRUE(same_bits(with.segments[s].measured, plain.segments[s].measured)) << "what was measured stays";
  }
}

/// Predictions of both rods where the elbow's position is read `slip` too much before sample `end` from `first` on.
void expect_slip(const std::vector<std::vector<double>>& moved, const std::vector<std::vector<double>>& plain,
                 std::size_t first, std::size_t end, double slip) {
  ASSERT_EQ(moved.size(), 4u);
  for (std::size_t k = 0; k < moved[1].size(); ++k)
    EXPECT_EQ(moved[1][k], plain[1][k] + (k >= first && k < end ? slip : 0.0)) << "sample " << k;
  for (const std::size_t c : {0, 2, 3}) EXPECT_TRUE(same_bits(moved[c], plain[c])) << "channel " << c;
}

TEST(Slip, IsAddedToItsPositionAndToNothingElse) {
  const DrivenRods rods;
  const Segment& segment = rods.experiment.segments[0];
  const Experiment with = rods.with({slip_of(1, segment.time(50), segment.time(120), 0.03)});
  expect_slip(predict_one(rods.model, with, on("featherstone", 0.005)).front(),
              predict_one(rods.model, rods.experiment, on("featherstone", 0.005)).front(), 50, 120, 0.03);
}

TEST(Slip, IsTakenOffTheStartThatWasReadWithIt) {
  const DrivenRods rods;
  const Experiment with = rods.with({slip_of(1, -1.0, rods.experiment.segments[0].time(120), 0.03)});
  Experiment shifted = rods.experiment;
  shifted.segments[0].q0[1] -= 0.03;
  expect_slip(predict_one(rods.model, with, on("featherstone", 0.005)).front(),
              predict_one(rods.model, shifted, on("featherstone", 0.005)).front(), 0, 120, 0.03);
}

std::vector<Event> one_of_each_kind_on_rods() {
  return {push_on(1, 0.513, 0.787, 2.0, 0.1), push_on(0, 0.6, 1.1, -3.0), command_of(0, 0.3, 0.5, 0.0),
          slip_of(1, -1.0, 0.9, 0.05)};
}

TEST(EventsInMotion, AreTheSameByBothIntegrators) {
  // Of a fourth-order method at steps of 0.25 ms and one that keeps to 1e-8 a step, over 2 s.
  constexpr double kOfBoth = 1e-5;
  const DrivenRods rods;
  const auto plain = predict_one(rods.model, rods.experiment, on("featherstone", 2.5e-4)).front();
  TruthOptions options;
  options.engine = "featherstone";
  options.settle = false;
  for (const Event& event : one_of_each_kind_on_rods()) {
    const Experiment with = rods.with({event});
    const auto rollout = predict_one(rods.model, with, on("featherstone", 2.5e-4)).front();
    const auto truth = simulate_truth(rods.model, with.segments[0], with.channels, rods.model.values(), options);
    double moved = 0.0;
    for (std::size_t c = 0; c < truth.size(); ++c) {
      EXPECT_LT(worst_difference(truth[c], rollout[c]), kOfBoth) << "channel " << c << " from " << event.begin;
      moved = std::max(moved, worst_difference(plain[c], rollout[c]));
    }
    EXPECT_GT(moved, 1e-2) << "nothing was tested";
  }
}

TEST(EventsInMotion, AreTheSameOnEveryEngine) {
  const DrivenRods rods;
  const Experiment with = rods.with(one_of_each_kind_on_rods());
  const auto reference = predict_one(rods.model, with, on("featherstone", 0.002)).front();
  const auto plain = predict_one(rods.model, rods.experiment, on("featherstone", 0.002)).front();
  for (const std::string& engine : available_engines()) {
    const auto other = predict_one(rods.model, with, on(engine, 0.002)).front();
    for (std::size_t c = 0; c < reference.size(); ++c) {
      const double size = worst_difference(reference[c], std::vector<double>(reference[c].size(), 0.0));
      EXPECT_LT(worst_difference(other[c], reference[c]), (engine == "ode" ? kOfOdesMotion : kOfAMotion) * size)
          << engine << " channel " << c;
      EXPECT_GT(worst_difference(plain[c], reference[c]), 1e-2 * size) << "nothing was tested";
    }
  }
}

TEST(EventsInMotion, OfOneRecordingLeaveTheOthersOfAPackAsTheyAre) {
  SprungBlock block;  // with a second recording: both are simulated in one pack
  const Drive later = sine_drive(1, 3.0, 0.01, 4.0, 5.0);
  add_recording(block.scenario, recording_of(*block.scenario.robot, later, block.start, "second.csv"));
  const PlantModel model =
      PlantModel(block.scenario).with_effects({effect("coulomb_friction", "slide", {{"Fc", 1.0}})});
  const Experiment plain = started_experiment(block.scenario, block.start);
  for (const std::size_t pushed : {0, 1}) {
    Experiment together = plain;
    add_event(together.segments[pushed], push_on(0, 0.513, 0.787, 5.0, 0.1));
    const auto moved = predict_one(model, together, on("featherstone", 0.002));
    for (const std::size_t s : {0, 1}) {
      Experiment alone = together;
      alone.segments = {together.segments[s]};
      EXPECT_TRUE(same_bits(moved[s], predict_one(model, alone, on("featherstone", 0.002)).front()))
          << "segment " << s << " beside a push in " << pushed;
    }
    EXPECT_FALSE(same_bits(moved, predict_one(model, plain, on("featherstone", 0.002)))) << "nothing was tested";
  }
}

TEST(EventsInMotion, AreInTheMotionThatAPlantIsLinearisedAbout) {
  constexpr double kSmallPush = 1e-4;  // N m, of efforts of the order of one: the response is linear to that share
  const DrivenRods rods;
  const std::vector<Event> large = one_of_each_kind_on_rods();
  const Event small = push_on(1, 0.613, 0.907, kSmallPush, 0.05);
  const Experiment with = rods.with(large);
  const std::vector<int> one{0};
  const auto motion =
      make_simulator(rods.model, with, on("featherstone", 0.01))->linearise(rods.model.values(), one, {1.0, 1.0});
  const std::vector<double> means = mean_of_intervals(with.segments[0], small);
  const Eigen::MatrixXd efforts = kSmallPush * Eigen::Map<const Eigen::RowVectorXd>(means.data(), means.size());
  const Eigen::MatrixXd response = motion.front().responses_at(1, efforts).front();
  Experiment more = with;
  add_event(more.segments[0], small);
  const auto before = predict_one(rods.model, with, on("featherstone", 0.01)).front();
  const auto after = predict_one(rods.model, more, on("featherstone", 0.01)).front();
  for (std::size_t c = 0; c < 4; ++c) {
    double missed = 0.0, all = 0.0;
    for (std::size_t k = 0; k < after[c].size(); ++k) {
      const double change = after[c][k] - before[c][k];
      all += change * change;
      missed += std::pow(change - response(c, k), 2);
    }
    EXPECT_GT(all, 0.0);
    EXPECT_LT(std::sqrt(missed / all), 1e-3) << "channel " << c;
  }
}

}  // namespace
}  // namespace lacuna
