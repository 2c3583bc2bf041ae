#include "diagnosis/set_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "diagnosis/baseline.h"
#include "diagnosis/coarse.h"
#include "diagnosis/evidence.h"
#include "diagnosis/free_number.h"
#include "diagnosis/kin.h"
#include "diagnosis/screen.h"
#include "diagnosis/thinned.h"
#include "diagnosis/where.h"
#include "ga/sandwich.h"
#include "physics/catalogue.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr int kMostSetRounds = 12;
constexpr double kWorthPutting = 10.0;    ///< log evidence that a change must bring
constexpr int kSetIterations = 15;        ///< of a set on its way
constexpr std::size_t kMostTogether = 4;  ///< members of a compound
constexpr double kIdleWindow = 8.0;       ///< log evidence under which an undetermined member is idle
constexpr double kLeastShareOfRest =
    0.1;  ///< that an effect must explain to be worth a fit, and a member to stay unconfirmed
constexpr double kShareOfExcess = 0.25;    ///< of what stands above the noise at a joint, that its additions must
constexpr double kClaimed = 0.5;           ///< probability of a class under which nothing is claimed
constexpr std::size_t kRivalsFitted = 2;   ///< in each member's place
constexpr std::size_t kLookedAt = 15'000;  ///< train values that rank what is then fitted to all
constexpr int kFinerIterations = 6;        ///< of a fit that only changes its step
constexpr int kSetDraws = 60;              ///< of block resamples

class SetSearch {
 public:
  SetSearch(const CurrentModel& plain, const CurrentModel& current, const std::vector<Finding>& findings,
            const FitContext& context, const SetSearchOptions& options)
      : experiment_(context.experiment),
        looked_at_in_(thinned(experiment_, kLookedAt)),
        options_(options),
        sets_(plain, context),
        standing_{{}, current} {
    for (const Finding& f : findings) {
      standing_.effects.push_back({f.effect, f.place, f.fixed, f.recordings, f.effect});
      std::vector<Rival>& rivals = rivals_[{f.effect, f.place}];
      for (const Rival& rival : f.rivals)
        if (rival.effect != f.effect && rivals.size() < kRivalsFitted) rivals.push_back(rival);
    }
  }

  std::optional<SetSearchResult> run() {
    if (sets_.validate().empty()) return std::nullopt;  // nothing to prove anything on
    if (!sets_.fit(standing_.model, kRefitIterations)) return std::nullopt;
    const Hypothesis before = standing_;
    for (const ValveStart& valve : options_.valves) put_in_valve(valve);
    for (int round = 0; round < kMostSetRounds; ++round) {
      progress(0.6 * round / kMostSetRounds);
      bool freed = false;
      while (free_number()) freed = true;
      if (!improve() && !freed) break;
    }
    if (!changed_) return std::nullopt;
    hold_to_share(before);
    sets_.fit(standing_.model, kSetIterations);  // no less deeply than what it is held against
    sets_.settle(standing_);
    take_out_idle(before, 0.6);
    const auto is_new = [&](const EffectSpec& spec) {
      return std::none_of(before.effects.begin(), before.effects.end(), [&](const EffectSpec& had) {
        return place_of(had) == place_of(spec) && had.parameters == spec.parameters;
      });
    };
    if (std::none_of(standing_.effects.begin(), standing_.effects.end(), is_new)) return std::nullopt;
    const double step = needed_step();
    const bool finer = step < sets_.context().simulator.max_step;
    const bool matters = finer && step_matters(standing_.model, sets_.context(), step);
    if (matters) set_step(step);
    sets_.settle(standing_);
    sets_.fit(standing_.model, kRefitIterations);
    std::vector<Finding> findings = claimed();
    if (finer && !matters) {
      set_step(step);
      sets_.fit(standing_.model, kFinerIterations);
    }
    return SetSearchResult{standing_.model, std::move(findings), std::move(rounds_), std::move(notes_),
                           sets_.context().simulator.max_step};
  }

 private:
  void progress(double done) const {
    if (const auto* stop = sets_.context().control.stop; stop != nullptr && *stop) throw Interrupted();
    if (options_.progress) options_.progress(done);
  }
  static bool holds(const Hypothesis& set, const EffectSpec& member) {
    return std::any_of(set.effects.begin(), set.effects.end(),
                       [&](const EffectSpec& spec) { return place_of(spec) == place_of(member); });
  }

