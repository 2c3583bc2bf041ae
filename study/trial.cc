#include "study/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "backends/engine.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

/// Predictions with and without the locked joints may differ by this share of the noise.
constexpr double kSameMotion = 1e-2;

double parameter_of(const Axis& axis, double coordinate) {
  return axis.coordinate == Coordinate::inverse ? 1.0 / coordinate : coordinate;
}

std::vector<std::vector<double>> predicted(const PlantModel& model, const Experiment& experiment, double step) {
  SimulatorOptions options;
  options.max_step = step;
  std::vector<std::vector<double>> out(experiment.channels.size());
  const std::vector<std::vector<double>> one{model.values()};
  const std::vector<int> segments{experiment.with_role(Role::train).front()};
  make_simulator(model, experiment, options)->run(one, segments, [&](int, int, const auto& p) { out = p; });
  return out;
}

/// Whether two plants move alike at their start values, in the first train segment.
bool move_alike(const PlantModel& a, const Experiment& of_a, const PlantModel& b, const Experiment& of_b) {
  const double step = std::min(0.01, of_a.sample_period);
  const auto x = predicted(a, of_a, step), y = predicted(b, of_b, step);
  for (std::size_t c = 0; c < x.size(); ++c) {
    const double noise = of_a.channels[c].noise;
    for (std::size_t k = 0; k < x[c].size(); ++k) {
      if (!(std::fabs(x[c][k] - y[c][k]) <= kSameMotion * (noise > 0.0 ? noise : 1e-6))) return false;
    }
  }
  return true;
}

void set_output_unit(Trial& trial) {
  trial.output_unit = "times the noise";
  if (trial.experiment.channels.size() != 1 || std::holds_alternative<InverseDynamics>(trial.scenario.prediction))
    return;
  const Channel& channel = trial.experiment.channels.front();
  const bool angle = channel.unit == "rad";
  if (!angle && channel.unit != "m") return;
  trial.output_unit = angle ? "deg" : "mm";
  trial.output_scale = trial.weights.front() * (angle ? 180.0 / std::numbers::pi : 1000.0);
}

void set_truth(Trial& trial, const Scenario& truth) {
  const PlantModel model(truth);
  std::vector<double> point;
  for (std::size_t i = 0; i < trial.box.names.size(); ++i) {
    const int index = model.find(trial.box.names[i]);
    if (index < 0)
      throw InputError(truth.file.string(), "no parameter " + trial.box.names[i], "every one that is searched");
    const double x = parameter_of(trial.axes[i], model.parameters()[index].value);
    if (!(x >= trial.box.lower[i] && x <= trial.box.upper[i])) {
      throw InputError(truth.file.string(), fmt::format("{} outside the bounds of the search", trial.box.names[i]),
                       "a truth that the search can reach");
    }
    point.push_back(x);
  }
  trial.truth = point;
}

Experiment usable_experiment(const Scenario& scenario) {
  Experiment out = make_experiment(scenario);
  if (out.with_role(Role::train).empty())
    throw InputError(scenario.file.string() + ": recordings", "none with role train", "at least one");
  return out;
}

}  // namespace

Trial make_trial(const Scenario& scenario, const Scenario* truth) {
  const PlantModel full(scenario);
  const SearchSpace space(full, scenario);
  if (space.size() == 0)
    throw InputError(scenario.file.string() + ": identify", "no free parameter",
                     "at least one, as gain: {relative_bounds: [0.5, 2]}");
  Trial trial;
  trial.name = scenario.name;
  const Experiment whole = usable_experiment(scenario);
  LockedScenario locked = with_locked_joints_fixed(scenario);
  trial.model = std::make_shared<const PlantModel>(locked.scenario);
  trial.experiment = usable_experiment(locked.scenario);
  if (!locked.fixed.empty() && !move_alike(full, whole, *trial.model, trial.experiment)) {
    locked = {scenario, {}};
    trial.model = std::make_shared<const PlantModel>(scenario);
    trial.experiment = whole;
  }
  trial.scenario = std::move(locked.scenario);
  trial.fixed = std::move(locked.fixed);
  trial.weights = first_weights(*trial.model, trial.experiment);
  trial.step = choose_step(*trial.model, trial.experiment, {}, trial.model->values());
  trial.box = space.box(full);
  trial.start = space.start();
  for (std::size_t i = 0; i < space.size(); ++i) {
    Axis axis = space.axes()[i];
    trial.units.push_back(full.parameters()[axis.parameter].unit);
    axis.parameter = trial.model->find(trial.box.names[i]);
    trial.axes.push_back(axis);
  }
  set_output_unit(trial);
  if (truth != nullptr) set_truth(trial, *truth);
  return trial;
}

std::optional<std::filesystem::path> find_truth(const Scenario& scenario) {
  for (const RecordingSpec& spec : scenario.recordings) {
    if (spec.role != Role::train) continue;
    const std::filesystem::path file = (scenario.folder() / spec.file).parent_path() / "truth.yaml";
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return file;
    return std::nullopt;
  }
  return std::nullopt;
}

Task make_task(const Trial& trial, const std::string& engine, const StopFlag* stop) {
  return make_task(trial, trial.experiment, std::nullopt, engine, stop);
}

