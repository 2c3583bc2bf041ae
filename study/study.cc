#include "study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>

#include "scenarios/error.h"

namespace lacuna {
namespace {

const std::vector<std::string> kParts{"grid", "engines", "identifiability", "rivals", "robustness", "recovery"};

/// What is done of a scenario, and why the rest is not.
class Choice {
 public:
  Choice(const Trial& trial, const std::vector<std::string>& asked) : asked_(asked) {
    const std::string many = fmt::format(
        "{} joints move: the paper's experiments are about one; ask for it with --parts", trial.model->dof());
    if (asked.empty() && trial.model->dof() > 1) {
      for (const char* part : {"grid", "engines", "rivals", "robustness"}) skip(part, many);
    }
    if (std::holds_alternative<InverseDynamics>(trial.scenario.prediction))
      skip("robustness", "the scenario compares efforts; data are simulated for positions only");
    if (!trial.truth) skip("recovery", "the truth is unknown: intervals can be held against nothing");
  }

  bool has(const std::string& part) const {
    const bool wanted = asked_.empty() || std::find(asked_.begin(), asked_.end(), part) != asked_.end();
    return wanted && std::none_of(skipped_.begin(), skipped_.end(), [&](const auto& s) { return s.part == part; });
  }
  std::vector<SkippedPart> skipped() const {
    std::vector<SkippedPart> out = skipped_;
    for (const std::string& part : kParts) {
      if (!has(part) && std::none_of(out.begin(), out.end(), [&](const auto& s) { return s.part == part; }))
        out.push_back({part, "not asked for"});
    }
    return out;
  }

 private:
  void skip(const std::string& part, const std::string& reason) { skipped_.push_back({part, reason}); }
  const std::vector<std::string>& asked_;
  std::vector<SkippedPart> skipped_;
};

void check(const StudyOptions& options) {
  for (const std::string& part : options.parts) {
    if (std::find(kParts.begin(), kParts.end(), part) == kParts.end()) {
      std::string known;
      for (const std::string& name : kParts) known += (known.empty() ? "" : ", ") + name;
      throw InputError("--parts", quoted(part), "some of " + known);
    }
  }
}

Study described(const Trial& trial, const Scenario* truth, const StudyOptions& options) {
  Study out;
  out.scenario = trial.name;
  out.parameters = trial.box.names;
  out.units = trial.units;
  out.start = parameter_values(trial, trial.start);
  out.lower = parameter_values(trial, trial.box.lower);
  out.upper = parameter_values(trial, trial.box.upper);
  if (trial.truth) out.truth = parameter_values(trial, *trial.truth);
  if (truth != nullptr) out.truth_file = truth->file.filename().string();
  out.fixed = trial.fixed;
  out.output_unit = trial.output_unit;
  out.step = trial.step;
  out.data = trial.truth
                 ? "the scenario's train recordings; only their author's truth file knows what they were made with"
                 : "the scenario's train recordings; their truth is unknown";
  out.seeds = options.seeds;
  out.population = options.population;
  out.generations = options.generations;
  return out;
}

}  // namespace

std::vector<std::string> study_parts() { return kParts; }

Study run_study(const Scenario& scenario, const Scenario* truth, const StudyOptions& options) {
  check(options);
  const Trial trial = make_trial(scenario, truth);
  const Choice choice(trial, options.parts);
  const StopFlag* stop = options.runner.stop;
  const GridPlan grid{options.seeds, options.seed, options.population, options.generations};
  GridPlan engines = grid;
  engines.generations = std::min(grid.generations, options.engine_generations);
  const RivalsPlan rivals{options.seeds, options.seed, options.population,
                          static_cast<long>(options.population) * options.generations,
                          std::max(1, options.generations / 10)};
  StudyRunner runner(options.runner);
  std::optional<Robustness> robustness;
  if (choice.has("grid")) plan_grid(trial, grid, stop, runner);
  if (choice.has("rivals")) plan_rivals(trial, rivals, stop, runner);
  if (choice.has("recovery")) plan_recovery(trial, rivals, stop, runner);
  if (choice.has("robustness")) {
    robustness.emplace(trial, options.seeds, options.seed, options.population, options.generations, stop);
    robustness->plan(runner);
  }
  if (choice.has("engines")) plan_engines(trial, engines, stop, runner);
  runner.execute();

  Study out = described(trial, truth, options);
  out.skipped = choice.skipped();
  if (choice.has("grid")) out.grid = summarise_grid(trial, grid, runner);
  if (choice.has("rivals")) out.rivals = summarise_rivals(trial, rivals, runner);
  if (choice.has("recovery")) out.recovery = summarise_recovery(trial, rivals, runner);
  if (robustness) out.robustness = robustness->summarise(runner);
  if (choice.has("engines")) out.engines = summarise_engines(trial, engines, runner);
  if (choice.has("identifiability")) {
    // A known total mass is looked at both ways, so here every mass is free.
    Scenario free = scenario;
    free.total_mass.reset();
    out.identifiability = assess_all(scenario.total_mass ? make_trial(free, truth) : trial);
  }
  out.conclusions = judge(out.grid, out.output_unit, out.parameters.size());
  if (const auto outliers = judge_outliers(out.robustness, out.output_unit)) out.conclusions.push_back(*outliers);
  std::tie(out.evaluations, out.run_seconds) = runner.spent();
  return out;
}

}  // namespace lacuna
