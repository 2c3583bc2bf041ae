#include "diagnosis/learned.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <numbers>

#include "diagnosis/evidence.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/linear_look.h"
#include "diagnosis/projector.h"
#include "diagnosis/resemblance.h"
#include "physics/effects/learned_effort.h"

namespace lacuna {
namespace {

constexpr std::array kResolutions{8, 16, 32, 64, 128};  ///< knots over the range travelled
constexpr double kSmooth = 2.0;                         ///< knots over which a curve keeps its value
constexpr double kKnotsInPeriod = 5.0;                  ///< at least
constexpr double kNotToldApart = 3.0;                   ///< log evidence: 20 to 1
constexpr double kPeriodStep = 0.25;                    ///< of a period, by which neighbours shift over the range
constexpr double kPeriodsSeen = 2.0;                    ///< at least
constexpr double kJitter = 1e-6;                        ///< of the prior's variance, on its diagonal
constexpr int kSizes = 40;                              ///< sizes of the curve that are tried, four a decade
constexpr double kInterval = 1.96;                      ///< standard errors of a 95 % band

constexpr double kLeastTaken = 0.25;  ///< of the validate recordings' rest, that it takes away: as of a finding
constexpr int kRefitSteps = 5;        ///< of the plain parameters beside a curve on its way
constexpr int kBends = 8;             ///< times that a curve is learned anew about the motion with it
constexpr double kStands = 0.01;      ///< relative change of what is left, under which it stays as it is
constexpr std::size_t kTried = 3;     ///< laws that are fitted in full before the search gives up

/// A law at one joint of one variable, with what the linearised plant says of it.
struct Learnable {
  int joint = 0;
  bool over_speed = false;
  double from = 0.0, to = 0.0;
  double period = 0.0;             ///< with which it repeats itself, in units of the variable; 0: it does not
  Eigen::VectorXd values, errors;  ///< at the knots, and their standard errors, N m (N)
  double evidence = -HUGE_VAL;
};

enum class Kind {
  smooth,
  periodic,  ///< of whatever period
  of_period  ///< of about the one that it has
};

/// Covariance of a smooth curve's values at so many knots, over its variance; `period`, in knots, of one that repeats
/// itself, 0: it need not.
Eigen::MatrixXd smooth_prior(int knots, double period) {
  Eigen::MatrixXd out(knots, knots);
  for (int a = 0; a < knots; ++a)
    for (int b = 0; b < knots; ++b) {
      const double apart = period > 0.0 ? std::sin(std::numbers::pi * (a - b) / period) : (a - b) / kSmooth;
      out(a, b) = std::exp(-(period > 0.0 ? 2.0 : 0.5) * apart * apart);
    }
  out.diagonal().array() += kJitter;
  return out;
}

/// The curve's own efforts: [motion], a row a knot.
std::vector<Eigen::MatrixXd> efforts_of_knots(const std::vector<LinearMotion>& motions, const Learnable& law,
                                              int knots) {
  const double spacing = (law.to - law.from) / (knots - 1);
  std::vector<Eigen::MatrixXd> out;
  for (const LinearMotion& motion : motions) {
    const auto& x = (law.over_speed ? motion.between->v : motion.between->q)[static_cast<std::size_t>(law.joint)];
    out.emplace_back(Eigen::MatrixXd::Zero(knots, static_cast<Eigen::Index>(x.size())));
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double at = std::clamp((x[k] - law.from) / spacing, 0.0, knots - 1.0);
      const auto weight = [&](int knot) { return LearnedEffort::weight(at - knot); };
      auto column = out.back().col(static_cast<Eigen::Index>(k));
      for (int knot = 0; knot < knots; ++knot) column(knot) = weight(knot);
      // One more knot beyond either end, on the line through the last two.
      column(0) += 2.0 * weight(-1), column(1) -= weight(-1);
      column(knots - 1) += 2.0 * weight(knots), column(knots - 2) -= weight(knots);
    }
  }
  return out;
}

/// What the data say of a curve: quadratic form and slope of what it leaves, in its values at the knots.
struct CurveData {
  Eigen::MatrixXd square;  ///< G^T G, G the sensitivities with what the fitted parameters take up projected off
  Eigen::VectorXd slope;   ///< -G^T r, r what is left without the curve
  double all = 0.0;        ///< r^T r
  double samples = 0.0, effective = 0.0;  ///< all, and those that say one thing each
};

/// Takes the curve of most evidence under a prior of this period, if it has more than the one that `law` has; over no
/// curve at all, the noise level profiled out.
void weigh_curve(const CurveData& data, double period, Learnable& law) {
  const int knots = static_cast<int>(data.slope.size());
  const double spacing = (law.to - law.from) / (knots - 1);
  const Eigen::MatrixXd root = smooth_prior(knots, period / spacing).llt().matrixL();
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
    law.evidence = evidence, law.period = period;
    law.values = back * (shrunk * b).matrix();
    law.errors = (left / data.effective * (back.array().square().matrix() * shrunk.matrix()).array()).sqrt();
  }
}

