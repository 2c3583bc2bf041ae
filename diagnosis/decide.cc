#include "diagnosis/decide.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "diagnosis/baseline.h"
#include "diagnosis/kin.h"
#include "diagnosis/partial.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double kLeastShare = 0.25;
constexpr double kPromising = 0.9;  ///< share of energy left under which a start is re-identified whatever its chance
constexpr std::size_t kShortlist = 4;
constexpr double kDisappointing = 1.5;      ///< energy left over the promised one
constexpr std::size_t kPromisingTried = 5;  ///< of those that the linear look promised most
constexpr int kKinRounds = 3;
constexpr double kAtEnd = 1e-6;          ///< of a parameter's typical size
constexpr double kNearly = 0.95;         ///< share of the best one's share of energy
constexpr double kChanceLikelier = 0.5;  ///< probability of chance from which nothing is claimed
constexpr double kOneNat = 2.0;          ///< energy over noise that a log-likelihood of 1 is worth

/// A candidate with its model, re-identified, and both residuals.
struct Tried {
  ScreenedEffect effect;
  CurrentModel model;
  Gain train;
  HeldoutGain heldout;
  double p_value = 1.0;
  bool refitted = false;

  double evidence = 0.0;     ///< against other candidates, see sort_by_evidence
  double over_chance = 0.0;  ///< the same against nothing: no tie makes it larger
  std::string objection;     ///< why it cannot be what is missing; empty: it can

  bool finite() const {
    return std::all_of(effect.own.begin(), effect.own.end(), [](double x) { return std::isfinite(x); });
  }
  /// An own number driven to the end of its range, as seen at its typical size. Optional ones and those of every joint may
  /// stand there; all but the leading one may stand at an end at or beyond which their neutral value lies.
  bool at_end(const Experiment& experiment) const {
    const auto& axes = model.space.axes();
    const std::size_t plain = axes.size() - effect.own.size();
    for (std::size_t k = 0; k < effect.own.size(); ++k) {
      const Axis& axis = axes[plain + k];
      const Parameter& p = model.model.parameters()[static_cast<std::size_t>(axis.parameter)];
      if (p.info->optional || p.info->per_joint) continue;
      const double x = model.fit.point[plain + k], margin = kAtEnd * size_of(axis, p, experiment);
      if (!std::isfinite(margin)) continue;
      const double neutral = to_search(axis.coordinate, p.neutral);
      const bool low = x <= axis.lower + margin && !(k > 0 && neutral <= axis.lower + margin);
      const bool high = x >= axis.upper - margin && !(k > 0 && neutral >= axis.upper - margin);
      if (low || high) return true;
    }
    return false;
  }

 private:
  /// A typical step along the axis, in its coordinate; at most its length.
  double size_of(const Axis& axis, const Parameter& p, const Experiment& experiment) const {
    const double size = typical_size(p.info->scale, model.model, experiment, p.joint, model.model.values());
    const double along = axis.coordinate == Coordinate::linear    ? size
                         : axis.coordinate == Coordinate::inverse ? 1.0 / size
                                                                  : 1.0;
    return std::min(along, axis.upper - axis.lower);
  }
};

class Judge {
 public:
  Judge(const CurrentModel& current, const Experiment& experiment, const DecideOptions& options, int tries)
      : current_(current),
        experiment_(experiment),
        options_(options),
        simulator_(options.simulator),
        tries_(tries),
        train_(experiment.with_role(Role::train)),
        validate_(experiment.with_role(Role::validate)),
        plain_(current.model, experiment, current.space, options.simulator, current.weights) {
    before_validate_ = plain_.residual(current.fit.point, validate_);
    floor_ = noise_floor();
    if (validate_.empty() || current.space.size() == 0) return;
    spread_ = prediction_spread(current.fit.jacobian, current.fit.residual, plain_.layout(train_),
                                plain_.jacobian(current.fit.point, before_validate_, validate_));
  }

  Tried weigh(ScreenedEffect effect) {
    Tried out{std::move(effect), current_, {}, {}};
    set_recordings(out);
    out.model = extended(current_, experiment_, out.effect.spec, out.effect.point, out.effect.own);
    out.train = residual_gain(current_.fit.residual, out.effect.residual, plain_.layout(train_));
    judge_heldout(out);
    return out;
  }

