#include "diagnosis/regions.h"

#include <algorithm>
#include <cmath>

namespace lacuna {
namespace {

constexpr double kSlow = 0.25, kLarge = 1.5;  // of the rms speed, command
constexpr double kMoves = 0.1;                // of the rms speed: under it a joint has no direction
constexpr double kAfter = 0.3;                // s, that a reversal counts as just passed
constexpr double kOuter = 0.5;                // of the half range, beyond which a position is outer
constexpr std::size_t kReach = 5;             // samples, of a difference

/// Difference quotients of a measured column; 0 where a sample is missing.
class Speed {
 public:
  Speed(const Segment& segment, const std::vector<double>& column) : segment_(segment), column_(column) {}
  double operator()(std::size_t k) const {
    const auto [low, high] = ends(k);
    return finite((column_[high] - column_[low]) / (segment_.time(high) - segment_.time(low)));
  }
  double change(std::size_t k) const {
    const auto [low, high] = ends(k);
    return finite(((*this)(high) - (*this)(low)) / (segment_.time(high) - segment_.time(low)));
  }

 private:
  std::pair<std::size_t, std::size_t> ends(std::size_t k) const {
    return {k < kReach ? 0 : k - kReach, std::min(k + kReach, segment_.count - 1)};
  }
  static double finite(double x) { return std::isfinite(x) ? x : 0.0; }

  const Segment& segment_;
  const std::vector<double>& column_;
};

}  // namespace

void JointStates::append(const JointStates& more) {
  const auto join = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  join(t, more.t), join(q, more.q), join(v, more.v), join(a, more.a), join(u, more.u);
  join(since_reversal, more.since_reversal), join(others, more.others);
}

std::vector<int> position_channels(const Experiment& experiment) {
  std::vector<int> out(experiment.joint_names.size(), -1);
  for (std::size_t c = 0; c < experiment.channels.size(); ++c)
    if (experiment.channels[c].kind == ChannelKind::position) out[experiment.channels[c].joint] = static_cast<int>(c);
  return out;
}

JointStates joint_states(const Experiment& experiment, const Segment& segment, std::size_t joint,
                         std::span<const std::size_t> samples) {
  const std::vector<int> channels = position_channels(experiment);
  const auto speed_of = [&](std::size_t j) { return Speed(segment, segment.measured[channels[j]]); };
  const std::vector<double>& position = segment.measured[channels[joint]];
  const Speed speed = speed_of(joint);
  std::vector<std::pair<Speed, double>> others;
  for (std::size_t j = 0; j < channels.size(); ++j)
    if (j != joint && channels[j] >= 0 && experiment.speed_rms[j] > 0.0)
      others.emplace_back(speed_of(j), experiment.speed_rms[j]);
  JointStates out;
  double reversed = -HUGE_VAL, before = 0.0;
  std::size_t looked = 0;
  for (const std::size_t k : samples) {
    for (; looked <= k; ++looked) {
      const double v = speed(looked);
      if (std::fabs(v) < kMoves * experiment.speed_rms[joint]) continue;
      if (v * before < 0.0) reversed = segment.time(looked);
      before = v;
    }
    double sum = 0.0;
    for (const auto& [other, rms] : others) sum += std::pow(other(k) / rms, 2);
    out.t.push_back(segment.session + segment.time(k));
    out.q.push_back(std::isfinite(position[k]) ? position[k] : 0.0);
    out.v.push_back(speed(k));
    out.a.push_back(speed.change(k));
    out.u.push_back(segment.commands->value[joint][segment.first + k]);
    out.since_reversal.push_back(segment.time(k) - reversed);
    out.others.push_back(sum);
  }
  return out;
}

std::vector<Region> regions_of(const Experiment& e, std::size_t j, const JointStates& all) {
  std::vector<double> busy = all.others;
  if (busy.empty()) return {};
  std::nth_element(busy.begin(), busy.begin() + static_cast<std::ptrdiff_t>(busy.size() / 2), busy.end());
  const double median = busy[busy.size() / 2], v = e.speed_rms[j], u = e.command_rms[j], half = 0.5 * e.span;
  const double middle = e.position_middle[j], reach = kOuter * e.position_reach[j];
  using States = const JointStates&;
  return {{"near standstill", [=](States s, std::size_t k) { return std::fabs(s.v[k]) < kSlow * v; }},
          {"moving up", [=](States s, std::size_t k) { return s.v[k] > kSlow * v; }},
          {"moving down", [=](States s, std::size_t k) { return s.v[k] < -kSlow * v; }},
          {"moving fast", [=](States s, std::size_t k) { return std::fabs(s.v[k]) > kLarge * v; }},
          {"just after a reversal", [](States s, std::size_t k) { return s.since_reversal[k] < kAfter; }},
          {"at small commands", [=](States s, std::size_t k) { return std::fabs(s.u[k]) < kSlow * u; }},
          {"at large commands", [=](States s, std::size_t k) { return std::fabs(s.u[k]) > kLarge * u; }},
          {"at the upper end of its travel", [=](States s, std::size_t k) { return s.q[k] > middle + reach; }},
          {"at the lower end of its travel", [=](States s, std::size_t k) { return s.q[k] < middle - reach; }},
          {"while other joints move", [=](States s, std::size_t k) { return s.others[k] > median; }},
          {"in the first half of the session", [=](States s, std::size_t k) { return s.t[k] < half; }},
          {"in the second half of the session", [=](States s, std::size_t k) { return s.t[k] >= half; }}};
}

}  // namespace lacuna
