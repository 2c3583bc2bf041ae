#include "draft/actuation.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "backends/engine.h"
#include "physics/measured_motion.h"

namespace lacuna {
namespace {

constexpr std::size_t kFewestSamples = 20;
constexpr std::size_t kMostSamples = 400'000;  ///< of all recordings together; more would only take longer
constexpr std::size_t kMostRows = 20'000;      ///< of one regression
/// The rms frequency is about half of a motion's band, and a filter leaves what lies below a tenth of its cutoff as it
/// is (M. Gautier, Proc. ECC 1997).
constexpr double kCutoffOverMotion = 20.0;
constexpr double kStill = 0.05;         ///< of the rms speed: slower is at rest
constexpr double kClear = 0.8;          ///< share of the remaining effort that a command must explain to be its cause
constexpr double kShown = 0.5;          ///< share from which a measured effort's gain is taken from the motion
constexpr double kFollows = 0.4;        ///< share of the speed that a valve's command explains
constexpr double kOilFrequency = 10.0;  ///< Hz, of a stiff drive on the robot's own inertia

/// One recording, even and low-passed, with the efforts that its motion needs.
struct Piece {
  MeasuredMotion motion;
  std::vector<std::vector<double>> u, effort, tau;  ///< [joint][sample]; empty: not recorded
};

using Signals = std::vector<std::vector<double>>;

double rms_value(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double each : x) sum += each * each;
  return x.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(x.size()));
}

bool usable(const std::vector<double>& x) {
  return std::count_if(x.begin(), x.end(), [](double v) { return std::isfinite(v); }) >= 2;
}

MeasuredMotion motion_of(const JointSignals& signals, std::size_t dof, double cutoff) {
  RawMotion raw;
  raw.time = signals.time;
  raw.position.resize(dof), raw.velocity.resize(dof);
  raw.position_noise.assign(dof, std::nan("")), raw.velocity_noise.assign(dof, std::nan(""));
  for (std::size_t j = 0; j < dof; ++j)
    if (usable(signals.position[j])) raw.position[j] = signals.position[j];
  return measured_motion(raw, cutoff);
}

/// rms frequency of every moving joint: rms acceleration over 2 pi rms speed.
std::vector<double> frequencies_of(const MeasuredMotion& motion) {
  std::vector<double> out;
  for (std::size_t j = 0; j < motion.v.size(); ++j)
    if (const double speed = rms_value(motion.v[j]); speed > 0.0)
      out.push_back(rms_value(motion.a[j]) / (2.0 * std::numbers::pi * speed));
  std::sort(out.begin(), out.end());
  return out;
}

/// The fastest joint's frequency, and from it the cutoff: the narrower the filter the less noise is taken for motion,
/// until both agree.
MotionBand band_of(const std::vector<const JointSignals*>& recordings, std::size_t dof) {
  MotionBand out;
  constexpr int kRounds = 6;
  for (const JointSignals* signals : recordings) {
    const double span = signals->time.back() - signals->time.front();
    const double rate = static_cast<double>(signals->time.size() - 1) / span;
    double cutoff = 0.2 * rate, frequency = 0.0, middle = 0.0;
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<double> all = frequencies_of(motion_of(*signals, dof, cutoff));
      frequency = all.empty() ? 0.0 : all.back();
      middle = all.empty() ? 0.0 : all[all.size() / 2];
      cutoff = std::min(cutoff, std::max(kCutoffOverMotion * frequency, 3.0 / span));
    }
    out.rate = out.rate == 0.0 ? rate : std::min(out.rate, rate);
    out.frequency = std::max(out.frequency, frequency), out.middle = std::max(out.middle, middle);
    out.cutoff_hz = std::max(out.cutoff_hz, cutoff);
  }
  out.cutoff_hz = std::min(out.cutoff_hz, 0.2 * out.rate);
  return out;
}

