#include "ga/optimizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "ga/random.h"
#include "tests/ga/test_problems.h"

namespace lacuna {
namespace {

using test::infinity;

std::string box_refusal(const Box& box) {
  try {
    validate(box);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Box, RefusesWhatCannotBeSearchedAndNamesTheParameter) {
  EXPECT_EQ(box_refusal({{0, 0}, {1, 1}, {"a", "b"}}), "");
  EXPECT_NE(box_refusal({}).find("no parameter"), std::string::npos);
  EXPECT_NE(box_refusal({{0, 0}, {1}, {}}).find("equal numbers"), std::string::npos);
  EXPECT_NE(box_refusal({{0, 2}, {1, 2}, {"gain", "mass"}}).find("mass has bounds [2, 2]"), std::string::npos);
  EXPECT_NE(box_refusal({{0}, {std::nan("")}, {}}).find("parameter 0"), std::string::npos);
  EXPECT_NE(box_refusal({{-1.7e308}, {1.7e308}, {}}).find("finite"), std::string::npos);
}

TEST(Diversity, IsOneForAUniformPopulationAndZeroForEqualPoints) {
  const Box box{{-3, 100}, {5, 101}, {}};
  std::vector<std::vector<double>> points(20000);
  RandomStream stream(1, 0, 0);
  for (auto& point : points) point = {stream.uniform(-3, 5), stream.uniform(100, 101)};
  EXPECT_NEAR(diversity(points, box), 1.0, 0.01);
  points.assign(70, {1.0, 100.5});
  EXPECT_EQ(diversity(points, box), 0.0);
}

TEST(GenerationRecord, LeavesFailedIndividualsOutOfMedianAndMean) {
  const Box box{{0}, {1}, {}};
  const std::vector<std::vector<double>> points(5, {0.5});
  const std::vector<double> costs = {4.0, std::nan(""), 1.0, infinity, 10.0};
  const auto record = record_generation(points, costs, box, 1.0, 5, 0.1);
  EXPECT_EQ(record.median, 4.0);
  EXPECT_EQ(record.mean, 5.0);
  const std::vector<double> all_failed(5, infinity);
  EXPECT_EQ(record_generation(points, all_failed, box, infinity, 5, 0.1).median, infinity);
}

TEST(Evaluate, TurnsEveryFailureIntoPlusInfinity) {
  const BatchCost cost = [](std::span<const std::vector<double>> points, std::span<double> costs) {
    for (std::size_t i = 0; i < points.size(); ++i) costs[i] = points[i][0];
  };
  const std::vector<std::vector<double>> points = {{1.0}, {std::nan("")}, {-infinity}, {infinity}};
  EXPECT_EQ(evaluate(cost, points), (std::vector<double>{1.0, infinity, infinity, infinity}));
}

}  // namespace
}  // namespace lacuna
