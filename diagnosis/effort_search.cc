#include "diagnosis/effort_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "diagnosis/baseline.h"
#include "diagnosis/evidence.h"
#include "diagnosis/free_number.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/kin.h"
#include "diagnosis/prior.h"
#include "diagnosis/simpler_name.h"
#include "diagnosis/surroundings.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr int kMostRounds = 40;
constexpr double kMustBring = 10.0;  ///< log evidence, of a change that was fitted
constexpr double kSettled = 100.0;   ///< of a round, under which the colour of what is left is taken for known
constexpr int kFitIterations = 8;    ///< of a set on its way; to the bottom at the end
constexpr double kWindow = 8.0;  ///< log evidence behind the best, beyond which a rival is no rival (Occam's window)
constexpr int kBlockDraws = 60;  ///< of block resamples
constexpr double kLeastClaim = 0.5;  ///< probability of a class under which nothing is claimed

class EffortSearch {
 public:
  EffortSearch(const CurrentModel& plain, const FitContext& context, const EffortSearchOptions& options)
      : experiment_(context.experiment),
        options_(options),
        sets_(plain, context,
              knows_a_mass(plain.model, plain.space) ? scales_of(plain, experiment_) : std::vector<EffectSpec>()),
        train_(sets_.train()),
        validate_(sets_.validate()),
        standing_(sets_.none(kFitIterations)) {}

  EffortSearchResult run() {
    start();
    free_bodies();
    for (int round = 0; round < kMostRounds; ++round) {
      if (options_.progress) options_.progress(0.9 * round / kMostRounds);
      if (const auto* stop = sets_.context().control.stop; stop != nullptr && *stop) throw Interrupted();
      if (!improve()) break;
    }
    sets_.fit(standing_.model, kRefitIterations);
    call_by_the_simplest_name();
    keep_what_predicts();
    call_by_the_simplest_name();  // what went may have held a number off its end
    EffortSearchResult out{standing_.model, {}, {}, notes_};
    claim(out);
    out.rounds = std::move(rounds_);
    return out;
  }

 private:
  /// The efforts' scales, which are known to a tenth only.
  static std::vector<EffectSpec> scales_of(const CurrentModel& plain, const Experiment& experiment) {
    std::vector<EffectSpec> out;
    for (const Channel& channel : experiment.channels) {
      if (channel.kind != ChannelKind::effort) continue;
      const std::string& joint = experiment.joint_names[channel.joint];
      if (plain.model.find_effect_at("effort_scale", joint) < 0)
        out.push_back({"effort_scale", joint, {}, {}, "effort_scale"});
    }
    return out;
  }

  /// What every machine's joint has, as the regression by base parameters takes it: together, since one hides another.
  void start() {
    const PlantModel& plain = sets_.plain().model;
    SetChange dry;
    for (const char* effect : {"coulomb_friction", "viscous_friction", "torque_offset", "armature"}) {
      for (EffectSpec& spec : offered_beside(sets_, standing_, effect_info(effect))) {
        const PlantModel model = plain.with_effects({spec});
        const std::vector<Axis> axes = effect_axes(model, experiment_, model.effects().back(), spec);
        dry.own.push_back(starting_points(model, experiment_, axes).front());
        dry.in.push_back(std::move(spec));
      }
    }
    std::optional<Hypothesis> next = sets_.changed(standing_, dry, kFitIterations);
    if (next && sets_.log_odds(*next, standing_) > 0.0) standing_ = std::move(*next);
  }

  /// All links' mass properties together, as the regression has them: the weight of one is carried by all before it, so
  /// that one alone says little.
  void free_bodies() {
    SetChange bodies;
    const PlantModel& model = standing_.model.model;
    for (EffectSpec& spec : offered_beside(sets_, standing_, effect_info("rigid_body"))) {
      const PlantModel with = model.with_effects({spec});
      const std::vector<Axis> axes = effect_axes(with, experiment_, with.effects().back(), spec);
      bodies.own.emplace_back(axes.size(), 0.0);
      bodies.in.push_back(std::move(spec));
    }
    if (bodies.in.empty()) return;
    std::optional<Hypothesis> next = sets_.changed(standing_, bodies, kFitIterations);
    if (next && brought_by(*next) > kMustBring) standing_ = std::move(*next);
  }