Piece piece_of(const JointSignals& signals, Dynamics& dynamics, double cutoff) {
  const std::size_t dof = dynamics.dof();
  Piece out{motion_of(signals, dof, cutoff), Signals(dof), Signals(dof), Signals(dof)};
  const MeasuredMotion& motion = out.motion;
  const ZeroPhaseLowPass filter(cutoff, motion.rate);
  for (std::size_t j = 0; j < dof; ++j) {
    for (auto [from, to] : {std::pair(&signals.command, &out.u), std::pair(&signals.effort, &out.effort)}) {
      if (!usable((*from)[j])) continue;
      (*to)[j] = resampled(signals.time, (*from)[j], motion.time);
      filter.apply((*to)[j]);
    }
    out.tau[j].resize(motion.samples());
  }
  std::vector<double> q(dof), v(dof), a(dof), tau(dof);
  for (std::size_t k = 0; k < motion.samples(); ++k) {
    for (std::size_t j = 0; j < dof; ++j) q[j] = motion.q[j][k], v[j] = motion.v[j][k], a[j] = motion.a[j][k];
    dynamics.inverse_dynamics(q, v, a, tau);
    for (std::size_t j = 0; j < dof; ++j) out.tau[j][k] = tau[j];
  }
  return out;
}

/// Ordinary least squares; columns of unit size, so that units do not matter to the rank.
struct Regression {
  Eigen::VectorXd slopes;
  double rest = 0.0;   ///< sum of squares left
  double total = 0.0;  ///< about the mean
  double share() const { return total > 0.0 ? 1.0 - rest / total : 0.0; }
};

Regression regress(Eigen::MatrixXd columns, const Eigen::VectorXd& y) {
  Eigen::VectorXd size = columns.colwise().norm();
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    if (!(size[c] > 0.0)) size[c] = 1.0;
    columns.col(c) /= size[c];
  }
  Regression out;
  const Eigen::VectorXd scaled = columns.colPivHouseholderQr().solve(y);
  out.slopes = scaled.cwiseQuotient(size);
  out.rest = (y - columns * scaled).squaredNorm();
  out.total = (y.array() - y.mean()).matrix().squaredNorm();
  return out;
}

/// Rows of one joint over all pieces, thinned to kMostRows.
class Rows {
 public:
  Rows(const std::vector<Piece>& pieces, std::size_t joint) : joint_(joint) {
    std::size_t samples = 0;
    for (const Piece& piece : pieces) samples += piece.motion.samples();
    stride_ = std::max<std::size_t>(1, samples / kMostRows);
    for (const Piece& piece : pieces)
      for (std::size_t k = 0; k < piece.motion.samples(); k += stride_) rows_.push_back({&piece, k});
    for (const auto& [piece, k] : rows_) speed_ += piece->motion.v[joint][k] * piece->motion.v[joint][k];
    speed_ = rows_.empty() ? 0.0 : std::sqrt(speed_ / static_cast<double>(rows_.size()));
  }

  std::size_t size() const { return rows_.size(); }
  double speed() const { return speed_; }  ///< rms

  template <class Function>
  Eigen::VectorXd column(const Function& value) const {
    Eigen::VectorXd out(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i)
      out[static_cast<Eigen::Index>(i)] = value(*rows_[i].first, rows_[i].second);
    return out;
  }
  Eigen::VectorXd q() const {
    return column([this](const Piece& p, std::size_t k) { return p.motion.q[joint_][k]; });
  }
  Eigen::VectorXd v() const {
    return column([this](const Piece& p, std::size_t k) { return p.motion.v[joint_][k]; });
  }
  Eigen::VectorXd a() const {
    return column([this](const Piece& p, std::size_t k) { return p.motion.a[joint_][k]; });
  }
  Eigen::VectorXd tau() const {
    return column([this](const Piece& p, std::size_t k) { return p.tau[joint_][k]; });
  }
  /// A recorded signal `lag` s ago; 0 in recordings without it.
  Eigen::VectorXd given(const Signals Piece::*signals, double lag = 0.0) const {
    return column([this, signals, lag](const Piece& p, std::size_t k) {
      const std::vector<double>& x = (p.*signals)[joint_];
      const std::size_t back = static_cast<std::size_t>(std::lround(lag * p.motion.rate));
      return x.empty() ? 0.0 : x[k - std::min(k, back)];
    });
  }
  /// The way of the motion, rounded where it turns: friction beside the searched parameters.
  Eigen::VectorXd way() const {
    const double turn = std::max(kStill * speed_, 1e-12);
    return column([this, turn](const Piece& p, std::size_t k) { return std::tanh(p.motion.v[joint_][k] / turn); });
  }

 private:
  std::size_t joint_, stride_ = 1;
  std::vector<std::pair<const Piece*, std::size_t>> rows_;
  double speed_ = 0.0;
};

