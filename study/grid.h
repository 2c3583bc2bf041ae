// The paper's own experiments: one setting of the genetic algorithm changed at a time from its final ones (its table
// 4).
#pragma once

#include <string>
#include <vector>

#include "study/runner.h"
#include "study/statistics.h"

namespace lacuna {

/// A setting and its runs, one a seed.
struct SettingRecord {
  std::string key;    ///< unique: "coding.integer"
  std::string group;  ///< what is varied: "coding"; "final": nothing
  std::string title;
  GeneticOptions genetic;
  Fitness fitness = Fitness::norm_inf;
  std::vector<SearchRun> runs;

  std::vector<double> each(double (*what)(const SearchRun&)) const;
  /// Best cost by generation: quartiles over the runs.
  std::vector<Quartiles> curve() const;
};
double final_cost(const SearchRun& run);
double output_largest(const SearchRun& run);
double output_rms(const SearchRun& run);
double parameter_index(const SearchRun& run);
double combination_index(const SearchRun& run);
double run_seconds(const SearchRun& run);
/// Generations until 99 % of a run's own improvement is reached: what the paper's normalised curves show.
double convergence_generation(const SearchRun& run);

/// Fitness pairs of one norm, with and without denominator, over the same random points.
struct RankingCheck {
  std::string norm;
  int points = 0;
  int discordant = 0;   ///< neighbours in one ranking that the other ranks the other way round
  int same_answer = 0;  ///< runs (of `runs`) that ended at the very same parameters
  int runs = 0;
};

/// Measured and simulated output of one run, for the plots.
struct OutputTrace {
  std::string file, unit;
  std::vector<double> time, measured, simulated;
  double overshot = 0.0;  ///< share of the turning points of the measured motion that the simulation goes beyond
  int peaks = 0;
};

struct GridRecord {
  std::vector<SettingRecord> settings;  ///< the final setting first; empty: the part was left out
  std::vector<RankingCheck> rankings;
  OutputTrace output;  ///< of the final setting's median run (by output error)
  const SettingRecord* find(const std::string& key) const;
};

struct GridPlan {
  int seeds = 5;
  std::uint64_t seed = 1;
  int population = 70, generations = 200;
};

void plan_grid(const Trial& trial, const GridPlan& plan, const StopFlag* stop, StudyRunner& runner);
GridRecord summarise_grid(const Trial& trial, const GridPlan& plan, const StudyRunner& runner);

/// The final setting on one engine.
struct EngineRecord {
  std::string engine, reason;  ///< reason: why there are no runs
  SettingRecord setting;
};
/// `plan` with the generations that engines without lanes can afford; engines that are not built in say so.
void plan_engines(const Trial& trial, const GridPlan& plan, const StopFlag* stop, StudyRunner& runner);
std::vector<EngineRecord> summarise_engines(const Trial& trial, const GridPlan& plan, const StudyRunner& runner);

}  // namespace lacuna