  // ---- moves --------------------------------------------------------------------------------------------------------

  /// A change, and the log evidence that it promises over the set that stands. What is put in is worth a fit if it
  /// promises anything, since the colour is of a rest that it would take away, which makes little of it. What has more
  /// numbers than the one whose place it takes finds that rest gone, and must promise what it must bring.
  struct Move {
    double gain = 0.0;
    int in = -1, out = -1;  ///< parts
    std::string where;
  };

  /// One round; whether the set changed. The best of every place together, else one by one.
  bool improve() {
    const Linearised near = linearised(surroundings_of(sets_, standing_, true), false);
    const Linearised::Set now = near.present();
    const double standing = near.evidence(now);
    std::vector<Move> moves = promising(near, now, standing);
    record(near, moves);
    if (moves.size() > 1) {
      if (try_moves(near, moves)) return true;
      moves = promising(near, now, standing);  // without those that were refused for numbers of their own
    }
    for (const Move& move : moves) {
      if (try_moves(near, {move})) return true;
      refused_.insert(name_of(near, move));
    }
    return false;
  }

  std::string name_of(const Linearised& near, const Move& move) const {
    const auto name = [&](int k) {
      if (k < 0) return std::string("-");
      const Part& part = near.parts()[k];
      std::string out = part.spec.effect + "@" + part.spec.place;
      for (const auto& [key, value] : part.spec.parameters) out += "," + key;
      return out;
    };
    return name(move.in) + ">" + name(move.out) + fmt::format("#{}", standing_.effects.size());
  }

  static std::size_t numbers_of(const Linearised& near, int part) { return near.parts()[part].columns.size(); }

  /// At every place the best of what can be put in, taken out or exchanged there; most evidence first.
  std::vector<Move> promising(const Linearised& near, const Linearised::Set& now, double standing) const {
    std::map<std::string, Move> best;
    const auto offer = [&](Move move, const Linearised::Set& set) {
      move.gain = near.evidence(set) - standing;
      if (move.in >= 0 && !clashing(near, set, move.in).empty()) return;
      const bool richer = move.in >= 0 && move.out >= 0 && numbers_of(near, move.in) > numbers_of(near, move.out);
      if (!(move.gain > (richer ? kMustBring : 0.0)) || refused_.count(name_of(near, move)) > 0) return;
      Move& there = best[move.where];
      if (move.gain > there.gain) there = move;
    };
    const auto& parts = near.parts();
    for (int k = 0; k < std::ssize(parts); ++k) {
      const Part& part = parts[k];
      const Linearised::Set with = near.toggled(now, k);
      offer({0.0, part.present ? -1 : k, part.present ? k : -1, part.spec.place}, with);
      if (!part.present) continue;
      for (int other = 0; other < std::ssize(parts); ++other) {  // an exchange at the same place
        const Part& rival = parts[other];
        if (rival.present || rival.needs >= 0 || rival.spec.place != part.spec.place) continue;
        if (place_of(rival.spec) == place_of(part.spec)) continue;
        offer({0.0, other, k, part.spec.place}, near.toggled(with, other));
      }
    }
    std::vector<Move> out;
    for (const auto& [where, move] : best) out.push_back(move);
    std::stable_sort(out.begin(), out.end(), [](const Move& a, const Move& b) { return a.gain > b.gain; });
    return out;
  }

  /// Members of the set at that place that are a special case of the part, or both are of a third one: what both
  /// contain could be told of either.
  std::vector<int> clashing(const Linearised& near, const Linearised::Set& set, int which) const {
    const auto& parts = near.parts();
    const Part& part = parts[which];
    std::vector<int> out;
    for (int k = 0; k < std::ssize(parts); ++k) {
      const Part& other = parts[k];
      if (!set[k] || k == which || other.needs >= 0 || part.needs >= 0) continue;
      if (other.spec.place == part.spec.place && overlap(effect_info(other.spec.effect), effect_info(part.spec.effect)))
        out.push_back(k);
    }
    return out;
  }
  /// The set with a part in place of a member and of all that it clashes with: unequal friction either way is friction
  /// and an offset at once.
  Linearised::Set instead(const Linearised& near, const Linearised::Set& now, int member, int part) const {
    Linearised::Set out = near.toggled(now, member);
    for (const int other : clashing(near, out, part)) out = near.toggled(out, other);
    return near.toggled(out, part);
  }