  /// Share of the train energy that the first, linear look expected to remain.
  double promised_rest(const Tried& tried) const {
    return tried.effect.promise / std::max(current_.fit.residual.squaredNorm(), 1e-300);
  }
  /// Whether it stands far above what that look expected.
  bool disappoints(const Tried& tried) const {
    return tried.effect.residual.squaredNorm() > kDisappointing * tried.effect.promise;
  }
  /// Re-identified from where that look stood; kept if that is the better end.
  void refit_from_first_look(Tried& tried) {
    Tried again{tried};
    again.effect.point.assign(current_.fit.point.begin(), current_.fit.point.end());
    again.effect.own = tried.effect.first_own;
    again.model = extended(current_, experiment_, again.effect.spec, again.effect.point, again.effect.own);
    if (refit(again) && again.effect.residual.squaredNorm() < tried.effect.residual.squaredNorm())
      tried = std::move(again);
  }

  /// Least squares to the end: first with the present weights, then with those of what it leaves, since a joint that the
  /// candidate brings down to its noise decides by that noise how well it does. Residuals are kept in present weights, so
  /// that candidates compare. Returns whether it could: one that cannot be simulated from where it stands is left as it is.
  bool refit(Tried& tried) {
    tried.refitted = true;
    CurrentModel& model = tried.model;
    model.weights = current_.weights;
    if (!lacuna::refit(model, experiment_, simulator_, options_.control)) return false;
    const std::vector<double> weights = weights_from(model, experiment_, simulator_);
    if (weights != model.weights) {
      model.fit.jacobian = reweighed(model.fit.jacobian, plain_.layout(train_), model.weights, weights);
      model.weights = weights;
      if (!settle(model)) return false;
    }
    take_over(tried);
    return true;
  }
  /// Calls work(candidate) for several at once, each with its share of the threads; ranks compute each one together.
  template <class Work>
  void share(const std::vector<Tried*>& those, const Work& work) {
    const int threads = simulator_.threads, count = static_cast<int>(those.size());
    const bool at_once = simulator_.ranks == nullptr && count > 1;
    if (at_once) simulator_.threads = std::max(1, threads / count);
    parallel_for(at_once ? threads : 1, count, [&](int, int k) { work(*those[static_cast<std::size_t>(k)]); });
    simulator_.threads = threads;
  }
  /// A re-identified candidate once more, from where it stands, at the step in use.
  void follow(Tried& tried) {
    if (settle(tried.model)) take_over(tried);
  }

  /// The step in use; a candidate may need a finer one than the present model does.
  double step() const { return simulator_.max_step; }
  void set_step(double step) { simulator_.max_step = step; }
  double step_for(const Tried& tried) const {
    return choose_step(tried.model.model, experiment_, simulator_, tried.model.space.expand(tried.model.fit.point))
        .step;
  }

  /// The same effect with its optional parameters free, re-identified from where it stands; nothing where none is fixed.
  std::optional<Tried> freed(const Tried& tried) {
    const EffectInfo& info = effect_table()[static_cast<std::size_t>(find_effect(tried.effect.spec.effect))];
    EffectSpec spec = tried.effect.spec;
    for (const ParameterInfo& p : info.parameters) {
      if (p.optional) spec.parameters.erase(p.name);
    }
    if (spec.parameters.size() == tried.effect.spec.parameters.size()) return std::nullopt;
    const PlantModel model = current_.model.with_effects({spec});
    std::vector<double> own;
    std::size_t taken = 0;
    for (const Axis& axis : effect_axes(model, experiment_, model.effects().back(), spec)) {
      const Parameter& p = model.parameters()[static_cast<std::size_t>(axis.parameter)];
      const double size = typical_size(p.info->scale, model, experiment_, p.joint, model.values());
      own.push_back(p.info->optional ? to_search(axis.coordinate, p.info->starts.front() * size)
                                     : tried.effect.own[taken++]);
    }
    Tried free{tried};
    free.effect.spec = spec;
    free.effect.own = own;
    free.effect.parameters = static_cast<int>(own.size());
    free.model = extended(current_, experiment_, spec, tried.effect.point, own);
    if (!refit(free)) return std::nullopt;
    return free;
  }

