#include "python/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/engine.h"
#include "scenarios/error.h"
#include "python/convert.h"
#include "python/room.h"

namespace lacuna {
namespace {

/// Accuracy asked of a channel whose noise nobody knows, as a share of the range that it was measured over.
constexpr double kUnknownShare = 1e-6;

/// The scenario with one recording alone, to be simulated from its start.
Scenario on_recording(Scenario scenario, std::string& name) {
  std::vector<std::string> known;
  for (const RecordingSpec& spec : scenario.recordings) known.push_back(spec.file);
  if (known.empty()) throw InputError(scenario.file.string() + ": recordings", "none", "at least one");
  if (name.empty()) name = known.front();
  const auto at = std::find(known.begin(), known.end(), name);
  if (at == known.end()) throw InputError("recording", quoted(name), fmt::format("one of {}", fmt::join(known, ", ")));
  const RecordingSpec spec = scenario.recordings[at - known.begin()];
  scenario.recordings = {spec};
  scenario.recordings.front().role = Role::train;  // the role that start values and steps are taken from
  scenario.prediction = FreeRun{};
  return scenario;
}

void ask_for_accuracy(Experiment& experiment) {
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    if (experiment.channels[c].noise > 0.0) continue;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const double x : experiment.segments.front().measured[c]) {
      if (std::isnan(x)) continue;
      low = std::min(low, x);
      high = std::max(high, x);
    }
    experiment.channels[c].noise = high > low ? kUnknownShare * (high - low) : kUnknownShare;
  }
}

}  // namespace

PythonSimulator::PythonSimulator(const Scenario& scenario, PythonSimulatorOptions options, const StopFlag& stop)
    : options_(std::move(options)),
      model_(scenario),
      experiment_(make_experiment(on_recording(scenario, options_.recording))) {
  const EngineInfo engine = find_engine(options_.engine).info();
  if (!engine.available) throw WorkError("engine " + engine.name + " is not available: " + engine.reason);
  if (options_.names.empty())
    for (const Parameter& parameter : model_.parameters()) options_.names.push_back(parameter.name);
  for (const std::string& name : options_.names) {
    index_.push_back(model_.find(name));
    if (index_.back() < 0) throw InputError("names", quoted(name), "a parameter of the scenario (Scenario.parameters)");
  }
  if (options_.threads <= 0) options_.threads = default_threads();
  ask_for_accuracy(experiment_);
  step_ = options_.step ? *options_.step : chosen_step(stop);
  if (!(step_ > 0.0)) throw InputError("step", fmt::format("{}", step_), "seconds > 0");
}

double PythonSimulator::chosen_step(const StopFlag& stop) const {
  return choose_step(model_, experiment_, {options_.engine, options_.threads, 0.0, &stop}, model_.values()).step;
}

std::vector<double> PythonSimulator::values() const {
  const std::vector<double> all = model_.values();
  std::vector<double> out;
  for (const int i : index_) out.push_back(all[i]);
  return out;
}

std::vector<double> PythonSimulator::full(const std::vector<double>& set) const {
  if (set.size() != index_.size())
    throw InputError("parameters", fmt::format("{} numbers a set", set.size()), fmt::format("{}", index_.size()));
  std::vector<double> out = model_.values();
  for (std::size_t i = 0; i < set.size(); ++i) {
    const Parameter& parameter = model_.parameters()[index_[i]];
    if (!(set[i] >= parameter.lower && set[i] <= parameter.upper))
      throw InputError("parameters: " + parameter.name, fmt::format("{}", set[i]),
                       fmt::format("from {} to {} {}", parameter.lower, parameter.upper, parameter.unit));
    out[index_[i]] = set[i];
  }
  return out;
}

