#include "draft/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace lacuna {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// Beyond its limits by this share of them a joint is in another unit, not driven past its stops: a degree is 57 times
/// a rad, a millimetre 1000 times a metre.
constexpr double kBeyondTurning = 1.3, kBeyondSliding = 10.0;
/// A joint without limits that turns further than this (rad), eight turns, is more likely in degrees.
constexpr double kManyTurns = 50.0;
/// m: no slide of an arm goes further; it is in millimetres then.
constexpr double kLongSlide = 10.0;

bool is_degree(const std::string& unit) { return unit == "deg" || unit == "degree" || unit == "degrees"; }

std::optional<UnitGuess> named_length(const std::string& unit) {
  if (unit == "m") return UnitGuess{1.0, "m, as its name says", true};
  if (unit == "mm") return UnitGuess{1e-3, "mm -> m, as its name says", true};
  if (unit == "cm") return UnitGuess{1e-2, "cm -> m, as its name says", true};
  return std::nullopt;
}

/// Largest size that the joint's limits allow; infinite where it has none.
double allowed(const Joint& joint) { return std::max(std::fabs(joint.lower), std::fabs(joint.upper)); }

UnitGuess guess_slide(const Joint& joint, const ColumnGuess& column, const ColumnRange& range) {
  if (const auto named = named_length(column.unit)) return *named;
  const double most =
      std::isfinite(allowed(joint)) ? kBeyondSliding * std::max(allowed(joint), joint.upper - joint.lower) : kLongSlide;
  if (!range.any || range.largest() <= most) return {1.0, "m: its range fits", true};
  return {1e-3, fmt::format("mm -> m: up to {:.4g}, too far for m", range.largest()), false};
}

}  // namespace

double ColumnRange::largest() const { return any ? std::max(std::fabs(low), std::fabs(high)) : 0.0; }

ColumnRange range_of_column(const std::vector<const Recording*>& recordings, const std::string& column) {
  ColumnRange out;
  for (const Recording* recording : recordings) {
    const int at = recording->find(column);
    if (at < 0) continue;
    for (const double x : recording->columns[at]) {
      if (!std::isfinite(x)) continue;
      out.low = out.any ? std::min(out.low, x) : x;
      out.high = out.any ? std::max(out.high, x) : x;
      out.any = true;
    }
  }
  return out;
}

UnitGuess guess_position_unit(const Robot& robot, const ColumnGuesses& guesses, const ColumnGuess& column,
                              const std::vector<const Recording*>& recordings) {
  const auto joint_of = [&](const ColumnGuess& guess) -> const Joint& { return robot.joints()[guess.joint]; };
  if (joint_of(column).prismatic())
    return guess_slide(joint_of(column), column, range_of_column(recordings, column.column));
  if (column.unit == "rad") return {1.0, "rad, as its name says", true};
  if (is_degree(column.unit)) return {kDegree, "deg -> rad, as its name says", true};
  for (const ColumnGuess& other : guesses.columns) {
    if (other.kind != column.kind || joint_of(other).prismatic() || !other.unit.empty()) continue;
    const ColumnRange range = range_of_column(recordings, other.column);
    const double limit = allowed(joint_of(other));
    const double most = std::isfinite(limit) ? kBeyondTurning * std::max(limit, 2.0 * std::numbers::pi) : kManyTurns;
    if (range.largest() <= most) continue;
    return {kDegree,
            fmt::format("deg -> rad: {} goes to {:.4g}, {}", other.column, range.largest(),
                        std::isfinite(limit) ? fmt::format("the robot's file ends the joint at {:.3g} rad", limit)
                                             : "too many turns for rad"),
            false};
  }
  return {1.0, "rad: no joint goes further than its limits or a few turns", true};
}

