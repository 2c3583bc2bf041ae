#include "compare/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>

#include "scenarios/error.h"
#include "compare/accuracy.h"
#include "compare/agreement.h"
#include "compare/conservation.h"
#include "compare/cost.h"
#include "compare/identification.h"
#include "compare/repeatability.h"

namespace lacuna {
namespace {

constexpr double kKeptDuration = 2.0;    // s, of free motion for what it must keep
constexpr double kOrderWindow = 0.512;   // s, of free motion for the order of convergence
constexpr double kRepeatWindow = 0.256;  // s, run over and over
constexpr double kCostWindow = 0.5;      // s, that steps are timed over
constexpr double kCostBudget = 0.2;      // s of computing, for each time that they are

class Comparing {
 public:
  Comparing(const Scenario& scenario, const CompareOptions& options)
      : scenario_(scenario),
        options_(options),
        motion_(motion_of(scenario, options.duration)),
        window_(motion_.first(kWindow)),
        free_(free_motion_of(scenario, motion_, std::min(kKeptDuration, motion_.duration()), true, options.seed)),
        weightless_(free_motion_of(scenario, motion_, free_.duration(), false, options.seed)),
        order_window_(free_.first(kOrderWindow)),
        repeat_window_(free_.first(kRepeatWindow)),
        step_(common_step(motion_)),
        free_step_(common_step(free_)) {}

  ScenarioComparison run(std::vector<EngineRun>* runs) {
    const auto begun = std::chrono::steady_clock::now();
    describe();
    stage("referee", 0.0);
    referee_ = make_referee(motion_, options_.threads, options_.stop);
    free_referee_ = make_referee(order_window_, options_.threads, options_.stop);
    out_.referee = referee_.record;
    note_trust();
    if (runs != nullptr) runs->push_back({"referee", "", referee_.times, referee_.reference});
    measure_engines(runs);
    require_one();
    measure_costs();
    identify_all();
    out_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    return std::move(out_);
  }

 private:
  void describe() {
    out_.name = scenario_.name;
    out_.file = scenario_.file.string();
    out_.motion = motion_.words;
    out_.dof = motion_.model.dof();
    out_.duration = motion_.duration();
    out_.step = step_;
    out_.window = window_.duration();
    out_.commanded = motion_.commanded;
  }

  void note_trust() {
    if (referee_.trusted >= referee_.times.size()) return;
    out_.notes.push_back(
        fmt::format("The motion is so sensitive that the referee's two runs part after {:.3g} s; trajectories are "
                    "judged until then.",
                    referee_.record.trusted_until));
  }

  void stage(const std::string& words, double done) const {
    if (options_.stop != nullptr && *options_.stop) throw Interrupted();
    if (options_.progress) options_.progress(words, done);
  }

  /// What one engine's measurements leave, apart from the others'.
  struct Measured {
    EngineComparison engine;
    std::vector<EngineRun> runs;
    std::vector<std::string> notes;
    std::unique_ptr<Motion> cost_motion;
    std::unique_ptr<Runner> cost_runner;
  };

  /// Engines beside each other on threads: nothing of this is timed but to leave out what would take too long.
  void measure_engines(std::vector<EngineRun>* runs) {
    std::vector<Measured> all(options_.engines.size());
    for (const std::string& name : options_.engines) methods_ += methods_of(name).size();
    parallel_for(
        options_.threads, static_cast<int>(all.size()),
        [&](int, int e) {
          Measured& one = all[e];
          one.engine.engine = options_.engines[e];
          measure_engine(one, runs != nullptr);
        },
        options_.stop);
    for (Measured& one : all) {
      out_.engines.push_back(std::move(one.engine));
      out_.notes.insert(out_.notes.end(), one.notes.begin(), one.notes.end());
      if (runs != nullptr) runs->insert(runs->end(), one.runs.begin(), one.runs.end());
      cost_motions_.push_back(std::move(one.cost_motion));
      runners_.push_back(std::move(one.cost_runner));
    }
  }

  void measure_engine(Measured& out, bool drawn) {
    const std::string& name = out.engine.engine;
    out.engine.version = find_engine(name).info().version;
    try {
      measure_agreement(motion_, options_.seed, 1, options_.stop, out.engine);
      measure_methods(out, drawn);
      out.engine.joint_drift = joint_drift(name, free_, free_step_);
      out.cost_motion = cost_motion_of(name);
      out.cost_runner = std::make_unique<Runner>(name, *out.cost_motion);
      out.engine.available = true;
    } catch (const WorkError& error) {
      out.runs.clear();
      out.engine.reason = error.what();
    }
  }

  /// One more method of one engine is begun.
  void count_method(const std::string& words) {
    const std::lock_guard lock(counting_);
    stage(words, 0.05 + 0.6 * static_cast<double>(methods_begun_++) / static_cast<double>(methods_));
  }

