#include "study/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "backends/engine.h"
#include "ga/random.h"

namespace lacuna {
namespace {

constexpr int kRankedPoints = 500;
constexpr std::uint32_t kRanking = 62;  // use of random draws: points that are ranked
constexpr double kConverged = 0.99;     // share of a run's own improvement

/// The settings: the final one, then each of the paper's choices changed alone, then what it leaves open.
std::vector<SettingRecord> settings_of(const GridPlan& plan) {
  GeneticOptions base;
  base.population = plan.population;
  base.generations = plan.generations;
  std::vector<SettingRecord> out{{"final", "final", "final setting (table 4)", base, Fitness::norm_inf, {}}};
  const auto add = [&](const std::string& group, const std::string& name, const std::string& title, auto change) {
    SettingRecord record{group + "." + name, group, title, base, Fitness::norm_inf, {}};
    change(record);
    out.push_back(std::move(record));
  };
  using R = SettingRecord;
  add("coding", "integer", "integer coding", [](R& r) { r.genetic.coding = Coding::integer; });
  for (const int cuts : {1, 4, 8})
    add("crossover", fmt::format("pointwise_{}", cuts), fmt::format("pointwise, {} cut{}", cuts, cuts > 1 ? "s" : ""),
        [cuts](R& r) { r.genetic.cut_points = cuts; });
  add("crossover", "uniform_gene", "uniform, by gene", [](R& r) { r.genetic.crossover = Crossover::uniform_gene; });
  add("crossover", "uniform_bit", "uniform, by bit", [](R& r) { r.genetic.crossover = Crossover::uniform_bit; });
  for (const double rate : {0.6, 1.0})
    add("crossover_rate", fmt::format("{:.1f}", rate), fmt::format("crossover rate {:.1f}", rate),
        [rate](R& r) { r.genetic.crossover_rate = rate; });
  add("mutation", "per_bit", "mutation per bit", [](R& r) { r.genetic.mutation = Mutation::per_bit; });
  add("mutation", "per_chromosome", "mutation per chromosome",
      [](R& r) { r.genetic.mutation = Mutation::per_chromosome; });
  for (const double rate : {0.01, 0.2})
    add("mutation_rate", fmt::format("{:.2f}", rate), fmt::format("mutation rate {:.2f}", rate),
        [rate](R& r) { r.genetic.mutation_rate = rate; });
  add("selection", "roulette_literal", "roulette taken literally",
      [](R& r) { r.genetic.selection = Selection::roulette_literal; });
  add("selection", "tournament", "tournament of two", [](R& r) { r.genetic.selection = Selection::tournament; });
  add("selection", "rank", "rank selection", [](R& r) { r.genetic.selection = Selection::rank; });
  for (const Fitness fitness : {Fitness::norm_inf_relative, Fitness::norm_1, Fitness::norm_1_relative, Fitness::norm_2,
                                Fitness::norm_2_relative})
    add("fitness", to_string(fitness), fmt::format("fitness {}", to_string(fitness)),
        [fitness](R& r) { r.fitness = fitness; });
  // Other sizes at the same number of evaluations.
  for (const int size : {plan.population / 2, plan.population * 2})
    add("population", std::to_string(size), fmt::format("population {}", size), [&plan, size](R& r) {
      r.genetic.population = std::max(2, size);
      r.genetic.generations = std::max(1, plan.generations * plan.population / r.genetic.population);
    });
  return out;
}

std::string key_of(const std::string& prefix, const SettingRecord& setting, std::uint64_t seed) {
  return fmt::format("{}/{}/{}", prefix, setting.key, seed);
}

void plan_setting(const Trial& trial, const SettingRecord& setting, const std::string& prefix, const GridPlan& plan,
                  const std::string& engine, double cost_of_one, const StopFlag* stop, StudyRunner& runner) {
  for (int k = 0; k < plan.seeds; ++k) {
    GeneticOptions options = setting.genetic;
    options.seed = plan.seed + static_cast<std::uint64_t>(k);
    const double weight = cost_of_one * options.population * options.generations;
    runner.add(key_of(prefix, setting, options.seed), weight,
               [&trial, options, fitness = setting.fitness, engine, stop] {
                 return run_genetic(make_task(trial, engine, stop), options, fitness);
               });
  }
}

void collect(SettingRecord& setting, const std::string& prefix, const GridPlan& plan, const StudyRunner& runner) {
  for (int k = 0; k < plan.seeds; ++k)
    setting.runs.push_back(runner.at(key_of(prefix, setting, plan.seed + static_cast<std::uint64_t>(k))));
}

/// Ranks random points by both fitness functions of each norm.
std::vector<RankingCheck> check_rankings(const Trial& trial, const GridPlan& plan, const GridRecord& record) {
  const Task task = make_task(trial, "featherstone", nullptr);
  Problem problem(*trial.model, task.experiment, task.space, task.simulator, task.weights);
  std::vector<std::vector<double>> points;
  for (std::uint32_t i = 0; i < kRankedPoints; ++i) {
    RandomStream draws(plan.seed, i, 0, kRanking);
    std::vector<double> point;
    for (std::size_t k = 0; k < task.box.lower.size(); ++k)
      point.push_back(draws.uniform(task.box.lower[k], task.box.upper[k]));
    points.push_back(inner_point(task, point));
  }
  std::vector<RankingCheck> out;
  for (const auto& [plain, relative] :
       {std::pair(Fitness::norm_1, Fitness::norm_1_relative), std::pair(Fitness::norm_2, Fitness::norm_2_relative),
        std::pair(Fitness::norm_inf, Fitness::norm_inf_relative)}) {
    std::vector<double> a(points.size()), b(points.size());
    problem.costs(points, a, task.train, plain);
    problem.costs(points, b, task.train, relative);
    RankingCheck check{to_string(plain), kRankedPoints, 0, 0, 0};
    const auto order = ranking(a);
    for (std::size_t k = 1; k < order.size(); ++k) check.discordant += b[order[k]] < b[order[k - 1]];
    const SettingRecord* with = record.find(std::string("fitness.") + to_string(relative));
    const SettingRecord* without =
        plain == Fitness::norm_inf ? record.find("final") : record.find(std::string("fitness.") + to_string(plain));
    for (std::size_t k = 0; with != nullptr && without != nullptr && k < with->runs.size(); ++k) {
      ++check.runs;
      check.same_answer += with->runs[k].point == without->runs[k].point;
    }
    out.push_back(check);
  }
  return out;
}

/// Turning points of `signal` that stand out by more than `least`: index and direction (+1 a maximum).
std::vector<std::pair<std::size_t, int>> turning_points(const std::vector<double>& signal, double least) {
  std::vector<std::pair<std::size_t, int>> out;
  std::size_t low = 0, high = 0;
  int direction = 0;
  for (std::size_t k = 1; k < signal.size(); ++k) {
    if (signal[k] > signal[high]) high = k;
    if (signal[k] < signal[low]) low = k;
    if (direction >= 0 && signal[high] - signal[k] > least) {
      if (direction > 0) out.emplace_back(high, 1);
      direction = -1, low = k;
    } else if (direction <= 0 && signal[k] - signal[low] > least) {
      if (direction < 0) out.emplace_back(low, -1);
      direction = 1, high = k;
    }
  }
  return out;
}

/// The first channel of the first train segment under the median run of the final setting.
OutputTrace trace_output(const Trial& trial, const SettingRecord& setting) {
  OutputTrace out;
  if (setting.runs.empty() || std::holds_alternative<InverseDynamics>(trial.scenario.prediction)) return out;
  std::vector<std::size_t> order(setting.runs.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return setting.runs[a].errors.output_largest < setting.runs[b].errors.output_largest;
  });
  const SearchRun& median = setting.runs[order[(order.size() - 1) / 2]];
  const int first = trial.experiment.with_role(Role::train).front();
  const Segment& segment = trial.experiment.segments[first];
  const Channel& channel = trial.experiment.channels.front();
  const double scale = trial.output_scale != 1.0 ? trial.output_scale / trial.weights.front() : 1.0;
  out.file = segment.file;
  out.unit = trial.output_scale != 1.0 ? trial.output_unit : channel.unit;
  SimulatorOptions options;
  options.max_step = trial.step.step;
  const std::vector<std::vector<double>> one{model_values(trial, median.point)};
  const std::vector<int> segments{first};
  make_simulator(*trial.model, trial.experiment, options)->run(one, segments, [&](int, int, const auto& predicted) {
    for (const double x : predicted.front()) out.simulated.push_back(scale * x);
  });
  for (std::size_t k = 0; k < segment.count; ++k) out.time.push_back(segment.time(k));
  for (const double x : segment.measured.front()) out.measured.push_back(scale * x);
  const auto [low, high] = std::minmax_element(out.measured.begin(), out.measured.end());
  int beyond = 0;
  for (const auto& [k, direction] : turning_points(out.measured, 0.05 * (*high - *low))) {
    ++out.peaks;
    // The simulation's own peak may come a little earlier or later.
    const std::size_t reach = 10, from = k > reach ? k - reach : 0, to = std::min(k + reach + 1, out.simulated.size());
    for (std::size_t i = from; i < to; ++i) {
      if (direction * (out.simulated[i] - out.measured[k]) <= 0.0) continue;
      ++beyond;
      break;
    }
  }
  out.overshot = out.peaks > 0 ? static_cast<double>(beyond) / out.peaks : std::nan("");
  return out;
}

/// Engines without lanes cost about this many times as much, for the progress only.
double relative_cost(const std::string& engine) {
  return engine == "featherstone" ? 1.0 : engine == "mujoco" ? 10.0 : engine == "ode" ? 40.0 : 60.0;
}

SettingRecord final_setting(const GridPlan& plan) { return settings_of(plan).front(); }

}  // namespace

