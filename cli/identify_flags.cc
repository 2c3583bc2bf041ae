#include "cli/identify_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/pictures.h"

namespace lacuna {

void IdentifyFlags::add_to(CLI::App& command, bool everything) {
  command.add_option("--engine", engine,
                     everything ? "Engine, several with commas, or all (default: featherstone)"
                                : "Engine to identify on (default: featherstone)");
  command.add_option("--optimizer", optimizer, "ga, cmaes, de, lsq or ga+lsq (default: ga+lsq)");
  command.add_option("--population", population,
                     fmt::format("Parameter sets per generation (default: {})", population));
  command.add_option("--generations", generations, fmt::format("Generations (default: {})", generations));
  command.add_flag("--no-pictures", no_pictures, "Leaves out the pose snapshots");
  add_package_paths(command, package_paths);
  if (!everything) return;
  const GeneticOptions standard;
  const auto add = [&](const char* name, std::string& value, const char* choices, const char* preset) {
    value = preset;
    command.add_option(name, value, fmt::format("{} (default: {})", choices, preset));
  };
  add("--fitness", fitness, "norm_1, norm_2 or norm_inf, each also with _relative", to_string(Fitness::norm_2));
  add("--coding", coding, "mvbs or integer", to_string(standard.coding));
  add("--crossover", crossover, "pointwise, uniform_gene or uniform_bit", to_string(standard.crossover));
  add("--mutation", mutation, "per_gene, per_bit or per_chromosome", to_string(standard.mutation));
  add("--selection", selection, "roulette, roulette_literal, tournament or rank", to_string(standard.selection));
}

IdentifyOptions IdentifyFlags::understood(const Session& session, const std::string& engine_name) const {
  IdentifyOptions out;
  out.optimizer = optimizer_from_name(optimizer);
  if (!fitness.empty()) out.fitness = fitness_from_name(fitness);
  if (!coding.empty()) out.genetic.coding = coding_from_name(coding);
  if (!crossover.empty()) out.genetic.crossover = crossover_from_name(crossover);
  if (!mutation.empty()) out.genetic.mutation = mutation_from_name(mutation);
  if (!selection.empty()) out.genetic.selection = selection_from_name(selection);
  out.genetic.population = population;
  out.genetic.generations = generations;
  out.genetic.seed = session.seed;
  out.simulator.engine = engine_name;
  out.simulator.threads = session.threads;
  out.simulator.stop = &stop_flag();
  out.simulator.ranks = session.ranks.get();
  out.control.stop = &stop_flag();
  out.control.writes = session.first();
  return out;
}

std::vector<std::string> IdentifyFlags::words() const {
  return {optimizer, fitness, coding, crossover, mutation, selection, fmt::format("population {}", population)};
}

}  // namespace lacuna