  /// Special cases of `tried` or effects that it is a special case of, from where it stands; with optional shapes and
  /// without.
  std::vector<Tried> kin_of(const Tried& tried, const EffectInfo& kin) {
    std::vector<Tried> out;
    for (ScreenedEffect& start : kin_starts(kin, tried.effect, tried.model, current_, experiment_, simulator_))
      out.push_back(weigh(std::move(start)));
    return out;
  }

  std::string objection(const Tried& tried) const {
    if (!tried.finite()) return "a parameter is not finite";
    if (tried.at_end(experiment_)) return "a parameter at the end of its range";
    if (tried.p_value > kChance) return fmt::format("chance {:.2g}", tried.p_value);
    if (validate_.empty()) return "no validate recording to prove it on";
    if (!held_out(tried.heldout)) {
      return fmt::format("held-out gain {:.1f}, {:.1f} standard errors its way", tried.heldout.gain,
                         tried.heldout.standard_errors);
    }
    if (const double share = share_of_excess(tried); share < kLeastShare) {
      return fmt::format("removes {:.2g} of the held-out energy above the noise", share);
    }
    return "";
  }

  double share_of_excess(const Tried& tried) const {
    const double before = before_validate_.squaredNorm();
    return tried.heldout.share * before / std::max(before - floor_, 1e-3 * before);
  }

 private:
  /// The model's fit becomes the candidate's figures.
  void take_over(Tried& tried) {
    const CurrentModel& model = tried.model;
    const std::size_t base = current_.space.size();
    tried.effect.point.assign(model.fit.point.begin(), model.fit.point.begin() + static_cast<std::ptrdiff_t>(base));
    tried.effect.own.assign(model.fit.point.begin() + static_cast<std::ptrdiff_t>(base), model.fit.point.end());
    tried.effect.residual = reweighed(model.fit.residual, plain_.layout(train_), model.weights, current_.weights);
    tried.train = residual_gain(current_.fit.residual, tried.effect.residual, plain_.layout(train_));
    judge_heldout(tried);
  }

  /// From a fit with its Jacobian to where a step is worth less than one nat.
  bool settle(CurrentModel& model) {
    const Eigen::MatrixXd known = model.fit.jacobian;
    const double tolerance = kOneNat / static_cast<double>(model.fit.residual.size());
    return lacuna::refit(model, experiment_, simulator_, options_.control, tolerance, &known);
  }

  /// Energy that the noise alone would leave on the validate recordings; 0 where it is unknown.
  double noise_floor() const {
    const std::vector<double> noise = noise_levels(current_.model, experiment_);
    double floor = 0.0;
    for (const ResidualBlock& block : plain_.layout(validate_)) {
      const std::size_t c = static_cast<std::size_t>(block.channel);
      const double ratio = noise[c] > 0.0 ? noise[c] / current_.weights[c] : 0.0;
      floor += ratio * ratio * static_cast<double>(block.count);
    }
    return floor;
  }

  /// An effect that is on in some recordings only: which of the validate and test recordings have it is read off
  /// their first second, as their start state is.
  void set_recordings(Tried& tried) {
    EffectSpec& spec = tried.effect.spec;
    if (spec.recordings.empty()) return;
    EffectSpec everywhere = spec;
    everywhere.recordings.clear();
    const CurrentModel all = extended(current_, experiment_, everywhere, tried.effect.point, tried.effect.own);
    const std::vector<double> values = all.space.expand(all.fit.point);
    for (const std::string& file : recordings_with_effect(all.model, all.model.effects().back(), values, experiment_,
                                                          simulator_, current_.weights, {Role::validate, Role::test})) {
      if (std::find(spec.recordings.begin(), spec.recordings.end(), file) == spec.recordings.end()) {
        spec.recordings.push_back(file);
      }
    }
  }

