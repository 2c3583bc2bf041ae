#include "study/robustness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "backends/engine.h"
#include "ga/enum_names.h"
#include "ga/random.h"
#include "physics/truth.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 4> kSearchers = {"ga_norm_inf", "ga_norm_1", "ga_norm_2", "ga_lsq"};
constexpr std::array<const char*, 4> kTitles = {"GA, infinity norm", "GA, one-norm", "GA, two-norm",
                                                "GA, then least squares"};
/// Uses of random draws: each has streams of its own.
enum Purpose : std::uint32_t { kNoise = 63, kOutlier = 64, kLoss = 65 };

constexpr double kGap = 1.0;  // s

/// Simbody where it is built in, then what there is beside the engine that identifies.
std::string making_engine() {
  for (const char* name : {"simbody", "mujoco", "ode"}) {
    if (find_engine(name).info().available) return name;
  }
  return "featherstone";
}

double range_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

}  // namespace

std::vector<Condition> robustness_conditions() {
  using Bounds = Condition::Bounds;
  return {{"noise_0", "no noise", 0.0, 0.0, 0.0, Bounds::as_given},
          {"noise_1", "noise as recorded", 1.0, 0.0, 0.0, Bounds::as_given},
          {"noise_10", "10 times the noise", 10.0, 0.0, 0.0, Bounds::as_given},
          {"noise_100", "100 times the noise", 100.0, 0.0, 0.0, Bounds::as_given},
          {"outliers_1", "1 % outliers", 1.0, 0.01, 0.0, Bounds::as_given},
          {"outliers_5", "5 % outliers", 1.0, 0.05, 0.0, Bounds::as_given},
          {"missing_30", "30 % missing and a gap", 1.0, 0.0, 0.3, Bounds::as_given},
          {"bounds_wrong", "truth outside the bounds", 1.0, 0.0, 0.0, Bounds::wrong},
          {"truth_at_bound", "truth in a corner of the bounds", 1.0, 0.0, 0.0, Bounds::truth_at_corner}};
}

const char* to_string(Searcher searcher) { return kSearchers[static_cast<std::size_t>(searcher)]; }
std::string title_of(Searcher searcher) { return kTitles[static_cast<std::size_t>(searcher)]; }
std::vector<Searcher> all_searchers() {
  return {Searcher::ga_norm_inf, Searcher::ga_norm_1, Searcher::ga_norm_2, Searcher::ga_lsq};
}

std::optional<Conclusion> judge_outliers(const RobustnessRecord& record, const std::string& unit) {
  std::vector<double> infinity, two;
  for (const RobustnessCell& cell : record.cells) {
    if (cell.condition.name != "outliers_5") continue;
    for (const SearchRun& run : cell.runs) {
      if (cell.searcher == Searcher::ga_norm_inf) infinity.push_back(run.errors.output_rms);
      if (cell.searcher == Searcher::ga_norm_2) two.push_back(run.errors.output_rms);
    }
  }
  if (infinity.empty() || two.empty()) return std::nullopt;
  return Conclusion{kBeyondThePaper, "under 5 % outliers the two-norm leaves a smaller error than the infinity norm",
                    "rank-sum test of the runs' rms errors of the motion, two-sided, 5 %; the direction by the medians",
                    fmt::format("median {:.3g} {} against {:.3g}, p = {:.2g}", quartiles_of(two).median, unit,
                                quartiles_of(infinity).median, rank_sum_p(two, infinity)),
                    compare_runs(two, infinity)};
}

Robustness::Robustness(const Trial& trial, int seeds, std::uint64_t seed, int population, int generations,
                       const StopFlag* stop)
    : trial_(trial),
      seeds_(seeds),
      population_(population),
      generations_(generations),
      seed_(seed),
      stop_(stop),
      engine_(making_engine()),
      planted_(!trial.truth) {
  if (std::holds_alternative<InverseDynamics>(trial.scenario.prediction))
    throw InputError(trial.scenario.file.string() + ": prediction", "inverse_dynamics",
                     "positions compared, for data that can be simulated");
  if (trial.truth) {
    truth_ = *trial.truth;
  } else {
    truth_ =
        run_method(make_task(trial, "featherstone", stop), SearchMethod::multi_start, {population, 2000, seed}).point;
  }
  clean_ = trial.experiment;
  std::erase_if(clean_.segments, [](const Segment& s) { return s.role != Role::train; });
  TruthOptions options;
  options.engine = engine_;
  options.stop = stop;
  const std::vector<double> values = model_values(trial, truth_);
  for (Segment& segment : clean_.segments) {
    segment.measured =
        simulate_truth(*trial.model, segment, clean_.channels, trial.model->values_in(segment.file, values), options);
    for (std::size_t c = 0; c < clean_.channels.size(); ++c) {
      if (clean_.channels[c].kind != ChannelKind::position) continue;
      const std::size_t j = clean_.channels[c].joint;
      segment.q0[j] = segment.measured[c].front();
      segment.v0[j] = 0.0;
    }
  }
}

std::vector<Condition> Robustness::conditions() const {
  std::vector<Condition> out = robustness_conditions();
  if (trial_.scenario.total_mass)  // its constraint has bounds of its own
    std::erase_if(out, [](const Condition& c) { return c.bounds != Condition::Bounds::as_given; });
  return out;
}

