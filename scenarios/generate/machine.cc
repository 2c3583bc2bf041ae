#include "scenarios/generate/machine.h"

#include <Eigen/LU>
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <memory>
#include <span>

#include "backends/engine.h"
#include "scenarios/error.h"

namespace lacuna::generate {
namespace {

namespace odeint = boost::numeric::odeint;

constexpr double kTolerance = 1e-9;  // of the integrator, absolute and relative, rad, rad/s and kUnit
constexpr double kBrake = 1e5;       // N m: friction from here on is a brake, and the joint locked
constexpr double kUnit = 1e5;        // Pa, of the pressures among the states
constexpr double kSettled = 5.0;     // s, for which the valves have been closed before a hydraulic machine's start
constexpr double kLaminar = 2e5;     // Pa, drop about which an orifice's flow turns from laminar to turbulent

/// A valve, two chambers and a linkage, in SI units; `p` as the scenario calls them.
struct Cylinder {
  std::map<std::string, double> p;

  double of(const char* name) const {
    const auto found = p.find(name);
    return found == p.end() ? 0.0 : found->second;
  }
  double pins_apart(double q) const {
    const double a = of("lever_a"), b = of("lever_b");
    return std::sqrt(a * a + b * b - 2.0 * a * b * std::cos(q + of("lever_angle")));
  }
  bool on_lever() const { return of("lever_a") > 0.0; }
  /// Stroke from its middle, m (rad).
  double stroke(double q) const { return on_lever() ? pins_apart(q) - pins_apart(of("middle")) : q - of("middle"); }
  /// Growth of the stroke with the joint's position.
  double arm(double q) const {
    return on_lever() ? of("lever_a") * of("lever_b") * std::sin(q + of("lever_angle")) / pins_apart(q) : 1.0;
  }
  /// m^3/s through an edge of the fully open valve.
  double orifice(double drop) const { return of("gain") * drop / std::pow(drop * drop + kLaminar * kLaminar, 0.25); }
  /// Pa/m^3: what a chamber's pressure gains per oil; `swept` the oil in the stroke.
  double stiffness(double swept) const {
    return 1.0 / ((of("dead_volume_a") + swept) / of("bulk_modulus") + of("dead_volume_a") * of("hose_compliance"));
  }
  double effort(double q, double a, double b) const { return (a * of("area_a") - b * of("area_b")) * arm(q); }

  /// Pa/s of either chamber at position q, speed v, command u and pressures a and b.
  std::pair<double, double> rates(double q, double v, double u, double a, double b) const {
    const double open = std::clamp(u / of("full_command"), -1.0, 1.0), swept = arm(q) * v;
    const double feed = of("supply_pressure"), back = of("return_pressure"), across = of("leakage") * (a - b);
    const double into_a = std::abs(open) * orifice((open > 0.0 ? feed : back) - a);
    const double into_b = std::abs(open) * orifice((open > 0.0 ? back : feed) - b);
    const double half = 0.5 * of("stroke"), s = stroke(q);
    return {(into_a - of("area_a") * swept - across) * stiffness(of("area_a") * (half + s)),
            (into_b + of("area_b") * swept + across) * stiffness(of("area_b") * (half - s))};
  }
  /// Pressures that carry `load` (N m, N), as far from vacuum as from the supply.
  std::pair<double, double> holding(double q, double load) const {
    const double force = load / arm(q), middle = 0.5 * (of("supply_pressure") + of("return_pressure"));
    const double a = of("area_a"), b = of("area_b"), together = 2.0 * middle;
    return {(force + together * b) / (a + b), (together * a - force) / (a + b)};
  }
};

/// One joint of the true machine.
struct Drive {
  double gain = 0.0, damping = 0.0, stiffness = 0.0, rest = 0.0;  // N m/V, N m s/rad, N m/rad, rad
  double friction = 0.0, creep = 1.0;                             // N m, rad/s
  bool locked = false;                                            // by friction that nothing overcomes
  std::unique_ptr<Cylinder> cylinder = nullptr;                   // in place of gain and spring
};

void add_actuator(const ActuatorSpec& spec, Drive& drive) {
  const auto& p = spec.parameters;
  if (spec.model == "hydraulic") {
    drive.cylinder = std::make_unique<Cylinder>(Cylinder{p});
    return;
  }
  if (spec.model != "torque_source") throw InputError(spec.where, spec.model, "torque_source or hydraulic");
  drive.gain = p.at("gain"), drive.damping = p.at("damping");
  drive.stiffness = p.at("stiffness"), drive.rest = p.at("rest");
}

void add_effect(const EffectSpec& spec, Drive& drive) {
  if (spec.effect == "viscous_friction") {
    drive.damping += spec.parameters.at("D");
    return;
  }
  if (spec.effect != "coulomb_friction")
    throw InputError(spec.where, spec.effect, "coulomb_friction or viscous_friction");
  drive.locked = spec.parameters.at("Fc") >= kBrake;
  if (drive.locked) return;
  drive.friction = spec.parameters.at("Fc");
  drive.creep = spec.parameters.at("v0");
}

std::vector<Drive> drives_of(const Scenario& truth) {
  std::vector<Drive> out(truth.robot->dof());
  const auto at = [&](const std::string& joint) -> Drive& { return out[*truth.robot->find_joint(joint)]; };
  for (const auto& spec : truth.actuators) add_actuator(spec, at(spec.joint));
  for (const auto& spec : truth.effects) add_effect(spec, at(spec.place));
  return out;
}

/// Its state: positions, speeds, then both pressures of every joint that is hydraulic, in kUnit.
class Machine {
 public:
  using State = std::vector<double>;