/// tau = slopes[0] x - slopes[1] v - slopes[2] way + slopes[3] - slopes[4] (q or a), and what x and the last add to the
/// rest. `beside`: the position, where a spring may hold the joint; or the acceleration, where the motor's own inertia,
/// which the robot's file lacks, takes its share of a measured effort.
struct EffortFit {
  Regression all;
  double by_drive = 0.0, by_last = 0.0;  ///< shares of what is left without them
};

EffortFit fit_effort(const Rows& rows, const Eigen::VectorXd& drive, const Eigen::VectorXd* beside) {
  const Eigen::Index n = static_cast<Eigen::Index>(rows.size()), count = beside != nullptr ? 5 : 4;
  Eigen::MatrixXd columns(n, count);
  columns.leftCols(4) << drive, -rows.v(), -rows.way(), Eigen::VectorXd::Ones(n);
  if (beside != nullptr) columns.col(4) = -*beside;
  const Eigen::VectorXd tau = rows.tau();
  const auto share_of = [](const Regression& with, const Regression& without) {
    return without.rest > 0.0 ? 1.0 - with.rest / without.rest : 0.0;
  };
  EffortFit out;
  out.all = regress(columns, tau);
  out.by_drive = share_of(out.all, regress(columns.rightCols(count - 1), tau));
  if (beside != nullptr) out.by_last = share_of(out.all, regress(columns.leftCols(4), tau));
  return out;
}

/// Square of the correlation of y with x and a constant, and x's slope.
std::pair<double, double> line_fit(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  Eigen::MatrixXd columns(x.size(), 2);
  columns << x, Eigen::VectorXd::Ones(x.size());
  const Regression fit = regress(columns, y);
  return {fit.share(), fit.slopes[0]};
}

double middle_of(std::vector<double> x) {
  if (x.empty()) return 0.0;
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  return x[x.size() / 2];
}

class Guesser {
 public:
  Guesser(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity)
      : robot_(std::move(robot)), dynamics_(find_engine("featherstone").build(robot_, gravity)) {}

  ActuationGuess run(const std::vector<JointSignals>& recordings, const std::vector<DriveHint>& hints) {
    ActuationGuess out;
    const std::size_t dof = robot_->dof();
    std::vector<const JointSignals*> used;
    std::size_t samples = 0;
    for (const JointSignals& signals : recordings) {
      if (signals.time.size() < kFewestSamples || samples > kMostSamples) continue;
      used.push_back(&signals), samples += signals.time.size();
    }
    if (!used.empty()) {
      out.band = band_of(used, dof);
      for (const JointSignals* signals : used) pieces_.push_back(piece_of(*signals, *dynamics_, out.band.cutoff_hz));
    }
    measure_inertias();
    for (std::size_t j = 0; j < dof; ++j) out.joints.push_back(guess(j, hints[j]));
    agree(out.joints);
    for (std::size_t j = 0; j < dof; ++j) {
      fill(out.joints[j], Rows(pieces_, j), j);
      within_range(out.joints[j]);
    }
    return out;
  }

 private:
  const Joint& joint(std::size_t j) const { return robot_->joints()[j]; }

  /// Largest diagonal of the mass matrix over poses of the recordings.
  void measure_inertias() {
    const std::size_t dof = robot_->dof();
    inertia_.assign(dof, 0.0);
    constexpr std::size_t kPoses = 20;
    std::vector<double> q(dof, 0.0);
    Eigen::MatrixXd mass;
    const auto look = [&] {
      dynamics_->mass_matrix(q, mass);
      for (std::size_t j = 0; j < dof; ++j) inertia_[j] = std::max(inertia_[j], mass(j, j));
    };
    look();
    for (const Piece& piece : pieces_) {
      const std::size_t stride = std::max<std::size_t>(1, piece.motion.samples() / kPoses);
      for (std::size_t k = 0; k < piece.motion.samples(); k += stride) {
        for (std::size_t j = 0; j < dof; ++j) q[j] = piece.motion.q[j][k];
        look();
      }
    }
  }

  ActuatorGuess guess(std::size_t j, const DriveHint& hint) const {
    ActuatorGuess out;
    out.joint = static_cast<int>(j);
    const Rows rows(pieces_, j);
    const bool moves = rows.size() > 0 && rows.speed() > 0.0;
    if (hint.effort_measured) {
      out.model = "direct_effort";
      if (moves)
        by_effort(out, rows, hint.effort_is_current);
      else
        out.reason = "does not move in the recordings";
    } else if (hint.commanded) {
      if (moves)
        by_command(out, rows, j, hint.command_is_effort);
      else
        out.model = hint.command_is_effort ? "direct_effort" : "torque_source",
        out.reason = "does not move in the recordings";
    }
    return out;
  }

