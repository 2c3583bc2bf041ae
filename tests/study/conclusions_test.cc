#include "study/conclusions.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lacuna {
namespace {

/// A setting of eight runs with final costs from `first` upwards.
SettingRecord setting(const std::string& key, double first, double index = 100.0) {
  SettingRecord out{key, key.substr(0, key.find('.')), key, {}, Fitness::norm_inf, {}};
  for (int k = 0; k < 8; ++k) {
    SearchRun run;
    run.cost = first + 0.01 * k;
    run.curve = {{10, 10.0}, {20, run.cost}};
    run.errors = {run.cost, run.cost, index + k, 10.0};
    out.runs.push_back(run);
  }
  return out;
}

/// A grid in which every comparison of the paper's comes out as `better` (its choice) against `worse`.
GridRecord grid(double better, double worse) {
  GridRecord out;
  out.settings = {setting("final", better)};
  for (const char* key : {"coding.integer", "crossover.uniform_gene", "crossover_rate.0.6", "crossover_rate.1.0",
                          "fitness.norm_1", "fitness.norm_2", "fitness.norm_inf_relative"})
    out.settings.push_back(setting(key, worse));
  return out;
}

const Conclusion& about(const std::vector<Conclusion>& all, const std::string& words) {
  for (const Conclusion& c : all) {
    if (c.claim.find(words) != std::string::npos) return c;
  }
  throw std::logic_error(words);
}

TEST(Conclusions, FollowTheFiguresWhateverThePaperSays) {
  for (const char* claim : {"MVBS", "pointwise", "0.8", "one-norm and two-norm"}) {
    SCOPED_TRACE(claim);
    EXPECT_EQ(about(judge(grid(1.0, 2.0), "deg", 9), claim).verdict, Judgement::holds);
    EXPECT_EQ(about(judge(grid(2.0, 1.0), "deg", 9), claim).verdict, Judgement::does_not_hold);
    EXPECT_EQ(about(judge(grid(1.0, 1.0), "deg", 9), claim).verdict, Judgement::cannot_be_told);
  }
}

TEST(Conclusions, OneRivalThatIsBetterIsEnoughAndOneThatIsEqualLeavesItOpen) {
  GridRecord record = grid(1.0, 2.0);
  record.settings[3] = setting("crossover_rate.0.6", 1.0);
  EXPECT_EQ(about(judge(record, "deg", 9), "0.8").verdict, Judgement::cannot_be_told);
  record.settings[3] = setting("crossover_rate.0.6", 0.5);
  EXPECT_EQ(about(judge(record, "deg", 9), "0.8").verdict, Judgement::does_not_hold);
}

TEST(Conclusions, ParametersAreJudgedOnlyWhereTheTruthIsKnown) {
  GridRecord record = grid(1.0, 2.0);
  EXPECT_EQ(about(judge(record, "deg", 9), "reasonable accuracy").verdict, Judgement::holds);
  record.settings[0] = setting("final", 1.0, 400.0);
  EXPECT_EQ(about(judge(record, "deg", 9), "reasonable accuracy").verdict, Judgement::does_not_hold);
  record.settings[0] = setting("final", 1.0, std::nan(""));
  EXPECT_THROW(about(judge(record, "deg", 9), "reasonable accuracy"), std::logic_error);
}

TEST(Conclusions, SettingsThatEndAlikeInEveryRunDoNotDiffer) {
  GridRecord record = grid(1.0, 1.0);
  record.rankings = {{"norm_inf", 500, 0, 7, 8}};
  EXPECT_EQ(about(judge(record, "deg", 9), "without denominator").verdict, Judgement::cannot_be_told);
  record.rankings[0].same_answer = 8;
  EXPECT_EQ(about(judge(record, "deg", 9), "without denominator").verdict, Judgement::does_not_hold);
}

TEST(Conclusions, TheOutputIsJudgedAgainstItsOwnRange) {
  GridRecord record = grid(1.0, 2.0);
  record.output.measured = {0.0, 100.0};
  record.output.peaks = 4;
  record.output.overshot = 0.75;
  EXPECT_EQ(about(judge(record, "deg", 9), "tracks").verdict, Judgement::holds);
  EXPECT_EQ(about(judge(record, "deg", 9), "overshoots").verdict, Judgement::holds);
  record.output.measured = {0.0, 1.0};
  record.output.overshot = 0.25;
  EXPECT_EQ(about(judge(record, "deg", 9), "tracks").verdict, Judgement::does_not_hold);
  EXPECT_EQ(about(judge(record, "deg", 9), "overshoots").verdict, Judgement::does_not_hold);
}

TEST(Conclusions, OfNothingThereAreNone) { EXPECT_TRUE(judge({}, "deg", 9).empty()); }

TEST(CitedFigures, AddUpAsThePaperSays) {
  // Its table 3 lists the sums of its table 2 (cut to whole percents; the first by one less).
  for (const paper::FitnessRow& row : paper::kFitness) {
    double sum = 0.0;
    for (const double x : row.relative_errors) sum += x;
    EXPECT_NEAR(sum, row.parameter_error_index, 1.0 + 1e-9) << row.fitness;
  }
}

}  // namespace
}  // namespace lacuna
