#include "diagnosis/learnable.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/KroneckerProduct>

namespace lacuna {
namespace {

constexpr double kSmooth = 2.0;         ///< knots over which a curve keeps its value
constexpr double kKnotsInPeriod = 5.0;  ///< at least
constexpr double kPeriodStep = 0.25;    ///< of a period, by which neighbours shift over the range
constexpr double kPeriodsSeen = 2.0;    ///< at least
constexpr double kJitter = 1e-6;        ///< of the prior's variance, on its diagonal
constexpr int kSizes = 40;              ///< sizes of the curve that are tried, four a decade

/// Covariance of a curve's values along one variable, over their variance; `period`, in knots, of one that repeats
/// itself, 0: it need not. Two knots are the two ways in which a joint moves, either with a curve of its own.
Eigen::MatrixXd prior_along(int knots, double period) {
  if (knots == 2) return Eigen::MatrixXd::Identity(2, 2);
  Eigen::MatrixXd out(knots, knots);
  for (int a = 0; a < knots; ++a)
    for (int b = 0; b < knots; ++b) {
      const double apart = period > 0.0 ? std::sin(std::numbers::pi * (a - b) / period) : (a - b) / kSmooth;
      out(a, b) = std::exp(-(period > 0.0 ? 2.0 : 0.5) * apart * apart);
    }
  return out;
}

Eigen::MatrixXd prior_of(const Learnable& law, double period) {
  Eigen::MatrixXd out = prior_along(law.over.knots, period / law.over.spacing());
  if (law.beside) out = Eigen::kroneckerProduct(out, prior_along(law.beside->knots, 0.0)).eval();
  out.diagonal().array() += kJitter;
  return out;
}

/// Takes the curve of most evidence under a prior of this period, in the variable's units.
void weigh_under(const CurveData& data, double period, Learnable& law) {
  const Eigen::MatrixXd root = prior_of(law, period).llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(root.transpose() * data.square * root);
  const Eigen::ArrayXd lambda = eigen.eigenvalues().array().max(0.0);
  const Eigen::MatrixXd back = root * eigen.eigenvectors();
  const Eigen::ArrayXd b = (back.transpose() * data.slope).array();
  const double share = data.effective / data.samples;
  if (!(lambda.maxCoeff() > 0.0) || !(data.all > 0.0)) return;
  for (int k = 0; k < kSizes; ++k) {
    // The curve's variance over the noise's, in units in which a sample counts `share`.
    const double ratio = std::pow(10.0, 0.25 * k - 3.0) / (lambda.maxCoeff() * share);
    const Eigen::ArrayXd shrunk = ratio * share / (1.0 + ratio * share * lambda);
    const double left = std::max(data.all - (b.square() * shrunk).sum(), 1e-300);
    const double evidence =
        0.5 * data.effective * std::log(data.all / left) - 0.5 * (1.0 + ratio * share * lambda).log().sum();
    if (!(evidence > law.evidence)) continue;
    law.evidence = evidence;
    const double unexplained = data.all - (b.square() * shrunk * (2.0 - shrunk * lambda)).sum();
    law.occam = 0.5 * (1.0 + ratio * share * lambda).log().sum() +
                0.5 * data.effective * std::log(left / std::max(unexplained, 1e-300));
    law.values = back * (shrunk * b).matrix();
    law.errors = (left / data.effective * (back.array().square().matrix() * shrunk.matrix()).array()).sqrt();
  }
}

}  // namespace

void weigh_curve(const CurveData& data, Learnable& law) { weigh_under(data, law.period, law); }

std::optional<double> period_of(const CurveData& data, const Learnable& law) {
  const double range = law.over.to - law.over.from;
  const double shortest = kKnotsInPeriod * law.over.spacing(), longest = range / kPeriodsSeen;
  double best = 0.0, most = -HUGE_VAL;
  for (double period = shortest; period < longest; period *= 1.0 + period_share(law, period)) {
    Learnable here = law;
    here.evidence = -HUGE_VAL;
    weigh_under(data, period, here);
    if (here.evidence > most) most = here.evidence, best = period;
  }
  return best > 0.0 ? std::optional(best) : std::nullopt;
}

double period_share(const Learnable& law, double period) {
  return kPeriodStep * period / (law.seen.second - law.seen.first);
}

void sharpen_period(const std::function<CurveData(const Learnable&)>& data, double share, Learnable& law) {
  constexpr int kBits = 12;
  const auto at = [&](double period) {
    Learnable out = law;
    out.set_period(period);
    out.evidence = -HUGE_VAL;
    weigh_curve(data(out), out);
    return out;
  };
  const double best =
      boost::math::tools::brent_find_minima([&](double period) { return -at(period).evidence; },
                                            (1.0 - share) * law.period, (1.0 + share) * law.period, kBits)
          .first;
  law = at(best);
  // What is not known of the period widens the curve's errors (Laplace).
  const double step = 0.02 * share * law.period;
  const Learnable up = at(law.period + step), down = at(law.period - step);
  const double curvature = (2.0 * law.evidence - up.evidence - down.evidence) / (step * step);
  if (!(curvature > 0.0)) return;
  const Eigen::ArrayXd moved = (up.values - down.values).array() / (2.0 * step * std::sqrt(curvature));
  law.errors = (law.errors.array().square() + moved.square()).sqrt();
}

void Learnable::set_period(double of) {
  period = of;
  over.from = seen.first, over.to = seen.first + of * (over.knots - 1) / over.knots;
}

const char* learned_effect(Stage stage) {
  using Kind = EventSpec::Kind;
  switch (stage) {
    case Stage::command: return to_string(Kind::command);
    case Stage::reading: return to_string(Kind::reading);
    default: return to_string(Kind::effort);
  }
}

bool Learnable::is_alike(const Learnable& other) const {
  const bool second =
      beside ? other.beside && beside->is(*other.beside) && has_branches() == other.has_branches() : !other.beside;
  return joint == other.joint && stage == other.stage && over.is(other.over) && second;
}

bool Learnable::contains(const Learnable& other) const {
  const bool one_of_both = over.is(other.over) || (beside && beside->is(other.over));
  return beside && !other.beside && joint == other.joint && stage == other.stage && one_of_both;
}

EffectSpec Learnable::spec(const std::string& joint_name) const {
  EffectSpec out{learned_effect(stage), joint_name, {}, {}, "learned"};
  const auto put = [&](const Variable& v, const std::string& suffix) {
    out.parameters["over" + suffix] = v.over, out.parameters["of" + suffix] = v.of;
    out.parameters["from" + suffix] = v.from, out.parameters["to" + suffix] = v.to;
    out.parameters["knots" + suffix] = v.knots;
  };
  put(over, "");
  if (period > 0.0) out.parameters["period"] = period;
  if (beside) put(*beside, "_2");
  for (Eigen::Index k = 0; k < values.size(); ++k) out.parameters[fmt::format("value_{}", k + 1)] = values(k);
  return out;
}

}  // namespace lacuna