  SetChange change_of(const Linearised& near, const std::vector<Move>& moves) const {
    SetChange out;
    for (const Move& move : moves) {
      if (move.out >= 0) out.out.push_back(place_of(near.parts()[move.out].spec));
      if (move.in < 0) continue;
      const Part& part = near.parts()[move.in];
      if (part.needs < 0) {
        out.in.push_back(part.spec);
        out.own.push_back(part.start.front());
        continue;
      }
      const EffectSpec& old = standing_.effects[part.needs];
      out.shaped.emplace_back(place_of(old), part.spec);
      out.shapes.push_back(own_point_with(standing_.model, experiment_, old, part.spec, part.start[0][0]));
    }
    return out;
  }

  /// Fits the set with all these changes; keeps it if it has more evidence, both weighed alike.
  bool try_moves(const Linearised& near, const std::vector<Move>& moves) {
    std::optional<Hypothesis> next = sets_.changed(standing_, change_of(near, moves), kFitIterations);
    if (!next) return false;
    bool sound = true;
    for (const Move& move : moves) {
      if (move.in < 0 || sets_.ends_within(*next, near.parts()[move.in].spec)) continue;
      refused_.insert(name_of(near, move));
      unsound_.insert(place_of(near.parts()[move.in].spec));
      sound = false;
    }
    if (!sound) {
      std::vector<Move> others = moves;
      std::erase_if(others, [&](const Move& m) { return refused_.count(name_of(near, m)) > 0; });
      return !others.empty() && others.size() < moves.size() && try_moves(near, others);
    }
    const double odds = brought_by(*next);
    const bool more = std::any_of(moves.begin(), moves.end(), [](const Move& m) { return m.in >= 0; });
    if (!(odds > (more ? kMustBring : 0.0))) return false;
    standing_ = std::move(*next);
    if (odds < kSettled && !sets_.settled()) sets_.settle(standing_);
    return true;
  }

  /// What train and validate recordings together say for a fitted set over the one that stands.
  double brought_by(const Hypothesis& next) const {
    return sets_.log_odds(next, standing_) + heldout_gain(next, standing_);
  }
  /// Log-likelihood that one fitted set gains over another on the validate recordings, which neither was fitted to.
  /// Less than nothing counts for a refusal: what is put in must predict them.
  double heldout_gain(const Hypothesis& one, const Hypothesis& other) const {
    if (validate_.empty()) return 0.0;
    const double gain = sets_.heldout_difference(one, other).gain;
    return gain < 0.0 && one.effects.size() >= other.effects.size() ? -HUGE_VAL : gain;
  }
  void record(const Linearised& near, const std::vector<Move>& moves) {
    std::vector<Candidate> round;
    for (const Move& move : moves) {
      if (move.in < 0) continue;
      const Part& part = near.parts()[move.in];
      Candidate c;
      c.effect = part.spec.effect, c.place = part.spec.place;
      c.train_gain = move.gain;
      c.parameters = static_cast<int>(part.columns.size());
      round.push_back(std::move(c));
    }
    if (!round.empty()) rounds_.push_back(std::move(round));
  }

  /// An effect whose numbers ended where it is a simpler one (a break-away effort no larger than the sliding one) is
  /// that one, or none; where the recordings insist on it, it stays, and is not claimed.
  void call_by_the_simplest_name() {
    std::set<NamedPlace> kept;
    for (std::size_t k = 0; k < standing_.effects.size();) {
      const EffectSpec spec = standing_.effects[k];
      if (kept.count(place_of(spec)) > 0 || sets_.ends_within(standing_, spec)) {
        ++k;
        continue;
      }
      std::optional<Hypothesis> best = without(spec);
      for (const EffectInfo& info : effect_table()) {
        std::optional<Hypothesis> simpler = in_place_of(sets_, standing_, spec, info);
        if (simpler && !sets_.ends_within(*simpler, {info.name, spec.place, {}, {}, {}})) simpler.reset();
        if (simpler && (!best || sets_.log_odds(*simpler, *best) > 0.0)) best = std::move(simpler);
      }
      kept.insert(place_of(spec));
      if (!best || sets_.log_odds(*best, standing_) < -kWindow) continue;
      standing_ = std::move(*best);
      k = 0;
    }
  }

