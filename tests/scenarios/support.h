// What the tests of this room share: temporary folders, a small valid robot, scenario and recording to be spoiled.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/error.h"
#include "scenarios/scenario.h"

namespace lacuna::test {

/// A folder of its own, gone with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    static std::atomic<int> counter{0};
    path_ = std::filesystem::temp_directory_path() /
            ("lacuna_" + std::to_string(::getpid()) + "_" + std::to_string(counter++));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    auto file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

 private:
  std::filesystem::path path_;
};

/// The message of the InputError that `work` throws; "" and a failure where it throws none.
template <typename Work>
std::string input_error(Work&& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return "";
  }
  ADD_FAILURE() << "no InputError";
  return "";
}

/// A column by its name; throws where there is none.
inline const std::vector<double>& column(const Recording& data, const std::string& name) {
  return data.columns.at(static_cast<std::size_t>(data.find(name)));
}

/// `text` with the one occurrence of `from` replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << "nothing to replace: " << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

/// A text spoiled in one place, and what its refusal must say.
struct Spoiled {
  const char* name;
  const char* from;
  const char* to;
  const char* message;  ///< a part of it
};

inline const std::string kRobot = R"(<?xml version='1.0'?>
<robot name='two'>
  <link name='base'/>
  <link name='upper'>
    <inertial><origin xyz='0.5 0 0'/><mass value='2'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.2'/></inertial>
  </link>
  <link name='lower'>
    <inertial><origin xyz='0.2 0 0'/><mass value='1'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.05' iyz='0' izz='0.05'/></inertial>
  </link>
  <joint name='a' type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 -1 0'/><limit lower='-2' upper='2' effort='100' velocity='1'/></joint>
  <joint name='b' type='revolute'><parent link='upper'/><child link='lower'/><origin xyz='1 0 0'/><axis xyz='0 -1 0'/><limit lower='-2' upper='2' effort='50' velocity='1'/></joint>
</robot>
)";

inline const std::string kScenario = R"(format: lacuna-scenario/1
name: two
robot: two.urdf
gravity: [0, 0, -9.81]
sample_period: 0.1
total_mass: 3
actuators:
  a: {model: torque_source, gain: 10, damping: 2}
  b: {model: torque_source, gain: 5, damping: 1}
identify:
  gain: {relative_bounds: [0.5, 2.0]}
  a.damping: [1, 4]
channels:
  time: t
  command: {a: u_a, b: {column: u_b, scale: 2, offset: -1, unit: "%"}}
  position: {a: q_a, b: q_b}
noise:
  position: {a: 0.001, b: 0.002}
recordings:
  - {file: run.csv, role: train, from: 0.0, to: 0.3}
  - {file: run.csv, role: test, from: 0.4}
effects:
  - {effect: coulomb_friction, where: a, parameters: {Fc: 3.5}, recordings: [run.csv]}
prediction: {horizon: 0.2}
)";

inline const std::string kRecording =
    "t,u_a,u_b,q_a,q_b\n"
    "0.0,1,2,0.10,0.20\n0.1,1,2,0.11,0.21\n0.2,1,2,,0.22\n0.3,1,2,0.13,nan\n"
    "0.4,1,2,0.14,0.24\n0.5,1,2,0.15,0.25\n0.6,1,2,0.16,0.26\n";

/// A folder with the valid three files.
class ScenarioFolder : public TemporaryFolder {
 public:
  explicit ScenarioFolder(const std::string& scenario = kScenario) {
    write("two.urdf", kRobot);
    write("run.csv", kRecording);
    file = write("scenario.yaml", scenario);
  }
  std::filesystem::path file;
};

/// The folder of shared data, where there is one: $LACUNA_DATA, else ../shared beside the source tree.
inline std::optional<std::filesystem::path> shared_data() {
  const char* given = std::getenv("LACUNA_DATA");
  const std::filesystem::path folder =
      given != nullptr ? std::filesystem::path(given) : std::filesystem::path(LACUNA_SOURCE_DIR) / ".." / "shared";
  if (std::filesystem::is_directory(folder / "cases")) return folder;
  return std::nullopt;
}

/// A scenario spoiled so is refused in one line that says where, what was found and what was expected.
inline void expect_refused(const std::string& scenario, const Spoiled& spoiled) {
  using testing::HasSubstr;
  const ScenarioFolder folder(replaced(scenario, spoiled.from, spoiled.to));
  const std::string message = input_error([&] { load_scenario(folder.file); });
  EXPECT_THAT(message, testing::AllOf(HasSubstr(spoiled.message), HasSubstr(": found "), HasSubstr(", expected ")));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

}  // namespace lacuna::test
