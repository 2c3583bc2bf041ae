#include "compare/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "scenarios/error.h"
#include "compare/accuracy.h"
#include "compare/agreement.h"
#include "compare/conservation.h"
#include "compare/cost.h"
#include "compare/identification.h"
#include "compare/repeatability.h"

namespace lacuna {
namespace {

constexpr double kFreeDuration = 2.0;    // s, of free motion for what it must keep
constexpr double kOrderWindow = 0.512;   // s, of free motion for the order of convergence
constexpr double kRepeatWindow = 0.256;  // s, run over and over
constexpr double kCostWindow = 0.5;      // s, that steps are timed over
constexpr double kCostBudget = 0.2;      // s of computing, for each time that they are

bool adaptive(const MethodResult& method) { return method.name == kAdaptiveMethod && !method.native; }

class Comparing {
 public:
  Comparing(const Scenario& scenario, const CompareOptions& options)
      : scenario_(scenario),
        options_(options),
        motion_(motion_of(scenario, options.duration)),
        window_(motion_.first(kWindow)),
        free_(free_motion_of(scenario, motion_, std::min(kFreeDuration, motion_.duration()), true, options.seed)),
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
    for (const std::string& engine : options_.engines) add_engine(engine, runs);
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

  /// `within` 0..1 of engine number `engine`; the referee, the costs and the identification take a share of their own.
  void stage(const std::string& words, double within) const {
    if (options_.stop != nullptr && *options_.stop) throw Interrupted();
    if (!options_.progress) return;
    const double engines = static_cast<double>(std::max<std::size_t>(1, options_.engines.size()));
    options_.progress(words, 0.05 + 0.6 * (static_cast<double>(out_.engines.size()) + within - 1.0) / engines);
  }

  void add_engine(const std::string& name, std::vector<EngineRun>* runs) {
    const EngineInfo info = find_engine(name).info();
    out_.engines.emplace_back();
    EngineComparison& engine = out_.engines.back();
    engine.engine = name;
    engine.version = info.version;
    runners_.emplace_back();
    cost_motions_.emplace_back();
    try {
      stage(name + ": agreement", 0.0);
      measure_agreement(motion_, options_.seed, options_.threads, options_.stop, engine);
      measure_methods(engine, runs);
      engine.joint_drift = joint_drift(name, free_, free_step_);
      cost_motions_.back() = cost_motion_of(name);
      runners_.back() = std::make_unique<Runner>(name, *cost_motions_.back());
      engine.available = true;
    } catch (const WorkError& error) {
      runners_.back().reset();
      engine.available = false;
      engine.reason = error.what();
    }
  }

  void measure_methods(EngineComparison& engine, std::vector<EngineRun>* runs) {
    Runner whole(engine.engine, motion_), window(engine.engine, window_), free(engine.engine, free_),
        weightless(engine.engine, weightless_), order(engine.engine, order_window_);
    const std::vector<Method> methods = methods_of(engine.engine);
    const std::size_t drawn = drawn_method(methods, whole);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      stage(engine.engine + ": " + methods[m].name, static_cast<double>(m) / static_cast<double>(methods.size()));
      MethodResult result;
      result.name = methods[m].name;
      result.native = methods[m].native;
      result.not_run = whole.refuses(methods[m]);
      if (result.not_run.empty()) {
        measure_points(window, window_, referee_, result, options_.stop);
        if (!adaptive(result)) {
          const Affordable part(engine.engine, motion_, whole, methods[m], step_);
          Trajectory run = part.runner().run(methods[m], step_);
          describe_trajectory(part.motion(), run, referee_, result);
          note_cut(engine.engine, result, part);
          if (runs != nullptr && m == drawn)
            runs->push_back({engine.engine, result.name, referee_.times, std::move(run)});
        }
      }
      if (!adaptive(result)) measure_free(engine.engine, free, weightless, order, result);
      engine.methods.push_back(std::move(result));
    }
  }

  void note_cut(const std::string& engine, const MethodResult& method, const Affordable& part) {
    if (part.motion().duration() >= motion_.duration() * (1.0 - 1e-9)) return;
    out_.notes.push_back(
        fmt::format("{}, {}: a run of the whole motion at the common step would take {:.2g} s; its trajectory is of the "
                    "first {:.3g} s, and so are its drifts.",
                    engine, method.name, part.seconds(), part.motion().duration()));
  }

  /// The engine's default integrator is what its users run; where that cannot carry the motion, the common one.
  static std::size_t drawn_method(const std::vector<Method>& methods, const Runner& runner) {
    for (std::size_t m = 0; m < methods.size(); ++m)
      if (methods[m].native) return runner.refuses(methods[m]).empty() ? m : 0;
    return 0;
  }

  void measure_free(const std::string& engine, Runner& free, Runner& weightless, Runner& order, MethodResult& result) {
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
    if (options_.progress) options_.progress("costs", 0.7);
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
  std::vector<std::unique_ptr<Runner>> runners_;  ///< of the cost motions, one an engine
};

}  // namespace

ScenarioComparison compare_engines(const Scenario& scenario, const CompareOptions& options,
                                   std::vector<EngineRun>* runs) {
  return Comparing(scenario, options).run(runs);
}

}  // namespace lacuna