  std::optional<Hypothesis> without(const EffectSpec& spec) const {
    SetChange change;
    change.out.push_back(place_of(spec));
    return sets_.changed(standing_, change, kRefitIterations);
  }

  // ---- what is claimed ----------------------------------------------------------------------------------------------

  /// Takes out what the validate recordings are better predicted without, and what is as likely without it and so
  /// little determined that nobody could say how large it is; each time by the fit without it.
  void keep_what_predicts() {
    std::set<NamedPlace> needed, negligible;
    const Hypothesis whole = standing_;  // what goes must be little in all
    for (;;) {
      const Linearised near = linearised(surroundings_of(sets_, standing_, false), false);
      const Linearised::Set now = near.present();
      int worst = -1;
      double least = HUGE_VAL;
      for (int k = 0; k < std::ssize(standing_.effects); ++k) {
        const EffectSpec& spec = standing_.effects[k];
        if (needed.count(place_of(spec)) > 0) continue;
        const Linearised::Set without = near.toggled(now, k);
        const double loss = near.evidence(now) - near.evidence(without);
        const double gain = validate_.empty() ? -HUGE_VAL : near.heldout(now) - near.heldout(without);
        const bool small = !validate_.empty() && says_little(left_of(near, now), left_of(near, without));
        const bool idle = small || (loss < kWindow && !sets_.is_determined(standing_, spec));
        if (small) negligible.insert(place_of(spec));
        if ((idle || gain <= 0.0) && std::min(gain, loss) < least) least = std::min(gain, loss), worst = k;
      }
      if (worst < 0) return;
      const EffectSpec gone = standing_.effects[worst];
      SetChange change;
      change.out.push_back(place_of(gone));
      std::optional<Hypothesis> next = sets_.changed(standing_, change, kFitIterations);
      const double lost = next ? sets_.log_odds(standing_, *next) : HUGE_VAL;
      const double predicts = next && !validate_.empty() ? sets_.heldout_difference(standing_, *next).gain : -HUGE_VAL;
      const bool little = next && negligible.count(place_of(gone)) > 0 && says_little(left_of(whole), left_of(*next));
      if (!next || (predicts > 0.0 && lost > kWindow && !little)) {
        needed.insert(place_of(gone));
        continue;
      }
      standing_ = std::move(*next);
      notes_.push_back(
          fmt::format("{} at {} was put in and taken out again: the recordings do not determine it, or it "
                      "explains nothing to speak of on the validate ones",
                      gone.effect, gone.place));
    }
  }

  /// Whether a set leaves hardly less than another at every joint: a link's mass tells at all joints that carry it.
  static bool says_little(const Eigen::ArrayXd& with, const Eigen::ArrayXd& without) {
    return (with >= (1.0 - kLeastOfEfforts) * without).all();
  }
  /// Energy of the validate recordings' efforts that a set leaves, each channel over its noise. [channel]
  Eigen::ArrayXd left_of(const Hypothesis& set) const {
    const CurrentModel& model = set.model;
    Problem problem = problem_of(model, sets_.context(), first_weights(model.model, experiment_));
    return energies(problem.residual(model.fit.point, validate_));
  }
  /// The same of what the linearised set leaves, whitened.
  Eigen::ArrayXd left_of(const Linearised& near, const Linearised::Set& set) const {
    return energies(near.heldout_rest(set));
  }
  Eigen::ArrayXd energies(const Eigen::VectorXd& rest) const {
    const CurrentModel& now = standing_.model;
    const Problem problem = problem_of(now, sets_.context());
    Eigen::ArrayXd out = Eigen::ArrayXd::Zero(experiment_.channels.size());
    if (rest.size() == 0) return out + HUGE_VAL;  // no such set can be
    for (const ResidualBlock& block : problem.layout(validate_))
      out(block.channel) += rest.segment(block.first, block.count).squaredNorm();
    return out;
  }

