#include "diagnosis/valve_chart.h"

#include <Eigen/Dense>
#include <algorithm>
#include <map>

#include "physics/actuators/table.h"

namespace lacuna {
namespace {

constexpr double kWhile = 0.1;          ///< s, over which a change of position is looked at
constexpr int kChartSteps = 24;         ///< between the smallest and the largest command
constexpr double kLongestLate = 0.5;    ///< s, delay and lag searched
constexpr int kCoarse = 10;             ///< steps of either
constexpr int kRefinements = 2;         ///< each in steps a third as long
constexpr double kSmooth = 1e-4;        ///< of a knot's mean weight: bridges commands that were never given
constexpr double kNearEnd = 0.02;       ///< of the travel: where a stop may act
constexpr double kMissedTravel = 0.05;  ///< of the travel, that the drive would have gone on at least
constexpr double kYields = 0.2;         ///< of which it did at most

/// One recording's commands and the spans of them that are compared.
struct CommandWay {
  const CommandTrack* commands = nullptr;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
      way;  ///< (sample, knot): integral of that knot's share of the lagged command, s
};

/// A short while: samples of a track and the change of position.
struct While {
  std::size_t track = 0;
  double begin = 0.0, end = 0.0;  ///< s
  double q0 = 0.0, q1 = 0.0;      ///< rad (m)
};

std::size_t channel_of(const Experiment& experiment, int joint) {
  const auto at = std::ranges::find_if(
      experiment.channels, [&](const Channel& c) { return c.kind == ChannelKind::position && c.joint == joint; });
  return static_cast<std::size_t>(at - experiment.channels.begin());
}

class ChartFit {
 public:
  ChartFit(const Experiment& experiment, int joint) : experiment_(experiment), joint_(joint) {
    channel_ = channel_of(experiment, joint);
    chart_.joint = joint, chart_.name = experiment.joint_names[joint_];
    for (const Segment& segment : experiment.segments) add_track(segment);
    place_knots();
    find_travel();
    for (const int s : experiment.with_role(Role::train)) add_whiles(experiment.segments[s]);
  }

  ValveChart best(bool delay, bool lag) {
    const double step = kLongestLate / kCoarse;
    search(0.0, 0.0, delay ? kCoarse : 0, lag ? kCoarse : 0, step, true);
    double finer = step;
    for (int round = 0; round < kRefinements; ++round) {
      finer /= 3.0;
      search(chart_.delay, chart_.lag, delay ? 2 : 0, lag ? 2 : 0, finer, false);
    }
    set_lag(chart_.lag);
    solve(chart_.delay);
    find_stops();
    for (const Role role : {Role::train, Role::validate, Role::test}) chart_.rms.emplace_back(role, rms(role));
    return std::move(chart_);
  }

 private:
  const std::vector<double>& command(const CommandTrack& track) const { return track.value[joint_]; }

  void add_track(const Segment& segment) {
    const CommandTrack* commands = segment.commands.get();
    if (track_of_.emplace(commands, tracks_.size()).second) tracks_.push_back({commands, {}});
  }

  void place_knots() {
    double low = 0.0, high = 0.0;
    for (const int s : experiment_.with_role(Role::train)) {
      const auto [a, b] = std::ranges::minmax(command(*experiment_.segments[s].commands));
      low = std::min(low, a), high = std::max(high, b);
    }
    const double step = (high - low) / kChartSteps;
    for (double k = std::floor(low / step); k <= std::ceil(high / step - 1e-9); ++k) chart_.command.push_back(k * step);
    chart_.seen.assign(chart_.command.size(), 0.0);
  }
  std::pair<std::size_t, double> between(double u) const {
    const std::vector<double>& at = chart_.command;
    const double x = std::clamp((u - at.front()) / (at[1] - at[0]), 0.0, static_cast<double>(at.size() - 1));
    const std::size_t k = std::min(static_cast<std::size_t>(x), at.size() - 2);
    return {k, x - static_cast<double>(k)};
  }

  void find_travel() {
    low_ = HUGE_VAL, high_ = -HUGE_VAL;
    for (const int s : experiment_.with_role(Role::train)) {
      for (const double q : experiment_.segments[s].measured[channel_])
        if (!std::isnan(q)) low_ = std::min(low_, q), high_ = std::max(high_, q);
    }
  }
  double margin() const { return kNearEnd * (high_ - low_); }

