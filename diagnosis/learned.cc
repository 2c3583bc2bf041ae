#include "diagnosis/learned.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/evidence.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/law_fit.h"
#include "diagnosis/resemblance.h"
#include "diagnosis/set_search.h"
#include "diagnosis/simpler_name.h"
#include "scenarios/learned_entry.h"

namespace lacuna {
namespace {

constexpr double kInterval = 1.96;  ///< standard errors of a 95 % band

constexpr double kLeastTaken = 0.25;  ///< of the validate recordings' rest, that it takes away: as of a finding
constexpr double kLesserPart = 0.5;   ///< of a curve's mean square, left beside a name that is most of it
constexpr double kMostOfLaw = 0.75;   ///< of a law's energy: what a name leaves of it is half its size at most
constexpr std::size_t kTried = 3;     ///< laws that are fitted in full before the search gives up

class Learner {
 public:
  Learner(const CurrentModel& plain, const CurrentModel& current, const FitContext& context)
      : experiment_(context.experiment),
        sets_(plain, context, of_every_set(plain, current)),
        standing_{effects_beyond(plain.model, current), current},
        laws_(experiment_, sets_, standing_) {
    std::erase_if(standing_.effects, is_of_every_set);
  }

  LearnedLaws run() {
    LearnedLaws out{standing_.model, {}, {}, {}, standing_.model};
    if (sets_.validate().empty() || !sets_.fit(standing_.model, kRefitSteps)) return out;
    if (is_whole()) replace_heaps(out.needless);
    is_measured() ? learn_joint_by_joint(out) : learn_where_most_is_left(out);
    if (kept_.empty() && out.needless.empty()) return out;
    sets_.fit(standing_.model, kRefitIterations);
    for (const Kept& law : kept_) out.laws.push_back(described(law));
    out.model = standing_.model;
    if (!out.needless.empty() || !out.simpler.empty()) out.named = names_alone();
    return out;
  }

 private:
  /// What acts at a joint may move the others.
  void learn_where_most_is_left(LearnedLaws& out) {
    const std::vector<EffectSpec> names = named_effects();
    while (kept_.size() < experiment_.joint_names.size() && leaves_a_rest(standing_.model, sets_.context()))
      if (!learn(laws_.offer(every_joint()))) break;
    if (kept_.empty()) return;
    drop_needless(names, out.needless);
    call_by_simpler_names(out.simpler);
  }
  /// Where efforts are predicted a law is seen at its own joint alone, beside the names there.
  void learn_joint_by_joint(LearnedLaws& out) {
    for (const int joint : every_joint()) {
      std::vector<EffectSpec> names = named_effects();
      std::erase_if(names, [&](const EffectSpec& spec) { return spec.place != experiment_.joint_names[joint]; });
      if (!learn(laws_.offer({joint}))) continue;
      drop_needless(names, out.needless);
      call_by_simpler_names(out.simpler);
    }
  }
  void drop_needless(const std::vector<EffectSpec>& names, std::vector<NamedPlace>& needless) {
    for (const EffectSpec& name : names)
      if (drop_if_needless(place_of(name))) needless.push_back(place_of(name));
  }

  /// Sensitivities of effort transducers that are free to be other than stated: no finding, and never taken out.
  static std::vector<EffectSpec> of_every_set(const CurrentModel& plain, const CurrentModel& current) {
    std::vector<EffectSpec> out = effects_beyond(plain.model, current);
    std::erase_if(out, [](const EffectSpec& spec) { return !is_of_every_set(spec); });
    return out;
  }
  static bool is_of_every_set(const EffectSpec& spec) { return spec.effect == "effort_scale"; }

  /// Whether recordings are simulated from end to end.
  bool is_whole() const { return std::holds_alternative<FreeRun>(experiment_.prediction); }
  /// Whether the motion is measured and efforts are predicted.
  bool is_measured() const { return std::holds_alternative<InverseDynamics>(experiment_.prediction); }
  std::vector<int> every_joint() const {
    std::vector<int> out(standing_.model.model.dof());
    std::iota(out.begin(), out.end(), 0);
    return out;
  }

  /// What train recordings (the freedom of either curve paid for) and validate recordings together say for one law over
  /// another.
  double says_over(const FittedLaw& one, const FittedLaw& other) const {
    return sets_.log_odds(one.set, other.set) - one.law.occam + other.law.occam +
           sets_.heldout_difference(one.set, other.set).gain;
  }
  /// On the validate recordings; of efforts, at the joint, which alone a law there acts on.
  HeldoutDifference predicts_better(const Hypothesis& one, const Hypothesis& other, int joint) const {
    return sets_.heldout_difference(one, other, is_measured() ? std::optional(joint) : std::nullopt);
  }
  double least_taken() const { return is_measured() ? kLeastOfEfforts : kLeastTaken; }