/// The period of most evidence within a share of the present one either way; what is not known of it widens the curve's
/// errors (Laplace).
void sharpen_period(const CurveData& data, double share, Learnable& law) {
  constexpr int kBits = 14;
  const auto at = [&](double period) {
    Learnable out = law;
    out.evidence = -HUGE_VAL;
    weigh_curve(data, period, out);
    return out;
  };
  const double best =
      boost::math::tools::brent_find_minima([&](double period) { return -at(period).evidence; },
                                            (1.0 - share) * law.period, (1.0 + share) * law.period, kBits)
          .first;
  const Learnable here = at(best);
  if (!(here.evidence >= law.evidence)) return;
  law = here;
  const double step = 0.02 * share * law.period;
  const Learnable up = at(law.period + step), down = at(law.period - step);
  const double curvature = (2.0 * law.evidence - up.evidence - down.evidence) / (step * step);
  if (!(curvature > 0.0)) return;
  const Eigen::ArrayXd moved = (up.values - down.values).array() / (2.0 * step * std::sqrt(curvature));
  law.errors = (law.errors.array().square() + moved.square()).sqrt();
}

/// Of the law's own period, and those close by.
void weigh_period(const CurveData& data, Learnable& law) {
  weigh_curve(data, law.period, law);
  sharpen_period(data, kPeriodStep * law.period / (law.to - law.from), law);
}

/// The same over all periods from a few knots to half of the range, each its own prior; then around the best one.
void weigh_periods(const CurveData& data, Learnable& law) {
  const double range = law.to - law.from, spacing = range / static_cast<double>(data.slope.size() - 1);
  const double shortest = kKnotsInPeriod * spacing, longest = range / kPeriodsSeen;
  if (!(longest > shortest)) return;
  for (double period = shortest; period < longest; period *= 1.0 + kPeriodStep * period / range)
    weigh_curve(data, period, law);
  if (law.period > 0.0) weigh_period(data, law);
}

class Learner {
 public:
  Learner(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& simulator,
          const RunControl& control)
      : experiment_(experiment), sets_(current, experiment, simulator, control), standing_{{}, current} {}

  LearnedLaws run() {
    LearnedLaws out{standing_.model, {}};
    if (sets_.validate().empty() || !sets_.fit(standing_.model, kRefitSteps)) return out;
    for (int law = 0; law < out.model.model.dof(); ++law) {
      const std::vector<Learnable> offered = offer();
      if (offered.empty() || !learn(offered, out)) break;
    }
    if (!out.laws.empty()) {
      sets_.fit(standing_.model, kRefitIterations);
      out.model = std::move(standing_.model);
    }
    return out;
  }

