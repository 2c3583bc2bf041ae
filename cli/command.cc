#include "cli/command.h"

#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <iostream>

#include "backends/engine.h"
#include "physics/plant_model.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/text.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

StopFlag stop{false};
const StopFlag* followed = &stop;
static_assert(StopFlag::is_always_lock_free, "a signal handler sets it");

void on_signal(int) { stop.store(true); }

/// strtoull would take "-1" for a very large number.
std::string whole_number(const std::string& text) {
  const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  return digits ? "" : "found " + quoted(text) + ", expected a whole number from 0";
}

}  // namespace

CLI::App& add_command(CLI::App& app, Session& session, const std::string& name, const std::string& description,
                      const std::string& example, std::function<void()> work) {
  CLI::App& command = *app.add_subcommand(name, description);
  command.add_flag("--json", session.json, "The result as JSON on standard output; logs stay on standard error");
  command.add_option("--threads", session.threads, "Threads to compute on (default: all)")->check(CLI::Range(1, 4096));
  command.add_option("--seed", session.seed, "Seed of every random draw (default: 1)")->check(whole_number);
  command.add_option("-o,--output", session.output, "Folder for the files written");
  command.footer("Example:\n  " + example);
  command.callback([&session, work = std::move(work)] { session.run = work; });
  return command;
}

CLI::App& add_scenario_command(CLI::App& app, Session& session, const std::string& name, const std::string& description,
                               const std::string& example, std::function<void()> work) {
  CLI::App& command = add_command(app, session, name, description, example, std::move(work));
  command.add_option("SCENARIO", session.scenario_file, "The scenario file (scenario.yaml)")
      ->required()
      ->option_text(" ");
  return command;
}

const StopFlag& stop_flag() { return *followed; }

void stop_with(const Ranks& ranks) { followed = &ranks.stop(); }

const StopFlag& watch_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  // The default returns with the first signal, so that a second one ends a program that does not listen.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);  // a file larger than `ulimit -f` allows is an error of the writing, not our end
  return stop;
}

void print(const std::string& text) {
  std::cout << text << std::flush;
  if (!std::cout) throw WriteError(std::string("cannot write to standard output: ") + std::strerror(errno));
}

void log_notes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) spdlog::info(note);
}

void log_notes(const Scenario& scenario) {
  log_notes(scenario.notes);
  log_notes(idle_effects(scenario));
}

fs::path Session::output_folder(const Scenario& scenario) const {
  const fs::path folder = output.empty() ? fs::path("out") / file_name(scenario.name) : fs::path(output);
  make_folder(folder);
  return folder;
}

std::string file_name(const std::string& text) {
  std::string out;
  for (const unsigned char c : text.substr(0, 100)) {
    const bool plain = std::isalnum(c) != 0 || c == '_' || c == '-' || (c == '.' && !out.empty() && out.back() != '.');
    out += plain && c < 0x80 ? static_cast<char>(c) : '_';
  }
  return out.empty() ? "_" : out;
}

void make_parent_folder(const fs::path& file) {
  make_folder(file.has_parent_path() ? file.parent_path() : fs::path("."));
}

void refuse_overwriting(const fs::path& source, const fs::path& target) {
  std::error_code ignored;
  if (fs::equivalent(source, target, ignored))
    throw InputError("--output", quoted(target.string()) + ", which this command reads", "another folder");
}

std::vector<std::string> engines_named(const std::string& text) {
  std::vector<std::string> out;
  if (text == "all") {
    for (const Engine* engine : engines()) {
      if (engine->info().available) out.push_back(engine->info().name);
    }
    return out;
  }
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string name = text.substr(begin, end - begin);
    const EngineInfo info = find_engine(name).info();
    if (!info.available) throw WorkError("engine " + name + " is not available: " + info.reason);
    if (std::find(out.begin(), out.end(), name) != out.end())
      throw InputError("--engine", quoted(name) + " twice", "each engine once");
    out.push_back(name);
    begin = end + 1;
  }
  return out;
}

std::string engine_named(const std::string& name) {
  const EngineInfo info = find_engine(name).info();
  if (!info.available) throw WorkError("engine " + name + " is not available: " + info.reason);
  return name;
}

}  // namespace lacuna