  /// What one joint does not show is taken from the others: a machine's drives are mostly of one kind.
  void agree(std::vector<ActuatorGuess>& joints) const {
    std::vector<double> scales, gains;
    for (const ActuatorGuess& each : joints) {
      if (each.sure && each.model == "flow_source") gains.push_back(each.gain);
      if (each.sure && each.effort_scale != 1.0) scales.push_back(each.effort_scale);
    }
    for (ActuatorGuess& each : joints) {
      if (each.effort_scale == 0.0) close_gain(each, scales);
      if (each.sure || gains.empty() || each.model != "torque_source") continue;
      each.model = "flow_source", each.gain = middle_of(gains);
      each.neutral = neutral_command(static_cast<std::size_t>(each.joint));
      each.reason += "; a valve as at the other joints";
    }
  }

  /// From a measured effort, or the motor's current: its gain where it is one, and the damping. A current's gain is
  /// sought beside the motor's own inertia, which the robot's file lacks; a joint without load to tell the two apart
  /// leaves it open (0).
  static void by_effort(ActuatorGuess& out, const Rows& rows, bool current) {
    const Eigen::VectorXd effort = rows.given(&Piece::effort), a = rows.a();
    const EffortFit plain = fit_effort(rows, effort, nullptr);
    const EffortFit fit = current ? fit_effort(rows, effort, &a) : plain;
    const double slope = fit.all.slopes[0];
    out.damping = plain.all.slopes[1];
    out.sure = fit.by_drive > kShown;
    out.reason = fmt::format("the measured {} explains {:.0f} % of what the file's masses need beside friction{}",
                             current ? "current" : "effort", 100.0 * std::max(0.0, fit.by_drive),
                             current ? " and the motor's inertia" : "");
    if (current) out.effort_scale = out.sure ? slope : 0.0;
    if (!current && out.sure && !(slope > 0.5 && slope < 2.0)) {
      out.sure = false;
      out.reason +=
          fmt::format("; they need {:.3g} times as much: look at its unit and sign, and at the masses", slope);
    }
  }

  /// A current's gain that was left open: as the other drives have it, else without the motor's inertia.
  void close_gain(ActuatorGuess& out, std::vector<double> others) const {
    if (!others.empty()) {
      out.effort_scale = middle_of(std::move(others));
      out.reason += "; its gain as the other drives have it";
      return;
    }
    const Rows rows(pieces_, static_cast<std::size_t>(out.joint));
    const EffortFit plain = fit_effort(rows, rows.given(&Piece::effort), nullptr);
    out.effort_scale = plain.by_drive > kShown ? plain.all.slopes[0] : 1.0;
    out.reason +=
        plain.by_drive > kShown ? "; its gain as if the motor had no inertia" : "; its gain is not to be seen";
  }

  void by_command(ActuatorGuess& out, const Rows& rows, std::size_t j, bool is_effort) const {
    const Eigen::VectorXd u = rows.given(&Piece::u);
    const Eigen::VectorXd q = rows.q();
    const EffortFit fit = fit_effort(rows, u, is_effort ? nullptr : &q);
    double lag = 0.0, follows = 0.0, speed_gain = 0.0;
    for (const double candidate : {0.0, 0.05, 0.1, 0.15, 0.2, 0.3}) {
      const auto [share, slope] = line_fit(rows.given(&Piece::u, candidate), rows.v());
      if (share > follows) follows = share, speed_gain = slope, lag = candidate;
    }
    const double holds = line_fit(u, rows.q()).first;
    const bool flows = !is_effort && fit.by_drive < kClear && follows > kFollows && follows > holds;
    if (flows) {
      out.model = "flow_source";
      out.gain = speed_gain, out.neutral = neutral_command(j);
      out.reason = fmt::format("the speed follows the command, {:.0f} % of it{}", 100.0 * follows,
                               lag > 0.0 ? fmt::format(" {:.2g} s later", lag) : std::string());
      out.sure = true;
      return;
    }
    by_torque(out, fit, is_effort);
  }

