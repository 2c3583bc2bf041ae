// Effects that are one another's special cases, searched from each other's end; and two effects that look like one.
#include "diagnosis/kin.h"

#include <gtest/gtest.h>

#include <set>

#include "diagnosis/baseline.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kTransducer = 1e-3, kGap = 0.01, kContact = 300.0, kSide = 0.05;  // rad, rad, N m/rad, kg m^2
const PendulumTruth kGuess{2.2, 1.1, 5.0, 1.0};

TEST(Kin, AreTheseAndNoOthers) {
  std::set<std::set<std::string>> found;
  for (const EffectInfo& one : effect_table()) {
    for (const EffectInfo& other : effect_table()) {
      if (are_kin(one, other)) found.insert({one.name, other.name});
    }
  }
  const std::set<std::set<std::string>> expected{{"coulomb_friction", "stribeck_friction"},
                                                 {"coulomb_friction", "hysteresis_friction"},
                                                 {"armature", "joint_compliance"},
                                                 {"armature", "backlash"},
                                                 {"joint_compliance", "backlash"},
                                                 {"gravity_spring", "gear_ripple"},
                                                 {"valve_offset", "valve_drift"}};
  EXPECT_EQ(found, expected);
}

TEST(Kin, OfASpringIsAGapThatBeginsWithItsStiffnessAndInertia) {
  const Scenario scenario = pendulum_problem(
      kGuess, {"gain", "damping", "stiffness"}, kTransducer,
      {effect("backlash", "swing", {{"gap", kGap}, {"k", kContact}, {"J", kSide}})}, 6.0, engine_of_data());
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  options.step = 0.005;
  FitResult fit;
  const CurrentModel plain = identify_plain(model, experiment, space, options, fit);
  const FitContext context{experiment, on("featherstone", 0.005)};

  ScreenedEffect spring;
  spring.spec = {"joint_compliance", "swing", {{"c", 0.0}}, {}, "test"};
  spring.point = plain.fit.point;
  spring.own = {1.0 / kContact, std::log(kSide)};
  CurrentModel sprung = extended(plain, experiment, spring.spec, spring.point, spring.own);
  ASSERT_TRUE(refit(sprung, context));
  spring.point.assign(sprung.fit.point.begin(), sprung.fit.point.begin() + static_cast<std::ptrdiff_t>(space.size()));
  spring.own.assign(sprung.fit.point.begin() + static_cast<std::ptrdiff_t>(space.size()), sprung.fit.point.end());

  const EffectInfo& gap = effect_table()[find_effect("backlash")];
  const std::vector<ScreenedEffect> starts = kin_starts(gap, spring, sprung, plain, context);
  ASSERT_EQ(starts.size(), 1u) << "the spring has no damper of its own";
  ASSERT_EQ(starts[0].own.size(), 3u);
  EXPECT_EQ(starts[0].spec.parameters, (std::map<std::string, double>{{"c", 0.0}}));
  EXPECT_NEAR(std::exp(starts[0].own[1]), 1.0 / spring.own[0], 1e-6 / spring.own[0]);
  EXPECT_EQ(starts[0].own[2], spring.own[1]);
  EXPECT_GT(starts[0].own[0], 0.0);

  // From there to the gap that is there.
  CurrentModel open = extended(plain, experiment, starts[0].spec, starts[0].point, starts[0].own);
  ASSERT_TRUE(refit(open, context));
  const double noise = kTransducer / plain.weights[0];  // rms, whitened
  EXPECT_LT(open.fit.sum_of_squares, 1.2 * noise * noise * static_cast<double>(open.fit.residual.size()));
  EXPECT_GT(sprung.fit.sum_of_squares, 2.0 * open.fit.sum_of_squares);
  EXPECT_NEAR(open.fit.point[space.size()], kGap, 0.2 * kGap);
}

}  // namespace
}  // namespace lacuna