  // ---- growing ------------------------------------------------------------------------------------------------------

  struct Move {
    ScreenedEffect effect;
    double gain = 0.0;  ///< log-likelihood that the first look promises
  };

  /// One round; whether the set changed. What promised nothing at the last look is looked at again only before the
  /// search ends.
  bool improve() {
    for (;;) {
      const bool everything = hopeless_.empty();
      std::vector<Move> moves = promising();
      record(moves);
      if (moves.size() > 1 && put_in(moves)) return true;
      bool any = false;
      for (const Move& move : moves) {
        const bool kept = put_in_for_limits(move) || put_in({move}) || put_in_compound(move);
        if (!kept) refused_.insert(place_of(move.effect.spec));
        any = any || kept;
      }
      if (any) return true;
      if (everything) return false;
      hopeless_.clear();
    }
  }

  /// Frees an optional number that takes away enough of the rest at one of its starts, all else as it stands, and
  /// brings enough evidence when it is fitted; whether there is one.
  bool free_number() {
    for (const FreeNumber& number : numbers_worth_a_fit()) {
      const NamedPlace here = place_of(number.member);
      SetChange change;
      change.shaped = {{here, number.with}};
      change.shapes = {own_point_with(standing_.model, experiment_, number.member, number.with, number.start)};
      std::optional<Hypothesis> next = sets_.changed(standing_, change, kSetIterations);
      const bool better = next && sets_.ends_within(*next, number.with) &&
                          sets_.log_odds(*next, standing_) > kWorthPutting &&
                          !sets_.heldout_difference(*next, standing_).speaks_against();
      if (better) {
        grow_to(std::move(*next));
        return true;
      }
      refused_numbers_.insert({here, number.key});
    }
    return false;
  }
  /// The best start of each.
  std::vector<FreeNumber> numbers_worth_a_fit() const {
    const CurrentModel& now = standing_.model;
    std::vector<FreeNumber> starts = numbers_to_free(standing_, first_looks());
    if (starts.empty()) return starts;
    Problem problem = problem_of(now, first_looks());
    const std::vector<int> train = looked_at_in_.with_role(Role::train);
    const std::vector<ResidualBlock> blocks = problem.layout(train);
    const std::vector<double> rest = energies(problem.residual(now.fit.point, train), blocks);
    std::map<std::pair<NamedPlace, std::string>, double> best;
    std::vector<FreeNumber> out;
    for (FreeNumber& start : starts) {
      const std::pair<NamedPlace, std::string> name{place_of(start.member), start.key};
      if (!start.residual.allFinite() || refused_numbers_.count(name) > 0) continue;
      const double share = largest_share(rest, energies(start.residual, blocks));
      if (share < kLeastShareOfRest || (best.count(name) > 0 && share <= best[name])) continue;
      if (best.count(name) > 0) out.pop_back();  // starts of one number follow each other
      best[name] = share;
      out.push_back(std::move(start));
    }
    return out;
  }

  /// A joint's whole valve as its chart shows it, the plain gain with it.
  void put_in_valve(const ValveStart& valve) {
    Hypothesis from = standing_;
    CurrentModel& base = from.model;
    for (std::size_t a = 0; a < base.space.size(); ++a) {
      const Axis& axis = base.space.axes()[a];
      const bool gain = axis.parameter == gain_of(base.model, valve.joint);
      if (gain) base.fit.point[a] = std::clamp(axis.at(valve.gain), axis.lower, axis.upper);
    }
    std::vector<Move> moves;
    for (const EffectSpec& spec : valve.effects) {
      if (clashes(standing_.effects, spec) || (options_.skipped && options_.skipped(spec))) continue;
      moves.push_back({start_at(base, experiment_, spec), 0.0});
    }
    if (!moves.empty()) put_in(moves, from);
  }
  static int gain_of(const PlantModel& model, int joint) {
    const Component& drive = model.actuators()[joint];
    return drive.first + actuator_table()[drive.type].roles.gain;
  }