  void judge_heldout(Tried& tried) {
    tried.p_value = chance(tried.train.log_likelihood, tried.effect.parameters, tries_);
    if (validate_.empty()) return;
    Problem problem(tried.model.model, experiment_, tried.model.space, simulator_, current_.weights);
    const Eigen::VectorXd after = problem.residual(tried.model.fit.point, validate_);
    tried.heldout = heldout_gain(before_validate_, after, plain_.layout(validate_), spread_);
    tried.p_value = chance(tried.train.log_likelihood, tried.effect.parameters, tried.heldout, tries_);
  }

  const CurrentModel& current_;
  const Experiment& experiment_;
  const DecideOptions& options_;
  SimulatorOptions simulator_;
  int tries_;
  std::vector<int> train_, validate_;
  Problem plain_;
  Eigen::VectorXd before_validate_;
  Eigen::MatrixXd spread_;  ///< of the present model's predictions of the validate recordings
  double floor_ = 0.0;      ///< whitened energy of the noise alone
};

/// Train and validate gain less the Schwarz penalty. All are counted at the effective samples of the strongest, since the
/// error of that count would otherwise outweigh the difference between two near-perfect candidates. An integration error
/// of e noise rms changes a residual's energy by up to e^2 of the noise's: gains nearer than that are not told apart.
void sort_by_evidence(std::vector<Tried>& tried, double integration_error) {
  if (tried.empty()) return;
  auto own = [](const Tried& t) {
    const double both = t.train.log_likelihood + t.heldout.gain;
    return std::isfinite(both) ? both : -HUGE_VAL;
  };
  const Tried& strongest =
      *std::max_element(tried.begin(), tried.end(), [&](const Tried& a, const Tried& b) { return own(a) < own(b); });
  const Gain train = strongest.train, heldout = strongest.heldout.whole;
  const double resolution =
      0.5 * (train.effective + heldout.effective) * std::log1p(integration_error * integration_error);
  double most = -HUGE_VAL;
  for (Tried& t : tried) {
    t.evidence = t.train.at(train) + t.heldout.whole.at(heldout);
    if (!std::isfinite(t.evidence)) t.evidence = -HUGE_VAL;  // diverges on a recording that was not fitted
    most = std::max(most, t.evidence);
  }
  const double worth = 0.5 * std::log(std::max(2.0, train.effective));  // of one parameter
  for (Tried& t : tried) {
    t.over_chance = t.evidence - worth * t.effect.parameters;
    t.evidence = std::min(t.evidence + resolution, most) - worth * t.effect.parameters;
  }
  std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) { return a.evidence > b.evidence; });
}

/// Shares of exp(evidence) among the candidates that can be what is missing, chance (evidence 0, prior weight that of all
/// candidates together) included. The others have none: what removes a small part of the rest is no rival of what removes
/// most of it, however clearly it does.
std::vector<double> probabilities(const std::vector<Tried>& tried) {
  double most = -HUGE_VAL, over_chance = -HUGE_VAL;
  for (const Tried& t : tried) {
    if (!t.objection.empty()) continue;
    most = std::max(most, t.evidence), over_chance = std::max(over_chance, t.over_chance);
  }
  double total = static_cast<double>(tried.size()) * std::exp(std::clamp(-over_chance, -700.0, 600.0));
  std::vector<double> out;
  for (const Tried& t : tried) {
    out.push_back(t.objection.empty() ? std::exp(std::max(t.evidence - most, -700.0)) : 0.0);
    total += out.back();
  }
  for (double& p : out) p /= total;
  return out;
}