std::vector<double> PythonSimulator::rollouts(const std::vector<std::vector<double>>& sets,
                                              const StopFlag& stop) const {
  std::vector<std::vector<double>> individuals;
  individuals.reserve(sets.size());
  for (const std::vector<double>& set : sets) individuals.push_back(full(set));
  const std::size_t rows = samples(), columns = experiment_.channels.size();
  std::vector<double> out(sets.size() * rows * columns);
  const std::vector<int> only{0};
  make_simulator(model_, experiment_, {options_.engine, options_.threads, step_, &stop})
      ->run(individuals, only, [&](int individual, int, const std::vector<std::vector<double>>& predicted) {
        double* to = out.data() + static_cast<std::size_t>(individual) * rows * columns;
        for (std::size_t k = 0; k < rows; ++k)
          for (std::size_t c = 0; c < columns; ++c) *to++ = predicted[c][k];
      });
  return out;
}

std::vector<std::string> PythonSimulator::channels() const {
  std::vector<std::string> out;
  for (const Channel& channel : experiment_.channels)
    out.push_back(experiment_.joint_names[channel.joint] + "." + to_string(channel.kind));
  return out;
}

std::vector<double> PythonSimulator::time() const {
  std::vector<double> out;
  for (std::size_t k = 0; k < samples(); ++k) out.push_back(segment().commands->begin + segment().compared_time(k));
  return out;
}

std::vector<double> PythonSimulator::measured() const {
  std::vector<double> out;
  for (std::size_t k = 0; k < samples(); ++k)
    for (const std::vector<double>& channel : segment().measured) out.push_back(channel[k]);
  return out;
}

namespace {

Array shaped(const std::vector<double>& numbers, const std::vector<std::size_t>& shape) {
  Array out(shape);
  std::copy(numbers.begin(), numbers.end(), out.mutable_data());
  return out;
}

Array rollouts(const PythonSimulator& simulator, const Array& parameters) {
  const bool fits = parameters.ndim() == 2 && parameters.shape(1) == static_cast<py::ssize_t>(simulator.names().size());
  if (!fits) throw py::value_error(fmt::format("parameters have the shape (n, {})", simulator.names().size()));
  std::vector<std::vector<double>> sets(parameters.shape(0));
  const std::size_t width = simulator.names().size();
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const double* row = parameters.data() + i * width;
    sets[i].assign(row, row + width);
  }
  const std::vector<double> out = interruptible([&](const StopFlag& stop) { return simulator.rollouts(sets, stop); });
  return shaped(out, {sets.size(), simulator.samples(), simulator.channels().size()});
}

PythonSimulator make(const Scenario& scenario, const std::string& recording, const std::vector<std::string>& names,
                     const std::string& engine, std::optional<double> step, int threads) {
  return interruptible([&](const StopFlag& stop) {
    return PythonSimulator(scenario, {recording, names, engine, step, threads}, stop);
  });
}

/// One simulation: {"time", "step", "engine", "recording", "channels": {name: array}, "measured": {name: array}}.
py::dict simulate(const Scenario& scenario, const std::map<std::string, double>& values, const std::string& recording,
                  const std::string& engine, std::optional<double> step, int threads) {
  std::vector<std::string> names;
  std::vector<double> set;
  for (const auto& [name, value] : values) {
    names.push_back(name);
    set.push_back(value);
  }
  const PythonSimulator simulator = make(scenario, recording, names, engine, step, threads);
  const std::vector<std::vector<double>> sets{names.empty() ? simulator.values() : set};
  const std::vector<double> predicted =
      interruptible([&](const StopFlag& stop) { return simulator.rollouts(sets, stop); });
  const std::vector<double> measured = simulator.measured();
  const std::vector<std::string> channels = simulator.channels();
  py::dict out, simulated, read;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    std::vector<double> ours, theirs;
    for (std::size_t k = c; k < predicted.size(); k += channels.size()) {
      ours.push_back(predicted[k]);
      theirs.push_back(measured[k]);
    }
    simulated[py::str(channels[c])] = array_of(ours);
    read[py::str(channels[c])] = array_of(theirs);
  }
  out["engine"] = engine;
  out["recording"] = simulator.recording();
  out["step"] = simulator.step();
  out["time"] = array_of(simulator.time());
  out["channels"] = simulated;
  out["measured"] = read;
  return out;
}

