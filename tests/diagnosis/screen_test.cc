// The first look at every effect, and those that follow it.
#include "diagnosis/screen.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/baseline.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

/// A pendulum whose valve has a deadband of .5 V, its plain model identified.
struct Screened {
  Screened() {
    FitResult fit;
    IdentifyOptions options;
    options.optimizer = Optimizer::lsq;
    options.simulator = on("featherstone", 0.005);
    options.step = options.simulator.max_step;
    plain = identify_plain(model, experiment, SearchSpace(model, scenario), options, fit);
  }
  std::vector<ScreenedEffect> look() const {
    return screen_effects(*plain, {experiment, on("featherstone", 0.005)}, how);
  }

  Scenario scenario = pendulum_problem({2.2, 1.1, 5.0, 1.0}, {"gain", "damping", "stiffness"}, 1e-3,
                                       {effect("valve_deadband", "swing", {{"d", 0.5}})}, 10.0, engine_of_data());
  PlantModel model{scenario};
  Experiment experiment = make_experiment(scenario);
  ScreenOptions how{[](const std::string&) { return true; }};
  std::optional<CurrentModel> plain;
};

const ScreenedEffect& best_of(const std::vector<ScreenedEffect>& looked) {
  return *std::min_element(looked.begin(), looked.end(),
                           [](const auto& a, const auto& b) { return a.sum_of_squares < b.sum_of_squares; });
}

TEST(Screen, PutsTheEffectThatIsThereFirst) {
  const Screened s;
  const std::vector<ScreenedEffect> looked = s.look();
  const ScreenedEffect& best = best_of(looked);
  EXPECT_EQ(best.spec.effect, "valve_deadband");
  ASSERT_EQ(best.own.size(), 1u);
  EXPECT_NEAR(best.own.front(), 0.5, 0.05);
  EXPECT_LT(best.sum_of_squares, 0.1 * s.plain->fit.residual.squaredNorm());
}

}  // namespace
}  // namespace lacuna