Task make_task(const Trial& trial, const Experiment& experiment, const std::optional<Box>& box,
               const std::string& engine, const StopFlag* stop) {
  Scenario scenario = trial.scenario;
  const bool constrained = scenario.total_mass.has_value();
  if (constrained && box) throw std::logic_error("make_task: other bounds with a known total mass");
  if (!constrained) scenario.identify.clear();
  Task task{trial,
            experiment,
            SearchSpace(*trial.model, scenario),
            box.value_or(trial.box),
            first_weights(*trial.model, experiment),
            {engine, 1, trial.step.step, stop},
            experiment.with_role(Role::train)};
  for (std::size_t i = 0; i < trial.axes.size() && !constrained; ++i) {
    Axis axis = trial.axes[i];
    if (axis.parameter < 0) continue;
    axis.lower = task.box.lower[i], axis.upper = task.box.upper[i];
    axis.start = std::clamp(axis.start, axis.lower, axis.upper);
    task.space.add(*trial.model, axis);
  }
  return task;
}

std::vector<double> inner_point(const Task& task, std::span<const double> point) {
  std::vector<double> out;
  for (std::size_t i = 0; i < point.size(); ++i) {
    if (task.trial.axes[i].parameter >= 0) out.push_back(point[i]);
  }
  return out;
}

std::vector<double> outer_point(const Task& task, std::span<const double> inner, std::span<const double> rest) {
  std::vector<double> out(rest.begin(), rest.end());
  for (std::size_t i = 0, k = 0; i < out.size(); ++i) {
    if (task.trial.axes[i].parameter >= 0) out[i] = inner[k++];
  }
  return out;
}

std::vector<double> model_values(const Trial& trial, std::span<const double> point) {
  const Task task = make_task(trial, "featherstone", nullptr);
  return task.space.expand(inner_point(task, point));
}

std::vector<double> parameter_values(const Trial& trial, std::span<const double> point) {
  std::vector<double> out;
  for (std::size_t i = 0; i < point.size(); ++i) out.push_back(parameter_of(trial.axes[i], point[i]));
  return out;
}

std::vector<Combination> combinations(const Trial& trial, std::span<const double> point) {
  const PlantModel& model = *trial.model;
  if (model.dof() != 1 || !model.effects().empty() || model.actuators().front().type < 0) return {};
  const std::string& joint = model.robot().joints().front().name;
  if (model.robot().joints().front().prismatic()) return {};
  const std::vector<double> values = model_values(trial, point);
  const auto value = [&](const char* name) {
    const int index = model.find(joint + "." + name);
    return index < 0 ? 0.0 : values[index];
  };
  const double stiffness = value("stiffness");
  if (actuator_table()[model.actuators().front().type].name != std::string("torque_source") || !(stiffness > 0.0))
    return {};
  const auto dynamics = find_engine("featherstone").build(model.robot_ptr(), model.gravity());
  dynamics->set_inertial(0, model.inertials(values).front());
  const auto weight = [&](double q) {
    const std::vector<double> at{q}, zero{0.0};
    std::vector<double> tau{0.0};
    dynamics->inverse_dynamics(at, zero, zero, tau);
    return tau.front();
  };
  Eigen::MatrixXd mass;
  dynamics->mass_matrix(std::vector<double>{0.0}, mass);
  return {{"gain / stiffness", "rad/V", value("gain") / stiffness},
          {"damping / stiffness", "s", value("damping") / stiffness},
          {"inertia / stiffness", "s^2", mass(0, 0) / stiffness},
          {"weight at 0 / stiffness", "rad", weight(0.0) / stiffness},
          {"weight at 90 deg / stiffness", "rad", weight(0.5 * std::numbers::pi) / stiffness}};
}

AnswerErrors errors_of(Problem& problem, const Task& task, std::span<const double> point) {
  const Trial& trial = task.trial;
  const Eigen::VectorXd residual = problem.residual(inner_point(task, point), task.train);
  AnswerErrors out;
  out.output_largest = trial.output_scale * residual.cwiseAbs().maxCoeff();
  out.output_rms = trial.output_scale * std::sqrt(residual.squaredNorm() / static_cast<double>(residual.size()));
  out.parameter_index = out.combination_index = std::nan("");
  if (!trial.truth) return out;
  const std::vector<double> found = parameter_values(trial, point), truth = parameter_values(trial, *trial.truth);
  out.parameter_index = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i)
    out.parameter_index += 100.0 * std::fabs(found[i] - truth[i]) / std::fabs(truth[i]);
  const auto a = combinations(trial, point), b = combinations(trial, *trial.truth);
  if (a.empty()) return out;
  // A weight about a joint whose lever passes through it is a rounded zero: the two weights are judged as one length.
  const double weight = std::hypot(b[3].value, b[4].value);
  out.combination_index = 0.0;
  for (std::size_t k = 0; k < 3; ++k) out.combination_index += 100.0 * std::fabs(a[k].value / b[k].value - 1.0);
  if (weight > 0.0)
    out.combination_index += 100.0 * std::hypot(a[3].value - b[3].value, a[4].value - b[4].value) / weight;
  return out;
}

}  // namespace lacuna