  explicit Machine(const Scenario& truth)
      : drives_(drives_of(truth)),
        dynamics_(find_engine("simbody").build(truth.robot, truth.gravity)),
        n_(drives_.size()),
        command_(n_, 0.0),
        effort_(n_) {
    for (std::size_t j = 0; j < n_; ++j) {
      if (!drives_[j].locked) moving_.push_back(j);
      if (drives_[j].cylinder) hydraulic_.push_back(j);
    }
    if (hydraulic_.empty()) return;
    if (hydraulic_.size() < moving_.size())
      throw InputError(truth.file.string(), "joints with chambers and without", "all that move, or none");
    if (!truth.motion) throw InputError(truth.file.string(), "no motion", "motion.position, where it starts");
    start_ = State(n_);
    for (const auto& [joint, q] : truth.motion->position) start_[*truth.robot->find_joint(joint)] = q;
  }

  std::size_t joints() const { return n_; }
  void set_command(std::size_t joint, double volts) { command_[joint] = volts; }
  void read(const State& x, Course& out) const {
    for (std::size_t j = 0; j < n_; ++j) out.position[j].push_back(x[j]);
    for (std::size_t k = 0; k < hydraulic_.size(); ++k) {
      out.pressure_a[hydraulic_[k]].push_back(kUnit * x[2 * n_ + 2 * k]);
      out.pressure_b[hydraulic_[k]].push_back(kUnit * x[2 * n_ + 2 * k + 1]);
    }
  }

  void derivative(const State& x, State& rate) {
    for (std::size_t j = 0; j < n_; ++j) {
      const Drive& d = drives_[j];
      const double q = x[j], v = x[n_ + j];
      effort_[j] =
          d.gain * command_[j] - d.damping * v - d.stiffness * (q - d.rest) - d.friction * std::tanh(v / d.creep);
      rate[j] = v;
    }
    for (std::size_t k = 0; k < hydraulic_.size(); ++k) {
      const std::size_t j = hydraulic_[k], z = 2 * n_ + 2 * k;
      const double a = kUnit * x[z], b = kUnit * x[z + 1];
      effort_[j] += drives_[j].cylinder->effort(x[j], a, b);
      const auto [rise_a, rise_b] = drives_[j].cylinder->rates(x[j], x[n_ + j], command_[j], a, b);
      rate[z] = rise_a / kUnit, rate[z + 1] = rise_b / kUnit;
    }
    dynamics_->forward_dynamics({x.data(), n_}, {x.data() + n_, n_}, effort_, {rate.data() + n_, n_});
    if (moving_.size() < n_) lock({x.data(), n_}, rate.data() + n_);
  }