  /// What all joints share, in place of the limits that single joints seemed to have of their own, begun at these.
  bool put_in_for_limits(const Move& move) {
    const EffectSpec& spec = move.effect.spec;
    const char* alone = effect_info(spec.effect).alone;
    if (alone == nullptr) return false;
    SetChange change{{spec}, {move.effect.own}, {}, {}, {}};
    std::vector<Rival> limits;
    for (const EffectSpec& member : standing_.effects) {
      if (member.effect != alone) continue;
      change.out.push_back(place_of(member));
      limits.push_back({member.effect, member.place, 0.0, member.parameters, own_point(standing_.model, member), {}});
      begin_at_limit(spec, member, change.own.front());
    }
    if (limits.empty()) return false;
    std::optional<Hypothesis> next = sets_.changed(standing_, change, kSetIterations);
    if (!next || !sets_.is_determined(*next, spec) || !sets_.ends_within(*next, spec)) return false;
    if (!(sets_.log_odds(*next, standing_) > kNotToldApart)) return false;
    if (sets_.heldout_difference(*next, standing_).speaks_against()) return false;
    grow_to(std::move(*next));
    limits.resize(std::min(limits.size(), kRivalsFitted));
    rivals_[place_of(spec)] = std::move(limits);
    in_place_of_others_.insert(place_of(spec));
    return true;
  }
  /// The part of the limit's joint in what is shared, among its own coordinates: the limit itself.
  void begin_at_limit(const EffectSpec& shared, const EffectSpec& limit, std::vector<double>& own) const {
    const PlantModel& now = standing_.model.model;
    const Component& c = now.effects()[now.find_effect_at(limit.effect, limit.place)];
    const double value = standing_.model.space.expand(standing_.model.fit.point)[c.first];
    const PlantModel with = now.with_effects({shared});
    const std::vector<Axis> axes = effect_axes(with, experiment_, with.effects().back(), shared);
    for (std::size_t a = 0; a < axes.size() && a < own.size(); ++a) {
      const Parameter& p = with.parameters()[axes[a].parameter];
      if (p.info->per_joint && p.joint == c.joint) own[a] = std::clamp(axes[a].at(value), axes[a].lower, axes[a].upper);
    }
  }

  /// What makes sense only together: beside one move, the most promising others of its place that act on the same part
  /// of the way from command to reading; those that the recordings do not need go when the search ends.
  bool put_in_compound(const Move& first) {
    std::vector<Move> together{first};
    std::vector<EffectSpec> specs{first.effect.spec};
    for (const Move& other : looked_at_[first.effect.spec.place]) {
      const EffectSpec& spec = other.effect.spec;
      if (together.size() >= kMostTogether || clashes(specs, spec)) continue;
      if (part_of(spec) != part_of(first.effect.spec)) continue;
      together.push_back(other);
      specs.push_back(spec);
    }
    std::set<NamedPlace> members;
    for (const EffectSpec& spec : specs) members.insert(place_of(spec));
    return together.size() > 1 && tried_together_.insert(members).second && put_in(together);
  }
  /// The command's way to the joint, the joint's transmission, its link, the readings.
  static Stage part_of(const EffectSpec& spec) {
    const Stage stage = effect_info(spec.effect).stage;
    return stage < Stage::transmission ? Stage::command : stage;
  }

