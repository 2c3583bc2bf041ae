#include "study/robustness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/study/problems.h"
#include "study/statistics.h"

namespace lacuna {
namespace {

using namespace test;

/// Median rms error of a cell, output unit.
double rms_of(const RobustnessRecord& record, const std::string& condition, Searcher searcher) {
  for (const RobustnessCell& cell : record.cells) {
    if (cell.condition.name != condition || cell.searcher != searcher) continue;
    std::vector<double> all;
    for (const SearchRun& run : cell.runs) all.push_back(run.errors.output_rms);
    return quartiles_of(all).median;
  }
  return std::nan("");
}

RobustnessRecord record_of(const Trial& trial, int threads = 2) {
  RunnerOptions options;
  options.threads = threads;
  StudyRunner runner(options);
  const Robustness robustness(trial, 3, 1, 20, 25, nullptr);
  robustness.plan(runner);
  runner.execute();
  return robustness.summarise(runner);
}

TEST(Robustness, MoreNoiseWrongBoundsAndOutliersLeaveLargerErrors) {
  const RobustnessRecord record = record_of(pendulum_trial());
  EXPECT_FALSE(record.planted);
  EXPECT_EQ(record.cells.size(), robustness_conditions().size() * all_searchers().size());
  const double plain = rms_of(record, "noise_1", Searcher::ga_lsq);
  EXPECT_LT(rms_of(record, "noise_0", Searcher::ga_lsq), plain);
  EXPECT_GT(rms_of(record, "noise_100", Searcher::ga_lsq), 10.0 * plain);
  EXPECT_GT(rms_of(record, "bounds_wrong", Searcher::ga_lsq), 10.0 * plain);
  EXPECT_GT(rms_of(record, "outliers_5", Searcher::ga_norm_inf), rms_of(record, "outliers_5", Searcher::ga_norm_1));
  // A truth in the corner is still reachable.
  EXPECT_LT(rms_of(record, "truth_at_bound", Searcher::ga_lsq), 5.0 * plain);
}

TEST(Robustness, NormsAreJudgedByTheirRunsUnderOutliers) {
  RobustnessRecord record;
  EXPECT_FALSE(judge_outliers(record, "deg"));
  for (const Searcher searcher : all_searchers()) {
    RobustnessCell cell{robustness_conditions()[5], searcher, {}};
    for (int k = 0; k < 6; ++k) {
      SearchRun run;
      run.errors.output_rms = (searcher == Searcher::ga_norm_inf ? 2.0 : 1.0) + 0.01 * k;
      cell.runs.push_back(run);
    }
    record.cells.push_back(cell);
  }
  ASSERT_EQ(record.cells.front().condition.name, "outliers_5");
  EXPECT_EQ(judge_outliers(record, "deg")->verdict, Judgement::holds);
  for (RobustnessCell& cell : record.cells) {
    if (cell.searcher == Searcher::ga_norm_2) cell.runs = record.cells.front().runs;
  }
  EXPECT_EQ(judge_outliers(record, "deg")->verdict, Judgement::cannot_be_told);
}

TEST(Robustness, WithoutATruthThePlantIsTheBestFit) {
  const Trial trial = make_trial(swinging(), nullptr);
  StudyRunner runner({});
  const Robustness robustness(trial, 1, 1, 14, 2, nullptr);
  robustness.plan(runner);
  runner.execute();
  const RobustnessRecord record = robustness.summarise(runner);
  EXPECT_TRUE(record.planted);
  for (const RobustnessCell& cell : record.cells) EXPECT_TRUE(std::isnan(cell.runs.front().errors.parameter_index));
}

}  // namespace
}  // namespace lacuna
