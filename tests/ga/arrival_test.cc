#include "ga/arrival.h"

#include <gtest/gtest.h>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

const PendulumTruth kOffGuess{2.0, 1.5, 6.0, 1.0};

/// A pendulum's problem, descended from its start values.
struct Descended : Setting {
  explicit Descended(Scenario given, Coordinates coordinates = Coordinates::values)
      : Setting(std::move(given), 0.005, "featherstone", coordinates),
        first(solve_least_squares(problem, space.start(), train, {})) {}
  SeveralStarts further(bool noise_known) { return from_several_starts(problem, train, {first}, noise_known, 1, {}); }
  LeastSquaresResult first;
};

Scenario without_friction(std::vector<EffectSpec> concealed = {}) {
  return pendulum_problem(kOffGuess, {"gain", "damping", "stiffness"}, 1e-3, std::move(concealed));
}
Scenario with_friction() { return without_friction({effect("coulomb_friction", "swing", {{"Fc", 0.5}})}); }

TEST(SeveralStarts, AreNotDrawnWhereTheNoiseAloneIsLeft) {
  const SeveralStarts found = Descended(without_friction()).further(true);
  EXPECT_EQ(found.starts, 1);
  EXPECT_TRUE(found.met && found.arrived) << found.doubt;
}

TEST(SeveralStarts, MeetWhereTheModelLeavesMore) {
  for (const Coordinates coordinates : {Coordinates::values, Coordinates::ratios}) {
    Descended d(with_friction(), coordinates);
    const SeveralStarts found = d.further(true);
    EXPECT_EQ(found.starts, 2);
    EXPECT_GT(found.evaluations, 0);
    EXPECT_TRUE(found.met && found.arrived) << found.doubt;
    EXPECT_LE(found.best.sum_of_squares + found.best.prior_cost, d.first.sum_of_squares + d.first.prior_cost);
    EXPECT_GT(found.best.sum_of_squares, 2.0 * static_cast<double>(found.best.residual.size()));
  }
}

TEST(SeveralStarts, SayOfABoundThatCutsTheWayOnThatTheyMetThere) {
  Scenario scenario = with_friction();
  for (IdentifySpec& spec : scenario.identify)
    if (spec.name == "gain") spec.lower = 0.9, spec.upper = 1.1;  // of 2; the truth is 3
  const SeveralStarts found = Descended(std::move(scenario)).further(true);
  EXPECT_TRUE(found.met);
  EXPECT_FALSE(found.arrived);
  EXPECT_NE(found.doubt.find("swing.gain"), std::string::npos) << found.doubt;
}

}  // namespace
}  // namespace lacuna
