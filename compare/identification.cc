#include "compare/identification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ga/identify.h"
#include "scenarios/error.h"
#include "compare/runner.h"

namespace lacuna {
namespace {

constexpr double kMostData = 2.0;  // s
constexpr int kPopulation = 12, kGenerations = 6;
constexpr double kWeight = 3e-4;  // rad (m), rms: about what a 12-bit transducer adds
constexpr std::size_t kMostParameters = 4;

/// The joint that travels farthest in the motion.
int busiest_joint(const Trajectory& run) {
  int out = 0;
  double farthest = -1.0;
  for (std::size_t j = 0; j < run.q.front().size(); ++j) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const std::vector<double>& q : run.q) {
      low = std::min(low, q[j]);
      high = std::max(high, q[j]);
    }
    if (high - low > farthest) farthest = high - low, out = static_cast<int>(j);
  }
  return out;
}

/// The scenario with only those free parameters that are the joint's own.
Scenario narrowed(const Scenario& scenario, const PlantModel& model, int joint) {
  const std::string name = model.robot().joints()[joint].name;
  Scenario out = scenario;
  out.identify.clear();
  out.total_mass.reset();
  for (const IdentifySpec& spec : scenario.identify) {
    for (const int index : model.matching(spec.name)) {
      const std::string& parameter = model.parameters()[index].name;
      if (!parameter.starts_with(name + ".") || out.identify.size() >= kMostParameters) continue;
      IdentifySpec one = spec;
      one.name = parameter;
      out.identify.push_back(std::move(one));
    }
  }
  return out;
}

/// What one engine would have recorded.
Experiment experiment_of(const std::string& engine, const Motion& motion, double step) {
  Runner runner(engine, motion);
  const std::vector<Method> methods = methods_of(engine);
  const auto native = std::find_if(methods.begin(), methods.end(), [](const Method& m) { return m.native; });
  const bool natively = native != methods.end() && runner.refuses(*native).empty();
  const Trajectory run = runner.run(natively ? *native : Method{kCommonMethod, false}, step);
  Experiment out;
  const Robot& robot = motion.model.robot();
  Segment segment = motion.phases.front().segment;
  segment.role = Role::train;
  for (int j = 0; j < robot.dof(); ++j) {
    const Joint& joint = robot.joints()[j];
    out.joint_names.push_back(joint.name);
    out.channels.push_back({ChannelKind::position, j, joint.prismatic() ? "m" : "rad", kWeight, true});
    std::vector<double> column;
    for (const std::vector<double>& q : run.q) column.push_back(q[j]);
    segment.measured.push_back(std::move(column));
  }
  const std::size_t n = out.joint_names.size();
  out.command_rms.assign(n, 1.0), out.speed_rms.assign(n, 1.0), out.position_rms.assign(n, 1.0);
  out.position_middle.assign(n, 0.0), out.position_reach.assign(n, 1.0);
  out.segments.push_back(std::move(segment));
  out.sample_period = motion.longest_step();
  out.span = motion.duration();
  return out;
}

PairFit fit_pair(const Motion& motion, const SearchSpace& space, const Experiment& experiment,
                 const std::string& data_engine, const std::string& engine, std::uint64_t seed, int threads,
                 const StopFlag* stop) {
  IdentifyOptions options;
  options.genetic.population = kPopulation;
  options.genetic.generations = kGenerations;
  options.genetic.seed = seed;
  options.simulator.engine = engine;
  options.simulator.threads = threads;
  options.simulator.stop = stop;
  options.control.stop = stop;
  const FitResult fit = identify(motion.model, experiment, space, options);
  PairFit out{data_engine, engine, {}, 0.0, kUnmeasured, fit.evaluations, fit.seconds};
  for (const Axis& axis : space.axes()) {
    const Parameter& parameter = motion.model.parameters()[axis.parameter];
    const double found = fit.values[axis.parameter];
    out.values.emplace_back(parameter.name, found);
    out.parameter_error = std::max(out.parameter_error, std::fabs(found / parameter.value - 1.0));
  }
  double sum = 0.0;
  for (const auto& [role, rms] : fit.rms) {
    if (role != Role::train) continue;
    for (const auto& [joint, value] : rms) sum += value * value / static_cast<double>(rms.size());
  }
  out.output_rms = std::sqrt(sum);
  return out;
}

}  // namespace

PairFits identify_pairs(const Scenario& scenario, const Motion& motion, const std::vector<std::string>& engines,
                        double step, std::uint64_t seed, int threads, const StopFlag* stop,
                        const std::function<void(double)>& progress) {
  PairFits out;
  const Motion data_motion = motion.first(kMostData);
  out.duration = data_motion.duration();
  out.weight = kWeight;
  if (!motion.commanded) out.not_run = "without commands nothing is excited";
  if (data_motion.phases.size() > 1) out.not_run = "the load changes in mid-motion";
  if (!out.not_run.empty()) return out;
  const Trajectory run = Runner(engines.front(), data_motion).run({kCommonMethod, false}, step);
  const int joint = busiest_joint(run);
  const Scenario narrow = narrowed(scenario, motion.model, joint);
  if (narrow.identify.empty()) {
    out.not_run =
        "the scenario frees no parameter of the joint that moves most, " + motion.model.robot().joints()[joint].name;
    return out;
  }
  const SearchSpace space(motion.model, narrow);
  for (const Axis& axis : space.axes()) {
    const Parameter& parameter = motion.model.parameters()[axis.parameter];
    out.truth.emplace_back(parameter.name, parameter.value);
  }
  out.budget = fmt::format("GA of {} x {} with a least-squares finish, seed {}, {:.3g} s of data", kPopulation,
                           kGenerations, seed, out.duration);
  for (const std::string& data_engine : engines) {
    const Experiment experiment = experiment_of(data_engine, data_motion, step);
    for (const std::string& engine : engines) {
      if (stop != nullptr && *stop) throw Interrupted();
      out.pairs.push_back(fit_pair(data_motion, space, experiment, data_engine, engine, seed, threads, stop));
      if (progress)
        progress(static_cast<double>(out.pairs.size()) / static_cast<double>(engines.size() * engines.size()));
    }
  }
  return out;
}

}  // namespace lacuna