  /// At every place the effect of most promise; most first.
  std::vector<Move> promising() {
    std::map<std::string, std::vector<Move>> at = look();
    std::vector<Move> out;
    for (auto& [place, moves] : at) {
      sort_by_gain(moves);
      remember_rivals(moves);
      out.push_back(std::move(moves.front()));
    }
    sort_by_gain(out);
    return out;
  }
  /// [place]: what is worth a fit. A rest may be slow: then few independent samples are in it, and what took most of it
  /// away would seem to gain little. So a share of it is enough, too, of what one joint is left with.
  std::map<std::string, std::vector<Move>> look() {
    ScreenOptions how{[](const std::string&) { return true; }};
    how.skipped = [&](const EffectSpec& spec) {
      return hopeless_.count(place_of(spec)) > 0 || (options_.skipped && options_.skipped(spec));
    };
    const bool whole = looked_at_in_.segments.size() == experiment_.segments.size();
    const CurrentModel of = whole ? standing_.model : seen_in(standing_.model, first_looks());
    const std::vector<int> train = looked_at_in_.with_role(Role::train);
    const auto blocks = problem_of(of, first_looks()).layout(train);
    const double share =
        static_cast<double>(of.fit.residual.size()) / static_cast<double>(standing_.model.fit.residual.size());
    const double now = of.fit.residual.squaredNorm();
    const std::vector<double> rest = energies(of.fit.residual, blocks);
    std::map<std::string, std::vector<Move>> out;
    std::set<NamedPlace> seen, worth;
    looked_at_.clear();
    for (ScreenedEffect& s : screen_effects(of, first_looks(), how)) {
      const double gain = 0.5 * now / share * std::log(now / std::max(s.sum_of_squares, 1e-300));
      const bool worth_it =
          gain > kWorthPutting || largest_share(rest, energies(s.residual, blocks)) > kLeastShareOfRest;
      const NamedPlace here = place_of(s.spec);
      seen.insert(here);
      if (worth_it) worth.insert(here);
      if (!s.spec.recordings.empty() || clashes(standing_.effects, s.spec)) continue;
      if (gain > 0.0) looked_at_[s.spec.place].push_back({s, gain});
      if (worth_it && refused_.count(here) == 0) out[s.spec.place].push_back({std::move(s), gain});
    }
    std::set_difference(seen.begin(), seen.end(), worth.begin(), worth.end(),
                        std::inserter(hopeless_, hopeless_.end()));
    for (auto& [place, moves] : looked_at_) sort_by_gain(moves);
    return out;
  }
  /// Ranks only: what is then fitted is fitted to all.
  FitContext first_looks() const { return sets_.context().on(looked_at_in_); }
  /// [channel]: energy of a residual.
  std::vector<double> energies(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks) const {
    std::vector<double> out(experiment_.channels.size(), 0.0);
    for (const ResidualBlock& b : blocks) out[b.channel] += residual.segment(b.first, b.count).squaredNorm();
    return out;
  }
  /// Of what a channel was left with, that is gone.
  static double largest_share(const std::vector<double>& before, const std::vector<double>& after) {
    double out = 0.0;
    for (std::size_t c = 0; c < before.size(); ++c)
      if (before[c] > 0.0) out = std::max(out, 1.0 - after[c] / before[c]);
    return out;
  }
  static void sort_by_gain(std::vector<Move>& moves) {
    std::stable_sort(moves.begin(), moves.end(), [](const Move& a, const Move& b) { return a.gain > b.gain; });
  }
  /// Of the first one: the next best other effects.
  void remember_rivals(const std::vector<Move>& moves) {
    std::vector<Rival>& rivals = rivals_[place_of(moves.front().effect.spec)];
    rivals.clear();
    for (const Move& move : moves) {
      const EffectSpec& spec = move.effect.spec;
      const bool known =
          spec.effect == moves.front().effect.spec.effect ||
          std::any_of(rivals.begin(), rivals.end(), [&](const Rival& r) { return r.effect == spec.effect; });
      if (!known && rivals.size() < kRivalsFitted)
        rivals.push_back({spec.effect, spec.place, 0.0, spec.parameters, move.effect.own, {}});
    }
  }
  static bool clashes(const std::vector<EffectSpec>& set, const EffectSpec& with) {
    return std::any_of(set.begin(), set.end(), [&](const EffectSpec& member) {
      return member.place == with.place &&
             (member.effect == with.effect || overlap(effect_info(member.effect), effect_info(with.effect)));
    });
  }

  /// The set with these, fitted; kept if it has more evidence, the validate recordings do not speak against it, and
  /// each of them lies within its range.
  bool put_in(const std::vector<Move>& moves) { return put_in(moves, standing_); }
  /// The same, its fit begun at the numbers of `from`, the standing set.
  bool put_in(const std::vector<Move>& moves, const Hypothesis& from) {
    SetChange change;
    for (const Move& move : moves) change.in.push_back(move.effect.spec), change.own.push_back(move.effect.own);
    std::optional<Hypothesis> next = sets_.changed(from, change, kSetIterations);
    if (!next) return false;
    std::vector<Move> sound;
    for (const Move& move : moves) {
      const EffectSpec& spec = move.effect.spec;
      const bool takes = !effect_info(spec.effect).shares || sets_.is_determined(*next, spec);
      if (takes && sets_.ends_within(*next, spec))
        sound.push_back(move);
      else
        refused_.insert(place_of(move.effect.spec));
    }
    if (sound.size() < moves.size()) return !sound.empty() && put_in(sound, from);
    if (!(sets_.log_odds(*next, standing_) > kWorthPutting)) return false;
    if (sets_.heldout_difference(*next, standing_).speaks_against()) return false;
    grow_to(std::move(*next));
    return true;
  }
  void grow_to(Hypothesis next) {
    standing_ = std::move(next);
    changed_ = true;
  }