  void claim(EffortSearchResult& out) {
    out.notes = notes_;
    if (standing_.effects.empty()) return;
    Linearised near = beside_rivals();
    while (call_by_the_most_probable_name(near)) near = beside_rivals();
    out.model = standing_.model;
    const Linearised::Set now = near.present();
    const Eigen::Index second = std::max<Eigen::Index>(1, near.heldout_rest(now).size() / 40);
    for (int k = 0; k < std::ssize(standing_.effects); ++k) {
      if (options_.progress) options_.progress(0.9 + 0.1 * k / static_cast<double>(standing_.effects.size()));
      Finding finding = finding_of(near, now, k, second);
      if (!sets_.ends_within(standing_, standing_.effects[k])) {
        out.notes.push_back(
            fmt::format("{} at {} stays in the model, but is not claimed: a number of it ended at the "
                        "end of its range, where it is no law of a machine",
                        finding.effect, finding.place));
      } else if (class_probability(finding) >= kLeastClaim) {
        out.findings.push_back(std::move(finding));
      } else {
        out.notes.push_back(
            fmt::format("{} at {} stays in the model, but is not claimed: that it is that or one of its "
                        "class has a probability of {:.2f}",
                        finding.effect, finding.place, class_probability(finding)));
      }
    }
  }

  /// The set that stands and all that comes near it, block by block.
  Linearised beside_rivals() const {
    Surroundings s = surroundings_of(sets_, standing_, true);
    keep_near_rivals(s);
    return linearised(std::move(s), true);
  }

  /// What is claimed is the most probable one. The linear look may have promised too little for a rival to be fitted:
  /// if it is the most probable it is, and takes the member's place if it brings what the search asks for. It is no
  /// rival where it does worse; where it does as well at an end of its range it is one that cannot be claimed. Whether
  /// the set changed.
  bool call_by_the_most_probable_name(const Linearised& near) {
    const Linearised::Set now = near.present();
    for (int k = 0; k < std::ssize(standing_.effects); ++k) {
      const Contenders all = contenders(near, now, k);
      const std::vector<double> shares = near.bagged(all.sets, kBlockDraws, options_.seed);
      const int part = all.parts[std::max_element(shares.begin(), shares.end()) - shares.begin()];
      if (part < 0 || alike_.count(place_of(near.parts()[part].spec)) > 0) continue;
      if (took_its_place(near, k, part)) return true;
    }
    return false;
  }
  bool took_its_place(const Linearised& near, int member, int part) {
    const EffectSpec& rival = near.parts()[part].spec;
    SetChange change = change_of(near, {{0.0, part, member, rival.place}});
    for (const int other : clashing(near, near.toggled(near.present(), member), part))
      change.out.push_back(place_of(near.parts()[other].spec));
    std::optional<Hypothesis> next = sets_.changed(standing_, change, kRefitIterations);
    if (next && sets_.ends_within(*next, rival) && brought_by(*next) > kMustBring) {
      standing_ = std::move(*next);
      return true;
    }
    const bool worse = next && (sets_.log_odds(*next, standing_) < -kNotToldApart ||
                                sets_.heldout_difference(*next, standing_).speaks_against());
    (worse ? unsound_ : alike_).insert(place_of(rival));
    return false;
  }

  /// Of the absent parts, those that come within the window when they take another's place.
  void keep_near_rivals(Surroundings& s) const {
    const Linearised near = linearised(s, false);
    const Linearised::Set now = near.present();
    const double standing = near.evidence(now);
    std::map<NamedPlace, std::pair<double, std::size_t>> best;
    for (std::size_t k = 0; k < s.parts.size(); ++k) {
      const Part& part = s.parts[k];
      if (part.present || part.needs >= 0 || unsound_.count(place_of(part.spec)) > 0) continue;
      double most = -HUGE_VAL;
      for (int e = 0; e < std::ssize(standing_.effects); ++e)
        if (standing_.effects[e].place == part.spec.place)
          most = std::max(most, near.evidence(instead(near, now, e, static_cast<int>(k))));
      auto& there = best.emplace(place_of(part.spec), std::make_pair(-HUGE_VAL, k)).first->second;
      if (most - standing > there.first) there = {most - standing, k};
    }
    std::vector<Part> kept;
    for (std::size_t k = 0; k < s.parts.size(); ++k) {
      const auto of = best.find(place_of(s.parts[k].spec));
      const bool near_enough = of != best.end() && of->second.second == k && of->second.first > -kWindow;
      if (s.parts[k].present || near_enough) kept.push_back(std::move(s.parts[k]));
    }
    s.parts = std::move(kept);
  }

