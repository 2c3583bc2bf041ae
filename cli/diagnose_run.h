// One diagnosis with its checkpoint, as `diagnose` and `blind` both run it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "cli/identify_flags.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

struct DiagnoseFlags {
  IdentifyFlags identify;
  bool no_engines = false;

  DiagnoseFlags() { identify.generations = 8; }
  /// The options of identify, and `--no-engines`.
  void add_to(CLI::App& command);
};

/// Refuses at once what the diagnosis would refuse later. Throws InputError.
void check_diagnosable(const Scenario& scenario);

/// What the diagnosis is about, in one line: data, options, seed.
std::string diagnosis_fingerprint(const Session& session, const DiagnoseFlags& flags, const Scenario& scenario);

/// Runs it, or resumes it from `folder`/checkpoint.json, which is there while it runs and named in the session.
Diagnosis run_diagnosis(Session& session, const DiagnoseFlags& flags, const Scenario& scenario,
                        const std::filesystem::path& folder, std::function<void(const Progress&)> progress);

}  // namespace lacuna