  /// Puts the one in that, fitted in full, train and validate recordings together speak for most. Those are tried that
  /// are not clearly behind the first, others where nothing passed, and of a law of two variables what one alone does.
  bool learn(const std::vector<Learnable>& offered) {
    const std::size_t tried = is_measured() ? 1 : kTried;  // all but linear: the evidence ranks them as a fit would
    std::optional<FittedLaw> best;
    HeldoutDifference predicts;
    std::vector<double> says;
    for (const Learnable& law : offered) says.push_back(law.evidence);
    std::size_t which = 0;
    for (std::size_t k = 0; k < offered.size(); ++k) {
      const bool behind = k >= tried || offered[k].evidence < offered[0].evidence - kWorthLearning;
      if (best ? behind && !best->law.contains(offered[k]) : k >= tried) continue;
      std::optional<FittedLaw> found = laws_.fitted(offered[k], standing_);
      if (!found) continue;
      if (!found->law.beside && found->law.over.over == LearnedCurve::kPosition) laws_.look_for_a_period(*found);
      const HeldoutDifference here = predicts_better(found->set, standing_, offered[k].joint);
      if (!(found->law.evidence > kWorthLearning) || !here.speaks_for() || here.share < least_taken()) continue;
      says[k] = best ? says[which] + says_over(*found, *best) : says[k] + here.gain;
      if (best && says[k] <= says[which]) continue;
      which = k, predicts = here, best = std::move(found);
    }
    if (!best) return false;
    kept_.push_back({std::move(best->law), predicts, probability_of(says, which)});
    standing_ = std::move(best->set);
    return true;
  }

  std::vector<EffectSpec> named_effects() const {
    std::vector<EffectSpec> out = standing_.effects;
    std::erase_if(out, [](const EffectSpec& spec) { return is_learned(spec.effect); });
    return out;
  }
  /// Several names at one joint may all stand for one law that has none: that is learned in their place, and stays
  /// where evidence, the law's freedom paid for, prefers it to all of them and the validate recordings do not object.
  void replace_heaps(std::vector<NamedPlace>& needless) {
    for (int joint = 0; joint < standing_.model.model.dof(); ++joint) {
      SetChange without;
      for (const EffectSpec& spec : named_effects())
        if (spec.place == experiment_.joint_names[joint]) without.out.push_back(place_of(spec));
      if (without.out.size() < 2) continue;
      std::optional<Hypothesis> base = sets_.changed(standing_, without, kRefitSteps);
      if (!base) continue;
      const Hypothesis bare = *base, named = std::exchange(standing_, std::move(*base));
      const bool learned = learn(laws_.offer({joint}));
      if (learned && is_preferred_to(named)) {
        if (const std::optional<NamedPlace> kept = keep_the_name_of_it(named, bare, without.out))
          std::erase(without.out, *kept);
        needless.insert(needless.end(), without.out.begin(), without.out.end());
        continue;
      }
      if (learned) kept_.pop_back();
      standing_ = named;
    }
  }
  /// Of the names in whose place the last law was learned, the one that says most of it alone: it stays, and what it
  /// leaves is learned beside it. A machine's law is never quite the textbook's.
  std::optional<NamedPlace> keep_the_name_of_it(const Hypothesis& named, const Hypothesis& bare,
                                                const std::vector<NamedPlace>& names) {
    std::optional<Hypothesis> best;
    std::optional<NamedPlace> out;
    double most = kMostOfLaw;
    for (const NamedPlace& name : names) {
      if (!is_of_the_kind(name, kept_.back().law)) continue;
      SetChange others;
      std::ranges::copy_if(names, std::back_inserter(others.out), [&](const NamedPlace& n) { return n != name; });
      std::optional<Hypothesis> alone = sets_.changed(named, others, kRefitIterations);
      const double says = alone ? share_of_it(*alone, bare) : 0.0;
      if (says > most) most = says, best = std::move(alone), out = name;
    }
    if (!best) return std::nullopt;
    const Hypothesis by_law_alone = std::exchange(standing_, std::move(*best));
    const Kept law = std::move(kept_.back());
    kept_.pop_back();
    if (learn(laws_.offer({law.law.joint}))) return out;
    if (predicts_better(by_law_alone, standing_, law.law.joint).share < least_taken()) return out;
    standing_ = by_law_alone, kept_.push_back(law);
    return std::nullopt;
  }
  /// Of the energy that the present set takes off another, the share that a third takes alone.
  double share_of_it(const Hypothesis& alone, const Hypothesis& bare) const {
    return (laws_.left_by(bare) - laws_.left_by(alone)) / (laws_.left_by(bare) - laws_.left_by(standing_));
  }
  /// Whether a name's law acts where the learned one does, which may then be what is uneven of it.
  static bool is_of_the_kind(const NamedPlace& name, const Learnable& law) {
    const EffectInfo& info = effect_info(name.first);
    const bool reads = info.stage == Stage::reading, commands = info.stage <= Stage::flow;
    if (law.stage == Stage::reading || reads) return law.stage == Stage::reading && reads;
    return acts_by_a_law(find_effect(name.first)) && commands == (law.stage == Stage::command);
  }
  bool is_preferred_to(const Hypothesis& named) const {
    const double prior = sets_.log_prior(standing_.effects) - sets_.log_prior(named.effects);
    const double odds = sets_.log_odds(standing_, named) + prior - kept_.back().law.occam;
    return odds > 0.0 && !sets_.heldout_difference(standing_, named).speaks_against();
  }

