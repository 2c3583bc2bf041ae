#include "tests/cli/program.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <thread>

#include "scenarios/text.h"

namespace lacuna::test {
namespace fs = std::filesystem;

namespace {

/// Of the recordings, degrees: 3e-4 rad, as the scenario says.
constexpr double kNoise = 3e-4 / 0.017453292519943295;

int exit_code(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

/// White, with a standard deviation of 1, the same on every machine: twelve uniform numbers less six (splitmix64).
double noise(std::uint64_t stream, std::uint64_t i) {
  double sum = -6.0;
  for (std::uint64_t k = 0; k < 12; ++k) {
    std::uint64_t z = (stream << 40) + 12 * i + k + 1;
    z *= 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    sum += static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  return sum;
}

}  // namespace

Program::Program(const std::vector<std::string>& arguments, const fs::path& folder,
                 const std::vector<std::string>& launcher) {
  const std::string out = (outputs_.path() / "out").string(), err = (outputs_.path() / "err").string();
  std::vector<std::string> line = launcher;
  line.emplace_back(LACUNA_EXECUTABLE);
  line.insert(line.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : line) argv.push_back(argument.data());
  argv.push_back(nullptr);
  process_ = ::fork();
  if (process_ != 0) return;
  const int out_file = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int err_file = ::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(out_file, STDOUT_FILENO);
  ::dup2(err_file, STDERR_FILENO);
  if (folder.empty() || ::chdir(folder.c_str()) == 0) ::execvp(argv.front(), argv.data());
  ::_exit(127);
}

Program::~Program() {
  if (process_ <= 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

void Program::interrupt() const {
  if (process_ > 0) ::kill(process_, SIGINT);  // -1 would mean every process
}

void Program::kill() const {
  if (process_ > 0) ::kill(process_, SIGKILL);
}

bool Program::running() {
  if (process_ > 0 && ::waitpid(process_, &status_, WNOHANG) == process_) process_ = -1;
  return process_ > 0;
}

Outcome Program::wait() {
  if (process_ > 0) ::waitpid(process_, &status_, 0);
  process_ = -1;
  return {exit_code(status_), text_of(outputs_.path() / "out"), text_of(outputs_.path() / "err")};
}

Outcome lacuna(const std::vector<std::string>& arguments, const fs::path& folder) {
  return Program(arguments, folder).wait();
}

void expect_refused(const Outcome& outcome, int code, const std::string& part) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_THAT(outcome.err, testing::StartsWith("lacuna: "));
  EXPECT_THAT(outcome.err, testing::HasSubstr(part));
}

nlohmann::json json_of(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out, nullptr, false);
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

nlohmann::json json_file(const fs::path& file) { return nlohmann::json::parse(text_of(file), nullptr, false); }

nlohmann::json without_clock(nlohmann::json record) {
  if (record.is_object()) {
    for (const char* key : {"seconds", "run_seconds", "longest_seconds", "context"}) record.erase(key);
    for (auto& [key, value] : record.items()) value = without_clock(value);
  } else if (record.is_array()) {
    for (auto& value : record) value = without_clock(value);
  }
  return record;
}

nlohmann::json numbers_of(const fs::path& file) {
  auto record = json_file(file);
  for (const char* key : {"seconds", "context"}) record.erase(key);
  if (record.contains("engines"))
    for (auto& engine : record.at("engines")) engine.erase("seconds");
  return record;
}

std::vector<nlohmann::json> engine_records() { return json_of(lacuna({"engines", "--json"})).at("engines"); }

std::string arm_commands(double phase) {
  std::ostringstream out;
  out << "t,u\n";
  for (int i = 0; i < 200; ++i) {
    const double t = 0.02 * i;
    const double wave = 2.0 * std::sin(2.1 * t + phase) + 1.5 * std::sin(5.3 * t + 2.0 * phase);
    out << t << ',' << std::min(1.0, t * t) * wave << '\n';  // from rest
  }
  return out.str();
}

const std::string kArmScenario = R"(format: lacuna-scenario/1
name: arm
robot: arm.urdf
gravity: [0, 0, -9.81]
actuators:
  elbow: {model: torque_source, gain: 20, damping: 1, stiffness: 30, rest: 0.2616}
identify:
  gain: {relative_bounds: [0.25, 4]}
  damping: {relative_bounds: [0.25, 4]}
channels:
  time: t
  command: {elbow: u}
  position: {elbow: {column: degrees, scale: 0.017453292519943295, offset: 0.1}}
noise:
  position: 0.0003
recordings:
  - {file: train.csv, role: train}
  - {file: validate.csv, role: validate}
  - {file: test.csv, role: test}
)";

Arm::Arm(const std::vector<std::string>& settings) {
  folder_.write("arm.urdf", R"(<?xml version='1.0'?>
<robot name='arm'>
  <link name='base'/>
  <link name='beam'>
    <inertial><origin xyz='0.4 0 0'/><mass value='2'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.2'/></inertial>
    <visual><origin xyz='0.4 0 0'/><geometry><box size='0.8 0.1 0.1'/></geometry></visual>
  </link>
  <joint name='elbow' type='revolute'><parent link='base'/><child link='beam'/><axis xyz='0 -1 0'/><limit lower='-3' upper='3' effort='100' velocity='9'/></joint>
</robot>
)");
  folder_.write("scenario.yaml", kArmScenario);
  record("train", 0.0, settings);
  record("validate", 1.0, settings);
  record("test", 2.0, settings);
}

void Arm::record(const std::string& name, double phase, const std::vector<std::string>& settings) const {
  const fs::path commands = folder_.write("commands_" + name + ".csv", arm_commands(phase));
  std::vector<std::string> arguments{"simulate", scenario(), "--recording", commands.string()};
  for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
  const Outcome outcome = lacuna(arguments);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  auto columns = columns_of(outcome.out);
  std::ostringstream out;
  out.precision(17);
  out << "t,u,degrees,spare\n";
  for (std::size_t i = 0; i < columns["t"].size(); ++i)
    out << columns["t"][i] << ',' << columns["u"][i] << ',' << columns["degrees"][i] + kNoise * noise(name.size(), i)
        << ",7\n";
  folder_.write(name + ".csv", out.str());
}

std::map<std::string, std::vector<double>> columns_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line, field;
  std::vector<std::string> names;
  std::map<std::string, std::vector<double>> out;
  std::getline(lines, line);
  for (std::istringstream header(line); std::getline(header, field, ',');) names.push_back(field);
  while (std::getline(lines, line)) {
    std::size_t column = 0;
    for (std::istringstream row(line); std::getline(row, field, ','); ++column)
      out[names.at(column)].push_back(parse_number(field).value());
  }
  return out;
}

std::optional<Outcome> interrupted_run(const std::vector<std::string>& arguments, const fs::path& checkpoint) {
  Program program(arguments);
  while (program.running() && !fs::exists(checkpoint)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (!program.running()) return std::nullopt;
  program.interrupt();
  const Outcome outcome = program.wait();
  return outcome.code == 0 ? std::nullopt : std::optional(outcome);
}

}  // namespace lacuna::test
