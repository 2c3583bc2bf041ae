// lacuna_generate_recordings FOLDER
//   writes the bundled recordings below FOLDER (scenarios/ of the source tree)
// lacuna_generate_recordings --check FOLDER [SECONDS]
//   changes nothing; fails where a recording there differs by over twice the last digit that is written; SECONDS: only
//   the first ones of each
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "backends/engine.h"
#include "ga/random.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/generate/machine.h"

namespace {

using lacuna::ChannelKind;
using lacuna::Recording;
using lacuna::Scenario;

constexpr double kNoise = 3e-4;           // rad, rms
constexpr double kPrismaticNoise = 3e-5;  // m, rms
constexpr double kPressureNoise = 1e4;    // Pa, rms
constexpr int kDigits = 5;                // behind the point, of positions
constexpr int kPressureDigits = 2;        // of pressures, bar
constexpr double kAgreement = 2.0;        // of the last digit: another machine may round the other way
constexpr std::uint64_t kSeed = 20;
constexpr int kSkipped = 77;  // what ctest takes for "not run"

struct Job {
  const char *truth, *commands, *recording;  // paths below FOLDER/hydrolek
};
constexpr Job kJobs[] = {
    {"joint_2_table1/truth.yaml", "commands_joint_2_multisine.csv", "joint_2_table1/train.csv"},
    {"joint_2_table1/truth.yaml", "commands_joint_2_staircase.csv", "joint_2_table1/validate.csv"},
    {"joint_2_table1/truth.yaml", "commands_joint_2_steps.csv", "joint_2_table1/test.csv"},
    {"joint_2_table5/truth.yaml", "commands_joint_2_multisine.csv", "joint_2_table5/train.csv"},
    {"joint_2_table5/truth.yaml", "commands_joint_2_staircase.csv", "joint_2_table5/validate.csv"},
    {"joint_2_table5/truth.yaml", "commands_joint_2_steps.csv", "joint_2_table5/test.csv"},
    {"all_joints/truth.yaml", "commands_all_multisine.csv", "all_joints/train_1.csv"},
    {"all_joints/truth.yaml", "commands_all_steps.csv", "all_joints/train_2.csv"},
    {"all_joints/truth.yaml", "commands_all_staircase.csv", "all_joints/validate_1.csv"},
    {"all_joints/truth.yaml", "commands_all_triangle.csv", "all_joints/test_1.csv"},
    {"demo/truth.yaml", "commands_all_multisine.csv", "demo/train_1.csv"},
    {"demo/truth.yaml", "commands_all_steps.csv", "demo/train_2.csv"},
    {"demo/truth.yaml", "commands_all_triangle.csv", "demo/train_3.csv"},
    {"demo/truth.yaml", "commands_all_staircase.csv", "demo/validate_1.csv"},
    {"demo/truth.yaml", "demo/commands_chirp.csv", "demo/test_1.csv"},
    {"hydraulic/truth.yaml", "commands_all_multisine.csv", "hydraulic/train_1.csv"},
    {"hydraulic/truth.yaml", "commands_all_steps.csv", "hydraulic/train_2.csv"},
    {"hydraulic/truth.yaml", "commands_all_staircase.csv", "hydraulic/validate_1.csv"},
    {"hydraulic/truth.yaml", "commands_all_triangle.csv", "hydraulic/test_1.csv"},
    {"hydraulic/joint_2/truth.yaml", "commands_joint_2_multisine.csv", "hydraulic/joint_2/train.csv"},
    {"hydraulic/joint_2/truth.yaml", "commands_joint_2_staircase.csv", "hydraulic/joint_2/validate.csv"},
    {"hydraulic/joint_2/truth.yaml", "commands_joint_2_steps.csv", "hydraulic/joint_2/test.csv"},
};

/// What a transducer writes into its column.
struct Signal {
  std::string column;
  std::vector<double> values;  // in the column's unit, with noise
  int digits;
};

bool is_pressure(ChannelKind kind) { return kind == ChannelKind::pressure_a || kind == ChannelKind::pressure_b; }

/// Signals of one kind, in the order of the robot's joints. `number` of the recording keys the noise.
void add_signals(const Scenario& truth, ChannelKind kind, const std::vector<std::vector<double>>& course,
                 std::uint32_t number, std::vector<Signal>& out) {
  const auto columns = truth.channels.of.find(kind);
  if (columns == truth.channels.of.end()) return;
  for (std::size_t j = 0; j < course.size(); ++j) {
    const auto& joint = truth.robot->joints()[j];
    const auto column = columns->second.find(joint.name);
    if (column == columns->second.end()) continue;
    const double noise = is_pressure(kind) ? kPressureNoise : joint.prismatic() ? kPrismaticNoise : kNoise;
    constexpr std::uint32_t kMostJoints = 1000;  // keeps the streams of the kinds apart
    const std::uint32_t of_kind = kind == ChannelKind::position ? 0 : kind == ChannelKind::pressure_a ? 1 : 2;
    lacuna::RandomStream stream(kSeed, number, static_cast<std::uint32_t>(j) + of_kind * kMostJoints);
    Signal signal{column->second.column, course[j], is_pressure(kind) ? kPressureDigits : kDigits};
    for (double& value : signal.values)
      value = (value + noise * stream.normal() - column->second.offset) / column->second.scale;
    out.push_back(std::move(signal));
  }
}

/// The recording as text: time and commands as given, then what was measured.
std::string recorded(const Scenario& truth, const Recording& commands, std::uint32_t number) {
  const lacuna::generate::Course course = lacuna::generate::true_course(truth, commands);
  std::vector<Signal> signals;
  add_signals(truth, ChannelKind::position, course.position, number, signals);
  add_signals(truth, ChannelKind::pressure_a, course.pressure_a, number, signals);
  add_signals(truth, ChannelKind::pressure_b, course.pressure_b, number, signals);
  std::string text = fmt::format("{}", fmt::join(commands.names, ","));
  for (const Signal& signal : signals) text += "," + signal.column;
  text += '\n';
  for (std::size_t i = 0; i < commands.rows(); ++i) {
    text += fmt::format("{:.2f}", commands.columns[0][i]);
    for (std::size_t c = 1; c < commands.columns.size(); ++c) text += fmt::format(",{:.3f}", commands.columns[c][i]);
    for (const Signal& signal : signals) text += fmt::format(",{:.{}f}", signal.values[i], signal.digits);
    text += '\n';
  }
  return text;
}

/// The first `seconds` of a recording.
Recording first(const Recording& whole, double seconds) {
  Recording out = whole;
  const auto& time = whole.columns.front();
  const auto rows = std::upper_bound(time.begin(), time.end(), seconds) - time.begin();
  for (auto& column : out.columns) column.resize(rows);
  return out;
}

/// Digits behind the point of a column.
int digits_of(const Scenario& truth, const std::string& column) {
  for (const auto& [kind, columns] : truth.channels.of)
    for (const auto& [joint, spec] : columns)
      if (is_pressure(kind) && spec.column == column) return kPressureDigits;
  return kDigits;
}

/// Largest difference between two recordings, in last digits; infinite where their shape or names differ.
double difference(const Scenario& truth, const Recording& a, const Recording& b) {
  if (a.names != b.names || a.rows() != b.rows() || a.missing + b.missing > 0) return HUGE_VAL;
  double worst = 0.0;
  for (std::size_t c = 0; c < a.columns.size(); ++c) {
    const double last = std::pow(10.0, -digits_of(truth, a.names[c]));
    for (std::size_t i = 0; i < a.rows(); ++i)
      worst = std::max(worst, std::abs(a.columns[c][i] - b.columns[c][i]) / last);
  }
  return worst;
}

/// Recordings that differ (check) or were written.
int run(const std::filesystem::path& folder, bool check, double seconds) {
  const auto scratch = std::filesystem::temp_directory_path() /
                       fmt::format("lacuna_recording_{:x}.csv", std::hash<std::string>()(folder.string()));
  int count = 0;
  for (std::uint32_t k = 0; k < std::size(kJobs); ++k) {
    const Job& job = kJobs[k];
    const Scenario truth = lacuna::load_scenario(folder / job.truth, {.load_recordings = false});
    const Recording commands = first(*lacuna::load_recording(folder / job.commands, job.commands), seconds);
    const std::string text = recorded(truth, commands, k);
    if (!check) {
      lacuna::write_file_atomically(folder / job.recording, text);
      std::cout << "written: " << job.recording << '\n';
      ++count;
      continue;
    }
    lacuna::write_file_atomically(scratch, text);
    const double worst = difference(truth, *lacuna::load_recording(scratch, "regenerated"),
                                    first(*lacuna::load_recording(folder / job.recording, job.recording), seconds));
    if (worst <= kAgreement) continue;
    std::cout << "differs by " << worst << " last digits: " << job.recording << '\n';
    ++count;
  }
  std::filesystem::remove(scratch);
  std::cout << std::size(kJobs) << " recordings, " << count << (check ? " differ\n" : " written\n");
  return count;
}

}  // namespace

int main(int argc, char** argv) {
  const bool check = argc > 1 && std::string(argv[1]) == "--check";
  const int first_argument = check ? 2 : 1;
  if (argc <= first_argument || argc > first_argument + (check ? 2 : 1)) {
    std::cerr << "usage: lacuna_generate_recordings FOLDER | --check FOLDER [SECONDS]\n";
    return 2;
  }
  try {
    const lacuna::EngineInfo engine = lacuna::find_engine("simbody").info();
    if (!engine.available) {
      std::cout << "skipped, recordings are made by Simbody: " << engine.reason << '\n';
      return check ? kSkipped : 3;
    }
    const double seconds = argc > first_argument + 1 ? std::stod(argv[first_argument + 1]) : HUGE_VAL;
    const int count = run(std::filesystem::path(argv[first_argument]) / "hydrolek", check, seconds);
    return check && count > 0 ? 1 : 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
}
