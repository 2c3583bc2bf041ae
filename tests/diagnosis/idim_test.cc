// The regression by base parameters, on efforts whose frictions are known.
#include "diagnosis/idim.h"

#include <gtest/gtest.h>

#include "tests/physics/efforts.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kEffortSensor = 0.05;     // N m, rms
constexpr double kCutoffOfEfforts = 10.0;  // Hz
constexpr double kFriction = 0.02;         // of a friction: noise leaves 0.3 %, a command held for 1 ms as much

struct Frictions {
  double viscous, coulomb, offset;
};
const std::vector<Frictions> kTrue{{0.5, 0.8, 0.4}, {0.3, 0.4, -0.2}};  // shoulder, elbow
const std::vector<std::string> kJoints{"shoulder", "elbow"};

/// Recordings of rods with friction, viscous and Coulomb's so many times kTrue; the scenario itself knows nothing of
/// it.
Scenario rubbing_rods(double viscous, double dry, double push) {
  std::vector<EffectSpec> effects;
  for (std::size_t j = 0; j < 2; ++j) {
    effects.push_back(effect("viscous_friction", kJoints[j], {{"D", viscous * kTrue[j].viscous}}));
    effects.push_back(effect("coulomb_friction", kJoints[j], {{"Fc", dry * kTrue[j].coulomb}}));
    effects.push_back(effect("torque_offset", kJoints[j], {{"tau0", kTrue[j].offset}}));
  }
  const std::map<std::string, double> lossless{{"gain", 1.0}};
  const Scenario truth = pushed_rods(effects, "direct_effort", lossless);
  Scenario out = pushed_rods({}, "direct_effort", lossless);
  out.prediction = InverseDynamics{kCutoffOfEfforts};
  int k = 0;
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    const Drive drive = sines_at(clock(12.0, 0.001), push, 7.3 * k);
    const std::string file = std::string(to_string(role)) + ".csv";
    add_recording(out, truth_recording(truth, drive, file, kEffortSensor, static_cast<std::uint64_t>(++k)), role);
  }
  return out;
}

double filtered_noise(const Experiment& experiment) {
  return kEffortSensor * filter_gain(ZeroPhaseLowPass(kCutoffOfEfforts, experiment.segments[0].motion->rate), 1).value;
}

TEST(Idim, ReturnsTheFrictionsThatActed) {
  const Scenario scenario = rubbing_rods(1.0, 1.0, 6.0);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const std::optional<Idim> idim = regress_base_parameters(model, experiment);
  ASSERT_TRUE(idim.has_value());
  EXPECT_EQ(idim->columns, 28);  // ten a link, four a joint
  ASSERT_EQ(idim->joints.size(), 2u);
  for (std::size_t j = 0; j < 2; ++j) {
    const IdimJoint& found = idim->joints[j];
    EXPECT_EQ(found.joint, kJoints[j]);
    EXPECT_NEAR(found.viscous / kTrue[j].viscous, 1.0, kFriction) << found.joint;
    EXPECT_NEAR(found.coulomb / kTrue[j].coulomb, 1.0, kFriction) << found.joint;
  }
  // At turning points the corner is rounded alike, but a little beside its place: the motion was filtered before.
  constexpr double kCorners = 0.15;
  ASSERT_EQ(idim->rms.size(), 3u);
  for (const auto& [role, rms] : idim->rms) {
    ASSERT_EQ(rms.size(), 2u);
    for (std::size_t j = 0; j < 2; ++j) EXPECT_LT(rms[j].second, kCorners * kTrue[j].coulomb) << rms[j].first;
  }
}

TEST(Idim, LeavesTheNoiseWhereAllIsLinear) {
  constexpr double kHeavilyDamped = 3.0;  // so that nothing swings faster than the filter lets pass
  const Scenario scenario = rubbing_rods(kHeavilyDamped, 0.0, 5.0);
  const Experiment experiment = make_experiment(scenario);
  const std::optional<Idim> idim = regress_base_parameters(PlantModel(scenario), experiment);
  ASSERT_TRUE(idim.has_value());
  EXPECT_EQ(idim->rms.back().first, Role::test);
  for (const auto& [role, rms] : idim->rms)
    for (const auto& [joint, left] : rms) {
      // Beside noise: what the held command and products of filtered signals leave.
      EXPECT_GT(left, 0.8 * filtered_noise(experiment)) << joint;
      EXPECT_LT(left, 2.0 * filtered_noise(experiment)) << joint;
    }
  for (std::size_t j = 0; j < 2; ++j) {
    const IdimJoint& found = idim->joints[j];
    EXPECT_NEAR(found.viscous / (kHeavilyDamped * kTrue[j].viscous), 1.0, kFriction) << found.joint;
    EXPECT_NEAR(found.coulomb, 0.0, 2.0 * kFriction * kTrue[j].coulomb) << found.joint;
  }
}

TEST(Idim, IsNothingWhereNoEffortIsPredicted) {
  Scenario scenario = rubbing_rods(1.0, 1.0, 6.0);
  scenario.prediction = FreeRun{};
  EXPECT_FALSE(regress_base_parameters(PlantModel(scenario), make_experiment(scenario)).has_value());
  // A valve's flow is no effort.
  scenario.prediction = InverseDynamics{kCutoffOfEfforts};
  scenario.channels.of.erase(ChannelKind::effort);
  for (ActuatorSpec& drive : scenario.actuators) {
    drive.model = "flow_source";
    drive.parameters = {{"gain", 0.4}, {"stiffness", 60.0}, {"damping", 3.0}};
  }
  EXPECT_FALSE(regress_base_parameters(PlantModel(scenario), make_experiment(scenario)).has_value());
}

}  // namespace
}  // namespace lacuna
