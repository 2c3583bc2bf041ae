#include "study/grid.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/study/problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr GridPlan kSmallGrid{2, 1, 14, 3};

GridRecord small_grid(const Trial& trial, int threads) {
  RunnerOptions options;
  options.threads = threads;
  StudyRunner runner(options);
  plan_grid(trial, kSmallGrid, nullptr, runner);
  runner.execute();
  return summarise_grid(trial, kSmallGrid, runner);
}

void expect_one_change_at_a_time(const GridRecord& grid) {
  std::set<std::string> groups;
  for (const SettingRecord& s : grid.settings) {
    groups.insert(s.group);
    EXPECT_EQ(s.runs.size(), 2u) << s.key;
    const GeneticOptions base = grid.settings.front().genetic;
    const int changed = (s.genetic.coding != base.coding) + (s.genetic.crossover != base.crossover) +
                        (s.genetic.cut_points != base.cut_points) + (s.genetic.crossover_rate != base.crossover_rate) +
                        (s.genetic.mutation != base.mutation) + (s.genetic.mutation_rate != base.mutation_rate) +
                        (s.genetic.selection != base.selection) + (s.fitness != Fitness::norm_inf) +
                        (s.genetic.population != base.population);
    EXPECT_EQ(changed, s.key == "final" ? 0 : 1) << s.key;
  }
  EXPECT_EQ(groups, (std::set<std::string>{"coding", "crossover", "crossover_rate", "final", "fitness", "mutation",
                                           "mutation_rate", "population", "selection"}));
  for (const char* key :
       {"fitness.norm_1", "fitness.norm_1_relative", "fitness.norm_2", "fitness.norm_2_relative",
        "fitness.norm_inf_relative", "selection.roulette_literal", "selection.tournament", "selection.rank"})
    EXPECT_NE(grid.find(key), nullptr) << key;
}

void expect_pairs_rank_alike(const GridRecord& grid) {
  ASSERT_EQ(grid.rankings.size(), 3u);
  for (const RankingCheck& r : grid.rankings) {
    EXPECT_EQ(r.discordant, 0) << r.norm;
    EXPECT_GT(r.points, 100);
    EXPECT_EQ(r.runs, 2);
  }
}

void expect_falling_curves(const GridRecord& grid) {
  const SettingRecord& final = grid.settings.front();
  const std::vector<Quartiles> curve = final.curve();
  ASSERT_EQ(curve.size(), 3u);
  for (std::size_t g = 1; g < curve.size(); ++g) EXPECT_LE(curve[g].median, curve[g - 1].median);
  EXPECT_EQ(curve.back().median, quartiles_of(final.each(final_cost)).median);
}

void expect_costs_in_the_outputs_unit(const GridRecord& grid) {
  for (const SearchRun& run : grid.settings.front().runs)
    EXPECT_NEAR(run.cost, run.errors.output_largest, 1e-9 * run.cost);
}

void expect_turning_points(const GridRecord& grid) {
  EXPECT_EQ(grid.output.unit, "deg");
  EXPECT_EQ(grid.output.measured.size(), grid.output.simulated.size());
  EXPECT_GT(grid.output.peaks, 3);
  EXPECT_GE(grid.output.overshot, 0.0);
  EXPECT_LE(grid.output.overshot, 1.0);
}

/// One grid for all that is asked of it: a run costs most of a minute under sanitizers.
TEST(Grid, OfOneRunIsCompleteOrderedAndTheSameOnThreeThreads) {
  const Trial trial = pendulum_trial();
  const GridRecord a = small_grid(trial, 1), b = small_grid(trial, 3);
  expect_one_change_at_a_time(a);
  expect_pairs_rank_alike(a);
  expect_falling_curves(a);
  expect_costs_in_the_outputs_unit(a);
  expect_turning_points(a);
  for (std::size_t s = 0; s < a.settings.size(); ++s) {
    for (std::size_t k = 0; k < a.settings[s].runs.size(); ++k) {
      EXPECT_TRUE(same_bits(a.settings[s].runs[k].point, b.settings[s].runs[k].point)) << a.settings[s].key;
      EXPECT_EQ(a.settings[s].runs[k].cost, b.settings[s].runs[k].cost);
    }
  }
}

TEST(Grid, ConvergenceIsWhere99PercentOfTheImprovementIsReached) {
  SearchRun run;
  run.curve = {{1, 100.0}, {2, 50.0}, {3, 1.5}, {4, 0.9}, {5, 0.0}};
  EXPECT_EQ(convergence_generation(run), 4.0);
}

TEST(Engines, EveryEngineBuiltInRunsTheFinalSetting) {
  const Trial trial = pendulum_trial();
  StudyRunner runner({});
  plan_engines(trial, kSmallGrid, nullptr, runner);
  runner.execute();
  const std::vector<EngineRecord> records = summarise_engines(trial, kSmallGrid, runner);
  ASSERT_EQ(records.size(), engines().size());
  for (const EngineRecord& record : records) {
    EXPECT_EQ(record.setting.runs.empty(), !record.reason.empty());
    if (record.setting.runs.empty() || record.engine == "ode") continue;
    // One plant, one seed: engines may only differ by rounding.
    EXPECT_NEAR(record.setting.runs.front().cost, records.front().setting.runs.front().cost, 1e-6) << record.engine;
  }
}

}  // namespace
}  // namespace lacuna