Box Robustness::box_of(const Condition& condition) const {
  Box box = trial_.box;
  if (condition.bounds == Condition::Bounds::as_given) return box;
  // The first parameter at most (half) its true value, all others at least theirs: no common factor helps.
  for (std::size_t i = 0; i < box.lower.size(); ++i) {
    if (i > 0) box.lower[i] = std::min(truth_[i], box.upper[i] - 1e-3 * (box.upper[i] - box.lower[i]));
  }
  const double share = condition.bounds == Condition::Bounds::wrong ? 0.5 : 1.0;
  const double least = box.lower[0] + 1e-3 * (box.upper[0] - box.lower[0]);
  box.upper[0] = std::max(least, box.lower[0] + share * (truth_[0] - box.lower[0]));
  return box;
}

Experiment Robustness::spoilt(const Condition& condition, std::uint64_t seed) const {
  Experiment out = clean_;
  for (std::size_t s = 0; s < out.segments.size(); ++s) {
    Segment& segment = out.segments[s];
    for (std::size_t c = 0; c < out.channels.size(); ++c) {
      const std::uint32_t where = static_cast<std::uint32_t>(1000 * s + c);
      RandomStream noise(seed, where, 0, kNoise), outlier(seed, where, 0, kOutlier), loss(seed, where, 0, kLoss);
      const double rms = condition.noise * trial_.weights[c], jump = 0.5 * range_of(segment.measured[c]);
      const double gap = loss.uniform(0.0, std::max(segment.time(segment.count - 1) - kGap, 0.0));
      for (std::size_t k = 0; k < segment.count; ++k) {
        double& x = segment.measured[c][k];
        x += rms * noise.normal();
        if (outlier.chance(condition.outliers)) x += outlier.chance(0.5) ? jump : -jump;
        const bool in_gap = segment.time(k) >= gap && segment.time(k) < gap + kGap;
        if (condition.missing > 0.0 && k > 0 && (loss.chance(condition.missing) || in_gap)) x = std::nan("");
      }
    }
    // As for any recording, the start is what was measured there.
    for (std::size_t c = 0; c < out.channels.size(); ++c) {
      if (out.channels[c].kind != ChannelKind::position) continue;
      segment.q0[out.channels[c].joint] = local_state(segment.commands->time, segment.measured[c], 0, 0, segment.count,
                                                      std::max(condition.noise, 1e-3) * trial_.weights[c])
                                              .value;
    }
  }
  return out;
}

void Robustness::plan(StudyRunner& runner) const {
  for (const Condition& condition : conditions()) {
    for (const Searcher searcher : all_searchers()) {
      for (int k = 0; k < seeds_; ++k) {
        const std::uint64_t seed = seed_ + static_cast<std::uint64_t>(k);
        const double weight = static_cast<double>(population_) * generations_;
        runner.add(fmt::format("robustness/{}/{}/{}", condition.name, to_string(searcher), seed), weight,
                   [this, condition, searcher, seed] {
                     const Box box = box_of(condition);
                     const std::optional<Box> other =
                         condition.bounds == Condition::Bounds::as_given ? std::nullopt : std::optional(box);
                     Task task = make_task(trial_, spoilt(condition, seed), other, "featherstone", stop_);
                     task.weights = trial_.weights;
                     GeneticOptions options;
                     options.population = population_;
                     options.generations = generations_;
                     options.seed = seed;
                     SearchRun run;
                     if (searcher == Searcher::ga_lsq) {
                       const long budget = static_cast<long>(population_) * generations_;
                       run = run_method(task, SearchMethod::ga_lsq,
                                        {population_, budget / 5, seed, std::max(1, generations_ / 10)});
                     } else {
                       const Fitness fitness = searcher == Searcher::ga_norm_inf ? Fitness::norm_inf
                                               : searcher == Searcher::ga_norm_1 ? Fitness::norm_1
                                                                                 : Fitness::norm_2;
                       run = run_genetic(task, options, fitness);
                     }
                     Task truth = make_task(trial_, clean_, other, "featherstone", stop_);
                     truth.weights = trial_.weights;
                     Problem problem(*trial_.model, truth.experiment, truth.space, truth.simulator, truth.weights);
                     run.errors = errors_of(problem, truth, run.point);
                     return run;
                   });
      }
    }
  }
}

RobustnessRecord Robustness::summarise(const StudyRunner& runner) const {
  RobustnessRecord out;
  out.planted = planted_;
  out.data = fmt::format("simulated on {} by Dormand-Prince steps (tolerance 1e-8), faults drawn anew for every seed",
                         engine_);
  for (const Condition& condition : conditions()) {
    for (const Searcher searcher : all_searchers()) {
      RobustnessCell cell{condition, searcher, {}};
      for (int k = 0; k < seeds_; ++k)
        cell.runs.push_back(runner.at(fmt::format("robustness/{}/{}/{}", condition.name, to_string(searcher),
                                                  seed_ + static_cast<std::uint64_t>(k))));
      out.cells.push_back(std::move(cell));
    }
  }
  return out;
}

}  // namespace lacuna
