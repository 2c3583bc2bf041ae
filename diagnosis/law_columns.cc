#include "diagnosis/law_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lacuna {
namespace {

constexpr double kNudge = 0.01;  ///< of a joint's rms command, by which its sensitivity is taken

/// From the middles of intervals to the samples between them.
std::vector<double> at_samples(const std::vector<double>& between) {
  if (between.size() < 2) return std::vector<double>(between.size() + 1, between.empty() ? 0.0 : between.front());
  std::vector<double> out{1.5 * between[0] - 0.5 * between[1]};
  for (std::size_t k = 0; k + 1 < between.size(); ++k) out.push_back(0.5 * (between[k] + between[k + 1]));
  out.push_back(2.0 * between.back() - out.back());
  return out;
}

double weight_at(const Learnable::Variable& variable, double period, double x, int knot) {
  const double turns = period > 0.0 ? std::floor((x - variable.from) / period) : 0.0;
  const double at = (x - variable.from - turns * period) / variable.spacing();
  const double within = period > 0.0 ? at : std::clamp(at, 0.0, variable.knots - 1.0);
  return LearnedCurve::weight(within, knot, variable.knots, period > 0.0);
}

}  // namespace

bool LawColumns::cover(int joint, Learnable::Variable& variable) const {
  variable.from = HUGE_VAL, variable.to = -HUGE_VAL;
  for (std::size_t at = 0; at < segments_.size(); ++at) {
    const std::vector<double> x = course(at, joint, variable);
    if (x.empty()) continue;
    variable.from = std::min(variable.from, *std::min_element(x.begin(), x.end()));
    variable.to = std::max(variable.to, *std::max_element(x.begin(), x.end()));
  }
  return variable.to > variable.from;
}

Eigen::MatrixXd LawColumns::changes(const Learnable& law) const {
  if (law.stage == Stage::command) return commanded(law);
  std::vector<Eigen::MatrixXd> acts;
  for (std::size_t at = 0; at < segments_.size(); ++at) acts.push_back(weights(at, law));
  return law.stage == Stage::reading ? look_.changes_read(law.joint, acts) : look_.changes_at(law.joint, acts);
}

std::vector<double> LawColumns::course(std::size_t at, int joint, const Learnable::Variable& variable) const {
  const MeasuredMotion& motion = look_.motion(at);
  const auto whose = static_cast<std::size_t>(variable.of > 0 ? variable.of - 1 : joint);
  if (variable.over == LearnedCurve::kPosition) return motion.q[whose];
  if (variable.over == LearnedCurve::kSpeed) return motion.v[whose];
  const Segment& segment = experiment_.segments[segments_[at]];
  const auto first = segment.commands->value[whose].begin() + static_cast<std::ptrdiff_t>(segment.first);
  return {first, first + static_cast<std::ptrdiff_t>(motion.samples())};
}

Eigen::MatrixXd LawColumns::weights(std::size_t at, const Learnable& law) const {
  std::vector<double> x = course(at, law.joint, law.over), y;
  if (law.beside) y = course(at, law.joint, *law.beside);
  if (law.stage == Stage::reading) x = at_samples(x);
  const int columns = law.beside ? law.beside->knots : 1;
  Eigen::MatrixXd out(law.size(), x.size());
  for (std::size_t k = 0; k < x.size(); ++k)
    for (int row = 0; row < law.over.knots; ++row) {
      const double of_row = weight_at(law.over, law.period, x[k], row);
      for (int column = 0; column < columns; ++column)
        out(row * columns + column, k) =
            of_row * (law.beside && of_row != 0.0 ? weight_at(*law.beside, 0.0, y[k], column) : 1.0);
    }
  return out;
}

Eigen::MatrixXd LawColumns::commanded(const Learnable& law) const {
  const std::string& name = experiment_.joint_names[law.joint];
  const PlantModel& plain = now_.model;
  const bool stands = plain.find_effect_at(learned_effect(law.stage), name) >= 0;
  const PlantModel model = stands ? plain : plain.with_effects({law.spec(name)});
  std::vector<double> present = model.values();
  const std::vector<double> fitted = now_.space.expand(now_.fit.point);
  std::copy(fitted.begin(), fitted.end(), present.begin());
  const double nudge = kNudge * experiment_.command_rms[law.joint];
  const int first = model.find(fmt::format("{}.{}.value_1", name, learned_effect(law.stage)));
  std::vector<std::vector<double>> nudged(law.size(), present);
  for (std::size_t k = 0; k < nudged.size(); ++k) nudged[k][first + k] += nudge;
  const std::vector<Eigen::VectorXd> changes = look_.changes(model, nudged);
  Eigen::MatrixXd out(changes.front().size(), law.size());
  for (std::size_t k = 0; k < changes.size(); ++k) out.col(k) = changes[k] / nudge;
  return out;
}

}  // namespace lacuna