UnitGuess guess_pressure_unit(const ColumnGuesses& guesses, const std::vector<const Recording*>& recordings,
                              const ColumnGuess& column) {
  struct PressureUnit {
    const char* word;
    const char* name;
    double pascal;
  };
  static constexpr std::array kUnits{PressureUnit{"pa", "Pa", 1.0}, PressureUnit{"kpa", "kPa", 1e3},
                                     PressureUnit{"bar", "bar", 1e5}, PressureUnit{"mpa", "MPa", 1e6},
                                     PressureUnit{"psi", "psi", 6894.757}};
  for (const PressureUnit& unit : kUnits)
    if (column.unit == unit.word) return {unit.pascal, fmt::format("{} -> Pa, as its name says", unit.name), true};
  double most = 0.0;
  for (const ColumnGuess& other : guesses.columns)
    if (other.kind == ChannelKind::pressure_a || other.kind == ChannelKind::pressure_b)
      most = std::max(most, range_of_column(recordings, other.column).largest());
  if (most > 1e5) return {1.0, fmt::format("Pa: up to {:.3g}", most), false};
  if (most > 1e3) return {1e3, fmt::format("kPa -> Pa: up to {:.3g}, too much for bar", most), false};
  return {1e5, fmt::format("bar -> Pa: up to {:.3g}{}", most, most < 60.0 ? "; MPa would fit, too" : ""), false};
}

UnitGuess guess_effort_unit(const Joint& joint, const ColumnGuess& column) {
  if (column.unit == "knm" || column.unit == "kn") return {1e3, "kN m -> N m (kN -> N), as its name says", true};
  if (column.unit == "nm" || column.unit == "n") return {1.0, "as its name says", true};
  return {1.0, fmt::format("{}: nothing says otherwise", joint.prismatic() ? "N" : "N m"), true};
}

UnitGuess guess_velocity_unit(const Joint& joint, const ColumnGuess& column, const std::vector<double>& time,
                              const std::vector<double>& position, const std::vector<double>& velocity) {
  // Slope of the positions' central differences over the speeds.
  double products = 0.0, squares = 0.0, differences = 0.0;
  for (std::size_t i = 1; i + 1 < time.size(); ++i) {
    const double rate = (position[i + 1] - position[i - 1]) / (time[i + 1] - time[i - 1]);
    if (!std::isfinite(rate) || !std::isfinite(velocity[i])) continue;
    products += rate * velocity[i], squares += velocity[i] * velocity[i], differences += rate * rate;
  }
  const double slope = squares > 0.0 ? products / squares : 0.0;
  const double share = squares > 0.0 && differences > 0.0 ? products * products / (squares * differences) : 0.0;
  struct Candidate {
    const char* name;
    double scale;
  };
  static constexpr std::array kTurning{Candidate{"rad/s", 1.0}, Candidate{"deg/s -> rad/s", kDegree},
                                       Candidate{"rpm -> rad/s", std::numbers::pi / 30.0}};
  static constexpr std::array kSliding{Candidate{"m/s", 1.0}, Candidate{"mm/s -> m/s", 1e-3},
                                       Candidate{"cm/s -> m/s", 1e-2}};
  constexpr double kLike = 1.25;  // the positions' noise and the speeds' delay leave the slope this far off
  for (const double sign : {1.0, -1.0}) {
    for (const Candidate& unit : joint.prismatic() ? kSliding : kTurning) {
      const double ratio = sign * slope / unit.scale;
      if (!(share > 0.25 && ratio > 1.0 / kLike && ratio < kLike)) continue;
      return {
          sign * unit.scale,
          fmt::format("{}{}: as the position's differences say", unit.name, sign < 0.0 ? ", of the other sign" : ""),
          unit.scale == 1.0 && sign > 0.0};
    }
  }
  if (is_degree(column.unit)) return {kDegree, "deg/s -> rad/s, as its name says", true};
  return {1.0, fmt::format("its unit is not clear: the position changes {:.3g} times as fast as this says", slope),
          false};
}

}  // namespace lacuna
