// Runs the program as a user does, and a small arm for it to work on.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/scenarios/support.h"

namespace lacuna::test {

inline constexpr int kBadInput = 2, kNotDone = 3;  ///< exit codes (docs/formats.md)

struct Outcome {
  int code = -1;  ///< exit code; 128 + signal where a signal ended it
  std::string out, err;
};

/// A run of `lacuna`, its outputs in files of their own; `folder` is its working directory, `launcher` what stands
/// before it on the line (mpirun).
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments, const std::filesystem::path& folder = {},
                   const std::vector<std::string>& launcher = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t id() const { return process_; }
  void interrupt() const;
  void kill() const;  ///< -9
  bool running();
  Outcome wait();

 private:
  TemporaryFolder outputs_;
  pid_t process_ = -1;
  int status_ = 0;
};

Outcome lacuna(const std::vector<std::string>& arguments, const std::filesystem::path& folder = {});

/// Fails unless the run ended with `code`, no standard output, and one line on standard error with `part` in it.
void expect_refused(const Outcome& outcome, int code, const std::string& part);
/// The standard output of a run that must succeed.
nlohmann::json json_of(const Outcome& outcome);
nlohmann::json json_file(const std::filesystem::path& file);
/// Of a record what must not depend on threads, ranks, interruptions or the clock.
nlohmann::json numbers_of(const std::filesystem::path& file);
/// A study's records without what the clock decides, at any depth.
nlohmann::json without_clock(nlohmann::json record);
std::string text_of(const std::filesystem::path& file);
/// What `lacuna engines --json` says of each.
std::vector<nlohmann::json> engine_records();

/// For one link on a motor, in balance at 0: 4 s at 50 Hz, commands only: t, u.
std::string arm_commands(double phase = 0.0);
/// The arm's folder: arm.urdf, scenario.yaml, and train.csv, validate.csv, test.csv as simulated by the program itself
/// with `settings` ("elbow.gain=25") and a little noise.
class Arm {
 public:
  explicit Arm(const std::vector<std::string>& settings = {"elbow.gain=25", "elbow.damping=1.4"});

  const std::filesystem::path& folder() const { return folder_.path(); }
  std::string scenario() const { return (folder() / "scenario.yaml").string(); }
  const TemporaryFolder& files() const { return folder_; }

 private:
  void record(const std::string& name, double phase, const std::vector<std::string>& settings) const;
  TemporaryFolder folder_;
};
extern const std::string kArmScenario;

/// Columns of a CSV text by name.
std::map<std::string, std::vector<double>> columns_of(const std::string& csv);

/// Interrupts the command once `checkpoint` exists. Empty if it was done before; several tries are then due.
std::optional<Outcome> interrupted_run(const std::vector<std::string>& arguments,
                                       const std::filesystem::path& checkpoint);

}  // namespace lacuna::test
