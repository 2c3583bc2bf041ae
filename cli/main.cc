// `lacuna`: reads the command line, runs one subcommand, and turns every failure into one line and an exit code.
#include <fmt/format.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "cli/command.h"
#include "cli/progress.h"
#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {

// The subcommands, one file each, in the order of the help.
AddCommand add_init, add_engines, add_effects, add_simulate, add_compare, add_identify, add_study, add_excite,
    add_diagnose, add_diff, add_conceal, add_blind, add_render, add_export;

namespace {

constexpr AddCommand* kCommands[] = {
    add_init,      //
    add_engines,   //
    add_effects,   //
    add_simulate,  //
    add_compare,   //
    add_identify,  //
    add_study,     //
    add_excite,    //
    add_diagnose,  //
    add_diff,      //
    add_conceal,   //
    add_blind,     //
    add_render,    //
    add_export,
};

/// Those that every rank runs, to share the work; what they write and print is guarded by Session::first(). Of the
/// others only the first rank's run is needed.
constexpr std::string_view kOnEveryRank[] = {"identify", "diagnose", "study", "blind"};

constexpr int kBadInput = 2, kNotDone = 3, kInterrupted = 130;

std::string joined(int argc, char** argv) {
  std::string out;
  for (int i = 0; i < argc; ++i) out += (i > 0 ? " " : "") + std::string(argv[i]);
  return out;
}

void send_logs_to_standard_error() {
  auto logger = spdlog::stderr_logger_mt("lacuna");
  logger->set_pattern("lacuna: %l: %v");
  spdlog::set_default_logger(std::move(logger));
}

void describe(CLI::App& app) {
  app.name("lacuna");
  app.description("Finds the physics that a robot simulation leaves out.");
  app.set_version_flag("--version", std::string("lacuna ") + version(), "The version, and nothing else");
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  lacuna init my_arm.urdf run_1.csv run_2.csv -o my_arm   a first scenario.yaml from a robot and its "
      "recordings\n"
      "  lacuna diagnose my_arm/scenario.yaml -o out/my_arm      what the model leaves out, with a report\n"
      "  lacuna identify my_arm/scenario.yaml --engine mujoco    its parameters, with intervals\n"
      "  lacuna simulate my_arm/scenario.yaml > simulated.csv    what the model predicts\n"
      "  lacuna COMMAND --help                                   options of one command\n\n"
      "Exit codes: 0 done; 2 bad usage or input; 3 the work could not be done; 130 interrupted.");
}

std::string interrupted_message(const Session& session) {
  for (const std::filesystem::path& file : session.checkpoints) {
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return "interrupted; the same command resumes from " + file.string();
  }
  return "interrupted; nothing was finished that could be resumed from";
}

/// Does the work; every failure becomes an exit code and one line.
Ending run(Session& session) {
  try {
    session.run();
    return {};
  } catch (const RanksParted& error) {
    return {error.code, error.what()};
  } catch (const Interrupted&) {
    return {kInterrupted, interrupted_message(session)};
  } catch (const InputError& error) {
    return {kBadInput, error.what()};
  } catch (const std::invalid_argument& error) {
    return {kBadInput, error.what()};
  } catch (const std::bad_alloc&) {
    return {kNotDone, "out of memory"};
  } catch (const std::exception& error) {
    return {kNotDone, error.what()};
  }
}

/// The first argument that should be a command and is none; else empty.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return "";
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return "";
  return InputError("command", quoted(std::string(argv[1])), one_of(names)).what();
}

/// Understands the line, prints help where that was asked for, and says what to run: nothing where all is done.
Ending read_command_line(int argc, char** argv, CLI::App& app, Session& session) {
  describe(app);
  for (AddCommand* add : kCommands) add(app, session);
  if (const std::string unknown = unknown_command(app, argc, argv); !unknown.empty()) return {kBadInput, unknown};
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    session.run = nullptr;
    if (error.get_exit_code() != 0)
      return {kBadInput,
              std::string(error.what()) + "; `lacuna --help` and `lacuna COMMAND --help` list what there is"};
    if (!session.first()) return {};
    app.exit(error);  // --help, --version
    print("");        // says where that could not be written
  }
  return {};
}

/// Everything that must be alike for ranks to compute the same bits, in words.
std::string identity_of(const Session& session) {
  const Context c = session.context();
  return fmt::format("lacuna {} commit {} ({} {}) with lanes {}, run as `{}`", c.version, c.commit, c.compiler, c.flags,
                     c.lanes, c.command_line);
}

void join(Session& session, const StopFlag& asked) {
  if (!started_as_rank()) return;
  session.ranks = join_ranks(asked);
  set_progress_style(session.first() ? ProgressStyle::log : ProgressStyle::none);
  if (!session.first()) spdlog::set_level(spdlog::level::off);
}

/// All CPUs; ranks on one machine share them, unless each was bound to its own.
int threads_for(const Session& session) {
  const int neighbours = session.ranks ? session.ranks->neighbours() : 1;
  const int share = static_cast<int>(std::thread::hardware_concurrency()) / neighbours;
  return neighbours > 1 ? std::clamp(share, 1, default_threads()) : default_threads();
}

Ending do_command(int argc, char** argv, Session& session) {
  CLI::App app;
  Ending read = read_command_line(argc, argv, app, session);
  if (read.code != 0 || !session.run) return read;
  if (session.threads < 1) session.threads = threads_for(session);
  if (!session.ranks) return run(session);
  const std::string command = app.get_subcommands().front()->get_name();
  if (std::find(std::begin(kOnEveryRank), std::end(kOnEveryRank), command) == std::end(kOnEveryRank))
    return session.first() ? run(session) : Ending{};
  stop_with(*session.ranks);
  session.run = [work = session.run, &session] {
    session.ranks->agree_on(identity_of(session));
    work();
  };
  return run(session);
}

int main_program(int argc, char** argv) {
  send_logs_to_standard_error();
  Session session;
  session.command_line = joined(argc, argv);
  join(session, watch_signals());
  Ending ending = do_command(argc, argv, session);
  if (session.ranks) ending = session.ranks->part(ending);
  if (session.first() && !ending.message.empty())
    std::cerr << "lacuna: " << printable(ending.message, 2000) << std::endl;
  if (session.ranks && !session.ranks->leave()) std::_Exit(ending.code);
  return ending.code;
}

}  // namespace
}  // namespace lacuna

int main(int argc, char** argv) {
  try {
    return lacuna::main_program(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "lacuna: " << error.what() << std::endl;
    return 3;
  }
}
