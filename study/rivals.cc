#include "study/rivals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ga/identify.h"

namespace lacuna {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

std::string key_of(SearchMethod method, std::uint64_t seed) {
  return fmt::format("rivals/{}/{}", to_string(method), seed);
}

std::string recovery_key(std::uint64_t seed) { return fmt::format("recovery/{}", seed); }

double reached_at(const SearchRun& run, double threshold, long budget) {
  for (const SearchRun::Entry& entry : run.curve) {
    if (entry.evaluations > budget) break;
    if (entry.best <= threshold) return static_cast<double>(entry.evaluations);
  }
  return kNever;
}

/// Whether `a` is the better choice at the level: more successes, then fewer evaluations to them.
bool better(const MethodRecord& a, const MethodRecord& b, std::size_t level) {
  if (a.success[level] != b.success[level]) return a.success[level] > b.success[level];
  return quartiles_of(a.reached[level]).median < quartiles_of(b.reached[level]).median;
}

void recommend(RivalsRecord& record) {
  for (std::size_t m = 0; m < record.methods.size(); ++m) {
    if (record.recommended < 0 || better(record.methods[m], record.methods[record.recommended], 0))
      record.recommended = static_cast<int>(m);
  }
  const MethodRecord& best = record.methods[record.recommended];
  const auto words = [](const MethodRecord& m) {
    const double median = quartiles_of(m.reached[0]).median;
    const std::string when =
        std::isfinite(median) ? fmt::format(", the median run after {:.0f} evaluations", median) : "";
    return fmt::format("{:.0f} of {} runs{}", m.success[0] * static_cast<double>(m.runs.size()), m.runs.size(), when);
  };
  if (best.success[0] == 0.0) {
    record.recommended = -1;
    record.reason = "No method came as close as that to the best run within the budget: none is recommended.";
    return;
  }
  record.reason = fmt::format("Recommended here: {}, {}", title_of(best.method), words(best));
  for (const MethodRecord& other : record.methods) {
    if (other.method == SearchMethod::ga && best.method != SearchMethod::ga)
      record.reason += fmt::format("; the paper's GA alone: {}, so it is not the best choice", words(other));
  }
  record.reason += ".";
}

}  // namespace

std::vector<Level> success_levels() {
  return {{"within 1 % of the best", 1.01}, {"within 10 % of the best", 1.1}, {"within twice the best", 2.0}};
}

void plan_rivals(const Trial& trial, const RivalsPlan& plan, const StopFlag* stop, StudyRunner& runner) {
  for (const SearchMethod method : all_methods()) {
    for (int k = 0; k < plan.seeds; ++k) {
      const Budget budget{plan.population, plan.evaluations, plan.seed + static_cast<std::uint64_t>(k),
                          plan.round_generations};
      runner.add(key_of(method, budget.seed), static_cast<double>(plan.evaluations), [&trial, method, budget, stop] {
        return run_method(make_task(trial, "featherstone", stop), method, budget);
      });
    }
  }
}

void plan_recovery(const Trial& trial, const RivalsPlan& plan, const StopFlag* stop, StudyRunner& runner) {
  for (int k = 0; k < plan.seeds; ++k) {
    const Budget budget{plan.population, 1, plan.seed + static_cast<std::uint64_t>(k), plan.round_generations};
    const double weight = static_cast<double>(plan.population) * plan.round_generations;
    runner.add(recovery_key(budget.seed), weight, [&trial, budget, stop] {
      return run_method(make_task(trial, "featherstone", stop), SearchMethod::ga_lsq, budget);
    });
  }
}

RivalsRecord summarise_rivals(const Trial&, const RivalsPlan& plan, const StudyRunner& runner) {
  RivalsRecord out;
  out.budget = plan.evaluations;
  out.best = kNever;
  for (const SearchMethod method : all_methods()) {
    MethodRecord record{method, {}, {}, {}};
    for (int k = 0; k < plan.seeds; ++k) {
      record.runs.push_back(runner.at(key_of(method, plan.seed + static_cast<std::uint64_t>(k))));
      out.best = std::min(out.best, record.runs.back().cost);
    }
    out.methods.push_back(std::move(record));
  }
  for (MethodRecord& record : out.methods) {
    for (const Level& level : success_levels()) {
      std::vector<double> reached;
      for (const SearchRun& run : record.runs)
        reached.push_back(reached_at(run, level.factor * out.best, plan.evaluations));
      const auto hits = std::count_if(reached.begin(), reached.end(), [](double x) { return std::isfinite(x); });
      record.success.push_back(static_cast<double>(hits) / static_cast<double>(reached.size()));
      record.reached.push_back(std::move(reached));
    }
  }
  recommend(out);
  return out;
}

RecoveryRecord summarise_recovery(const Trial& trial, const RivalsPlan& plan, const StudyRunner& runner) {
  RecoveryRecord out;
  if (!trial.truth) return out;
  const Task task = make_task(trial, "featherstone", nullptr);
  Problem problem(*trial.model, task.experiment, task.space, task.simulator, task.weights);
  const std::vector<double> truth = task.space.expand(inner_point(task, *trial.truth));
  for (int k = 0; k < plan.seeds; ++k) {
    FitResult fit;
    fit.point = inner_point(task, runner.at(recovery_key(plan.seed + static_cast<std::uint64_t>(k))).point);
    fit.values = task.space.expand(fit.point);
    fit.solution.point = fit.point;
    fit.solution.residual = problem.residual(fit.point, task.train);
    fit.solution.jacobian = problem.jacobian(fit.point, fit.solution.residual, task.train);
    fit.solution.sum_of_squares = fit.solution.residual.squaredNorm();
    describe_fit(*trial.model, task.space, problem, task.train, fit);
    if (out.parameters.empty()) {
      for (const Estimate& e : fit.estimates)
        out.parameters.push_back({e.name, e.unit, truth[trial.model->find(e.name)], {}, {}, {}, {}});
    }
    for (std::size_t i = 0; i < fit.estimates.size(); ++i) {
      const Estimate& e = fit.estimates[i];
      Recovered& r = out.parameters[i];
      r.value.push_back(e.value);
      r.lower95.push_back(e.lower95);
      r.upper95.push_back(e.upper95);
      r.identifiable.push_back(e.identifiable);
      if (!e.identifiable) continue;
      ++out.asked;
      out.held += e.lower95 <= r.truth && r.truth <= e.upper95;
    }
  }
  return out;
}

}  // namespace lacuna