 private:
  /// At every joint that has none yet, over its position and its speed, the curve of most evidence; most first. Before
  /// the law is in, its own trace is all colour of the rest and the evidence says little: it ranks, nothing more.
  std::vector<Learnable> offer() const {
    const CurrentModel& now = standing_.model;
    const LinearLook look(now, experiment_, sets_.simulator(), sets_.train());
    std::vector<Learnable> out;
    if (!look.is_linearised()) return out;
    const Projector projector(now.fit.jacobian);
    const Eigen::VectorXd rest = projector.rest(now.fit.residual);
    const double effective = effective_samples(now);
    for (int joint = 0; joint < now.model.dof(); ++joint) {
      const std::string& name = experiment_.joint_names[static_cast<std::size_t>(joint)];
      if (now.model.find_effect_at("learned_effort", name) >= 0) continue;
      for (const bool over_speed : {false, true}) {
        const std::optional<Learnable> best = best_of(look, projector, rest, effective, joint, over_speed);
        if (best && best->evidence > 0.0) out.push_back(*best);
      }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Learnable& a, const Learnable& b) { return a.evidence > b.evidence; });
    return out;
  }

  std::optional<Learnable> best_of(const LinearLook& look, const Projector& projector, const Eigen::VectorXd& rest,
                                   double effective, int joint, bool over_speed) const {
    Learnable range{joint, over_speed, HUGE_VAL, -HUGE_VAL, 0.0, {}, {}, -HUGE_VAL};
    for (const LinearMotion& motion : look.motions()) {
      const auto& x = (over_speed ? motion.between->v : motion.between->q)[static_cast<std::size_t>(joint)];
      if (x.empty()) continue;
      range.from = std::min(range.from, *std::min_element(x.begin(), x.end()));
      range.to = std::max(range.to, *std::max_element(x.begin(), x.end()));
    }
    if (!(range.to > range.from)) return std::nullopt;
    Learnable best = range;
    for (const int knots : kResolutions) {
      Learnable law = range;
      law.values = Eigen::VectorXd::Zero(knots);
      bend(look, projector, rest, effective, Kind::smooth, law);
      if (law.evidence > best.evidence) best = law;
    }
    return best;
  }

  /// The curve anew, about a motion that its present values are part of.
  static void bend(const LinearLook& look, const Projector& projector, const Eigen::VectorXd& rest, double effective,
                   Kind kind, Learnable& law) {
    const int knots = static_cast<int>(law.values.size());
    Eigen::MatrixXd G = look.changes_at(law.joint, efforts_of_knots(look.motions(), law, knots));
    law.evidence = -HUGE_VAL;
    if (!G.allFinite()) return;
    for (Eigen::Index k = 0; k < G.cols(); ++k) G.col(k) = projector.rest(G.col(k));
    const Eigen::VectorXd without = rest - G * law.values;
    const CurveData data{G.transpose() * G, -(G.transpose() * without), without.squaredNorm(),
                         static_cast<double>(rest.size()), effective};
    switch (kind) {
      case Kind::smooth: return weigh_curve(data, 0.0, law);
      case Kind::periodic: return weigh_periods(data, law);
      default: return weigh_period(data, law);
    }
  }

  /// Of the whole residual: as many as say one thing each.
  double effective_samples(const CurrentModel& now) const {
    const Problem problem(now.model, experiment_, now.space, sets_.simulator(), now.weights);
    const auto blocks = problem.layout(sets_.train());
    const Colour colour = sets_.colour(now, now.fit.residual, blocks);
    double out = 0.0;
    for (const ResidualBlock& block : blocks)
      out += static_cast<double>(block.count) / colour.correlation_samples(block.channel);
    return out;
  }

  EffectSpec spec_of(const Learnable& law) const {
    EffectSpec out{"learned_effort",
                   experiment_.joint_names[static_cast<std::size_t>(law.joint)],
                   {{"over", law.over_speed ? 1.0 : 0.0},
                    {"from", law.from},
                    {"to", law.to},
                    {"knots", static_cast<double>(law.values.size())}},
                   {},
                   "learned"};
    for (Eigen::Index k = 0; k < law.values.size(); ++k) out.parameters[fmt::format("value_{}", k + 1)] = law.values(k);
    return out;
  }

  /// The standing model with a law, everything else fitted again.
  std::optional<Hypothesis> with(const Learnable& law) const {
    SetChange change;
    change.in.push_back(spec_of(law)), change.own.emplace_back();
    return sets_.changed(standing_, change, kRefitSteps);
  }

  struct Fitted {
    Learnable law;
    Hypothesis set;
    Fitted(Learnable l, Hypothesis h) : law(std::move(l)), set(std::move(h)) {}
  };
  /// The law and the parameters beside it in full simulation: the curve is learned again about the motion with it until
  /// it stands; a step that leaves more is halved.
  std::optional<Fitted> fitted(const Learnable& start, Kind kind) const {
    std::optional<Fitted> best;
    Learnable tried = start;
    for (int k = 0; k < kBends; ++k) {
      std::optional<Hypothesis> next = with(tried);
      const double now = left_by(best ? best->set : standing_), then = next ? left_by(*next) : HUGE_VAL;
      if (!(then < now)) {
        const Eigen::VectorXd from = best ? best->law.values : Eigen::VectorXd::Zero(start.values.size());
        tried.values = 0.5 * (tried.values + from);
        continue;
      }
      const bool stands = best && then > (1.0 - kStands) * now;
      best.emplace(tried, std::move(*next));
      if (stands || !bend_about(*best, kind, tried)) break;
    }
    return best;
  }
  /// The curve of a fitted law anew; the law's own evidence and errors with it.
  bool bend_about(Fitted& best, Kind kind, Learnable& tried) const {
    const CurrentModel& about = best.set.model;
    const LinearLook look(about, experiment_, sets_.simulator(), sets_.train());
    if (!look.is_linearised()) return false;
    const Projector projector(about.fit.jacobian);
    bend(look, projector, projector.rest(about.fit.residual), effective_samples(about), kind, tried);
    if (!std::isfinite(tried.evidence)) return false;
    best.law.evidence = tried.evidence, best.law.errors = tried.errors, best.law.period = tried.period;
    return true;
  }
  /// A curve that repeats itself says more with less: it stands where it predicts the validate recordings as well. What
  /// repeats itself after one period does so after two and three: of those that are not told apart it is the shortest.
  void look_for_a_period(Fitted& smooth) const {
    Learnable longest = smooth.law;
    Fitted about = smooth;
    if (!bend_about(about, Kind::periodic, longest) || !(longest.period > 0.0)) return;
    std::optional<Fitted> best = of_period(smooth, longest, longest.period);
    if (!best) return;
    const double evidence = best->law.evidence;
    for (const int parts : {3, 2}) {
      std::optional<Fitted> shorter = of_period(smooth, longest, longest.period / parts);
      if (!shorter || shorter->law.evidence < evidence - kNotToldApart) continue;
      best = std::move(shorter);
      break;
    }
    if (sets_.heldout_difference(best->set, smooth.set).gain >= 0.0) smooth = std::move(*best);
  }
  std::optional<Fitted> of_period(const Fitted& smooth, Learnable law, double period) const {
    law.period = period;
    Fitted about = smooth;
    if (!bend_about(about, Kind::of_period, law)) return std::nullopt;
    return fitted(law, Kind::of_period);
  }
  /// Energy on the train recordings over the noise, whatever a fit's own weights are.
  double left_by(const Hypothesis& one) const {
    double out = 0.0;
    const Problem problem(one.model.model, experiment_, one.model.space, sets_.simulator(), one.model.weights);
    for (const ResidualBlock& b : problem.layout(sets_.train())) {
      const auto c = static_cast<std::size_t>(b.channel);
      const double unit = one.model.weights[c] / standing_.model.weights[c];
      out += unit * unit * one.model.fit.residual.segment(b.first, b.count).squaredNorm();
    }
    return out;
  }

  /// Puts the first one in that full simulation and the validate recordings confirm.
  bool learn(const std::vector<Learnable>& offered, LearnedLaws& out) {
    for (std::size_t k = 0; k < std::min(kTried, offered.size()); ++k) {
      std::optional<Fitted> found = fitted(offered[k], Kind::smooth);
      if (!found) continue;
      look_for_a_period(*found);
      const HeldoutDifference predicts = sets_.heldout_difference(found->set, standing_);
      if (!(found->law.evidence > kWorthLearning) || !predicts.speaks_for() || predicts.share < kLeastTaken) continue;
      out.laws.push_back(described(found->law, predicts, probability_of(offered, k)));
      standing_ = std::move(found->set);
      return true;
    }
    return false;
  }
  LearnedLaw described(const Learnable& law, const HeldoutDifference& predicts, double probability) const {
    LearnedLaw out;
    out.place = experiment_.joint_names[static_cast<std::size_t>(law.joint)], out.over = law.over_speed ? "v" : "q";
    out.from = law.from, out.to = law.to, out.period = law.period;
    const bool sliding = standing_.model.model.robot().joints()[static_cast<std::size_t>(law.joint)].prismatic();
    out.unit = sliding ? "N" : "N m";
    out.way_unit = std::string(sliding ? "m" : "rad") + (law.over_speed ? "/s" : "");
    const double spacing = (law.to - law.from) / static_cast<double>(law.values.size() - 1);
    for (Eigen::Index k = 0; k < law.values.size(); ++k)
      out.curve.push_back({law.from + spacing * static_cast<double>(k), law.values(k),
                           law.values(k) - kInterval * law.errors(k), law.values(k) + kInterval * law.errors(k)});
    out.probability = probability, out.evidence = law.evidence;
    out.heldout_gain = predicts.gain, out.heldout_share = predicts.share;
    describe_curve(out);
    return out;
  }
  /// That it is this joint and variable and no other that was offered.
  static double probability_of(const std::vector<Learnable>& offered, std::size_t which) {
    double sum = 0.0;
    for (const Learnable& other : offered) sum += std::exp(std::min(other.evidence - offered[which].evidence, 700.0));
    return 1.0 / sum;
  }

  const Experiment& experiment_;
  Hypotheses sets_;
  Hypothesis standing_;
};

}  // namespace

LearnedLaws learn_laws(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& simulator,
                       const RunControl& control) {
  return Learner(current, experiment, simulator, control).run();
}

}  // namespace lacuna
