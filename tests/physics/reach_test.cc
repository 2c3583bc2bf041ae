#include "physics/reach.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

/// Names of the parameters that stay at their joint.
std::set<std::string> staying(const Prediction& prediction, std::vector<EffectSpec> effects,
                              const std::string& drive = "torque_source") {
  const auto driven = [&](const std::string& joint) {
    return actuator(joint, drive, {{"gain", 3.0}, {"stiffness", 4.0}, {"damping", 1.0}});
  };
  Scenario scenario = bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                                    {driven("shoulder"), driven("elbow")}, false);
  scenario.effects = std::move(effects);
  const PlantModel model(scenario);
  const std::vector<bool> stays = stays_at_its_joint(model, prediction);
  std::set<std::string> out;
  for (std::size_t i = 0; i < stays.size(); ++i)
    if (stays[i]) out.insert(model.parameters()[i].name);
  return out;
}

const std::vector<EffectSpec> kEffects{
    effect("coulomb_friction", "elbow", {{"Fc", 0.2}}), effect("armature", "elbow", {{"J", 0.1}}),
    effect("com_shift", "elbow", {{"dx", 0.01}}), effect("sensor_offset", "elbow", {{"o", 0.01}}),
    effect("payload", "arm", {{"m", 1.0}})};

TEST(Reach, OfADriveAndAFrictionIsTheirJointWhereTheMotionIsMeasured) {
  const std::set<std::string> names = staying(InverseDynamics{5.0}, kEffects);
  for (const char* name : {"shoulder.gain", "elbow.damping", "elbow.coulomb_friction.Fc", "elbow.armature.J"})
    EXPECT_TRUE(names.contains(name)) << name;
}

TEST(Reach, OfWhatWeighsOrIsReadAnewIsMoreThanItsJoint) {
  for (const std::string& name : staying(InverseDynamics{5.0}, kEffects))
    for (const char* other : {"mass", "com_shift", "payload", "sensor_offset"})
      EXPECT_EQ(name.find(other), std::string::npos) << name;
}

TEST(Reach, OfAnythingIsMoreThanItsJointWhereTheMotionIsSimulated) {
  EXPECT_TRUE(staying(FreeRun{}, kEffects).empty());
}

TEST(Reach, OfEveryDriveIsMoreThanItsJointBesideASharedPump) {
  const EffectSpec pump = effect("shared_supply", "arm", {{"full_shoulder", 1.0}, {"full_elbow", 1.0}, {"n", 4.0}});
  EXPECT_FALSE(staying(InverseDynamics{5.0}, {}, "flow_source").empty());
  EXPECT_TRUE(staying(InverseDynamics{5.0}, {pump}, "flow_source").empty());
}

}  // namespace
}  // namespace lacuna
