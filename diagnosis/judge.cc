#include "diagnosis/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/candidates.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/kin.h"
#include "diagnosis/partial.h"

namespace lacuna {
namespace {

constexpr double kLeastShare = 0.25;
constexpr double kLeastOfNoise = 0.01;  ///< energy over the noise's: a tenth in rms is what a step may be wrong by
constexpr double kDisappointing = 1.5;  ///< energy left over the promised one
constexpr double kAtEnd = 1e-6;         ///< of a parameter's typical size
constexpr double kUndriven = 2.0;       ///< standard errors from neutral within which a number is not determined
constexpr double kOneNat = 2.0;         ///< energy over noise that a log-likelihood of 1 is worth

/// A typical step along the axis, in its coordinate; at most its length.
double size_of(const Axis& axis, const Parameter& p, const PlantModel& model, const Experiment& experiment) {
  const double size = typical_size(p.info->scale, model, experiment, p.joint, model.values());
  const double along = axis.coordinate == Coordinate::linear    ? size
                       : axis.coordinate == Coordinate::inverse ? 1.0 / size
                                                                : 1.0;
  return std::min(along, axis.upper - axis.lower);
}

/// Standard error of each coordinate of a re-identified candidate; empty for others.
std::vector<double> standard_errors(const CurrentModel& model) {
  if (model.fit.jacobian.cols() != static_cast<Eigen::Index>(model.space.size())) return {};
  const Eigen::MatrixXd covariance =
      identifiability(model.space, model.fit.point, model.fit.jacobian, 1.0, 1.0).covariance;
  std::vector<double> out;
  for (Eigen::Index a = 0; a < covariance.rows(); ++a) out.push_back(std::sqrt(covariance(a, a)));
  return out;
}

bool too_small(const Tried& tried, const Experiment& experiment) {
  const auto& axes = tried.model.space.axes();
  const std::size_t plain = axes.size() - tried.effect.own.size();
  for (std::size_t a = plain; a < axes.size(); ++a)
    if (!is_large_enough(tried.model, experiment, axes[a], tried.model.fit.point[a])) return true;
  return false;
}

/// What joints are said to share, of which at most one of them takes anything that could be told from nothing.
bool takes_from_one(const Tried& tried) {
  if (!effect_info(tried.effect.spec.effect).shares) return false;
  const std::vector<double> errors = standard_errors(tried.model);
  const std::size_t plain = tried.model.space.size() - tried.effect.own.size();
  int taking = 0;
  for (std::size_t a = plain; a < errors.size(); ++a) {
    const Axis& axis = tried.model.space.axes()[a];
    const Parameter& p = tried.model.model.parameters()[axis.parameter];
    const double off = std::fabs(tried.model.fit.point[a] - to_search(axis.coordinate, p.neutral));
    taking += p.info->per_joint && off > kUndriven * errors[a];
  }
  return !errors.empty() && taking < 2;
}

bool is_finite(const Tried& tried) {
  return std::all_of(tried.effect.own.begin(), tried.effect.own.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace

bool at_end(const CurrentModel& model, const Component& effect, const Experiment& experiment) {
  const auto& axes = model.space.axes();
  const std::vector<double> errors = standard_errors(model);
  bool leading = true;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const Axis& axis = axes[a];
    if (axis.parameter < effect.first || axis.parameter >= effect.first + effect.count) continue;
    const Parameter& p = model.model.parameters()[axis.parameter];
    const bool first = std::exchange(leading, false);
    if (p.info->optional || p.info->per_joint) continue;
    const double x = model.fit.point[a], margin = kAtEnd * size_of(axis, p, model.model, experiment);
    if (!std::isfinite(margin)) continue;
    const double neutral = to_search(axis.coordinate, p.neutral);
    const bool low = x <= axis.lower + margin, high = x >= axis.upper - margin;
    const bool leads_nowhere = (low && neutral <= axis.lower + margin) || (high && neutral >= axis.upper - margin);
    const bool driven = errors.empty() || !(std::fabs(x - neutral) < kUndriven * errors[a]);
    if (leads_nowhere ? first : (low || high) && driven) return true;
  }
  return false;
}

Judge::Judge(const CurrentModel& current, const FitContext& context, int tries)
    : current_(current),
      context_(context),
      tries_(tries),
      train_(context.experiment.with_role(Role::train)),
      validate_(context.experiment.with_role(Role::validate)),
      plain_(problem_of(current, context)) {
  before_validate_ = plain_.residual(current.fit.point, validate_);
  heldout_energy_ = heldout_energy();
  for (const Energy& channel : heldout_energy_) floor_ += channel.noise;
  if (validate_.empty() || current.space.size() == 0) return;
  spread_ = prediction_spread(current.fit.jacobian, current.fit.residual, plain_.layout(train_),
                              plain_.jacobian(current.fit.point, before_validate_, validate_),
                              least_curvatures(current.space.axes()));
}

Tried Judge::weigh(ScreenedEffect effect) {
  Tried out{std::move(effect), current_, {}, {}};
  set_recordings(out);
  out.model = extended(current_, context_.experiment, out.effect.spec, out.effect.point, out.effect.own);
  out.train = residual_gain(current_.fit.residual, out.effect.residual, plain_.layout(train_));
  judge_heldout(out);
  return out;
}

double Judge::promised_rest(const Tried& tried) const {
  return tried.effect.promise / std::max(current_.fit.residual.squaredNorm(), 1e-300);
}

bool Judge::disappoints(const Tried& tried) const {
  return tried.effect.residual.squaredNorm() > kDisappointing * tried.effect.promise;
}

void Judge::refit_from_first_look(Tried& tried) {
  Tried again{tried};
  again.effect.point.assign(current_.fit.point.begin(), current_.fit.point.end());
  again.effect.own = tried.effect.first_own;
  again.model = extended(current_, context_.experiment, again.effect.spec, again.effect.point, again.effect.own);
  if (refit(again) && again.effect.residual.squaredNorm() < tried.effect.residual.squaredNorm())
    tried = std::move(again);
}

bool Judge::refit(Tried& tried) {
  tried.refitted = true;
  CurrentModel& model = tried.model;
  model.weights = current_.weights;
  if (!lacuna::refit(model, context_)) return false;
  const std::vector<double> weights = weights_from(model, context_);
  if (weights != model.weights) {
    change_weights(model, context_, weights);
    if (!settle(model)) return false;
  }
  take_over(tried);
  return true;
}

void Judge::follow(Tried& tried) {
  if (settle(tried.model)) take_over(tried);
}

double Judge::step_for(const Tried& tried) const {
  return choose_step(tried.model.model, context_.experiment, context_.simulator,
                     tried.model.space.expand(tried.model.fit.point))
      .step;
}

double Judge::doubt(const Tried& tried) const {
  Problem problem = problem_of(tried.model, context_.with_step(0.5 * step()), current_.weights);
  const Eigen::VectorXd& rest = tried.effect.residual;
  const Eigen::VectorXd error = kErrorOverChange * (problem.residual(tried.model.fit.point, train_) - rest);
  std::vector<double> errors(tried.train.channels.size(), 0.0), rests = errors;
  for (const ResidualBlock& block : plain_.layout(train_)) {
    const std::size_t c = block.channel;
    errors[c] += error.segment(block.first, block.count).squaredNorm();
    rests[c] += rest.segment(block.first, block.count).squaredNorm();
  }
  double nats = 0.0;
  for (std::size_t c = 0; c < errors.size(); ++c) {
    if (!(rests[c] > 0.0)) continue;
    const double ratio = std::sqrt(errors[c] / rests[c]);  // of rms
    if (!(ratio < 1.0)) return HUGE_VAL;
    const double heldout = c < tried.heldout.whole.channels.size() ? tried.heldout.whole.channels[c].effective : 0.0;
    nats -= (tried.train.channels[c].effective + heldout) * std::log1p(-ratio);
  }
  return nats;
}

std::optional<Tried> Judge::freed(const Tried& tried) {
  const EffectInfo& info = effect_table()[find_effect(tried.effect.spec.effect)];
  EffectSpec spec = tried.effect.spec;
  for (const ParameterInfo& p : info.parameters) {
    if (p.optional) spec.parameters.erase(p.name);
  }
  if (spec.parameters.size() == tried.effect.spec.parameters.size()) return std::nullopt;
  const PlantModel model = current_.model.with_effects({spec});
  std::vector<double> own;
  std::size_t taken = 0;
  for (const Axis& axis : effect_axes(model, context_.experiment, model.effects().back(), spec)) {
    const Parameter& p = model.parameters()[axis.parameter];
    const double size = typical_size(p.info->scale, model, context_.experiment, p.joint, model.values());
    own.push_back(p.info->optional ? to_search(axis.coordinate, p.info->starts.front() * size)
                                   : tried.effect.own[taken++]);
  }
  Tried free{tried};
  free.effect.spec = spec;
  free.effect.own = own;
  free.effect.parameters = static_cast<int>(own.size());
  free.model = extended(current_, context_.experiment, spec, tried.effect.point, own);
  if (!refit(free)) return std::nullopt;
  return free;
}

std::vector<Tried> Judge::kin_of(const Tried& tried, const EffectInfo& kin) {
  std::vector<Tried> out;
  const std::vector<EffectSpec> places = places_of(kin, current_, context_.experiment);
  if (std::ranges::find(places, tried.effect.spec.place, &EffectSpec::place) == places.end()) return out;  // not sought
  for (ScreenedEffect& start : kin_starts(kin, tried.effect, tried.model, current_, context_))
    out.push_back(weigh(std::move(start)));
  return out;
}

std::string Judge::objection(const Tried& tried) const {
  if (!is_finite(tried)) return "a parameter is not finite";
  if (at_end(tried.model, tried.model.model.effects().back(), context_.experiment))
    return "a parameter at the end of its range";
  if (too_small(tried, context_.experiment)) return "a parameter too small for such an effect";
  if (takes_from_one(tried)) return "no two joints take of what is shared";
  if (tried.p_value > kChance) return fmt::format("chance {:.2g}", tried.p_value);
  if (validate_.empty()) return "no validate recording to prove it on";
  if (!held_out(tried.heldout)) {
    return fmt::format("held-out gain {:.1f}, {:.1f} standard errors its way", tried.heldout.gain,
                       tried.heldout.standard_errors);
  }
  const double removed = tried.heldout.share * before_validate_.squaredNorm();
  if (removed > 0.0 && removed < kLeastOfNoise * floor_)
    return fmt::format("changes the held-out prediction by {:.2g} of the noise", std::sqrt(removed / floor_));
  if (const double share = share_of_excess(tried); share < kLeastShare) {
    return fmt::format("removes {:.2g} of what stands above the noise where it removes most", share);
  }
  return "";
}

bool Judge::cannot_tell(const Tried& special, const Tried& rich) const {
  const EffectSpec &one = special.effect.spec, &other = rich.effect.spec;
  if (one.effect == other.effect || one.place != other.place || one.recordings != other.recordings) return false;
  if (special.effect.parameters >= rich.effect.parameters) return false;
  if (!are_kin(effect_info(one.effect), effect_info(other.effect)) || !(floor_ > 0.0)) return false;
  const double more = (rich.heldout.share - special.heldout.share) * before_validate_.squaredNorm();
  return more < kLeastOfNoise * floor_;
}

double Judge::share_of_excess(const Tried& tried) const {
  double most = -HUGE_VAL, share = 0.0;
  for (std::size_t c = 0; c < tried.heldout.whole.channels.size(); ++c) {
    const auto [before, noise] = heldout_energy_[c];
    const double removed = before * -std::expm1(-tried.heldout.whole.channels[c].log_ratio);
    if (!(removed > most)) continue;
    most = removed;
    share = removed / std::max(before - noise, 1e-3 * before);
  }
  return share;
}

/// The model's fit becomes the candidate's figures.
void Judge::take_over(Tried& tried) {
  const CurrentModel& model = tried.model;
  const std::size_t base = current_.space.size();
  tried.effect.point.assign(model.fit.point.begin(), model.fit.point.begin() + static_cast<std::ptrdiff_t>(base));
  tried.effect.own.assign(model.fit.point.begin() + static_cast<std::ptrdiff_t>(base), model.fit.point.end());
  const Problem own = problem_of(model, context_);
  tried.effect.residual = plain_.reweighed(model.fit.residual, own, train_);
  tried.train = residual_gain(current_.fit.residual, tried.effect.residual, plain_.layout(train_));
  judge_heldout(tried);
}

/// From a fit with its Jacobian to where a step is worth less than one nat.
bool Judge::settle(CurrentModel& model) {
  const Eigen::MatrixXd known = model.fit.jacobian;
  const double tolerance = kOneNat / static_cast<double>(model.fit.residual.size());
  return lacuna::refit(model, context_, tolerance, &known);
}

std::vector<Judge::Energy> Judge::heldout_energy() const {
  const std::vector<double> noise = noise_over_weight(context_.experiment, current_.weights);
  std::map<int, Energy> channels;
  for (const ResidualBlock& block : plain_.layout(validate_)) {
    const std::size_t c = block.channel;
    const double ratio = noise[c] > 0.0 ? noise[c] : 0.0;
    Energy& of = channels[block.channel];
    of.before += before_validate_.segment(block.first, block.count).squaredNorm();
    of.noise += ratio * ratio * static_cast<double>(block.count);
  }
  std::vector<Energy> out;
  for (const auto& [channel, energy] : channels) out.push_back(energy);
  return out;
}

/// An effect that is on in some recordings only: which of the validate and test recordings have it is read off
/// their first second, as their start state is.
void Judge::set_recordings(Tried& tried) {
  EffectSpec& spec = tried.effect.spec;
  if (spec.recordings.empty()) return;
  EffectSpec everywhere = spec;
  everywhere.recordings.clear();
  const CurrentModel all = extended(current_, context_.experiment, everywhere, tried.effect.point, tried.effect.own);
  for (const std::string& file : recordings_with_effect(all, context_, {Role::validate, Role::test})) {
    if (std::find(spec.recordings.begin(), spec.recordings.end(), file) == spec.recordings.end()) {
      spec.recordings.push_back(file);
    }
  }
}

void Judge::judge_heldout(Tried& tried) {
  tried.p_value = chance(tried.train.log_likelihood, tried.effect.parameters, tries_);
  if (validate_.empty()) return;
  Problem problem = problem_of(tried.model, context_, current_.weights);
  const Eigen::VectorXd after = problem.residual(tried.model.fit.point, validate_);
  tried.heldout = heldout_gain(before_validate_, after, plain_.layout(validate_), spread_);
  tried.p_value = chance(tried.train.log_likelihood, tried.effect.parameters, tried.heldout, tries_);
}

}  // namespace lacuna
