#include "ga/fitness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "ga/random.h"
#include "tests/ga/test_problems.h"

namespace lacuna {
namespace {

using test::infinity;
using test::not_a_number;

constexpr Fitness all[] = {Fitness::norm_1,          Fitness::norm_1_relative, Fitness::norm_2,
                           Fitness::norm_2_relative, Fitness::norm_inf,        Fitness::norm_inf_relative};

TEST(Fitness, MatchesTheSeedsFormulasByHand) {
  const std::vector<double> errors = {3.0, -4.0, 0.0}, data = {6.0, -8.0, 10.0};
  EXPECT_EQ(fitness_of(Fitness::norm_1, errors, data), -7.0);
  EXPECT_EQ(fitness_of(Fitness::norm_2, errors, data), -5.0);
  EXPECT_EQ(fitness_of(Fitness::norm_inf, errors, data), -4.0);
  EXPECT_DOUBLE_EQ(fitness_of(Fitness::norm_1_relative, errors, data), -7.0 / 24.0);
  EXPECT_DOUBLE_EQ(fitness_of(Fitness::norm_2_relative, errors, data), -5.0 / std::sqrt(200.0));
  EXPECT_EQ(fitness_of(Fitness::norm_inf_relative, errors, data), -0.4);
}

TEST(Fitness, PairsOfTheSameNormRankIdentically) {
  RandomStream stream(1, 0, 0);
  std::vector<double> data(50);
  for (double& d : data) d = stream.normal();
  const int candidates = 200;
  std::vector<std::vector<double>> errors(candidates, std::vector<double>(50));
  for (auto& e : errors) {
    for (double& x : e) x = stream.normal();
  }
  const auto order = [&](Fitness fitness) {
    std::vector<int> indices(candidates);
    std::iota(indices.begin(), indices.end(), 0);
    std::sort(indices.begin(), indices.end(), [&](int a, int b) {
      const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
      return fitness_of(fitness, errors[i], data) > fitness_of(fitness, errors[j], data);
    });
    return indices;
  };
  EXPECT_EQ(order(Fitness::norm_1), order(Fitness::norm_1_relative));
  EXPECT_EQ(order(Fitness::norm_2), order(Fitness::norm_2_relative));
  EXPECT_EQ(order(Fitness::norm_inf), order(Fitness::norm_inf_relative));
  EXPECT_NE(order(Fitness::norm_1), order(Fitness::norm_inf));
}

TEST(Fitness, LeavesMissingSamplesOutOfErrorAndData) {
  NormAccumulator with, without;
  with.add(1.0, 2.0);
  with.add(not_a_number, not_a_number);
  with.add(100.0, not_a_number);
  with.add(-3.0, 4.0);
  without.add(1.0, 2.0);
  without.add(-3.0, 4.0);
  for (const auto fitness : all) EXPECT_EQ(with.fitness(fitness), without.fitness(fitness)) << to_string(fitness);
  EXPECT_EQ(with.used(), 2);
  EXPECT_EQ(with.missing(), 2);
}

TEST(Fitness, OfASimulationThatFailedIsMinusInfinityHoweverItFailed) {
  for (const double error : {not_a_number, infinity, -infinity}) {
    NormAccumulator norms;
    norms.add(0.1, 1.0);
    norms.add(error, 1.0);
    for (const auto fitness : all) EXPECT_EQ(norms.fitness(fitness), -infinity) << to_string(fitness);
  }
}

TEST(Fitness, IsMinusInfinityWhenNothingWasCompared) {
  NormAccumulator norms;
  norms.add(0.0, not_a_number);
  for (const auto fitness : all) EXPECT_EQ(norms.fitness(fitness), -infinity) << to_string(fitness);
}

TEST(Fitness, RelativeToDataOfZeroIsMinusInfinityNotNan) {
  NormAccumulator norms;
  norms.add(0.0, 0.0);
  EXPECT_EQ(norms.fitness(Fitness::norm_2_relative), -infinity);
  EXPECT_EQ(norms.fitness(Fitness::norm_2), 0.0);
}

TEST(NormAccumulator, MergedPartsEqualTheWhole) {
  NormAccumulator whole, first, second;
  for (int i = 0; i < 100; ++i) {
    const double error = (i * 37 % 101) - 50, data = i % 7 == 0 ? not_a_number : i;  // whole numbers: exact sums
    whole.add(error, data);
    (i < 30 ? first : second).add(error, data);
  }
  first.merge(second);
  for (const auto fitness : all) EXPECT_EQ(first.fitness(fitness), whole.fitness(fitness));
  EXPECT_EQ(first.missing(), whole.missing());
}

TEST(Norm, LeavesNanOutAndRefusesOtherOrders) {
  const std::vector<double> values = {3.0, not_a_number, -4.0};
  EXPECT_EQ(norm(values, 1), 7.0);
  EXPECT_EQ(norm(values, 2), 5.0);
  EXPECT_EQ(norm(values, infinity), 4.0);
  EXPECT_THROW(norm(values, 3), std::invalid_argument);
}

TEST(Fitness, NamesRoundTripAndOthersAreRefused) {
  for (const auto fitness : all) EXPECT_EQ(fitness_from_name(to_string(fitness)), fitness);
  EXPECT_THROW(fitness_from_name("norm_3"), std::invalid_argument);
}

}  // namespace
}  // namespace lacuna