  void add_whiles(const Segment& s) {
    const std::vector<double>& q = s.measured[channel_];
    for (std::size_t a = 0, b = 0; a < q.size(); a = b) {
      while (b < q.size() && s.compared_time(b) - s.compared_time(a) < kWhile) ++b;
      if (b >= q.size()) return;
      if (std::isnan(q[a]) || std::isnan(q[b])) continue;
      whiles_.push_back({track_of_.at(s.commands.get()), s.compared_time(a), s.compared_time(b), q[a], q[b]});
    }
  }
  bool near_an_end(const While& w) const {
    const auto [a, b] = std::minmax(w.q0, w.q1);
    return a < low_ + margin() || b > high_ - margin();
  }

  /// The ways of every knot, behind a lag: the integral of what leaves a first-order lag is that of what enters it,
  /// less the lag times how far its output has come.
  void set_lag(double lag) {
    const auto knots = static_cast<Eigen::Index>(chart_.command.size());
    for (CommandWay& track : tracks_) {
      const std::vector<double>&time = track.commands->time, &u = command(*track.commands);
      track.way.setZero(time.size(), knots);
      Eigen::RowVectorXd input = share(u.front()), sum = Eigen::RowVectorXd::Zero(knots), left = input;
      const Eigen::RowVectorXd first = input;
      for (std::size_t i = 0; i + 1 < time.size(); ++i) {
        const double dt = time[i + 1] - time[i];
        input = share(u[i]);
        sum += dt * input;
        left = input + (left - input) * (lag > 0.0 ? std::exp(-dt / lag) : 0.0);
        track.way.row(static_cast<Eigen::Index>(i) + 1) = sum - lag * (left - first);
      }
    }
  }
  Eigen::RowVectorXd share(double u) const {
    Eigen::RowVectorXd out = Eigen::RowVectorXd::Zero(chart_.command.size());
    const auto [k, part] = between(u);
    out(k) = 1.0 - part, out(static_cast<Eigen::Index>(k) + 1) = part;
    return out;
  }
  /// Up to an instant; before the recording its first command stood.
  Eigen::RowVectorXd way_until(const CommandWay& track, double t) const {
    const std::vector<double>& time = track.commands->time;
    if (t <= time.front()) return (t - time.front()) * share(command(*track.commands).front());
    const auto next = std::min<std::ptrdiff_t>(std::ranges::upper_bound(time, t) - time.begin(),
                                               static_cast<std::ptrdiff_t>(time.size()) - 1);
    const double a = time[next - 1], b = time[next];
    const double part = (t - a) / (b - a);
    return (1.0 - part) * track.way.row(next - 1) + part * track.way.row(next);
  }
  Eigen::RowVectorXd way_of(const While& w, double delay) const {
    return way_until(tracks_[w.track], w.end - delay) - way_until(tracks_[w.track], w.begin - delay);
  }

  void search(double delay, double lag, int delays, int lags, double step, bool from_zero) {
    double least = HUGE_VAL, best_delay = delay, best_lag = lag;
    for (int l = from_zero ? 0 : -lags; l <= lags; ++l) {
      const double tau = lag + l * step;
      if (tau < 0.0) continue;
      set_lag(tau);
      for (int d = from_zero ? 0 : -delays; d <= delays; ++d) {
        const double late = delay + d * step;
        if (late < 0.0) continue;
        solve(late);
        if (chart_.energy < least) least = chart_.energy, best_delay = late, best_lag = tau;
      }
    }
    chart_.delay = best_delay, chart_.lag = best_lag;
  }

