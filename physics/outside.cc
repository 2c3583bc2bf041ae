#include "physics/outside.h"

#include <numeric>

namespace lacuna {

const std::vector<OutsideInfo>& outside_table() {
  using Kind = OutsidePhysics::Kind;
  static const std::vector<OutsideInfo> table{
      {Kind::position_ripple, "position_ripple", Stage::link, OutsideWay::position},
      {Kind::external_push, "external_push", Stage::link, OutsideWay::time},
      {Kind::command_dropout, "command_dropout", Stage::command, OutsideWay::time},
      {Kind::counterbalance_spring, "counterbalance_spring", Stage::link, OutsideWay::position},
      {Kind::tight_spot, "tight_spot", Stage::link, OutsideWay::position_and_direction},
      {Kind::valve_notch, "valve_notch", Stage::command, OutsideWay::command},
      {Kind::cable_drag, "cable_drag", Stage::link, OutsideWay::other_position},
      {Kind::repeated_samples, "repeated_samples", Stage::reading, OutsideWay::time}};
  return table;
}

const OutsideInfo& info_of(OutsidePhysics::Kind kind) { return outside_table()[static_cast<std::size_t>(kind)]; }

std::optional<OutsidePhysics::Kind> outside_physics_named(const std::string& name) {
  for (const OutsideInfo& known : outside_table())
    if (name == known.name) return known.kind;
  return std::nullopt;
}

const char* to_string(OutsidePhysics::Kind kind) { return info_of(kind).name; }

std::vector<std::string> outside_physics_names() {
  std::vector<std::string> out;
  for (const OutsideInfo& known : outside_table()) out.emplace_back(known.name);
  return out;
}

double seconds_of(const OutsidePhysics& physics) {
  if (info_of(physics.kind).over != OutsideWay::time) return 0.0;
  return physics.kind == OutsidePhysics::Kind::external_push ? kPushLasts : physics.strength;
}

std::vector<double> beyond_linear(const std::vector<std::vector<double>>& at, std::vector<double> values) {
  constexpr double kNothing = 1e-9;  // of a column: below it rounding is all that is left of it
  std::vector<std::vector<double>> basis;
  const auto clear = [&](std::vector<double>& x) {  // of the basis, whose columns have length 1
    for (const std::vector<double>& b : basis) {
      const double along = std::inner_product(b.begin(), b.end(), x.begin(), 0.0);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] -= along * b[i];
    }
  };
  for (std::size_t k = 0; !at.empty() && k <= at[0].size(); ++k) {
    std::vector<double> column(at.size(), 1.0);
    for (std::size_t i = 0; k > 0 && i < at.size(); ++i) column[i] = at[i][k - 1];
    const double before = root_mean_square(column);
    clear(column);
    clear(column);  // what rounding left
    const double left = root_mean_square(column);
    if (!(left > kNothing * before)) continue;
    for (double& x : column) x /= left * std::sqrt(static_cast<double>(at.size()));
    basis.push_back(std::move(column));
  }
  clear(values);
  return values;
}

double root_mean_square(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double x : values) squares += x * x;
  return values.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace lacuna
