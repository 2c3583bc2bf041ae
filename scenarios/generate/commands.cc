// Excitation: 20 s of commands at 0.01 s, V, at rest for the first half second.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "scenarios/generate/bundle.h"

namespace lacuna::generate {
namespace {

constexpr double kPeriod = 0.01;  // s
constexpr double kRest = 0.5;     // s
constexpr double kPeak = 7.0;     // V

/// Command of joint `joint` (1 to 7) at time t; every joint gets its own course, so that all can move at once.
using Course = std::function<double(double t, int joint)>;

/// Levels of the whole range, held for 0.8 to 2.4 s.
double steps(double t, int joint) {
  static constexpr double kLevels[] = {4, -3, 7, 1, -6, 2, -1, 5, -7, 3, -4, 6, -2};
  static constexpr double kHolds[] = {1.6, 2.4, 0.8, 1.2, 2.0, 0.9, 1.7};
  double end = kRest;
  for (int i = 0;; ++i) {
    end += kHolds[(i + 3 * joint) % 7];
    if (t < end) return kLevels[(i + 5 * joint) % 13];
  }
}

/// Twelve sines from 0.05 to about 3 Hz with Schroeder phases, which keep the peak low; faded in.
double multisine(double t, int joint) {
  constexpr int kCount = 12;
  double sum = 0.0;
  for (int k = 0; k < kCount; ++k) {
    const double hertz = (0.05 + 0.003 * joint) * std::pow(58.0, k / 11.0);
    const double phase = -std::numbers::pi * k * (k + 1.0) / kCount + 0.9 * joint;
    sum += std::sin(2.0 * std::numbers::pi * hertz * (t - kRest) + phase) / std::sqrt(1.0 + hertz);
  }
  return 1.5 * sum * std::min(1.0, (t - kRest) / 2.0);
}

/// One volt up or down each 0.7 s: 0 to 7 to -7 and back.
double staircase(double t, int joint) {
  const int step = static_cast<int>((t - kRest) / 0.7) + 2 * (joint - 2);
  const int phase = ((step % 28) + 28) % 28;
  return phase <= 7 ? phase : phase <= 21 ? 14 - phase : phase - 28;
}

/// Slow reversals: up and down at a constant rate.
double triangle(double t, int joint) {
  const double period = 6.0 + 0.7 * joint;
  const double turn = std::fmod((t - kRest) / period, 1.0);
  return 6.0 * (turn < 0.25 ? 4 * turn : turn < 0.75 ? 2 - 4 * turn : 4 * turn - 4);
}

/// From 0.1 to 2 Hz within ten seconds, then levels.
double chirp(double t, int joint) {
  constexpr double kEnd = 10.0;
  if (t > kEnd) return 0.8 * steps(t - 0.3, joint + 2);
  const double s = t - kRest, length = kEnd - kRest;
  const double turns = 0.1 * s + (1.9 + 0.1 * joint) * s * s / (2.0 * length) + 0.13 * joint;
  return 5.0 * std::min(1.0, s) * std::sin(2.0 * std::numbers::pi * turns);
}

/// All joints together, half a second after the start.
double step(double, int joint) { return joint % 2 == 0 ? 4.0 : -3.0; }

/// A fifth of a volt a second.
double ramp(double t, int) { return 0.2 * (t - kRest); }

struct NamedCourse {
  const char* name;
  Course course;
};
const std::vector<NamedCourse>& courses() {
  static const std::vector<NamedCourse> all{
      {"steps", &steps},       {"multisine", &multisine}, {"staircase", &staircase},
      {"triangle", &triangle}, {"chirp", &chirp},         {"step", &step},
      {"ramp", &ramp}};
  return all;
}

}  // namespace

std::string command_table(const std::string& name, const std::vector<int>& joints, int samples) {
  const auto named = std::find_if(courses().begin(), courses().end(), [&](const auto& c) { return name == c.name; });
  std::string out = "t";
  for (const int joint : joints) out += fmt::format(",u_{}", joint);
  out += '\n';
  for (int i = 0; i < samples; ++i) {
    const double t = i * kPeriod;
    out += fmt::format("{:.2f}", t);
    for (const int joint : joints)
      out += fmt::format(",{:.3f}", t < kRest ? 0.0 : std::clamp(named->course(t, joint), -kPeak, kPeak) + 0.0);
    out += '\n';
  }
  return out;
}

void add_commands(Files& files) {
  for (const std::string name : {"steps", "multisine", "staircase", "triangle"}) {
    files["hydrolek/commands_joint_2_" + name + ".csv"] = command_table(name, {2});
    files["hydrolek/commands_all_" + name + ".csv"] = command_table(name, {1, 2, 3, 4, 5, 6, 7});
  }
  files["hydrolek/demo/commands_chirp.csv"] = command_table("chirp", {1, 2, 3, 4, 5, 6, 7});
}

}  // namespace lacuna::generate