  void measure_methods(Measured& out, bool drawn) {
    const std::string& name = out.engine.engine;
    Runner whole(name, motion_), window(name, window_), free(name, free_), weightless(name, weightless_),
        order(name, order_window_);
    const std::vector<Method> methods = methods_of(name);
    const std::size_t shown = drawn_method(methods, whole);
    std::optional<EngineRun> picture;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      count_method(name + ": " + methods[m].name);
      MethodResult result;
      result.name = methods[m].name;
      result.native = methods[m].native;
      result.not_run = whole.refuses(methods[m]);
      if (result.not_run.empty()) measure_points(window, window_, referee_, result, options_.stop);
      if (result.not_run.empty() && !result.adaptive()) {
        Trajectory run = measure_whole(whole, methods[m], result, out);
        // The common method's run stands in for one of the engine's own that diverged.
        if (m == 0 || (m == shown && is_finite(run))) picture = {name, result.name, referee_.times, std::move(run)};
      }
      if (!result.adaptive()) measure_free(name, free, weightless, order, result);
      out.engine.methods.push_back(std::move(result));
    }
    if (drawn && picture && is_finite(picture->run)) out.runs.push_back(std::move(*picture));
  }

  static bool is_finite(const Trajectory& run) {
    return std::all_of(run.q.begin(), run.q.end(), [](const std::vector<double>& q) {
      return std::all_of(q.begin(), q.end(), [](double x) { return std::isfinite(x); });
    });
  }

  /// The motion at the common step, or its start.
  Trajectory measure_whole(Runner& whole, const Method& method, MethodResult& result, Measured& out) const {
    const Affordable part(out.engine.engine, motion_, whole, method, step_);
    Trajectory run = part.runner().run(method, step_);
    describe_trajectory(part.motion(), run, referee_, result);
    note_cut(out.engine.engine, result, part, out.notes);
    return run;
  }

  void note_cut(const std::string& engine, const MethodResult& method, const Affordable& part,
                std::vector<std::string>& notes) const {
    if (part.motion().duration() >= motion_.duration() * (1.0 - 1e-9)) return;
    notes.push_back(fmt::format(
        "{}, {}: a run of the whole motion at the common step would take {:.2g} s; its trajectory is of the "
        "first {:.3g} s, and so are its drifts.",
        engine, method.name, part.seconds(), part.motion().duration()));
  }

  /// The engine's default integrator is what its users run; where that cannot carry the motion, the common one.
  static std::size_t drawn_method(const std::vector<Method>& methods, const Runner& runner) {
    for (std::size_t m = 0; m < methods.size(); ++m)
      if (methods[m].native) return runner.refuses(methods[m]).empty() ? m : 0;
    return 0;
  }

  void measure_free(const std::string& engine, Runner& free, Runner& weightless, Runner& order,
                    MethodResult& result) const {
    const Method method{result.name, result.native};
    if (!free.refuses(method).empty()) return;
    const Affordable falling(engine, free_, free, method, free_step_),
        floating(engine, weightless_, weightless, method, free_step_);
    result.energy_drift = energy_drift(falling.motion(), falling.runner().run(method, free_step_));
    result.momentum_drift = momentum_drift(floating.motion(), floating.runner().run(method, free_step_));
    MethodResult ladder = {};
    ladder.name = result.name;
    ladder.native = result.native;
    measure_points(order, order_window_, free_referee_, ladder, options_.stop);
    result.order_free = ladder.order;
    measure_repeatability(engine, Affordable(engine, repeat_window_, order, method, free_step_).motion(), free_step_,
                          result);
  }

  void require_one() const {
    std::string reasons;
    for (const EngineComparison& engine : out_.engines) {
      if (engine.available) return;
      reasons += (reasons.empty() ? "" : "; ") + engine.reason;
    }
    throw WorkError("no engine could be compared: " + reasons);
  }

  /// What steps are timed over: the motion's start, less of it on a slow engine.
  std::unique_ptr<Motion> cost_motion_of(const std::string& engine) const {
    const Motion start = motion_.first(kCostWindow);
    Runner whole(engine, start);
    return std::make_unique<Motion>(
        Affordable(engine, start, whole, {kCommonMethod, false}, step_, kCostBudget).motion());
  }

  void measure_costs() {
    stage("costs", 0.7);
    measure_engine_costs(motion_, options_.seed, out_.engines, options_.stop);
    measure_step_costs(runners_, step_, out_.engines, options_.stop);
  }

  void identify_all() {
    if (!options_.identify) {
      out_.identification.not_run = "not asked for";
      return;
    }
    std::vector<std::string> engines;
    for (const EngineComparison& engine : out_.engines)
      if (engine.available) engines.push_back(engine.engine);
    out_.identification = identify_pairs(scenario_, motion_, engines, step_, options_.seed, options_.threads,
                                         options_.stop, [&](double done) {
                                           if (options_.progress)
                                             options_.progress("identification", 0.75 + 0.25 * done);
                                         });
  }

  const Scenario& scenario_;
  const CompareOptions& options_;
  Motion motion_, window_, free_, weightless_, order_window_, repeat_window_;
  double step_, free_step_;
  Referee referee_, free_referee_;
  ScenarioComparison out_;
  std::vector<std::unique_ptr<Motion>> cost_motions_;
  std::mutex counting_;
  std::size_t methods_ = 0, methods_begun_ = 0;   ///< of all engines
  std::vector<std::unique_ptr<Runner>> runners_;  ///< of the cost motions, one an engine
};

}  // namespace

ScenarioComparison compare_engines(const Scenario& scenario, const CompareOptions& options,
                                   std::vector<EngineRun>* runs) {
  return Comparing(scenario, options).run(runs);
}

}  // namespace lacuna