  /// Carries x from one instant to another under the present command.
  void advance(State& x, double from, double to) {
    auto stepper = odeint::make_controlled(kTolerance, kTolerance, odeint::runge_kutta_dopri5<State>());
    const auto system = [&](const State& at, State& rate, double) { derivative(at, rate); };
    odeint::integrate_adaptive(stepper, system, x, from, to, std::min(to - from, 0.01) / 4.0);
  }

  State start() { return hydraulic_.empty() ? equilibrium() : settled(); }

 private:
  /// At rest where the springs carry the weight under zero command: Newton's method from the springs' rest.
  State equilibrium() {
    State q(n_), rest(n_, 0.0);
    for (std::size_t j = 0; j < n_; ++j) q[j] = drives_[j].rest;
    const Eigen::Index n = n_;
    for (int step = 0; step < 50; ++step) {
      const Eigen::VectorXd error = imbalance(q);
      Eigen::MatrixXd slope(n, n);
      for (std::size_t j = 0; j < n_; ++j) {
        constexpr double kStep = 1e-6;
        State moved = q;
        moved[j] += kStep;
        slope.col(j) = (imbalance(moved) - error) / kStep;
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
    throw WorkError("no static equilibrium found");
  }

  /// The posture, and the pressures that carry it, after closed valves have let them settle.
  State settled() {
    const State zero(n_, 0.0);
    State load(n_), x = start_;
    dynamics_->inverse_dynamics(start_, zero, zero, load);
    x.insert(x.end(), n_, 0.0);
    for (const std::size_t j : hydraulic_) {
      const auto [a, b] = drives_[j].cylinder->holding(start_[j], load[j]);
      x.push_back(a / kUnit), x.push_back(b / kUnit);
    }
    advance(x, -kSettled, 0.0);
    return x;
  }

  /// Accelerations of the free arm become those with some joints locked: M_mm a_m = (M a_free)_m.
  void lock(std::span<const double> q, double* a) {
    Eigen::MatrixXd mass;
    dynamics_->mass_matrix(q, mass);
    Eigen::Map<Eigen::VectorXd> all(a, n_);
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
    Eigen::VectorXd out(n_);
    for (std::size_t j = 0; j < n_; ++j)
      out[static_cast<Eigen::Index>(j)] = holding[j] + drives_[j].stiffness * (q[j] - drives_[j].rest);
    return out;
  }

  std::vector<Drive> drives_;
  std::unique_ptr<Dynamics> dynamics_;
  std::size_t n_;
  std::vector<double> command_, effort_;
  std::vector<Eigen::Index> moving_;    // joints that are not locked
  std::vector<std::size_t> hydraulic_;  // joints with chambers
  std::vector<double> start_;           // rad (m), posture of a hydraulic machine
};

/// A cylinder has two ends, and nothing here stops it there.
void check_travel(const Scenario& truth, const Course& course) {
  for (std::size_t j = 0; j < course.position.size(); ++j) {
    if (course.pressure_a[j].empty()) continue;
    const Joint& joint = truth.robot->joints()[j];
    const auto [least, most] = std::ranges::minmax_element(course.position[j]);
    if (*least < joint.lower || *most > joint.upper)
      throw WorkError(joint.name + " leaves its travel: from " + std::to_string(*least) + " to " +
                      std::to_string(*most));
  }
}

}  // namespace

Course true_course(const Scenario& truth, const Recording& commands) {
  Machine machine(truth);
  Machine::State x = machine.start();
  Course out;
  for (auto* of : {&out.position, &out.pressure_a, &out.pressure_b}) of->resize(machine.joints());
  const std::vector<double>& time = commands.columns.front();
  for (std::size_t i = 0; i < time.size(); ++i) {
    machine.read(x, out);
    if (i + 1 == time.size()) break;
    for (const auto& [joint, column] : truth.channels.of.at(ChannelKind::command)) {
      const int c = commands.find(column.column);
      if (c >= 0)
        machine.set_command(static_cast<std::size_t>(*truth.robot->find_joint(joint)),
                            commands.columns.at(static_cast<std::size_t>(c))[i]);
    }
    machine.advance(x, time[i], time[i + 1]);  // anew: the command jumped
  }
  check_travel(truth, out);
  return out;
}

}  // namespace lacuna::generate
