#include "physics/course.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lacuna {
namespace {

constexpr int kSines = 8, kStairs = 10;  // per joint and motion

/// Fastest motion of a recorded signal, over strides that keep its noise small.
double fastest_in(const Segment& segment, const std::vector<double>& signal) {
  constexpr std::size_t kStride = 5;
  double out = 0.0;
  for (std::size_t k = kStride; k < signal.size(); ++k) {
    const double v = (signal[k] - signal[k - kStride]) / (segment.time(k) - segment.time(k - kStride));
    if (std::isfinite(v)) out = std::max(out, std::fabs(v));
  }
  return out;
}

}  // namespace

std::size_t Courses::size() const {
  const std::size_t sines = 2 * kSines + 1, stairs = 2 * kStairs;
  return shape_ == Shape::multisine ? sines : shape_ == Shape::staircase ? stairs : sines + stairs;
}

std::vector<double> Courses::course(std::span<const double> x, const std::vector<double>& time, double peak) const {
  if (shape_ == Shape::multisine) return sines(x, time, kRestBefore, seconds_, peak);
  if (shape_ == Shape::staircase) return stairs(x, time, kRestBefore, seconds_, peak);
  const double half = 0.5 * (kRestBefore + seconds_);
  std::vector<double> out = stairs(x.first(2 * kStairs), time, kRestBefore, half, peak);
  const std::vector<double> second = sines(x.subspan(2 * kStairs), time, half, seconds_, peak);
  for (std::size_t k = 0; k < out.size(); ++k) out[k] += second[k];
  return out;
}

std::vector<double> Courses::sines(std::span<const double> x, const std::vector<double>& time, double from, double to,
                                   double peak) const {
  std::vector<double> out(time.size(), 0.0);
  const double low = 1.0 / (to - from), ratio = std::max(hertz_ / low, 1.0);
  double highest = 0.0;
  for (std::size_t k = 0; k < time.size(); ++k) {
    if (time[k] < from || time[k] >= to) continue;
    for (int s = 0; s < kSines; ++s) {
      const double frequency = low * std::pow(ratio, s / (kSines - 1.0));
      const double phase = 2.0 * std::numbers::pi * (frequency * (time[k] - from) + x[2 * s + 1]);
      out[k] += x[2 * s] * std::sin(phase);
    }
    highest = std::max(highest, std::fabs(out[k]));
  }
  const double scale = highest > 0.0 ? peak * x[2 * kSines] / highest : 0.0;
  for (double& u : out) u *= scale;
  return out;
}

std::vector<double> Courses::stairs(std::span<const double> x, const std::vector<double>& time, double from, double to,
                                    double peak) const {
  // Lengths in proportion to their coordinates, none shorter than half a period of the highest frequency.
  const double shortest = std::min(0.5 / hertz_, (to - from) / kStairs);
  double sum = 0.0;
  for (int s = 0; s < kStairs; ++s) sum += x[2 * s + 1] + 1e-9;
  std::vector<double> out(time.size(), 0.0);
  double begin = from;
  for (int s = 0; s < kStairs; ++s) {
    const double end = begin + shortest + (to - from - kStairs * shortest) * (x[2 * s + 1] + 1e-9) / sum;
    for (std::size_t k = 0; k < time.size(); ++k) {
      if (time[k] >= begin && time[k] < end) out[k] = peak * (2.0 * x[2 * s] - 1.0);
    }
    begin = end;
  }
  return out;
}

Recording as_recording(const Scenario& scenario, const CommandTrack& commands) {
  Recording out;
  out.names = {scenario.channels.time};
  out.columns = {commands.time};
  for (const auto& [joint, column] : scenario.channels.of.at(ChannelKind::command)) {
    std::vector<double> values = commands.value[*scenario.robot->find_joint(joint)];
    for (double& u : values) u = (u - column.offset) / column.scale;
    out.names.push_back(column.column);
    out.columns.push_back(std::move(values));
  }
  return out;
}

CommandTrack still_commands(std::size_t joints, double seconds, double period) {
  CommandTrack out;
  const std::size_t count = static_cast<std::size_t>(std::lround(seconds / period)) + 1;
  for (std::size_t k = 0; k < count; ++k) out.time.push_back(static_cast<double>(k) * period);
  out.value.assign(joints, std::vector<double>(count, 0.0));
  return out;
}

MotionLimits recorded_limits(const Robot& robot, const Experiment& seen) {
  MotionLimits out;
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const Joint& joint = robot.joints()[j];
    double peak = 0.0, low = joint.lower, high = joint.upper, fastest = joint.velocity;
    for (const Segment& segment : seen.segments) {
      for (const double u : segment.commands->value[j]) peak = std::max(peak, std::fabs(u));
      for (std::size_t c = 0; c < seen.channels.size(); ++c) {
        if (seen.channels[c].kind != ChannelKind::position || seen.channels[c].joint != static_cast<int>(j)) continue;
        for (const double q : segment.measured[c]) {
          if (std::isfinite(q)) low = std::min(low, q), high = std::max(high, q);
        }
        fastest = std::max(fastest, fastest_in(segment, segment.measured[c]));
      }
    }
    out.command.push_back(peak);
    out.lowest.push_back(low);
    out.highest.push_back(high);
    out.speed.push_back(fastest);
  }
  return out;
}

Experiment commanded(const Experiment& like, const CommandTrack& commands, std::span<const double> start) {
  Experiment out = like;
  Segment segment = out.segments[out.with_role(Role::train).front()];
  segment.commands = std::make_shared<const CommandTrack>(commands);
  segment.first = 0;
  segment.count = commands.time.size();
  segment.file = "commands";
  segment.q0.assign(start.begin(), start.end());
  for (std::vector<double>* zero : {&segment.v0, &segment.q0_error, &segment.v0_error})
    std::fill(zero->begin(), zero->end(), 0.0);
  segment.start_effects = nullptr;
  segment.measured.assign(out.channels.size(), std::vector<double>(segment.count, 0.0));
  out.segments = {segment};
  out.prediction = FreeRun{};
  return out;
}

SeenMotion seen_motion(const Experiment& experiment, const Segment& segment,
                       const std::vector<std::vector<double>>& predicted, const MotionLimits& limits) {
  SeenMotion out;
  const std::size_t n = limits.command.size();
  out.lowest.assign(n, std::nan(""));
  out.highest = out.speed = out.lowest;
  const auto astray = [&](double excess, double size) {
    if (excess > 0.0) out.beyond = std::max(out.beyond, excess / std::max(size, 1e-9));
  };
  for (std::size_t c = 0; c < predicted.size(); ++c) {
    if (experiment.channels[c].kind != ChannelKind::position) continue;
    const std::size_t j = experiment.channels[c].joint;
    const std::vector<double>& signal = predicted[c];
    double low = HUGE_VAL, high = -HUGE_VAL, fastest = 0.0;
    for (std::size_t k = 0; k < signal.size(); ++k) {
      out.finite = out.finite && std::isfinite(signal[k]);
      low = std::min(low, signal[k]), high = std::max(high, signal[k]);
      if (k > 0)
        fastest = std::max(fastest, std::fabs(signal[k] - signal[k - 1]) / (segment.time(k) - segment.time(k - 1)));
    }
    out.lowest[j] = low, out.highest[j] = high, out.speed[j] = fastest;
    const double reach = limits.highest[j] - limits.lowest[j], width = std::isfinite(reach) ? reach : 1.0;
    astray(limits.lowest[j] - low, width);
    astray(high - limits.highest[j], width);
    astray(fastest - limits.speed[j], limits.speed[j]);
  }
  return out;
}

}  // namespace lacuna
