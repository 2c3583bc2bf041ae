#include "diagnosis/learned.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/evidence.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/law_columns.h"
#include "diagnosis/learnable.h"
#include "diagnosis/linear_look.h"
#include "diagnosis/projector.h"
#include "diagnosis/resemblance.h"
#include "diagnosis/set_search.h"
#include "diagnosis/simpler_name.h"
#include "scenarios/learned_entry.h"

namespace lacuna {
namespace {

constexpr std::array kFine{8, 16, 32, 64, 128, 256};  ///< knots over the range travelled
constexpr std::array kSharp{8, 16, 32, 64};           ///< where something may turn within a small part of it
constexpr std::array kCoarse{8, 16, 32};              ///< where nothing repeats itself many times
constexpr std::array kOfOthers{8, 16};                ///< over what another joint does
constexpr std::array kOfMaps{6};                      ///< of either variable
constexpr int kInPeriod = 24;                         ///< of a curve that repeats itself
constexpr double kAtRest = 0.05;                      ///< of a joint's rms speed, within which it moves neither way
constexpr double kNotToldApart = 3.0;                 ///< log evidence: 20 to 1
constexpr double kInterval = 1.96;                    ///< standard errors of a 95 % band

constexpr double kLeastTaken = 0.25;  ///< of the validate recordings' rest, that it takes away: as of a finding
constexpr int kRefitSteps = 5;        ///< of the plain parameters beside a curve on its way
constexpr int kBends = 8;             ///< times that a curve is learned anew about the motion with it
constexpr int kHalvings = 2;          ///< of steps that leave more
constexpr double kStands = 0.01;      ///< relative change of what is left, under which it stays as it is
constexpr double kLesserPart = 0.5;   ///< of a curve's mean square, left beside a name that is most of it
constexpr double kMostOfIt = 0.75;    ///< of a law's energy: what a name leaves of it is half its size at most
constexpr std::size_t kTried = 3;     ///< laws that are fitted in full before the search gives up

/// A law of given variables, and the knots of the first one that are tried.
struct Family {
  Learnable law;
  std::span<const int> resolutions;
};

class Learner {
 public:
  Learner(const CurrentModel& plain, const CurrentModel& current, const Experiment& experiment,
          const SimulatorOptions& simulator, const RunControl& control)
      : experiment_(experiment),
        sets_(plain, experiment, simulator, control, of_every_set(plain, current)),
        standing_{effects_beyond(plain.model, current), current} {
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
    while (kept_.size() < experiment_.joint_names.size() &&
           leaves_a_rest(standing_.model, experiment_, sets_.simulator()))
      if (!learn(offer(every_joint()))) break;
    if (kept_.empty()) return;
    drop_needless(names, out.needless);
    call_by_simpler_names(out.simpler);
  }
  /// Where efforts are predicted a law is seen at its own joint alone, beside the names there.
  void learn_joint_by_joint(LearnedLaws& out) {
    for (const int joint : every_joint()) {
      std::vector<EffectSpec> names = named_effects();
      std::erase_if(names, [&](const EffectSpec& spec) {
        return spec.place != experiment_.joint_names[static_cast<std::size_t>(joint)];
      });
      if (!learn(offer({joint}))) continue;
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

  /// Of every law that may be learned, the curve of most evidence; most first. Before the law is in, its own trace is
  /// all colour of the rest and the evidence says little: it ranks, nothing more.
  std::vector<Learnable> offer(const std::vector<int>& joints) const {
    const About about(*this, standing_.model);
    std::vector<Learnable> out;
    if (!about.look.is_linearised()) return out;
    for (const int joint : joints)
      for (const Family& family : families(about.along, joint))
        for (const int knots : family.resolutions) {
          out.push_back(family.law);
          out.back().over.knots = knots;
        }
    // What goes through valve and actuator is simulated, which has threads of its own.
    const auto simulated = std::ranges::partition(out, [](const Learnable& l) { return l.stage != Stage::command; });
    const auto weigh = [&](Learnable& law) {
      law.values = Eigen::VectorXd::Zero(law.size());
      bend(about, nullptr, law);
    };
    parallel_for(
        sets_.simulator().threads, static_cast<int>(simulated.begin() - out.begin()),
        [&](int, int k) { weigh(out[static_cast<std::size_t>(k)]); }, sets_.simulator().stop);
    std::ranges::for_each(simulated, weigh);
    return best_of_each(std::move(out));
  }

  /// Of laws that differ in their knots alone the one of most evidence; most first.
  static std::vector<Learnable> best_of_each(std::vector<Learnable> out) {
    std::stable_sort(out.begin(), out.end(),
                     [](const Learnable& a, const Learnable& b) { return a.evidence > b.evidence; });
    std::vector<Learnable> best;
    for (Learnable& law : out)
      if (law.evidence > 0.0 && std::ranges::none_of(best, [&](const Learnable& b) { return b.is_alike(law); }))
        best.push_back(std::move(law));
    return best;
  }

  /// Whether recordings are simulated from end to end.
  bool is_whole() const { return std::holds_alternative<FreeRun>(experiment_.prediction); }
  /// Whether the motion is measured and efforts are predicted.
  bool is_measured() const { return std::holds_alternative<InverseDynamics>(experiment_.prediction); }
  std::vector<int> every_joint() const {
    std::vector<int> out(static_cast<std::size_t>(standing_.model.model.dof()));
    std::iota(out.begin(), out.end(), 0);
    return out;
  }
  /// What a law of a joint may depend on, where it has none of that stage yet.
  std::vector<Family> families(const LawColumns& along, int joint) const {
    using enum LearnedCurve::Variable;
    std::vector<Family> out;
    const auto add = [&](Stage stage, Learnable::Variable over, std::span<const int> resolutions,
                         std::optional<Learnable::Variable> beside = {}) {
      const std::string& name = experiment_.joint_names[static_cast<std::size_t>(joint)];
      if (standing_.model.model.find_effect_at(learned_effect(stage), name) >= 0) return;
      if (!along.cover(joint, over) || (beside && beside->knots > 2 && !along.cover(joint, *beside))) return;
      out.push_back({{joint, stage, over, beside, {over.from, over.to}, 0.0, {}, {}, -HUGE_VAL}, resolutions});
    };
    add(Stage::link, {kPosition}, kFine);
    add(Stage::link, {kSpeed}, kSharp);
    // In hundreds of windows of a second or two more than a joint's own position and speed costs minutes.
    if (std::holds_alternative<Windows>(experiment_.prediction)) return out;
    const double rest = kAtRest * experiment_.speed_rms[static_cast<std::size_t>(joint)];
    if (rest > 0.0) add(Stage::link, {kPosition}, kCoarse, Learnable::Variable{kSpeed, 0, -rest, rest, 2});
    add(Stage::link, {kPosition}, kOfMaps, Learnable::Variable{kSpeed, 0, 0.0, 0.0, kOfMaps.front()});
    for (int other = 1; other <= standing_.model.model.dof(); ++other) {
      if (other == joint + 1) continue;
      add(Stage::link, {kPosition, other}, kOfOthers);
      add(Stage::link, {kSpeed, other}, kOfOthers);
      add(Stage::link, {kPosition}, kOfMaps, Learnable::Variable{kPosition, other, 0.0, 0.0, kOfMaps.front()});
    }
    if (!is_whole()) return out;  // what is compared is measured, motion and effort
    add(Stage::command, {kCommand}, kCoarse);
    add(Stage::reading, {kPosition}, kSharp);
    return out;
  }

  /// The present motion of a model, linearised, and what its fit leaves.
  struct About {
    About(const Learner& learner, const CurrentModel& model)
        : now(model),
          look(model, learner.experiment_, learner.sets_.simulator(), learner.sets_.train()),
          along(look, model, learner.experiment_, learner.sets_.train()),
          projector(model.fit.jacobian),
          rest(projector.rest(model.fit.residual)),
          effective(learner.effective_samples(model)) {}
    const CurrentModel& now;
    LinearLook look;
    LawColumns along;
    Projector projector;
    Eigen::VectorXd rest;
    double effective;
  };

  /// Changes of the whitened residual, one a value of the law; what the fitted parameters take up is off.
  Eigen::MatrixXd sensitivities(const About& about, const Learnable& law) const {
    Eigen::MatrixXd G = about.along.changes(law);
    if (!G.allFinite()) return {};
    for (Eigen::Index k = 0; k < G.cols(); ++k) G.col(k) = about.projector.rest(G.col(k));
    return G;
  }
  /// What the rest would be without the law that the model has.
  Eigen::VectorXd rest_without(const About& about, const Learnable* stands) const {
    if (stands == nullptr) return about.rest;
    const Eigen::MatrixXd G = sensitivities(about, *stands);
    return G.size() > 0 ? Eigen::VectorXd(about.rest - G * stands->values) : Eigen::VectorXd();
  }
  static CurveData data_of(const About& about, const Eigen::MatrixXd& G, const Eigen::VectorXd& without) {
    return {G.transpose() * G, -(G.transpose() * without), without.squaredNorm(),
            static_cast<double>(about.rest.size()), about.effective};
  }

  /// The curve anew, about a motion of which `stands` (null: nothing) is part. No evidence: it cannot be had.
  void bend(const About& about, const Learnable* stands, Learnable& law) const {
    law.evidence = -HUGE_VAL;
    const Eigen::VectorXd without = rest_without(about, stands);
    const Eigen::MatrixXd G = sensitivities(about, law);
    if (G.size() == 0 || without.size() == 0) return;
    if (law.period <= 0.0) return weigh_curve(data_of(about, G, without), law);
    const auto data = [&](const Learnable& of) { return data_of(about, sensitivities(about, of), without); };
    sharpen_period(data, period_share(law, law.period), law);
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

  const std::string& name_of(const Learnable& law) const {
    return experiment_.joint_names[static_cast<std::size_t>(law.joint)];
  }
  NamedPlace place_of_law(const Learnable& law) const { return {learned_effect(law.stage), name_of(law)}; }

  /// A model with a law, everything else fitted again.
  std::optional<Hypothesis> with(const Learnable& law, const Hypothesis& base) const {
    SetChange change;
    change.in.push_back(law.spec(name_of(law))), change.own.emplace_back();
    return sets_.changed(base, change, kRefitSteps);
  }

  struct Fitted {
    Learnable law;
    Hypothesis set;
    Fitted(Learnable l, Hypothesis h) : law(std::move(l)), set(std::move(h)) {}
  };
  /// The law and the parameters beside it in full simulation: the curve is learned again about the motion with it until
  /// it stands, on at most `finest` knots; a step that leaves more is halved.
  std::optional<Fitted> fitted(const Learnable& start, const Hypothesis& base, int finest = kMostKnots) const {
    std::optional<Fitted> best;
    Learnable tried = start;
    for (int k = 0, halved = 0; k < kBends; ++k) {
      std::optional<Hypothesis> next = with(tried, base);
      const double now = left_by(best ? best->set : base), then = next ? left_by(*next) : HUGE_VAL;
      if (!(then < now)) {
        if (++halved > kHalvings || (best && best->law.size() != tried.size())) break;
        const Eigen::VectorXd from = best ? best->law.values : Eigen::VectorXd::Zero(start.values.size());
        tried.values = 0.5 * (tried.values + from);
        continue;
      }
      const bool stands = best && then > (1.0 - kStands) * now;
      best.emplace(tried, std::move(*next));
      const About about(*this, best->set.model);
      bend(about, &best->law, tried);
      if (!std::isfinite(tried.evidence)) break;
      best->law.evidence = tried.evidence, best->law.occam = tried.occam, best->law.errors = tried.errors;
      const bool finer = 2 * tried.over.knots <= finest && refine(about, best->law, tried);
      if (!finer && stands) break;
    }
    return best;
  }

  /// Twice the knots, where the motion with the law in it speaks for them: before, its own trace hid what they show.
  bool refine(const About& about, const Learnable& stands, Learnable& law) const {
    Learnable finer = law;
    finer.over.knots *= 2;
    const bool simulated = law.stage == Stage::command;  // about the law's own knots, as the model has them
    if (simulated || law.period > 0.0 || finer.over.knots > kMostKnots || finer.size() > kMostValues) return false;
    bend(about, &stands, finer);
    if (!(finer.evidence > law.evidence + kNotToldApart)) return false;
    law = finer;
    return true;
  }

  /// A curve that repeats itself says more with less: it stands where it predicts the validate recordings as well. What
  /// repeats itself after one period does so after two and three: of those that are not told apart it is the shortest.
  void look_for_a_period(Fitted& smooth) const {
    const About about(*this, smooth.set.model);
    const Eigen::VectorXd without = rest_without(about, &smooth.law);
    const Eigen::MatrixXd G = sensitivities(about, smooth.law);
    if (G.size() == 0) return;
    const std::optional<double> longest = period_of(data_of(about, G, without), smooth.law);
    if (!longest) return;
    std::optional<Learnable> best;
    for (const int parts : {1, 2, 3}) {
      Learnable law = smooth.law;
      law.over.knots = kInPeriod;
      law.set_period(*longest / parts);
      law.values = Eigen::VectorXd::Zero(law.size());
      bend(about, &smooth.law, law);
      if (std::isfinite(law.evidence) && (!best || law.evidence > best->evidence - kNotToldApart)) best = law;
    }
    std::optional<Fitted> found = best ? fitted(*best, standing_) : std::nullopt;
    if (found && sets_.heldout_difference(found->set, smooth.set).gain >= 0.0) smooth = std::move(*found);
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

  /// What train recordings (the freedom of either curve paid for) and validate recordings together say for one law over
  /// another.
  double says_over(const Fitted& one, const Fitted& other) const {
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
    std::optional<Fitted> best;
    HeldoutDifference predicts;
    std::vector<double> says;
    for (const Learnable& law : offered) says.push_back(law.evidence);
    std::size_t which = 0;
    for (std::size_t k = 0; k < offered.size(); ++k) {
      const bool behind = k >= tried || offered[k].evidence < offered[0].evidence - kWorthLearning;
      if (best ? behind && !best->law.contains(offered[k]) : k >= tried) continue;
      std::optional<Fitted> found = fitted(offered[k], standing_);
      if (!found) continue;
      if (!found->law.beside && found->law.over.over == LearnedCurve::kPosition) look_for_a_period(*found);
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
        if (spec.place == experiment_.joint_names[static_cast<std::size_t>(joint)])
          without.out.push_back(place_of(spec));
      if (without.out.size() < 2) continue;
      std::optional<Hypothesis> base = sets_.changed(standing_, without, kRefitSteps);
      if (!base) continue;
      const Hypothesis bare = *base, named = std::exchange(standing_, std::move(*base));
      const bool learned = learn(offer({joint}));
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
    double most = kMostOfIt;
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
    if (learn(offer({law.law.joint}))) return out;
    if (predicts_better(by_law_alone, standing_, law.law.joint).share < least_taken()) return out;
    standing_ = by_law_alone, kept_.push_back(law);
    return std::nullopt;
  }
  /// Of the energy that the present set takes off another, the share that a third takes alone.
  double share_of_it(const Hypothesis& alone, const Hypothesis& bare) const {
    return (left_by(bare) - left_by(alone)) / (left_by(bare) - left_by(standing_));
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
    without.out = {name, place_of_law(law.law)};
    const std::optional<Hypothesis> base = sets_.changed(standing_, without, kRefitSteps);
    if (!base || says_most(name)) return false;
    std::optional<Fitted> found = fitted(law.law, *base, 2 * law.law.over.knots);
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
    others.out.push_back(place_of_law(kept_.back().law));
    for (const EffectSpec& spec : named_effects())
      if (spec.place == name.second && place_of(spec) != name) others.out.push_back(place_of(spec));
    all.out = others.out, all.out.push_back(name);
    const std::optional<Hypothesis> alone = sets_.changed(standing_, others, kRefitIterations),
                                    bare = sets_.changed(standing_, all, kRefitIterations);
    return alone && bare && share_of_it(*alone, *bare) > kMostOfIt;
  }
  /// What a name said with more numbers than a simpler one may be what the last law says: then it is that one.
  void call_by_simpler_names(std::vector<SimplerName>& simpler) {
    for (const EffectSpec& name : named_effects()) {
      if (name.place != name_of(kept_.back().law)) continue;
      SetChange law;
      law.out.push_back(place_of_law(kept_.back().law));
      const std::optional<Hypothesis> bare = sets_.changed(standing_, law, kRefitSteps);
      if (!bare) continue;
      for (const EffectInfo& info : effect_table()) {
        const std::optional<Hypothesis> named = in_place_of(sets_, *bare, name, info);
        std::optional<Fitted> found =
            named ? fitted(kept_.back().law, *named, kept_.back().law.over.knots) : std::nullopt;
        if (!found) continue;
        const double odds = sets_.log_odds(found->set, standing_) - found->law.occam + kept_.back().law.occam;
        if (!(odds > 0.0)) continue;
        simpler.push_back({place_of(name), info.name, odds});
        kept_.back().law = std::move(found->law), standing_ = std::move(found->set);
        break;
      }
    }
  }
  CurrentModel names_alone() const {
    SetChange without;
    for (const Kept& law : kept_) without.out.push_back(place_of_law(law.law));
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
    out.place = experiment_.joint_names[static_cast<std::size_t>(law.joint)], out.stage = law.stage;
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
  bool is_sliding(int joint) const {
    return standing_.model.model.robot().joints()[static_cast<std::size_t>(joint)].prismatic();
  }
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
  std::vector<Kept> kept_;
};

}  // namespace

LearnedLaws learn_laws(const CurrentModel& plain, const CurrentModel& current, const Experiment& experiment,
                       const SimulatorOptions& simulator, const RunControl& control) {
  return Learner(plain, current, experiment, simulator, control).run();
}

}  // namespace lacuna