  /// The set that stands, the one without a member, and those with a rival in its place.
  struct Contenders {
    std::vector<Linearised::Set> sets;
    std::vector<int> parts;  ///< of each set, the one that takes the place; -1: none
  };
  Contenders contenders(const Linearised& near, const Linearised::Set& now, int k) const {
    Contenders out{{now, near.toggled(now, k)}, {-1, -1}};
    for (int r = 0; r < std::ssize(near.parts()); ++r) {
      const Part& part = near.parts()[r];
      if (part.present || part.spec.place != standing_.effects[k].place || unsound_.count(place_of(part.spec)) > 0)
        continue;
      out.sets.push_back(instead(near, now, k, r));
      out.parts.push_back(r);
    }
    return out;
  }

  Finding finding_of(const Linearised& near, const Linearised::Set& now, int k, Eigen::Index second) const {
    const EffectSpec& spec = standing_.effects[k];
    const auto [sets, rivals] = contenders(near, now, k);
    const std::vector<double> shares = near.bagged(sets, kBlockDraws, options_.seed);
    Finding out;
    out.effect = spec.effect, out.place = spec.place, out.recordings = spec.recordings, out.fixed = spec.parameters;
    out.probability = shares[0];
    out.outside = shares[1];
    out.members = {spec.effect};
    const double standing = near.evidence(now);
    for (std::size_t s = 2; s < sets.size(); ++s) {
      const Part& part = near.parts()[rivals[s]];
      out.rivals.push_back(
          {part.spec.effect, part.spec.place, shares[s], part.spec.parameters, part.start.front(), {}});
      if (standing - near.evidence(sets[s]) < kNotToldApart) out.members.push_back(part.spec.effect);
    }
    std::stable_sort(out.rivals.begin(), out.rivals.end(),
                     [](const Rival& a, const Rival& b) { return a.probability > b.probability; });
    if (out.rivals.size() > 5) out.rivals.resize(5);
    out.heldout_gain = near.heldout(now) - near.heldout(sets[1]);
    const std::vector<double> with = near.heldout_blocks(now, second), without = near.heldout_blocks(sets[1], second);
    double sum = 0.0, squares = 0.0;
    const double n = static_cast<double>(with.size());
    for (std::size_t b = 0; b < with.size(); ++b)
      sum += with[b] - without[b], squares += std::pow(with[b] - without[b], 2);
    out.heldout_error = n > 1 ? std::sqrt(std::max(0.0, squares - sum * sum / n)) : 0.0;
    out.heldout_share = 1.0 - near.heldout(now) / std::min(near.heldout(sets[1]), -1e-300);
    const double gain = 0.5 * (near.train_energy(sets[1]) - near.train_energy(now));
    const int numbers = static_cast<int>(near.parts()[k].columns.size());
    out.p_value = chance(gain, std::max(numbers, 1), static_cast<int>(std::max<std::size_t>(sets_.offered(), 1)));
    out.stability = near.leads(sets, kBlockDraws, options_.seed);
    return out;
  }

  const Experiment& experiment_;
  EffortSearchOptions options_;
  Hypotheses sets_;
  const std::vector<int>&train_, &validate_;
  Hypothesis standing_;
  std::set<std::string> refused_;
  std::set<NamedPlace> unsound_;  ///< what ended at the end of its range, or far behind, when it was fitted
  std::set<NamedPlace> alike_;    ///< rivals that were fitted in a member's place and do no worse
  std::vector<std::vector<Candidate>> rounds_;
  std::vector<std::string> notes_;
};

}  // namespace

EffortSearchResult search_efforts(const CurrentModel& plain, const FitContext& context,
                                  const EffortSearchOptions& options) {
  return EffortSearch(plain, context, options).run();
}

}  // namespace lacuna
