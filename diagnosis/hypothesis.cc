#include "diagnosis/hypothesis.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/baseline.h"
#include "diagnosis/evidence.h"
#include "diagnosis/prior.h"

namespace lacuna {
namespace {

constexpr double kFitTolerance = 1e-6;
constexpr double kAtRangesEnd = 0.02;  ///< of a number's typical size
constexpr double kDetermined = 2.0;    ///< standard errors from neutral
constexpr Eigen::Index kHeldoutBlocks = 40;

}  // namespace

NamedPlace place_of(const EffectSpec& spec) { return {spec.effect, spec.place}; }

const EffectInfo& effect_info(const std::string& effect) { return effect_table()[find_effect(effect)]; }

std::vector<std::size_t> own_axes(const CurrentModel& current, const EffectSpec& spec) {
  const Component& c = current.model.effects()[current.model.find_effect_at(spec.effect, spec.place)];
  std::vector<std::size_t> out;
  for (std::size_t a = 0; a < current.space.size(); ++a) {
    const int p = current.space.axes()[a].parameter;
    if (p >= c.first && p < c.first + c.count) out.push_back(a);
  }
  return out;
}

std::vector<double> own_point(const CurrentModel& current, const EffectSpec& spec) {
  std::vector<double> out;
  for (const std::size_t a : own_axes(current, spec)) out.push_back(current.fit.point[a]);
  return out;
}

LinearColumn column_of(const Axis& axis, double x, Eigen::VectorXd train, Eigen::VectorXd validate) {
  return {std::move(train), std::move(validate), x - axis.center, axis.prior, axis.lower - x, axis.upper - x};
}

Hypotheses::Hypotheses(const CurrentModel& plain, const FitContext& context, std::vector<EffectSpec> everywhere)
    : plain_(plain),
      context_(context),
      everywhere_(std::move(everywhere)),
      train_(context.experiment.with_role(Role::train)),
      validate_(context.experiment.with_role(Role::validate)) {
  for (const EffectInfo& info : effect_table()) offered_ += places_of(info, plain, context.experiment).size();
}

Hypothesis Hypotheses::none(int iterations) const {
  Hypothesis out{{}, plain_};
  for (const EffectSpec& spec : everywhere_)
    out.model = extended(out.model, context_.experiment, spec, out.model.fit.point, {0.0});
  fit(out.model, iterations);
  return out;
}

bool Hypotheses::fit(CurrentModel& model, int iterations) const {
  set_priors(model.model, context_.experiment, model.space, model.fit.point);
  if (!refit(model, context_, kFitTolerance, nullptr, iterations)) return false;
  if (settled_) return true;
  change_weights(model, context_, independent_weights(model));
  if (!refit(model, context_, kFitTolerance, nullptr, iterations)) return false;
  change_weights(model, context_, independent_weights(model));
  return true;
}

/// What a channel leaves, times the root of how many samples say one thing: beside a prior each independent one counts
/// once.
std::vector<double> Hypotheses::independent_weights(const CurrentModel& model) const {
  std::vector<double> out = weights_from(model, context_);
  const Problem problem = problem_of(model, context_);
  const Colour colour(model.fit.residual, problem.layout(train_),
                      noise_over_weight(context_.experiment, model.weights));
  for (std::size_t c = 0; c < out.size(); ++c) out[c] *= std::sqrt(colour.correlation_samples(static_cast<int>(c)));
  return out;
}

std::optional<Hypothesis> Hypotheses::changed(const Hypothesis& from, const SetChange& change, int iterations) const {
  const CurrentModel& now = from.model;
  Hypothesis out{{}, {plain_.model, plain_.space, now.weights, {}}};
  out.model.fit.point.assign(now.fit.point.begin(),
                             now.fit.point.begin() + static_cast<std::ptrdiff_t>(plain_.space.size()));
  const auto add = [&](const EffectSpec& spec, const std::vector<double>& own) {
    const std::vector<double> point = out.model.fit.point;
    out.model = extended(out.model, context_.experiment, spec, point, own);
  };
  const auto present = [&](const EffectSpec& spec) { return own_point(now, spec); };
  for (const EffectSpec& spec : everywhere_) add(spec, present(spec));
  for (const EffectSpec& spec : from.effects) {
    if (std::find(change.out.begin(), change.out.end(), place_of(spec)) != change.out.end()) continue;
    const auto shaped = std::find_if(change.shaped.begin(), change.shaped.end(),
                                     [&](const auto& s) { return s.first == place_of(spec); });
    const bool same = shaped == change.shaped.end();
    add(same ? spec : shaped->second, same ? present(spec) : change.shapes[shaped - change.shaped.begin()]);
    out.effects.push_back(same ? spec : shaped->second);
  }
  for (std::size_t k = 0; k < change.in.size(); ++k) {
    add(change.in[k], change.own[k]);
    out.effects.push_back(change.in[k]);
  }
  if (!fit(out.model, iterations)) return std::nullopt;
  return out;
}

Colour Hypotheses::colour(const CurrentModel& model, const Eigen::VectorXd& residual,
                          std::span<const ResidualBlock> blocks) const {
  return settled_ ? *settled_ : Colour(residual, blocks, noise_over_weight(context_.experiment, model.weights));
}

void Hypotheses::settle(const Hypothesis& on) {
  const FittedRows r = rows(on.model, on.model.weights);
  settled_weights_ = on.model.weights;
  settled_ = Colour(r.residual, r.blocks, noise_over_weight(context_.experiment, on.model.weights));
}

FittedRows Hypotheses::rows(const CurrentModel& model, std::span<const double> weights) const {
  FittedRows out;
  const Problem own = problem_of(model, context_);
  const Problem asked = problem_of(model, context_, {weights.begin(), weights.end()});
  out.blocks = asked.layout(train_);
  out.residual = asked.reweighed(model.fit.residual, own, train_);
  const Eigen::MatrixXd J = asked.reweighed(model.fit.jacobian, own, train_);
  for (std::size_t a = 0; a < model.space.size(); ++a)
    out.columns.push_back(column_of(model.space.axes()[a], model.fit.point[a], J.col(a)));
  return out;
}

Eigen::VectorXd Hypotheses::heldout_rows(const Hypothesis& of, const Hypothesis& by) const {
  const std::vector<double>& weights = settled_ ? settled_weights_ : by.model.weights;
  Problem problem = problem_of(of.model, context_, weights);
  Eigen::MatrixXd out = problem.residual(of.model.fit.point, validate_);
  if (out.size() == 0) return {};
  const FittedRows r = settled_ ? FittedRows() : rows(by.model, weights);
  const Colour colour =
      settled_ ? *settled_ : Colour(r.residual, r.blocks, noise_over_weight(context_.experiment, weights));
  colour.whiten(out, problem.layout(validate_));
  return out;
}

double Hypotheses::evidence_of(FittedRows rows, const Colour& colour) {
  colour.whiten(rows.residual, rows.blocks);
  for (LinearColumn& c : rows.columns) colour.whiten(c.train, rows.blocks);
  const std::vector<int> blocks(rows.residual.size(), 0);
  const Linearised alone(std::move(rows.residual), {}, std::move(rows.columns), {}, blocks);
  return alone.evidence({});
}

double Hypotheses::log_odds(const Hypothesis& one, const Hypothesis& other) const {
  const std::vector<double>& weights = settled_ ? settled_weights_ : leaves_less(one, other).model.weights;
  FittedRows x = rows(one.model, weights), y = rows(other.model, weights);
  const FittedRows& less = x.residual.squaredNorm() < y.residual.squaredNorm() ? x : y;
  const Colour common =
      settled_ ? *settled_ : Colour(less.residual, less.blocks, noise_over_weight(context_.experiment, weights));
  return evidence_of(std::move(x), common) - evidence_of(std::move(y), common) + log_prior(one.effects) -
         log_prior(other.effects);
}

/// By the logarithms of what each channel leaves, so that none counts for more because of its unit or noise.
const Hypothesis& Hypotheses::leaves_less(const Hypothesis& one, const Hypothesis& other) const {
  double difference = 0.0;
  for (std::size_t c = 0; c < one.model.weights.size(); ++c)
    difference += std::log(one.model.weights[c] / other.model.weights[c]);
  return difference <= 0.0 ? one : other;
}

HeldoutDifference Hypotheses::heldout_difference(const Hypothesis& one, const Hypothesis& other,
                                                 std::optional<int> joint) const {
  if (validate_.empty()) return {};
  Eigen::VectorXd less = heldout_rows(one, one), more = heldout_rows(other, one);
  if (joint) {
    const std::vector<Eigen::Index> rows = heldout_rows_of(one.model, *joint);
    less = Eigen::VectorXd(less(rows)), more = Eigen::VectorXd(more(rows));
  }
  const Eigen::Index length = std::max<Eigen::Index>(1, less.size() / kHeldoutBlocks);
  HeldoutDifference out;
  double squares = 0.0, n = 0.0;
  for (Eigen::Index k = 0; k < less.size(); k += length, ++n) {
    const Eigen::Index count = std::min(length, less.size() - k);
    const double gain = 0.5 * (more.segment(k, count).squaredNorm() - less.segment(k, count).squaredNorm());
    out.gain += gain, squares += gain * gain;
  }
  out.error = n > 1.0 ? std::sqrt(std::max(0.0, squares - out.gain * out.gain / n)) : 0.0;
  out.share = 1.0 - less.squaredNorm() / std::max(more.squaredNorm(), 1e-300);
  return out;
}

std::vector<Eigen::Index> Hypotheses::heldout_rows_of(const CurrentModel& model, int joint) const {
  const Problem problem = problem_of(model, context_);
  std::vector<Eigen::Index> out;
  for (const ResidualBlock& block : problem.layout(validate_))
    if (context_.experiment.channels[block.channel].joint == joint)
      for (Eigen::Index k = 0; k < block.count; ++k) out.push_back(block.first + k);
  return out;
}

double Hypotheses::log_prior(const std::vector<EffectSpec>& effects) const {
  const double k = static_cast<double>(effects.size()), n = std::max(static_cast<double>(offered_), k);
  double out = log_prior_of_effects(k, n);
  for (const EffectSpec& spec : effects) out -= std::log(choices_of(spec));
  return out;
}

double Hypotheses::choices_of(const EffectSpec& spec) const {
  if (spec.recordings.empty()) return 1.0;
  std::set<std::string> files;
  for (const int s : train_) files.insert(context_.experiment.segments[s].file);
  return std::pow(2.0, static_cast<double>(files.size()));
}

bool Hypotheses::ends_within(const Hypothesis& h, const EffectSpec& spec) const {
  const std::vector<double> values = h.model.space.expand(h.model.fit.point);
  for (const std::size_t a : own_axes(h.model, spec)) {
    const Axis& axis = h.model.space.axes()[a];
    const Parameter& p = h.model.model.parameters()[axis.parameter];
    if (p.info->optional || p.info->per_joint) continue;  // of every joint: of one that moves little it may be neutral
    if (!is_large_enough(h.model, context_.experiment, axis, h.model.fit.point[a])) return false;
    const double x = h.model.fit.point[a];
    double margin = kAtRangesEnd * std::min(axis.prior, axis.upper - axis.lower);
    if (p.info->scale == Scale::inertia && p.info->coordinate == Coordinate::linear) {
      // Its prior is as wide as what the efforts could drive (prior.h), beside which any inertia is small.
      const double size = typical_size(Scale::inertia, h.model.model, context_.experiment, p.joint, values);
      margin = std::min(margin, kAtRangesEnd * size);
    }
    if (x <= axis.lower + margin || x >= axis.upper - margin) return false;
    if (p.info->at_least == nullptr) continue;
    const std::string base = p.name.substr(0, p.name.size() - p.key.size());
    const int other = h.model.model.find(base + p.info->at_least);
    if (other >= 0 && values[axis.parameter] <= values[other]) return false;
  }
  return true;
}

bool Hypotheses::is_determined(const Hypothesis& h, const EffectSpec& spec) const {
  const CurrentModel& now = h.model;
  FitResult fit;
  fit.solution = now.fit;
  fit.values = now.space.expand(now.fit.point);
  Problem problem = problem_of(now, context_);
  describe_fit(now.model, now.space, problem, train_, fit);
  const bool shared = effect_info(spec.effect).shares;
  int determined = 0, strengths = 0;
  for (const std::size_t a : own_axes(now, spec)) {
    const Axis& axis = now.space.axes()[a];
    const Parameter& p = now.model.parameters()[axis.parameter];
    const bool from_infinity = p.info->coordinate == Coordinate::inverse && !p.info->optional;
    if (shared ? !p.info->per_joint : !is_strength(*p.info) && !from_infinity) continue;
    const auto i = static_cast<Eigen::Index>(a);
    const double error = std::sqrt(fit.identifiability.covariance(i, i));
    ++strengths;
    determined += std::fabs(now.fit.point[a] - axis.at(p.neutral)) > kDetermined * error;
  }
  return strengths == 0 || determined >= (shared ? 2 : 1);
}

}  // namespace lacuna
