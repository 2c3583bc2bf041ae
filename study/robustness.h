// Bad data and bad bounds: what each method still finds, judged against the noise-free motion of the true plant.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/conclusions.h"

namespace lacuna {

/// What is wrong with the data or the bounds of one cell.
struct Condition {
  std::string name, title;
  double noise = 1.0;     ///< times the recordings' own
  double outliers = 0.0;  ///< share of samples moved by half of the range travelled, up or down
  double missing = 0.0;   ///< share of samples lost, and a gap of one second
  enum class Bounds { as_given, wrong, truth_at_corner } bounds = Bounds::as_given;
};
std::vector<Condition> robustness_conditions();

/// How a cell searches: the paper's setting under each norm, and the two-norm finished by least squares.
enum class Searcher { ga_norm_inf, ga_norm_1, ga_norm_2, ga_lsq };
const char* to_string(Searcher searcher);
std::string title_of(Searcher searcher);
std::vector<Searcher> all_searchers();

struct RobustnessCell {
  Condition condition;
  Searcher searcher = Searcher::ga_norm_inf;
  std::vector<SearchRun> runs;  ///< errors: against the noise-free true motion
};

struct RobustnessRecord {
  std::vector<RobustnessCell> cells;  ///< empty: the part was left out
  std::string data;                   ///< in words: what made the data
  bool planted = false;               ///< the truth is unknown: the data come from the best fit of the plan
};

/// Under 5 % outliers: does the infinity norm leave a larger error of the motion than the two-norm? Nothing without
/// cells.
std::optional<Conclusion> judge_outliers(const RobustnessRecord& record, const std::string& unit);

/// Data made by another engine and the integrator of physics/truth.h, noise and faults drawn anew for every seed.
class Robustness {
 public:
  /// The trial must outlive it. Throws InputError where recordings cannot be simulated freely (inverse dynamics).
  /// Without a truth the data are those of a plant planted where a multi-start least-squares search ends.
  Robustness(const Trial& trial, int seeds, std::uint64_t seed, int population, int generations, const StopFlag* stop);

  void plan(StudyRunner& runner) const;
  RobustnessRecord summarise(const StudyRunner& runner) const;

 private:
  const Trial& trial_;
  int seeds_, population_, generations_;
  std::uint64_t seed_;
  const StopFlag* stop_;
  std::string engine_;
  bool planted_ = false;
  std::vector<double> truth_;  ///< point of the box
  Experiment clean_;           ///< train segments alone, noise-free

  std::vector<Condition> conditions() const;
  Box box_of(const Condition& condition) const;
  Experiment spoilt(const Condition& condition, std::uint64_t seed) const;
};

}  // namespace lacuna