Finding make_finding(const std::vector<Tried>& tried, std::size_t winner, std::uint64_t seed) {
  const Tried& best = tried[winner];
  const std::vector<double> probability = probabilities(tried);
  Finding out;
  out.effect = best.effect.spec.effect;
  out.place = best.effect.spec.place;
  out.recordings = best.effect.spec.recordings;
  out.fixed = best.effect.spec.parameters;
  out.probability = probability[winner];
  out.outside = 1.0 - std::accumulate(probability.begin(), probability.end(), 0.0);
  out.p_value = best.p_value;
  out.heldout_gain = best.heldout.gain;
  out.heldout_error = best.heldout.error;
  out.heldout_share = best.heldout.share;
  out.members.push_back(out.effect);
  const std::vector<double>* elsewhere = nullptr;  // the strongest rival at another place
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const EffectSpec& spec = tried[k].effect.spec;
    const bool same = spec.effect == out.effect && spec.place == out.place;
    if (k == winner) continue;
    if (same) {  // the same effect in other recordings: one hypothesis with the winner
      out.probability += probability[k];
      continue;
    }
    if (!tried[k].objection.empty()) continue;
    if (out.rivals.size() < 5)
      out.rivals.push_back(
          {spec.effect, spec.place, probability[k], spec.parameters, tried[k].effect.own, spec.recordings});
    if (spec.place == out.place && best.evidence - tried[k].evidence < kClassLoss) out.members.push_back(spec.effect);
    if (spec.place != out.place && !elsewhere) elsewhere = &tried[k].heldout.blocks;
  }
  const std::vector<double> nothing(best.heldout.blocks.size(), 0.0);
  out.stability = stability(best.heldout.blocks, elsewhere != nullptr ? *elsewhere : nothing, seed);
  return out;
}

Candidate candidate_record(const Tried& tried, const std::string& note) {
  return {tried.effect.spec.effect,
          tried.effect.spec.place,
          tried.train.log_likelihood,
          tried.heldout.gain,
          tried.heldout.error,
          tried.heldout.share,
          tried.p_value,
          tried.effect.parameters,
          note};
}

/// Screening follows many candidates for a few cheap steps and may lose one whose parameters lie far off. Those that the
/// linear look promised most are therefore re-identified in full, too.
void refit_promising(Judge& judge, std::vector<Tried>& tried) {
  std::vector<Tried*> order;
  for (Tried& t : tried) order.push_back(&t);
  std::stable_sort(order.begin(), order.end(),
                   [](const Tried* a, const Tried* b) { return a->effect.promise < b->effect.promise; });
  order.resize(std::min(kPromisingTried, order.size()));
  std::erase_if(order, [&](const Tried* t) { return judge.promised_rest(*t) >= kPromising || !judge.disappoints(*t); });
  judge.share(order, [&](Tried& t) { judge.refit_from_first_look(t); });
}

/// Puts it in place of itself where it is the better end.
void take_in(std::vector<Tried>& tried, Tried found) {
  const auto same = std::find_if(tried.begin(), tried.end(), [&](const Tried& t) {
    return t.effect.spec.effect == found.effect.spec.effect && t.effect.spec.place == found.effect.spec.place &&
           t.effect.spec.recordings == found.effect.spec.recordings && t.effect.parameters == found.effect.parameters;
  });
  if (same == tried.end()) {
    tried.push_back(std::move(found));
  } else if (found.effect.residual.squaredNorm() < same->effect.residual.squaredNorm()) {
    *same = std::move(found);
  }
}

/// The strongest one's kin, those that do not do as well yet, from where it stands; and again if one of them is the
/// strongest then.
void refit_kin(Judge& judge, const CurrentModel& current, std::vector<Tried>& tried, double integration_error) {
  std::string last;
  for (int round = 0; round < kKinRounds && !tried.empty(); ++round) {
    const Tried strongest = tried.front();
    const EffectSpec& spec = strongest.effect.spec;
    if (!strongest.refitted || strongest.p_value > kChance || spec.effect == last) return;
    last = spec.effect;
    const EffectInfo& info = effect_table()[static_cast<std::size_t>(find_effect(spec.effect))];
    std::vector<Tried> found;
    for (const EffectInfo& kin : effect_table()) {
      if (!are_kin(info, kin) || current.model.find_effect_at(kin.name, spec.place) >= 0) continue;
      const bool as_good = std::any_of(tried.begin(), tried.end(), [&](const Tried& t) {
        return t.effect.spec.effect == kin.name && t.effect.spec.place == spec.place &&
               t.effect.residual.squaredNorm() <= strongest.effect.residual.squaredNorm();
      });
      if (as_good) continue;
      for (Tried& one : judge.kin_of(strongest, kin)) found.push_back(std::move(one));
    }
    std::vector<Tried*> each;
    for (Tried& one : found) each.push_back(&one);
    std::vector<char> reached(found.size());
    judge.share(each, [&](Tried& one) { reached[static_cast<std::size_t>(&one - found.data())] = judge.refit(one); });
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (reached[k]) take_in(tried, std::move(found[k]));
    }
    sort_by_evidence(tried, integration_error);
  }
}