  static double mean_square(const Learnable& law) { return law.values.squaredNorm() / static_cast<double>(law.size()); }
  /// Takes a named effect out where the last law, learned anew without it, does what both did: where the effect takes
  /// less from the validate recordings' rest than a finding must. A curve that needs many more knots for that has not
  /// made the name needless: fine enough, it is any friction. Nor has one that is little beside the name and large
  /// without it, nor one most of which the name says alone, with fewer numbers.
  bool drop_if_needless(const NamedPlace& name) {
    Kept& law = kept_.back();
    SetChange without;
    without.out = {name, laws_.place_of_law(law.law)};
    const std::optional<Hypothesis> base = sets_.changed(standing_, without, kRefitSteps);
    if (!base || says_most(name)) return false;
    std::optional<FittedLaw> found = laws_.fitted(law.law, *base, 2 * law.law.over.knots);
    if (!found || mean_square(law.law) < kLesserPart * mean_square(found->law)) return false;
    const HeldoutDifference says = predicts_better(standing_, found->set, law.law.joint);
    if (says.speaks_for() && says.share >= least_taken()) return false;
    // A name with its few numbers is weighed against what the curve costs that replaces it.
    if (sets_.log_odds(found->set, standing_) - found->law.occam + law.law.occam < 0.0) return false;
    law.law = std::move(found->law);
    standing_ = std::move(found->set);
    return true;
  }
  /// Whether a name alone, of those at its joint, takes most of what they and the last law take off a set without any.
  bool says_most(const NamedPlace& name) const {
    if (!is_of_the_kind(name, kept_.back().law)) return false;
    SetChange others, all;
    others.out.push_back(laws_.place_of_law(kept_.back().law));
    for (const EffectSpec& spec : named_effects())
      if (spec.place == name.second && place_of(spec) != name) others.out.push_back(place_of(spec));
    all.out = others.out, all.out.push_back(name);
    const std::optional<Hypothesis> alone = sets_.changed(standing_, others, kRefitIterations),
                                    bare = sets_.changed(standing_, all, kRefitIterations);
    return alone && bare && share_of_it(*alone, *bare) > kMostOfLaw;
  }
  /// What a name said with more numbers than a simpler one may be what the last law says: then it is that one.
  void call_by_simpler_names(std::vector<SimplerName>& simpler) {
    for (const EffectSpec& name : named_effects()) {
      if (name.place != laws_.name_of(kept_.back().law)) continue;
      SetChange law;
      law.out.push_back(laws_.place_of_law(kept_.back().law));
      const std::optional<Hypothesis> bare = sets_.changed(standing_, law, kRefitSteps);
      if (!bare) continue;
      for (const EffectInfo& info : effect_table()) {
        const std::optional<Hypothesis> named = in_place_of(sets_, *bare, name, info);
        std::optional<FittedLaw> found =
            named ? laws_.fitted(kept_.back().law, *named, kept_.back().law.over.knots) : std::nullopt;
        if (!found) continue;
        const double odds = sets_.log_odds(found->set, standing_) - found->law.occam + kept_.back().law.occam;
        if (!(odds > 0.0)) continue;
        const auto is = std::ranges::find(found->set.effects, NamedPlace(info.name, name.place), place_of);
        simpler.push_back({name, *is, own_point(standing_.model, name), odds});
        kept_.back().law = std::move(found->law), standing_ = std::move(found->set);
        break;
      }
    }
  }
  CurrentModel names_alone() const {
    SetChange without;
    for (const Kept& law : kept_) without.out.push_back(laws_.place_of_law(law.law));
    std::optional<Hypothesis> out = sets_.changed(standing_, without, kRefitIterations);
    return out ? std::move(out->model) : sets_.plain();
  }

