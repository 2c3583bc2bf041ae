// With pressures measured, what is concealed in one part of the chain shows in that part and in no other.
#include "diagnosis/chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/candidates.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kAngleNoise = 3e-4, kPressureNoise = 1e4, kPeriod = 0.01;  // rad, Pa, s
// Sanitized code is some thirty times slower: the same paths over fewer seconds.
#if defined(__SANITIZE_ADDRESS__)
constexpr double kSeconds = 18.0;
#else
constexpr double kSeconds = 45.0;
#endif

/// Rotary actuators on the double pendulum; the elbow's oil rings some 6 times a second.
std::map<std::string, double> rotary() {
  return {{"gain", 4e-9},           {"full_command", 10.0},      {"area_a", 2e-5},
          {"area_b", 2e-5},         {"dead_volume_a", 2e-5},     {"dead_volume_b", 2e-5},
          {"stroke", 6.0},          {"bulk_modulus", 1.4e9},     {"supply_pressure", 80e5},
          {"return_pressure", 5e5}, {"hose_compliance", 6.7e-9}, {"leakage", 1e-14}};
}

/// A third of the time the shoulder alone, a third the elbow alone, a third both; slow enough for the filter.
Drive in_turn() {
  Drive out{clock(kSeconds, kPeriod), {}};
  for (int joint = 0; joint < 2; ++joint) {
    std::vector<double> u;
    for (const double t : out.time) {
      const int third = std::min(2, static_cast<int>(3.0 * t / kSeconds));
      const bool on = third == joint || third == 2;
      u.push_back(on ? 5.0 * std::sin(2.0 * std::numbers::pi * (0.35 + 0.1 * joint) * t) : 0.0);
    }
    out.u.push_back(std::move(u));
  }
  return out;
}

Scenario model_of(const std::string& actuator_model, const std::map<std::string, double>& parameters) {
  const auto robot = bundled_robot("double_pendulum/double_pendulum.urdf");
  Scenario out = bare_scenario(
      robot, {actuator("shoulder", actuator_model, parameters), actuator("elbow", actuator_model, parameters)}, false);
  for (const char* joint : {"shoulder", "elbow"}) {
    out.effects.push_back(effect("viscous_friction", joint, {{"D", 3.0}}));
    for (const auto& [kind, prefix] : {std::pair{ChannelKind::pressure_a, "a_"}, {ChannelKind::pressure_b, "b_"}})
      out.channels.of[kind][joint] = {prefix + std::string(joint), 1.0, 0.0, ""};
    out.noise[ChannelKind::position][joint] = kAngleNoise;
  }
  return out;
}

/// Positions and pressures that `truth`, hydraulic, gives on another engine than the one that identifies, with noise.
std::shared_ptr<const Recording> recorded(Scenario truth, const std::string& file, std::uint64_t seed) {
  const Start start{{0.3, 0.4}, {0.0, 0.0}, false};
  auto data = recording_of(*truth.robot, in_turn(), start, file);
  for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b})
    for (const auto& [joint, column] : truth.channels.of.at(kind)) {
      data->names.push_back(column.column);
      data->columns.emplace_back(data->rows(), kMissing);
    }
  truth.noise.clear();
  add_recording(truth, data);
  const Experiment experiment = started_experiment(truth, start);
  const auto predicted = predict_one(PlantModel(truth), experiment, on(engine_of_data(), 0.001)).front();
  Noise random(seed);
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const std::string& joint = experiment.joint_names[channel.joint];
    const double noise = channel.kind == ChannelKind::position ? kAngleNoise : kPressureNoise;
    const std::string name =
        channel.kind == ChannelKind::position ? "q_" + joint : truth.channels.of.at(channel.kind).at(joint).column;
    auto& column = data->columns[data->find(name)];
    for (std::size_t k = 0; k < column.size(); ++k) column[k] = predicted[c][k] + noise * random();
  }
  return data;
}

std::vector<JointChain> chains(Scenario model, const Scenario& truth) {
  add_recording(model, recorded(truth, "train.csv", 3));
  add_recording(model, recorded(truth, "test.csv", 4), Role::test);
  const PlantModel plant(model);
  const CurrentModel current{plant, SearchSpace(plant, model), {}, {}};
  return joint_chains(current, current, model, {make_experiment(model), on("featherstone", 0.002)}, 1);
}
/// The hydraulic model's chains on recordings in which `concealed` was added to it.
std::vector<JointChain> with(const std::vector<EffectSpec>& concealed,
                             const std::map<std::string, double>& other_parameters = {}) {
  Scenario truth = model_of("hydraulic", rotary());
  for (const EffectSpec& each : concealed) truth.effects.push_back(each);
  for (ActuatorSpec& each : truth.actuators)
    for (const auto& [name, value] : other_parameters) each.parameters[name] = value;
  return chains(model_of("hydraulic", rotary()), truth);
}