std::vector<double> SettingRecord::each(double (*what)(const SearchRun&)) const {
  std::vector<double> out;
  for (const SearchRun& run : runs) out.push_back(what(run));
  return out;
}

std::vector<Quartiles> SettingRecord::curve() const {
  std::vector<Quartiles> out;
  for (std::size_t g = 0; !runs.empty() && g < runs.front().curve.size(); ++g) {
    std::vector<double> column;
    for (const SearchRun& run : runs) {
      if (g < run.curve.size()) column.push_back(run.curve[g].best);
    }
    out.push_back(quartiles_of(column));
  }
  return out;
}

double final_cost(const SearchRun& run) { return run.cost; }
double output_largest(const SearchRun& run) { return run.errors.output_largest; }
double output_rms(const SearchRun& run) { return run.errors.output_rms; }
double parameter_index(const SearchRun& run) { return run.errors.parameter_index; }
double combination_index(const SearchRun& run) { return run.errors.combination_index; }
double run_seconds(const SearchRun& run) { return run.seconds; }

double convergence_generation(const SearchRun& run) {
  if (run.curve.empty()) return std::nan("");
  const double first = run.curve.front().best, last = run.curve.back().best;
  for (std::size_t g = 0; g < run.curve.size(); ++g) {
    if (first - run.curve[g].best >= kConverged * (first - last)) return static_cast<double>(g + 1);
  }
  return static_cast<double>(run.curve.size());
}