  /// A law that stands.
  struct Kept {
    Learnable law;
    HeldoutDifference predicts;
    double probability = 0.0;
  };
  LearnedLaw described(const Kept& kept) const {
    const Learnable& law = kept.law;
    const Robot& robot = standing_.model.model.robot();
    LearnedLaw out;
    out.place = experiment_.joint_names[law.joint], out.stage = law.stage;
    const std::vector<std::string> names = variables_of(law.spec(out.place), robot);
    const auto variable = [&](const Learnable::Variable& v, const std::string& name, double from, double to) {
      const int whose = v.of > 0 ? v.of - 1 : law.joint;
      out.over.push_back({name, from, to, unit_of(v.over, whose), static_cast<std::size_t>(v.knots)});
    };
    variable(law.over, names.front(), law.seen.first, law.seen.second);
    if (law.beside) variable(*law.beside, names.back(), law.beside->from, law.beside->to);
    out.unit = law.stage == Stage::link      ? (is_sliding(law.joint) ? "N" : "N m")
               : law.stage == Stage::command ? unit_of(LearnedCurve::kCommand, law.joint)
                                             : unit_of(LearnedCurve::kPosition, law.joint);
    out.period = law.period;
    const int columns = law.beside ? law.beside->knots : 1;
    // One that repeats itself is shown as often as it was seen.
    const double times = law.period > 0.0 ? (law.seen.second - law.seen.first) / law.period : 1.0;
    const int rows = law.period > 0.0 ? static_cast<int>(times * law.over.knots) + 1 : law.over.knots;
    for (int k = 0; k < rows * columns; ++k) {
      const double value = law.values(k % law.size()), error = kInterval * law.errors(k % law.size());
      out.curve.push_back({law.over.place(k / columns), value, value - error, value + error,
                           law.beside ? law.beside->place(k % columns) : 0.0});
    }
    out.over.front().knots = static_cast<std::size_t>(rows);
    out.probability = kept.probability, out.evidence = law.evidence;
    out.heldout_gain = kept.predicts.gain, out.heldout_share = kept.predicts.share;
    describe_curve(out);
    return out;
  }
  bool is_sliding(int joint) const { return standing_.model.model.robot().joints()[joint].prismatic(); }
  std::string unit_of(LearnedCurve::Variable variable, int joint) const {
    switch (variable) {
      case LearnedCurve::kPosition: return is_sliding(joint) ? "m" : "rad";
      case LearnedCurve::kSpeed: return is_sliding(joint) ? "m/s" : "rad/s";
      case LearnedCurve::kCommand: return standing_.model.model.command_unit(joint);
      default: return "s";
    }
  }
  /// That it is this joint and these variables, of those that were offered.
  static double probability_of(const std::vector<double>& says, std::size_t which) {
    double sum = 0.0;
    for (const double other : says) sum += std::exp(std::min(other - says[which], 700.0));
    return 1.0 / sum;
  }

  const Experiment& experiment_;
  Hypotheses sets_;
  Hypothesis standing_;
  LawFit laws_;
  std::vector<Kept> kept_;
};

void rename(Finding& finding, const SimplerName& one) {
  const auto same = [&](const Rival& rival) { return rival.effect == one.is.effect && rival.place == finding.place; };
  double both = finding.probability;
  for (const Rival& rival : finding.rivals)
    if (same(rival)) both += rival.probability;
  std::erase_if(finding.rivals, same);
  const Rival was{finding.effect, finding.place, both / (1.0 + std::exp(one.odds)),
                  finding.fixed,  one.own,       finding.recordings};
  finding.rivals.insert(finding.rivals.begin(), was);
  finding.effect = one.is.effect, finding.fixed = one.is.parameters, finding.recordings = one.is.recordings;
  finding.probability = both - was.probability;
  finding.members = {finding.effect};
  if (one.odds < kNotToldApart) finding.members.push_back(was.effect);
}

}  // namespace

void LearnedLaws::follow(std::vector<Finding>& findings) const {
  if (!changes_names()) return;
  std::erase_if(findings, [&](const Finding& f) {
    return std::ranges::find(needless, NamedPlace(f.effect, f.place)) != needless.end();
  });
  for (const SimplerName& one : simpler)
    for (Finding& f : findings)
      if (NamedPlace(f.effect, f.place) == place_of(one.was)) rename(f, one);
  std::ranges::stable_sort(findings, {},
                           [&](const Finding& f) { return named.model.find_effect_at(f.effect, f.place); });
}

LearnedLaws learn_laws(const CurrentModel& plain, const CurrentModel& current, const FitContext& context) {
  return Learner(plain, current, context).run();
}

}  // namespace lacuna
