// lacuna_generate_recordings FOLDER
//   writes the bundled recordings below FOLDER (scenarios/ of the source tree)
// lacuna_generate_recordings --check FOLDER [SECONDS]
//   changes nothing; fails where a recording there differs by over 2e-5; SECONDS: only the first ones of each
//
// Made with nothing that identification on the default engine uses: Simbody's accelerations, a Dormand-Prince method
// with step control, the actuator and friction laws written out here. An error in those of physics/ cannot hide.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "backends/engine.h"
#include "ga/random.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording.h"
#include "scenarios/scenario.h"

namespace {

using lacuna::Recording;
using lacuna::Scenario;
namespace odeint = boost::numeric::odeint;

constexpr double kTolerance = 1e-9;       // of the integrator, absolute and relative, rad and rad/s
constexpr double kNoise = 3e-4;           // rad, rms
constexpr double kPrismaticNoise = 3e-5;  // m, rms
constexpr double kAgreement = 2e-5;       // twice the last digit written: another machine may round the other way
constexpr double kBrake = 1e5;            // N m: friction from here on is a brake, and the joint locked
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
};

/// One joint of the true machine.
struct Drive {
  double gain = 0.0, damping = 0.0, stiffness = 0.0, rest = 0.0;  // N m/V, N m s/rad, N m/rad, rad
  double friction = 0.0, creep = 1.0;                             // N m, rad/s
  bool locked = false;                                            // by friction that nothing overcomes
};

std::vector<Drive> drives_of(const Scenario& truth) {
  std::vector<Drive> out(static_cast<std::size_t>(truth.robot->dof()));
  const auto at = [&](const std::string& joint) -> Drive& {
    return out[static_cast<std::size_t>(*truth.robot->find_joint(joint))];
  };
  for (const auto& spec : truth.actuators) {
    if (spec.model != "torque_source") throw lacuna::InputError(spec.where, spec.model, "torque_source");
    const auto& p = spec.parameters;
    Drive& drive = at(spec.joint);
    drive.gain = p.at("gain"), drive.damping = p.at("damping");
    drive.stiffness = p.at("stiffness"), drive.rest = p.at("rest");
  }
  for (const auto& spec : truth.effects) {
    if (spec.effect != "coulomb_friction") throw lacuna::InputError(spec.where, spec.effect, "coulomb_friction");
    Drive& drive = at(spec.place);
    drive.locked = spec.parameters.at("Fc") >= kBrake;
    if (drive.locked) continue;
    drive.friction = spec.parameters.at("Fc");
    drive.creep = spec.parameters.at("v0");
  }
  return out;
}

/// The true machine: positions, then speeds.
class Machine {
 public:
  using State = std::vector<double>;

  explicit Machine(const Scenario& truth)
      : drives_(drives_of(truth)),
        dynamics_(lacuna::find_engine("simbody").build(truth.robot, truth.gravity)),
        n_(drives_.size()),
        command_(n_, 0.0),
        effort_(n_) {
    for (std::size_t j = 0; j < n_; ++j) {
      if (!drives_[j].locked) moving_.push_back(static_cast<Eigen::Index>(j));
    }
  }

  std::size_t joints() const { return n_; }
  void set_command(std::size_t joint, double volts) { command_[joint] = volts; }

  void derivative(const State& x, State& rate) {
    for (std::size_t j = 0; j < n_; ++j) {
      const Drive& d = drives_[j];
      const double q = x[j], v = x[n_ + j];
      effort_[j] =
          d.gain * command_[j] - d.damping * v - d.stiffness * (q - d.rest) - d.friction * std::tanh(v / d.creep);
      rate[j] = v;
    }
    dynamics_->forward_dynamics({x.data(), n_}, {x.data() + n_, n_}, effort_, {rate.data() + n_, n_});
    if (moving_.size() < n_) lock({x.data(), n_}, rate.data() + n_);
  }

  /// At rest where the springs carry the weight under zero command: Newton's method from the springs' rest.
  State equilibrium() {
    State q(n_), rest(n_, 0.0);
    for (std::size_t j = 0; j < n_; ++j) q[j] = drives_[j].rest;
    const Eigen::Index n = static_cast<Eigen::Index>(n_);
    for (int step = 0; step < 50; ++step) {
      const Eigen::VectorXd error = imbalance(q);
      Eigen::MatrixXd slope(n, n);
      for (std::size_t j = 0; j < n_; ++j) {
        constexpr double kStep = 1e-6;
        State moved = q;
        moved[j] += kStep;
        slope.col(static_cast<Eigen::Index>(j)) = (imbalance(moved) - error) / kStep;
      }
      Eigen::VectorXd move = Eigen::VectorXd::Zero(n);
      const Eigen::VectorXd solved = slope(moving_, moving_).partialPivLu().solve(error(moving_).eval());
      move(moving_) = solved;
      for (std::size_t j = 0; j < n_; ++j) q[j] -= move[static_cast<Eigen::Index>(j)];
      if (move.cwiseAbs().maxCoeff() < 1e-12) {
        q.insert(q.end(), rest.begin(), rest.end());
        return q;
      }
    }
    throw lacuna::WorkError("no static equilibrium found");
  }

