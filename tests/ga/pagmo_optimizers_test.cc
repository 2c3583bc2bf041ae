#include "ga/pagmo_optimizers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "ga/checkpoint.h"
#include "scenarios/error.h"
#include "tests/ga/test_problems.h"

namespace lacuna {
namespace {

using namespace test;

class PagmoOptimizer : public testing::TestWithParam<PagmoMethod> {
 protected:
  PagmoOptions small() const {
    PagmoOptions options;
    options.method = GetParam();
    options.population = 20;
    options.generations = 30;
    options.seed = 5;
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(All, PagmoOptimizer,
                         testing::Values(PagmoMethod::cmaes, PagmoMethod::de, PagmoMethod::pso, PagmoMethod::sga),
                         [](const auto& method) { return to_string(method.param); });

TEST_P(PagmoOptimizer, ConvergesOnTheSphere) {
  PagmoOptions options;
  options.method = GetParam();
  const auto result = run_pagmo(nine_box(), one_by_one(sphere), options);
  // The real-coded GA stays coarse, like ours; the others converge.
  EXPECT_LT(result.best_cost, GetParam() == PagmoMethod::sga ? 1.0 : 1e-3);
  EXPECT_EQ(result.best_cost, sphere(result.best));
}

TEST_P(PagmoOptimizer, AsksForWholeGenerationsInsideTheBox) {
  const auto options = small();
  const auto box = nine_box();
  int batches = 0;
  const BatchCost watching = [&](std::span<const std::vector<double>> points, std::span<double> costs) {
    ++batches;
    EXPECT_EQ(points.size(), 20u);
    for (const auto& point : points) EXPECT_NO_THROW(validate_points("asked", {&point, 1}, box));
    one_by_one(rastrigin)(points, costs);
  };
  const auto result = run_pagmo(box, watching, options);
  EXPECT_EQ(batches, 30);
  EXPECT_EQ(result.evaluations, 30 * 20);
  EXPECT_EQ(result.history.size(), 30u);
}

TEST_P(PagmoOptimizer, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto options = small();
  const auto reference = run_pagmo(nine_box(), one_by_one(rastrigin), options);
  EXPECT_TRUE(same_run(reference, run_pagmo(nine_box(), threaded(rastrigin, 3), options)));
  auto other = options;
  other.seed = 6;
  EXPECT_FALSE(same_run(reference, run_pagmo(nine_box(), one_by_one(rastrigin), other)));
}

TEST_P(PagmoOptimizer, ResumesToTheSameBitsWithoutEvaluatingAgain) {
  const auto options = small();
  const auto reference = run_pagmo(nine_box(), one_by_one(rastrigin), options);
  for (const int generation : {1, 2, 17}) {
    const TemporaryFolder folder;
    const auto file = folder / "run.json";
    const auto part = stopped_after(generation, file, [&](const RunControl& control) {
      return run_pagmo(nine_box(), one_by_one(rastrigin), options, control);
    });
    EXPECT_TRUE(part.interrupted);
    long asked = 0;
    const BatchCost counting = [&](std::span<const std::vector<double>> points, std::span<double> costs) {
      asked += static_cast<long>(points.size());
      one_by_one(rastrigin)(points, costs);
    };
    RunControl control;
    control.checkpoint = file;
    EXPECT_TRUE(same_run(reference, run_pagmo(nine_box(), counting, options, control))) << generation;
    EXPECT_EQ(asked, reference.evaluations - part.evaluations);
  }
}

TEST_P(PagmoOptimizer, ContinuesAFinishedRunWithMoreGenerations) {
  const TemporaryFolder folder;
  RunControl control;
  control.checkpoint = folder / "run.json";
  auto options = small();
  run_pagmo(nine_box(), one_by_one(sphere), options, control);
  options.generations = 40;
  const auto longer = run_pagmo(nine_box(), one_by_one(sphere), options, control);
  EXPECT_TRUE(same_run(longer, run_pagmo(nine_box(), one_by_one(sphere), options)));
}

TEST_P(PagmoOptimizer, RefusesAForeignCheckpoint) {
  const TemporaryFolder folder;
  RunControl control;
  control.checkpoint = folder / "run.json";
  auto options = small();
  run_pagmo(nine_box(), one_by_one(sphere), options, control);
  options.seed = 99;
  EXPECT_THROW(run_pagmo(nine_box(), one_by_one(sphere), options, control), InputError);
}

TEST_P(PagmoOptimizer, SurvivesFailedEvaluations) {
  const PointCost partly = [](const std::vector<double>& x) {
    return x[0] > 1.5 ? std::numeric_limits<double>::quiet_NaN() : sphere(x);
  };
  PagmoOptions options;
  options.method = GetParam();
  EXPECT_LT(run_pagmo(nine_box(), one_by_one(partly), options).best_cost, 1.0);
  const PointCost never = [](const std::vector<double>&) { return std::numeric_limits<double>::infinity(); };
  const auto failed = run_pagmo(nine_box(), one_by_one(never), small());
  EXPECT_EQ(failed.best_cost, std::numeric_limits<double>::infinity());
  EXPECT_EQ(failed.best.size(), 9u);
}

TEST_P(PagmoOptimizer, StartPointsJoinTheFirstPopulation) {
  auto options = small();
  options.generations = 1;
  options.start_points = {std::vector<double>(9, optimum)};
  const auto result = run_pagmo(nine_box(), one_by_one(sphere), options);
  EXPECT_LT(result.best_cost, 1e-25);
}

TEST(Cmaes, FollowsTheValleyOfTheRosenbrockFunction) {
  PagmoOptions options;
  options.generations = 600;
  options.population = 30;
  const auto result = run_pagmo(nine_box(), one_by_one(rosenbrock), options);
  EXPECT_LT(result.best_cost, 1e-9);
  for (const double x : result.best) EXPECT_NEAR(x, 1.0, 1e-4);
}

TEST(Cmaes, StartsAnewWhenItHasConverged) {
  PagmoOptions options;
  options.population = 12;
  options.generations = 1200;
  const auto result = run_pagmo(nine_box(), one_by_one(sphere), options);
  EXPECT_LT(result.best_cost, 1e-15);
  // A fresh random population shows as a jump of the diversity, from nothing to about 1.
  const auto is_random = [](const GenerationRecord& r) { return r.diversity > 0.8; };
  EXPECT_GT(std::count_if(result.history.begin() + 200, result.history.end(), is_random), 0);
  EXPECT_EQ(result.history.size(), 1200u);
}

TEST(PagmoOptions, RefusedWithNameValueAndRange) {
  const auto refusal = [](PagmoOptions options) -> std::string {
    try {
      validate(options, nine_box());
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({.method = PagmoMethod::de, .population = 6, .start_points = {}}),
            "population = 6, allowed for de: 7 .. 1000000");
  EXPECT_EQ(refusal({.generations = 0, .start_points = {}}), "generations = 0, allowed: at least 1");
  for (const auto method : {PagmoMethod::cmaes, PagmoMethod::de, PagmoMethod::pso, PagmoMethod::sga}) {
    EXPECT_EQ(pagmo_method_from_name(to_string(method)), method);
  }
  EXPECT_THROW(pagmo_method_from_name("adam"), std::invalid_argument);
}

}  // namespace
}  // namespace lacuna
