// `lacuna`: reads the command line, runs one subcommand, and turns every failure into one line and an exit code.
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>
#include <stdexcept>

#include "cli/command.h"
#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {

// The subcommands, one file each, in the order of the help.
AddCommand add_engines, add_effects, add_simulate, add_identify, add_study, add_excite, add_diagnose, add_conceal,
    add_blind, add_render, add_export;

namespace {

constexpr AddCommand* kCommands[] = {
    add_engines,   //
    add_effects,   //
    add_simulate,  //
    add_identify,  //
    add_study,     //
    add_excite,    //
    add_diagnose,  //
    add_conceal,   //
    add_blind,     //
    add_render,    //
    add_export,
};

constexpr int kBadInput = 2, kNotDone = 3, kInterrupted = 130;

/// One line on standard error, whatever the message holds.
int fail(int code, const std::string& message) {
  std::cerr << "lacuna: " << printable(message, 2000) << std::endl;
  return code;
}

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

int run(Session& session) {
  try {
    session.run();
    return 0;
  } catch (const Interrupted&) {
    return fail(kInterrupted, interrupted_message(session));
  } catch (const InputError& error) {
    return fail(kBadInput, error.what());
  } catch (const std::invalid_argument& error) {
    return fail(kBadInput, error.what());
  } catch (const std::bad_alloc&) {
    return fail(kNotDone, "out of memory");
  } catch (const std::exception& error) {
    return fail(kNotDone, error.what());
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

int main_program(int argc, char** argv) {
  send_logs_to_standard_error();
  watch_signals();
  Session session;
  session.command_line = joined(argc, argv);
  CLI::App app;
  describe(app);
  for (AddCommand* add : kCommands) add(app, session);
  if (const std::string unknown = unknown_command(app, argc, argv); !unknown.empty()) return fail(kBadInput, unknown);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return fail(kBadInput,
                std::string(error.what()) + "; `lacuna --help` and `lacuna COMMAND --help` list what there is");
  }
  if (session.threads < 1) session.threads = default_threads();
  return run(session);
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