py::list parameter_list(const Scenario& scenario) {
  py::list out;
  const PlantModel model(scenario);
  for (const Parameter& parameter : model.parameters()) {
    py::dict one;
    one["name"] = parameter.name;
    one["unit"] = parameter.unit;
    one["value"] = parameter.value;
    one["lower"] = parameter.lower;
    one["upper"] = parameter.upper;
    out.append(one);
  }
  return out;
}

py::list recording_list(const Scenario& scenario) {
  py::list out;
  for (const RecordingSpec& spec : scenario.recordings) {
    py::dict one;
    one["file"] = spec.file;
    one["role"] = to_string(spec.role);
    out.append(one);
  }
  return out;
}

void add_scenario(py::module_& module) {
  py::class_<Scenario>(module, "Scenario", "A scenario file with its robot and recordings, loaded and checked.")
      .def(py::init([](const std::filesystem::path& file) {
             const py::gil_scoped_release others;
             return load_scenario(file);
           }),
           py::arg("file"))
      .def_readonly("name", &Scenario::name)
      .def_readonly("notes", &Scenario::notes, "What loading ignored or counted.")
      .def_property_readonly("robot", [](const Scenario& self) { return std::const_pointer_cast<Robot>(self.robot); })
      .def_property_readonly("parameters", &parameter_list, "List of dicts: name, unit, value, lower, upper.")
      .def_property_readonly("recordings", &recording_list, "List of dicts: file, role.");
}

}  // namespace

void add_simulator(py::module_& module) {
  add_scenario(module);
  py::class_<PythonSimulator>(module, "Simulator",
                              "A scenario's plant on one recording, from its start to its end. names: the parameters "
                              "that are given to rollouts, all where none are named.")
      .def(py::init(&make), py::arg("scenario"), py::arg("recording") = "",
           py::arg("names") = std::vector<std::string>(), py::arg("engine") = "featherstone",
           py::arg("step") = py::none(), py::arg("threads") = 0)
      .def("rollouts", &rollouts, py::arg("parameters"),
           "Simulations of many parameter sets, (n, p) -> (n, t, channels). What diverged is not finite.")
      .def_property_readonly("recording", &PythonSimulator::recording)
      .def_property_readonly("names", &PythonSimulator::names)
      .def_property_readonly("values", [](const PythonSimulator& self) { return array_of(self.values()); })
      .def_property_readonly("channels", &PythonSimulator::channels)
      .def_property_readonly(
          "time", [](const PythonSimulator& self) { return array_of(self.time()); }, "s")
      .def_property_readonly(
          "measured",
          [](const PythonSimulator& self) {
            return shaped(self.measured(), {self.samples(), self.channels().size()});
          },
          "(t, channels); nan where missing.")
      .def_property_readonly("step", &PythonSimulator::step, "s");
  module.def(
      "rollouts",
      [](const Scenario& scenario, const Array& parameters, const std::string& recording,
         const std::vector<std::string>& names, const std::string& engine, std::optional<double> step,
         int threads) { return rollouts(make(scenario, recording, names, engine, step, threads), parameters); },
      py::arg("scenario"), py::arg("parameters"), py::arg("recording") = "",
      py::arg("names") = std::vector<std::string>(), py::arg("engine") = "featherstone", py::arg("step") = py::none(),
      py::arg("threads") = 0, "Simulator(scenario, ...).rollouts(parameters).");
  module.def("simulate", &simulate, py::arg("scenario"), py::arg("values") = std::map<std::string, double>(),
             py::arg("recording") = "", py::arg("engine") = "featherstone", py::arg("step") = py::none(),
             py::arg("threads") = 0,
             "One simulation as a dict: time, channels and measured by name. values: parameters that differ from the "
             "scenario's, by name.");
}

}  // namespace lacuna