  void record(const std::vector<Move>& moves) {
    std::vector<Candidate> round;
    for (const Move& move : moves) {
      Candidate c;
      c.effect = move.effect.spec.effect, c.place = move.effect.spec.place;
      c.train_gain = move.gain;
      c.parameters = move.effect.parameters;
      round.push_back(std::move(c));
    }
    if (!round.empty()) rounds_.push_back(std::move(round));
  }

  // ---- what may stay ------------------------------------------------------------------------------------------------

  /// [joint]: energy above the noise on the train and validate recordings, in the weights of `by`.
  std::vector<double> excess(const Hypothesis& of, const Hypothesis& by) const {
    std::vector<int> on = sets_.train();
    on.insert(on.end(), sets_.validate().begin(), sets_.validate().end());
    Problem problem = problem_of(of.model, sets_.context(), by.model.weights);
    const Eigen::VectorXd r = problem.residual(of.model.fit.point, on);
    const std::vector<double> noise = noise_over_weight(experiment_, by.model.weights);
    std::vector<double> out(experiment_.joint_names.size(), 0.0);
    for (const ResidualBlock& b : problem.layout(on)) {
      const std::size_t c = b.channel;
      const double floor = noise[c] > 0.0 ? std::pow(noise[c], 2) : 0.0;
      out[experiment_.channels[c].joint] +=
          r.segment(b.first, b.count).squaredNorm() - floor * static_cast<double>(b.count);
    }
    return out;
  }