  static void by_torque(ActuatorGuess& out, const EffortFit& fit, bool is_effort) {
    const Eigen::VectorXd& slopes = fit.all.slopes;
    out.sure = fit.by_drive > kClear;
    out.gain = is_effort ? 1.0 : slopes[0], out.damping = slopes[1];
    out.model = "direct_effort";
    out.reason = fmt::format("with the file's masses the command explains {:.0f} % of the effort of the motion",
                             100.0 * std::max(0.0, fit.by_drive));
    if (!is_effort && !out.sure) {
      out.model = "torque_source";
      out.gain = 0.0;  // filled from the limits
      out.reason = "neither effort nor speed follow the command clearly: values by the robot's size only";
    } else if (!is_effort && fit.by_last > 0.02 && slopes[4] > 0.0) {
      out.model = "torque_source", out.holds = true;
      out.stiffness = slopes[4], out.rest = slopes[3] / slopes[4];
    }
  }

  /// What the command is where the joint stands still: its middle there; 0 where that is next to it.
  double neutral_command(std::size_t j) const {
    std::vector<double> still;
    double low = HUGE_VAL, high = -HUGE_VAL;
    const double slow = kStill * Rows(pieces_, j).speed();
    for (const Piece& piece : pieces_) {
      for (std::size_t k = 0; k < piece.motion.samples() && !piece.u[j].empty(); ++k) {
        low = std::min(low, piece.u[j][k]), high = std::max(high, piece.u[j][k]);
        if (std::fabs(piece.motion.v[j][k]) < slow) still.push_back(piece.u[j][k]);
      }
    }
    const double middle = middle_of(std::move(still));
    return std::fabs(middle) < 0.02 * (high - low) ? 0.0 : middle;
  }

  /// What the actuator models take (physics/actuators); beyond it the recordings are of no machine.
  static void within_range(ActuatorGuess& out) {
    const auto within = [](double x, double low, double high) {
      return std::isfinite(x) ? std::clamp(x, low, high) : low;
    };
    out.gain = within(out.gain, -1e9, 1e9), out.damping = within(out.damping, 1e-12, 1e9);
    out.stiffness = within(out.stiffness, 0.0, 1e12), out.rest = within(out.rest, -1e3, 1e3);
    if (out.gain == 0.0) out.gain = 1.0;
  }

  /// Values that no regression gave, from the joint's inertia and limits; none stays 0 or of the wrong sign.
  void fill(ActuatorGuess& out, const Rows& rows, std::size_t j) const {
    for (double* each : {&out.gain, &out.damping, &out.stiffness, &out.rest, &out.neutral})
      if (!std::isfinite(*each)) *each = 0.0;
    if (!std::isfinite(out.effort_scale) || out.effort_scale == 0.0) out.effort_scale = 1.0;
    const double omega = 2.0 * std::numbers::pi * kOilFrequency;
    if (out.model == "flow_source") {
      out.stiffness = inertia_[j] * omega * omega, out.damping = 2.0 * inertia_[j] * omega;
      return;
    }
    const double needed = rows.size() > 0 ? rows.tau().norm() / std::sqrt(static_cast<double>(rows.size())) : 0.0;
    const double effort = needed > 0.0 ? needed : std::isfinite(joint(j).effort) ? joint(j).effort : 1.0;
    const double speed = rows.speed() > 0.0 ? rows.speed() : 1.0;
    if (!(out.damping > 0.0)) out.damping = 0.05 * effort / speed;
    if (out.gain == 0.0) {
      double largest = 0.0;
      for (const Piece& piece : pieces_)
        for (const double u : piece.u[j]) largest = std::max(largest, std::fabs(u));
      out.gain = (std::isfinite(joint(j).effort) ? joint(j).effort : 3.0 * effort) / (largest > 0.0 ? largest : 1.0);
    }
    if (out.model == "torque_source" && !(out.stiffness > 0.0)) {
      out.stiffness = effort, out.rest = rows.size() > 0 ? rows.q().mean() : 0.0;
      out.holds = true;
    }
  }

  std::shared_ptr<const Robot> robot_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<Piece> pieces_;
  std::vector<double> inertia_;
};

}  // namespace

ActuationGuess guess_actuation(const std::shared_ptr<const Robot>& robot, const Eigen::Vector3d& gravity,
                               const std::vector<JointSignals>& recordings, const std::vector<DriveHint>& hints) {
  return Guesser(robot, gravity).run(recordings, hints);
}

}  // namespace lacuna