/// Candidates that explain nearly as much as the best one are told apart by little: by less than the integration error at
/// the present model's step, if one of them needs a finer one. Then they are re-identified at that.
void sharpen(Judge& judge, std::vector<Tried>& tried) {
  std::vector<Tried*> close;
  double step = judge.step();
  for (Tried& t : tried) {
    if (!t.refitted || t.train.share < kNearly * tried.front().train.share || !judge.objection(t).empty()) continue;
    step = std::min(step, judge.step_for(t));
    close.push_back(&t);
    if (close.size() == kShortlist) break;
  }
  if (close.empty() || step >= judge.step()) return;
  judge.set_step(step);
  judge.share(close, [&](Tried& t) { judge.follow(t); });
}

std::optional<Branch> branch_of(const std::vector<Tried>& tried, std::size_t winner, std::uint64_t seed) {
  const EffectSpec& kept = tried[winner].effect.spec;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const Tried& t = tried[k];
    if (t.refitted && t.objection.empty() && t.effect.spec.effect != kept.effect && t.effect.spec.place == kept.place &&
        t.effect.spec.recordings == kept.recordings && t.effect.parameters < tried[winner].effect.parameters)
      return Branch{make_finding(tried, k, seed), t.model};
  }
  return std::nullopt;
}

}  // namespace

Decision decide(const CurrentModel& current, const Experiment& experiment, std::vector<ScreenedEffect> screened,
                const DecideOptions& options) {
  const double tries = options.choices * static_cast<double>(screened.size());
  Judge judge(current, experiment, options, static_cast<int>(std::ceil(tries)));
  std::vector<Tried> tried;
  for (ScreenedEffect& effect : screened) tried.push_back(judge.weigh(std::move(effect)));
  sort_by_evidence(tried, options.integration_error);
  std::vector<Tried*> shortlist;
  for (std::size_t k = 0; k < std::min(kShortlist, tried.size()); ++k) {
    if (tried[k].p_value < kChance || tried[k].train.share > 1.0 - kPromising) shortlist.push_back(&tried[k]);
  }
  judge.share(shortlist, [&](Tried& t) { judge.refit(t); });
  refit_promising(judge, tried);
  sort_by_evidence(tried, options.integration_error);
  if (!tried.empty() && tried.front().refitted) {
    if (std::optional<Tried> free = judge.freed(tried.front())) tried.push_back(std::move(*free));
  }
  sort_by_evidence(tried, options.integration_error);
  refit_kin(judge, current, tried, options.integration_error);
  sharpen(judge, tried);
  sort_by_evidence(tried, options.integration_error);
  Decision out{{}, std::nullopt, current, options.simulator, std::nullopt};
  std::optional<std::size_t> winner;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    tried[k].objection = judge.objection(tried[k]);
    if (tried[k].objection.empty() && !winner && !tried[k].refitted) {
      judge.refit(tried[k]);
      tried[k].objection = judge.objection(tried[k]);
    }
    const bool can = tried[k].objection.empty();
    out.candidates.push_back(candidate_record(tried[k], can && winner ? kLessEvidence : tried[k].objection));
    if (can && !winner) winner = k;
  }
  if (!winner) return out;
  Finding finding = make_finding(tried, *winner, options.seed);
  if (finding.outside > kChanceLikelier) {
    out.candidates[*winner].note = "more probably chance";
    return out;
  }
  out.finding = std::move(finding);
  // A rival's finer step served the comparison only.
  out.simulator.max_step = std::max(judge.step(), std::min(out.simulator.max_step, judge.step_for(tried[*winner])));
  out.branch = branch_of(tried, *winner, options.seed);
  out.model = tried[*winner].model;
  refine(out.model, experiment, out.simulator, options.control);
  return out;
}

}  // namespace lacuna
