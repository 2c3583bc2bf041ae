// What all subcommands share: their common options, where results and logs go, and how work is stopped.
//
// A subcommand is one file that defines `void add_NAME(CLI::App&, Session&)` and one entry in main.cc.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "physics/ranks.h"
#include "reports/context.h"
#include "scenarios/scenario.h"

namespace CLI {
class App;
}

namespace lacuna {

/// The command line as understood, and the work that it asks for.
struct Session {
  bool json = false;
  int threads = 0;  ///< at least 1 once the command runs
  std::uint64_t seed = 1;
  std::string output;                              ///< as given with -o; empty: none
  std::string command_line;                        ///< as the user gave it
  std::string scenario_file;                       ///< for subcommands that take one
  std::vector<std::filesystem::path> checkpoints;  ///< files from any of which an interrupted command resumes
  std::function<void()> run;                       ///< set by the subcommand that was named
  std::shared_ptr<Ranks> ranks;                    ///< null unless started as one of several

  /// Whether this process writes and prints; the other ranks compute only.
  bool first() const { return ranks == nullptr || ranks->first(); }

  /// `-o`, else out/<scenario's name>; created. Throws WriteError where nothing can be written there.
  std::filesystem::path output_folder(const Scenario& scenario) const;
  Context context() const { return make_context(seed, threads, command_line, ranks ? ranks->size() : 1); }
};

/// One subcommand's entry in the program.
using AddCommand = void(CLI::App& app, Session& session);

/// A subcommand with the common options; `work` runs once the whole line is understood. `example` closes its help.
CLI::App& add_command(CLI::App& app, Session& session, const std::string& name, const std::string& description,
                      const std::string& example, std::function<void()> work);
/// The same with the positional SCENARIO.
CLI::App& add_scenario_command(CLI::App& app, Session& session, const std::string& name, const std::string& description,
                               const std::string& example, std::function<void()> work);

/// What work looks at: set by SIGINT and SIGTERM, or by the ranks once all of them know of it.
const StopFlag& stop_flag();
/// Set by this process's own signals; a second one ends the program at once.
const StopFlag& watch_signals();
/// From here on stop_flag() is the ranks', which must stay.
void stop_with(const Ranks& ranks);

/// Text on standard output. Throws WriteError where it cannot be written.
void print(const std::string& text);
/// What loading noticed, to the log.
void log_notes(const std::vector<std::string>& notes);
/// The same of a scenario, and what in it does nothing.
void log_notes(const Scenario& scenario);

/// A file name made of a user's text: letters, digits, '.', '_', '-'; never hidden, never empty.
std::string file_name(const std::string& text);
/// Creates the folder of `file` where it is missing. Throws WriteError where nothing can be written there.
void make_parent_folder(const std::filesystem::path& file);
/// Throws InputError where `target` is `source` itself, which the command only reads.
void refuse_overwriting(const std::filesystem::path& source, const std::filesystem::path& target);

/// Names of the engines meant by `--engine`: one name, several with commas, or "all" that are built in.
/// Throws InputError for an unknown one, WorkError with the reason for one that is not built.
std::vector<std::string> engines_named(const std::string& text);
/// The one engine named; the same errors.
std::string engine_named(const std::string& name);

}  // namespace lacuna