 private:
  /// Accelerations of the free arm become those with some joints locked: M_mm a_m = (M a_free)_m.
  void lock(std::span<const double> q, double* a) {
    Eigen::MatrixXd mass;
    dynamics_->mass_matrix(q, mass);
    Eigen::Map<Eigen::VectorXd> all(a, static_cast<Eigen::Index>(n_));
    const Eigen::VectorXd net = mass * all;
    const Eigen::VectorXd solved = mass(moving_, moving_).partialPivLu().solve(net(moving_).eval());
    all.setZero();
    all(moving_) = solved;
  }

  /// Effort that gravity asks for less the springs', N m.
  Eigen::VectorXd imbalance(const State& q) {
    const State zero(n_, 0.0);
    State holding(n_);
    dynamics_->inverse_dynamics(q, zero, zero, holding);
    Eigen::VectorXd out(static_cast<Eigen::Index>(n_));
    for (std::size_t j = 0; j < n_; ++j)
      out[static_cast<Eigen::Index>(j)] = holding[j] + drives_[j].stiffness * (q[j] - drives_[j].rest);
    return out;
  }

  std::vector<Drive> drives_;
  std::unique_ptr<lacuna::Dynamics> dynamics_;
  std::size_t n_;
  std::vector<double> command_, effort_;
  std::vector<Eigen::Index> moving_;  // joints that are not locked
};

/// Positions of all joints at the instants of `time`, commands held in between. result[joint][sample]
std::vector<std::vector<double>> motion(const Scenario& truth, const Recording& commands) {
  Machine machine(truth);
  Machine::State x = machine.equilibrium();
  std::vector<std::vector<double>> out(machine.joints());
  auto stepper = odeint::make_controlled(kTolerance, kTolerance, odeint::runge_kutta_dopri5<Machine::State>());
  const auto system = [&](const Machine::State& at, Machine::State& rate, double) { machine.derivative(at, rate); };
  const std::vector<double>& time = commands.columns.front();
  for (std::size_t i = 0; i < time.size(); ++i) {
    for (std::size_t j = 0; j < machine.joints(); ++j) out[j].push_back(x[j]);
    if (i + 1 == time.size()) break;
    for (const auto& [joint, column] : truth.channels.of.at(lacuna::ChannelKind::command)) {
      const std::size_t c = static_cast<std::size_t>(commands.find(column.column));
      machine.set_command(static_cast<std::size_t>(*truth.robot->find_joint(joint)), commands.columns.at(c)[i]);
    }
    // The command jumped: what the stepper remembers of the slope is no longer true.
    stepper.reset();
    odeint::integrate_adaptive(stepper, system, x, time[i], time[i + 1], (time[i + 1] - time[i]) / 4.0);
  }
  return out;
}

/// The recording as text: time and commands as given, positions with noise, to the fifth decimal.
std::string recorded(const Scenario& truth, const Recording& commands, std::uint32_t number) {
  std::vector<std::vector<double>> positions = motion(truth, commands);
  std::vector<std::size_t> shown;
  std::string text = fmt::format("{}", fmt::join(commands.names, ","));
  for (std::size_t j = 0; j < positions.size(); ++j) {
    const auto& joint = truth.robot->joints()[j];
    const auto& columns = truth.channels.of.at(lacuna::ChannelKind::position);
    const auto column = columns.find(joint.name);
    if (column == columns.end()) continue;
    shown.push_back(j);
    text += "," + column->second.column;
    lacuna::RandomStream stream(kSeed, number, static_cast<std::uint32_t>(j));
    for (double& q : positions[j]) q += (joint.prismatic() ? kPrismaticNoise : kNoise) * stream.normal();
  }
  text += '\n';
  for (std::size_t i = 0; i < commands.rows(); ++i) {
    text += fmt::format("{:.2f}", commands.columns[0][i]);
    for (std::size_t c = 1; c < commands.columns.size(); ++c) text += fmt::format(",{:.3f}", commands.columns[c][i]);
    for (const std::size_t j : shown) text += fmt::format(",{:.5f}", positions[j][i]);
    text += '\n';
  }
  return text;
}

/// The first `seconds` of a recording.
Recording first(const Recording& whole, double seconds) {
  Recording out = whole;
  const auto& time = whole.columns.front();
  const auto rows = std::upper_bound(time.begin(), time.end(), seconds) - time.begin();
  for (auto& column : out.columns) column.resize(static_cast<std::size_t>(rows));
  return out;
}

/// Largest difference between two recordings; infinite where their shape or names differ.
double difference(const Recording& a, const Recording& b) {
  if (a.names != b.names || a.rows() != b.rows() || a.missing + b.missing > 0) return HUGE_VAL;
  double worst = 0.0;
  for (std::size_t c = 0; c < a.columns.size(); ++c)
    for (std::size_t i = 0; i < a.rows(); ++i) worst = std::max(worst, std::abs(a.columns[c][i] - b.columns[c][i]));
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
    const double worst = difference(*lacuna::load_recording(scratch, "regenerated"),
                                    first(*lacuna::load_recording(folder / job.recording, job.recording), seconds));
    if (worst <= kAgreement) continue;
    std::cout << "differs by " << worst << ": " << job.recording << '\n';
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
