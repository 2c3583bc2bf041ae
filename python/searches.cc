// Identification, diagnosis and the comparison of two sets of recordings: the program's own records as dicts.
#include "backends/engine.h"
#include "diagnosis/diagnosis.h"
#include "ga/identify.h"
#include "reports/diff.h"
#include "reports/json.h"
#include "scenarios/error.h"
#include "diff/diff.h"
#include "python/convert.h"
#include "python/room.h"

namespace lacuna {
namespace {

struct Search {
  std::string engine, optimizer;
  int population, generations;
  std::uint64_t seed;
  int threads;
  std::optional<double> step;

  IdentifyOptions understood(const StopFlag& stop) const {
    const EngineInfo info = find_engine(engine).info();
    if (!info.available) throw WorkError("engine " + info.name + " is not available: " + info.reason);
    IdentifyOptions out;
    out.optimizer = optimizer_from_name(optimizer);
    out.genetic.population = population;
    out.genetic.generations = generations;
    out.genetic.seed = seed;
    out.simulator.engine = engine;
    out.simulator.threads = threads > 0 ? threads : default_threads();
    out.simulator.stop = &stop;
    out.control.stop = &stop;
    out.step = step;
    return out;
  }
};

void need_train(const Scenario& scenario, const Experiment& experiment) {
  if (experiment.with_role(Role::train).empty())
    throw InputError(scenario.file.string() + ": recordings", "none with role train", "at least one");
}

Context context_of(const Search& search, const char* call) {
  return make_context(search.seed, search.threads > 0 ? search.threads : default_threads(), call);
}

py::object identify_scenario(const Scenario& scenario, const std::string& engine, const std::string& optimizer,
                             int population, int generations, std::uint64_t seed, int threads,
                             std::optional<double> step) {
  const Search search{engine, optimizer, population, generations, seed, threads, step};
  return dict_of(interruptible([&](const StopFlag& stop) {
    const IdentifyOptions options = search.understood(stop);
    const PlantModel model(scenario);
    const Experiment experiment = make_experiment(scenario);
    const SearchSpace space(model, scenario, Coordinates::ratios);
    if (space.size() == 0) throw InputError(scenario.file.string() + ": identify", "no free parameter", "at least one");
    need_train(scenario, experiment);
    return to_json(identify(model, experiment, space, options), scenario.name, context_of(search, "lacuna.identify"));
  }));
}

py::object diagnose_scenario(const Scenario& scenario, const std::string& engine, const std::string& optimizer,
                             int population, int generations, std::uint64_t seed, int threads, bool other_engines) {
  const Search search{engine, optimizer, population, generations, seed, threads, std::nullopt};
  return dict_of(interruptible([&](const StopFlag& stop) {
    DiagnoseOptions options;
    options.identify = search.understood(stop);
    options.other_engines = other_engines;
    need_train(scenario, make_experiment(scenario));
    return to_json(diagnose(scenario, options), context_of(search, "lacuna.diagnose"));
  }));
}

py::object diff_scenarios(const Scenario& a, const Scenario& b, const std::string& engine, const std::string& optimizer,
                          int population, int generations, std::uint64_t seed, int threads) {
  const Search search{engine, optimizer, population, generations, seed, threads, std::nullopt};
  return with_arrays(dict_of(interruptible([&](const StopFlag& stop) {
    DiagnoseOptions options;
    options.identify = search.understood(stop);
    options.other_engines = false;  // a diff has no use for it
    check_comparable(a, b);
    need_train(a, make_experiment(a)), need_train(b, make_experiment(b));
    const Diagnosis of_a = diagnose(a, options), of_b = diagnose(b, options);
    return to_json(compare_sets(a, of_a, b, of_b, options.identify), context_of(search, "lacuna.diff"));
  })));
}

}  // namespace

void add_searches(py::module_& module) {
  const GeneticOptions standard;
  constexpr int kDiagnoseGenerations = 20;  // as `lacuna diagnose`: a short look around, every fit has a start
  module.def("identify", &identify_scenario, py::arg("scenario"), py::arg("engine") = "featherstone",
             py::arg("optimizer") = "ga+lsq", py::arg("population") = standard.population,
             py::arg("generations") = standard.generations, py::arg("seed") = 1, py::arg("threads") = 0,
             py::arg("step") = py::none(), "The free parameters from the train recordings: fit.json as a dict.");
  module.def("diagnose", &diagnose_scenario, py::arg("scenario"), py::arg("engine") = "featherstone",
             py::arg("optimizer") = "ga+lsq", py::arg("population") = standard.population,
             py::arg("generations") = kDiagnoseGenerations, py::arg("seed") = 1, py::arg("threads") = 0,
             py::arg("other_engines") = true, "What the scenario's model leaves out: diagnosis.json as a dict.");
  module.def("diff", &diff_scenarios, py::arg("a"), py::arg("b"), py::arg("engine") = "featherstone",
             py::arg("optimizer") = "ga+lsq", py::arg("population") = standard.population,
             py::arg("generations") = kDiagnoseGenerations, py::arg("seed") = 1, py::arg("threads") = 0,
             "What changed between two scenarios of one machine: diff.json as a dict, its lists of numbers as arrays.");
}

}  // namespace lacuna