/// "shoulder.command_to_flow shoulder.supply": what fails, in order.
std::string failing(const std::vector<JointChain>& found) {
  std::string out;
  for (const JointChain& chain : found)
    for (const PartFit& part : chain.parts)
      if (part.fails()) out += (out.empty() ? "" : " ") + chain.joint + "." + to_string(part.part);
  return out;
}

TEST(Chain, HoldsThroughoutWhereNothingIsMissing) {
  const auto found = with({});
  ASSERT_EQ(found.size(), 2u);
  for (const JointChain& chain : found) {
    EXPECT_TRUE(chain.areas_given);
    for (const PartFit& part : chain.parts) {
      SCOPED_TRACE(chain.joint + " " + to_string(part.part));
      EXPECT_EQ(part.why_not, "");
      EXPECT_FALSE(part.fails());
      EXPECT_FALSE(part.still_fails());
      EXPECT_GT(part.before, 0.5 * part.noise);
      if (part.part != ChainPart::flow_to_pressure) {
        EXPECT_GT(part.signal, part.noise);
      }
    }
  }
}

TEST(Chain, FailsAtTheValveThatHasAnOverlap) {
  EXPECT_EQ(failing(with({effect("valve_deadband", "shoulder", {{"d", 1.0}})})), "shoulder.command_to_flow");
}

TEST(Chain, FailsBehindThePressuresWhereALinkRubs) {
  EXPECT_EQ(failing(with({effect("coulomb_friction", "elbow", {{"Fc", 2.0}, {"v0", 0.01}})})),
            "elbow.pressure_to_motion");
}

TEST(Chain, FailsAtTheChambersThatLeakMore) {
  const auto found = with({}, {{"leakage", 4e-13}});
  for (const JointChain& chain : found) {
    EXPECT_TRUE(chain.parts[2].fails()) << chain.joint;
    EXPECT_FALSE(chain.parts[3].fails()) << chain.joint;
  }
}

TEST(Chain, FailsAtTheSupplyThatTwoJointsShare) {
  const std::map<std::string, double> pump{{"n", 8.0}, {"full_shoulder", 8.0}, {"full_elbow", 8.0}};
  EXPECT_EQ(failing(with({effect("shared_supply", "arm", pump)})), "shoulder.supply elbow.supply");
}

TEST(Chain, OfAnActuatorWithoutAreasFitsThem) {
  const auto found = chains(model_of("flow_source", {{"gain", 0.06}, {"damping", 20.0}, {"stiffness", 3000.0}}),
                            model_of("hydraulic", rotary()));
  ASSERT_EQ(found.size(), 2u);
  for (const JointChain& chain : found) {
    SCOPED_TRACE(chain.joint);
    EXPECT_FALSE(chain.areas_given);
    EXPECT_TRUE(chain.parts[0].fails()) << "the flow's gain is another one";
    EXPECT_NE(chain.parts[2].why_not, "");
    EXPECT_EQ(chain.parts[3].why_not, "");
    EXPECT_FALSE(chain.parts[3].fails()) << chain.parts[3].before << " over " << chain.parts[3].noise;
  }
}

TEST(Chain, NeedsBothPressuresOfAJointAndSamplesThatShowItsMotion) {
  Scenario truth = model_of("hydraulic", rotary()), one = truth;
  one.channels.of.at(ChannelKind::pressure_b).erase("elbow");
  const auto found = chains(one, truth);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].joint, "shoulder");
  EXPECT_EQ(found[0].parts[0].why_not, "");

  Scenario slow = model_of("flow_source", {{"gain", 0.06}, {"damping", 20.0}, {"stiffness", 3000.0}});
  auto data = std::make_shared<Recording>(*recorded(truth, "test.csv", 4));
  for (auto& column : data->columns) {  // 5 Hz
    for (std::size_t k = 0; 20 * k < column.size(); ++k) column[k] = column[20 * k];
    column.resize(column.size() / 20);
  }
  add_recording(slow, data, Role::test);
  const PlantModel plant(slow);
  const CurrentModel current{plant, SearchSpace(plant, slow), {}, {}};
  for (const JointChain& chain :
       joint_chains(current, current, slow, {make_experiment(slow), on("featherstone", 0.002)}, 1))
    for (const PartFit& part : chain.parts) EXPECT_NE(part.why_not, "") << to_string(part.part);
}

TEST(Chain, IsNotJudgedWherePositionsArePredictedFromPressuresOrNotAtAll) {
  Scenario model = model_of("hydraulic", rotary());
  add_recording(model, recorded(model, "train.csv", 3));
  add_recording(model, recorded(model, "test.csv", 4), Role::test);
  model.pressure_driven = true;
  const PlantModel plant(model);
  const CurrentModel current{plant, SearchSpace(plant, model), {}, {}};
  EXPECT_TRUE(joint_chains(current, current, model, {make_experiment(model), on("featherstone", 0.002)}, 1).empty());
}

}  // namespace
}  // namespace lacuna