  void solve(double delay) {
    const auto knots = static_cast<Eigen::Index>(chart_.command.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(knots, knots);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(knots), seen = b;
    double all = 0.0;
    for (const While& w : whiles_) {
      if (near_an_end(w)) continue;
      const Eigen::RowVectorXd x = way_of(w, delay);
      const double moved = w.q1 - w.q0;
      A.selfadjointView<Eigen::Lower>().rankUpdate(x.transpose());
      b += moved * x.transpose(), all += moved * moved, seen += x.transpose();
    }
    A = A.selfadjointView<Eigen::Lower>();
    A.diagonal().array() += 1e-9 * A.trace() / static_cast<double>(knots);
    const Eigen::LLT<Eigen::MatrixXd> factor(A);
    chart_.root = factor.matrixL();
    chart_.target = factor.matrixL().solve(b);
    chart_.energy = all - chart_.target.squaredNorm();
    const Eigen::VectorXd f = (A + A.trace() / static_cast<double>(knots) * expected()).ldlt().solve(b);
    chart_.speed.assign(f.data(), f.data() + f.size());
    chart_.seen.assign(seen.data(), seen.data() + seen.size());
  }

  /// Quadratic form of what is expected of what was hardly seen, in mean weights of a knot: no flow without a command,
  /// and no more slope than needed.
  Eigen::MatrixXd expected() const {
    const auto knots = static_cast<Eigen::Index>(chart_.command.size());
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(knots, knots);
    for (Eigen::Index k = 0; k + 1 < knots; ++k) {
      out.block<2, 2>(k, k) += kSmooth * (Eigen::Matrix2d() << 1.0, -1.0, -1.0, 1.0).finished();
    }
    const Eigen::RowVectorXd none = share(0.0);
    return out + none.transpose() * none;
  }

  double moved_by_chart(const Eigen::RowVectorXd& way) const {
    return way * Eigen::Map<const Eigen::VectorXd>(chart_.speed.data(), way.size());
  }

  /// A stop is where the chart would have gone on, and the joint did not.
  void find_stops() {
    std::array<double, 2> would{}, did{};
    for (const While& w : whiles_) {
      if (!near_an_end(w)) continue;
      const bool upper = 0.5 * (w.q0 + w.q1) > 0.5 * (low_ + high_);
      const double side = upper ? 1.0 : -1.0, outward = side * moved_by_chart(way_of(w, chart_.delay));
      if (outward > 0.0) would[upper] += outward, did[upper] += std::max(0.0, side * (w.q1 - w.q0));
    }
    for (const bool upper : {false, true}) {
      if (would[upper] > kMissedTravel * (high_ - low_) && did[upper] < kYields * would[upper])
        chart_.stops[upper] = upper ? high_ : low_;
    }
  }

  double rms(Role role) const {
    double sum = 0.0, count = 0.0;
    for (const int s : experiment_.with_role(role)) {
      const Segment& segment = experiment_.segments[s];
      const std::vector<double>& measured = segment.measured[channel_];
      const CommandWay& track = tracks_[track_of_.at(segment.commands.get())];
      double q = segment.q0[joint_], before = 0.0;
      for (std::size_t k = 0; k < measured.size(); ++k) {
        const double way = moved_by_chart(way_until(track, segment.compared_time(k) - chart_.delay));
        if (k > 0) q = std::clamp(q + way - before, chart_.stops[0], chart_.stops[1]);
        before = way;
        if (!std::isnan(measured[k])) sum += (measured[k] - q) * (measured[k] - q), ++count;
      }
    }
    return count > 0.0 ? std::sqrt(sum / count) : std::nan("");
  }

  const Experiment& experiment_;
  std::size_t joint_, channel_ = 0;
  std::map<const CommandTrack*, std::size_t> track_of_;
  std::vector<CommandWay> tracks_;
  std::vector<While> whiles_;
  double low_ = 0.0, high_ = 0.0;  ///< rad (m), travel on the train recordings
  ValveChart chart_;
};

}  // namespace

ValveChart valve_chart(const Experiment& experiment, int joint, bool delay, bool lag) {
  return ChartFit(experiment, joint).best(delay, lag);
}

std::vector<ValveChart> valve_charts(const PlantModel& model, const Experiment& experiment) {
  std::vector<ValveChart> out;
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) return out;
  for (int j = 0; j < model.dof(); ++j) {
    const bool moves = experiment.command_rms[j] > 0.0 && experiment.position_reach[j] > 0.0;
    if (integrates_flow(model.actuators()[j].type) && moves && channel_of(experiment, j) < experiment.channels.size())
      out.push_back(valve_chart(experiment, j, true, true));
  }
  return out;
}

}  // namespace lacuna