  /// Where an effect stands; nothing: on the whole arm.
  std::optional<std::size_t> joint_of(const EffectSpec& spec) const {
    if (effect_info(spec.effect).where == Where::arm) return std::nullopt;
    const auto& names = experiment_.joint_names;
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), spec.place) - names.begin());
  }

  /// Takes out what was added at joints where all of it together explains too little (on the arm: at every joint), and
  /// took no other member's place.
  void hold_to_share(const Hypothesis& before) {
    const std::vector<double> had = excess(before, before), has = excess(standing_, before);
    std::vector<double> removed;
    for (std::size_t j = 0; j < had.size(); ++j) removed.push_back(had[j] > 0.0 ? 1.0 - has[j] / had[j] : 0.0);
    const double most = *std::max_element(removed.begin(), removed.end());
    SetChange change;
    for (const EffectSpec& spec : standing_.effects) {
      const std::optional<std::size_t> joint = joint_of(spec);
      if (in_place_of_others_.count(place_of(spec)) > 0) continue;
      if (!holds(before, spec) && (joint ? removed[*joint] : most) < kShareOfExcess)
        change.out.push_back(place_of(spec));
    }
    if (change.out.empty()) return;
    if (auto next = sets_.changed(standing_, change, kSetIterations)) standing_ = std::move(*next);
  }

  /// Takes out, one after the other, what the validate recordings speak against, what explains nothing to speak of and
  /// is not confirmed by them, and what is as likely absent and so little determined that nobody could say how large it
  /// is.
  void take_out_idle(const Hypothesis& before, double begun) {
    std::set<NamedPlace> needed;  // beside those that stand now
    const auto next = [&] {
      return std::find_if(standing_.effects.rbegin(), standing_.effects.rend(),
                          [&](const EffectSpec& spec) { return needed.count(place_of(spec)) == 0; });
    };
    for (auto at = next(); at != standing_.effects.rend(); at = next()) {
      progress(begun + 0.1 * static_cast<double>(needed.size()) / static_cast<double>(standing_.effects.size()));
      const EffectSpec spec = *at;
      std::optional<Hypothesis> without = sets_.changed(standing_, {{}, {}, {place_of(spec)}, {}, {}}, kSetIterations);
      const bool asked = !without || is_asked_for(spec, *without);
      if (asked && ((options_.judged && holds(before, spec)) || !without || is_confirmed(spec, *without))) {
        needed.insert(place_of(spec));
        continue;
      }
      standing_ = std::move(*without);
      // What stands elsewhere is as needed as before.
      const bool whole = !joint_of(spec);
      std::erase_if(needed, [&](const NamedPlace& one) { return whole || one.second == spec.place; });
      notes_.push_back(
          fmt::format("{} at {} was put in and taken out again: too little asks for it, or the validate "
                      "recordings speak against it",
                      spec.effect, spec.place));
    }
  }
  bool is_asked_for(const EffectSpec& spec, const Hypothesis& without) const {
    const double lost = sets_.log_odds(standing_, without);
    return lost > 0.0 && (lost >= kIdleWindow || sets_.is_determined(standing_, spec));
  }
  bool is_confirmed(const EffectSpec& spec, const Hypothesis& without) const {
    const HeldoutDifference predicts = sets_.heldout_difference(standing_, without);
    if (predicts.speaks_against()) return false;
    return predicts.speaks_for() || share_at_its_place(standing_, without, spec) > kLeastShareOfRest;
  }
  /// Share of what stands above the noise where a member acts that one set leaves less than another.
  double share_at_its_place(const Hypothesis& with, const Hypothesis& without, const EffectSpec& spec) const {
    const std::vector<double> one = excess(with, with), other = excess(without, with);
    const std::optional<std::size_t> joint = joint_of(spec);
    double a = 0.0, b = 0.0;
    for (std::size_t j = 0; j < one.size(); ++j) {
      if (!joint || *joint == j) a += std::max(0.0, one[j]), b += std::max(0.0, other[j]);
    }
    return b > 0.0 ? 1.0 - a / b : 0.0;
  }

  double needed_step() const {
    const CurrentModel& now = standing_.model;
    return choose_step(now.model, experiment_, sets_.context().simulator, now.space.expand(now.fit.point)).step;
  }
  void set_step(double step) {
    sets_.set_step(step);
    evaluate_at(standing_.model, std::vector<double>(standing_.model.fit.point), sets_.context());
  }

  // ---- what is claimed ----------------------------------------------------------------------------------------------

  /// What may stand in a member's place.
  struct Contestant {
    EffectSpec spec;
    std::vector<double> own;
    Hypothesis set;
  };
  /// The set without one member, and with what may stand in its place.
  struct Around {
    std::optional<Hypothesis> without;
    std::vector<Contestant> rivals;
  };

  /// [member]: what each is held against; a rival that turns out to be the better one stands instead first.
  std::vector<Around> surroundings() {
    std::vector<Around> out;
    bool exchanged = false;
    const std::vector<EffectSpec> members = standing_.effects;
    for (const EffectSpec& member : members) {
      progress(0.7 + 0.15 * static_cast<double>(out.size()) / static_cast<double>(members.size()));
      out.push_back(around(index_of(member)));
      exchanged = exchange(member, out.back()) || exchanged;
    }
    if (!exchanged) return out;
    out.clear();
    for (std::size_t k = 0; k < standing_.effects.size(); ++k) {
      progress(0.85 + 0.15 * static_cast<double>(k) / static_cast<double>(standing_.effects.size()));
      out.push_back(around(k));
    }
    return out;
  }
  std::size_t index_of(const EffectSpec& member) const {
    const auto at = std::find_if(standing_.effects.begin(), standing_.effects.end(),
                                 [&](const EffectSpec& spec) { return place_of(spec) == place_of(member); });
    return static_cast<std::size_t>(at - standing_.effects.begin());
  }
  Around around(std::size_t k) {
    const EffectSpec member = standing_.effects[k];
    Around out;
    out.without = sets_.changed(standing_, {{}, {}, {place_of(member)}, {}, {}}, kSetIterations);
    if (!out.without) return out;
    if (rivals_.count(place_of(member)) == 0) look_for_rivals(member, *out.without);
    for (const Rival& rival : rivals_[place_of(member)]) {
      const EffectSpec spec{rival.effect, rival.place, rival.fixed, rival.recordings, rival.effect};
      const bool stands = out.without->model.model.find_effect_at(spec.effect, spec.place) >= 0;
      if (stands || clashes(out.without->effects, spec)) continue;
      auto set = sets_.changed(*out.without, {{spec}, {rival.own}, {}, {}, {}}, kSetIterations);
      if (set && sets_.ends_within(*set, spec)) out.rivals.push_back({spec, rival.own, std::move(*set)});
    }
    return out;
  }
  /// Of what was put in without a look at others: the best of its place beside all else.
  void look_for_rivals(const EffectSpec& member, const Hypothesis& without) {
    ScreenOptions how{[&](const std::string& place) { return place == member.place; }};
    how.skipped = [&](const EffectSpec& spec) {
      return spec.effect == member.effect || clashes(without.effects, spec) ||
             (options_.skipped && options_.skipped(spec));
    };
    std::vector<Move> moves{{{member, {}, {}, 0.0, {}, 0, 0.0, {}}, HUGE_VAL}};
    for (ScreenedEffect& s : screen_effects(without.model, sets_.context(), how)) {
      if (s.spec.recordings.empty()) moves.push_back({std::move(s), -s.sum_of_squares});
    }
    sort_by_gain(moves);
    remember_rivals(moves);
  }
  /// Puts the rival of most evidence over the standing set in a member's place; whether there is one.
  bool exchange(const EffectSpec& member, Around& around) {
    double most = kNotToldApart;
    Contestant* best = nullptr;
    for (Contestant& rival : around.rivals) {
      const double odds = sets_.log_odds(rival.set, standing_);
      if (odds > most && !sets_.heldout_difference(rival.set, standing_).speaks_against()) most = odds, best = &rival;
    }
    if (best == nullptr) return false;
    const std::vector<double> own = own_point(standing_.model, member);
    std::vector<Rival> rivals = rivals_[place_of(member)];
    for (Rival& r : rivals)
      if (r.effect == best->spec.effect) r = {member.effect, member.place, 0.0, member.parameters, own, {}};
    rivals_[place_of(best->spec)] = std::move(rivals);
    standing_ = std::move(best->set);
    sets_.fit(standing_.model, kRefitIterations);
    return true;
  }

  std::vector<Finding> claimed() {
    std::vector<Finding> out;
    const std::vector<Around> around = surroundings();
    for (std::size_t k = 0; k < standing_.effects.size(); ++k) {
      Finding finding = judged(k, around[k]);
      const std::string doubt = doubt_about(finding, standing_.effects[k]);
      if (doubt.empty())
        out.push_back(std::move(finding));
      else
        notes_.push_back(
            fmt::format("{} at {} stays in the model, but is not claimed: {}", finding.effect, finding.place, doubt));
    }
    return out;
  }
  /// Why a member is no finding; empty: it is one.
  std::string doubt_about(const Finding& finding, const EffectSpec& spec) const {
    if (!(finding.heldout_gain > 0.0))
      return "the recordings that were fitted ask for it, and the validate ones do not confirm it";
    if (!sets_.is_determined(standing_, spec)) return "the recordings do not tell how strong it is from none at all";
    if (class_probability(finding) >= kClaimed) return "";
    return fmt::format("that it is that or one of its class has a probability of {:.2f}", class_probability(finding));
  }

  Finding judged(std::size_t k, const Around& around) const {
    const EffectSpec spec = standing_.effects[k];
    Finding out;
    out.effect = spec.effect, out.place = spec.place, out.recordings = spec.recordings, out.fixed = spec.parameters;
    out.members = {spec.effect};
    if (!around.without) return out;  // nothing to compare it with: not claimed
    std::vector<const Hypothesis*> sets{&standing_, &*around.without};
    for (const Contestant& rival : around.rivals) sets.push_back(&rival.set);
    weigh(out, sets, around.rivals);
    const HeldoutDifference predicts = sets_.heldout_difference(standing_, *around.without);
    out.heldout_gain = predicts.gain, out.heldout_error = predicts.error, out.heldout_share = predicts.share;
    describe_evidence(out, around.without->model, standing_.model, sets_.context());
    return out;
  }

  /// Shares of exp(log evidence) over block resamples, one linear refit of each set a resample.
  void weigh(Finding& out, const std::vector<const Hypothesis*>& sets, const std::vector<Contestant>& rivals) const {
    std::vector<Linearised> near;
    std::vector<double> whole, prior;
    for (const Hypothesis* set : sets) {
      FittedRows r = sets_.rows(set->model, standing_.model.weights);
      const Colour colour = sets_.colour(set->model, r.residual, r.blocks);
      double correlation = 1.0;
      for (std::size_t c = 0; c < experiment_.channels.size(); ++c)
        correlation = std::max(correlation, colour.correlation_samples(static_cast<int>(c)));
      colour.whiten(r.residual, r.blocks);
      for (LinearColumn& c : r.columns) colour.whiten(c.train, r.blocks);
      const std::vector<int> blocks = time_blocks(r.blocks, correlation);
      near.emplace_back(std::move(r.residual), Eigen::VectorXd(), std::move(r.columns), std::vector<Part>{}, blocks);
      prior.push_back(sets_.log_prior(set->effects));
      whole.push_back(near.back().evidence({}) + prior.back());
    }
    std::vector<double> shares(sets.size(), 0.0);
    int wins = 0;
    for (const std::vector<double>& draw : block_draws(near.front().blocks(), kSetDraws, options_.seed)) {
      std::vector<double> logs;
      for (std::size_t s = 0; s < near.size(); ++s) logs.push_back(near[s].evidence({}, draw) + prior[s]);
      const double most = *std::max_element(logs.begin(), logs.end());
      wins += logs.front() == most;
      double total = 0.0;
      for (double& x : logs) total += x = std::exp(std::max(x - most, -700.0));
      for (std::size_t s = 0; s < logs.size(); ++s) shares[s] += logs[s] / total / kSetDraws;
    }
    out.probability = shares[0];
    out.outside = shares[1];
    out.stability = static_cast<double>(wins) / kSetDraws;
    const int numbers = static_cast<int>(own_axes(standing_.model, {out.effect, out.place, {}, {}, ""}).size());
    out.p_value = chance(std::max(0.0, whole[0] - whole[1]), std::max(numbers, 1),
                         experiment_.parts * static_cast<int>(sets_.offered()));
    for (std::size_t r = 0; r < rivals.size(); ++r) {
      const Contestant& rival = rivals[r];
      out.rivals.push_back({rival.spec.effect, rival.spec.place, shares[r + 2], rival.spec.parameters, rival.own, {}});
      const bool here = rival.spec.place == out.place;
      if (here && whole[0] - whole[r + 2] < kNotToldApart) out.members.push_back(rival.spec.effect);
    }
    std::stable_sort(out.rivals.begin(), out.rivals.end(),
                     [](const Rival& a, const Rival& b) { return a.probability > b.probability; });
  }

  const Experiment& experiment_;
  const Experiment looked_at_in_;  ///< as much of it as first looks need
  SetSearchOptions options_;
  Hypotheses sets_;
  Hypothesis standing_;
  bool changed_ = false;                                ///< since the search began
  std::map<std::string, std::vector<Move>> looked_at_;  ///< [place]: what the last look gave anything for
  std::set<std::set<NamedPlace>> tried_together_;
  std::set<NamedPlace> refused_;                                  ///< put in without success
  std::set<NamedPlace> in_place_of_others_;                       ///< put in for members that went
  std::set<std::pair<NamedPlace, std::string>> refused_numbers_;  ///< freed without success
  std::set<NamedPlace> hopeless_;                                 ///< promised too little at the last look
  std::map<NamedPlace, std::vector<Rival>> rivals_;
  std::vector<std::vector<Candidate>> rounds_;
  std::vector<std::string> notes_;
};

}  // namespace

std::optional<SetSearchResult> search_sets(const CurrentModel& plain, const CurrentModel& current,
                                           const std::vector<Finding>& findings, const FitContext& context,
                                           const SetSearchOptions& options) {
  return SetSearch(plain, current, findings, context, options).run();
}

bool leaves_a_rest(const CurrentModel& current, const FitContext& context) {
  std::vector<int> unseen = context.experiment.with_role(Role::validate);
  if (unseen.empty()) unseen = context.experiment.with_role(Role::train);
  Problem problem = problem_of(current, context);
  const Eigen::VectorXd r = problem.residual(current.fit.point, unseen);
  const std::vector<double> noise = noise_over_weight(context.experiment, current.weights);
  return !excess_over_noise(r, problem.layout(unseen), noise).empty();
}

}  // namespace lacuna