const SettingRecord* GridRecord::find(const std::string& key) const {
  for (const SettingRecord& setting : settings) {
    if (setting.key == key) return &setting;
  }
  return nullptr;
}

void plan_grid(const Trial& trial, const GridPlan& plan, const StopFlag* stop, StudyRunner& runner) {
  for (const SettingRecord& setting : settings_of(plan))
    plan_setting(trial, setting, "grid", plan, "featherstone", 1.0, stop, runner);
}

GridRecord summarise_grid(const Trial& trial, const GridPlan& plan, const StudyRunner& runner) {
  GridRecord out;
  out.settings = settings_of(plan);
  for (SettingRecord& setting : out.settings) collect(setting, "grid", plan, runner);
  out.rankings = check_rankings(trial, plan, out);
  out.output = trace_output(trial, out.settings.front());
  return out;
}

void plan_engines(const Trial& trial, const GridPlan& plan, const StopFlag* stop, StudyRunner& runner) {
  const SettingRecord setting = final_setting(plan);
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    if (info.available)
      plan_setting(trial, setting, "engine/" + info.name, plan, info.name, relative_cost(info.name), stop, runner);
  }
}

std::vector<EngineRecord> summarise_engines(const Trial&, const GridPlan& plan, const StudyRunner& runner) {
  std::vector<EngineRecord> out;
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    EngineRecord record{info.name, info.available ? "" : info.reason, final_setting(plan)};
    if (info.available) collect(record.setting, "engine/" + info.name, plan, runner);
    out.push_back(std::move(record));
  }
  return out;
}

}  // namespace lacuna
