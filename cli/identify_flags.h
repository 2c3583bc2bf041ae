// Options of the search, shared by identify and diagnose.
#pragma once

#include <string>

#include "cli/command.h"
#include "ga/identify.h"

namespace lacuna {

struct IdentifyFlags {
  std::string engine = "featherstone", optimizer = "ga+lsq", fitness, coding, crossover, mutation, selection;
  int population = 70, generations = 200;
  std::vector<std::string> package_paths;
  bool no_pictures = false;

  /// `--engine`, `--optimizer`, `--population`, `--generations`, `--no-pictures`,
  /// `--package-path`; `everything`: the paper's other
  /// choices too.
  void add_to(CLI::App& command, bool everything);
  /// Understood; simulator and control with threads, engine and stop flag of the session. Throws InputError.
  IdentifyOptions understood(const Session& session, const std::string& engine_name) const;
  /// What of them decides the result, in one text per option.
  std::vector<std::string> words() const;
};

}  // namespace lacuna
