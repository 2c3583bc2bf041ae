#include "diff/diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "diagnosis/baseline.h"
#include "diagnosis/evidence.h"
#include "diagnosis/prior.h"
#include "scenarios/error.h"
#include "diff/claims.h"

namespace lacuna {
namespace {

constexpr int kRounds = 3;      ///< linearised anew about the best set's own fit
constexpr int kLoadStarts = 3;  ///< places from which a load in one set is fitted
constexpr int kLoadIterations = 8;
constexpr double kOfRestToSay = 0.1;  ///< share of the held-out rest that makes two sets differ beyond the changes
constexpr double kHoldsWithin = 0.1;  ///< of a number's size: as far as the linearised motions hold
constexpr double kLeastHold = 1e-3;   ///< of its prior
constexpr double kMoreRest = 1.3;     ///< times the other set's, both over their noise
constexpr double kErrors95 = 1.96;    ///< standard errors
constexpr const char* kLoadEffect = "payload";

/// A link's mass, as a plain number or as a body that differs from the URDF's.
bool is_of_masses(const Changeable& c) { return c.key == "mass" || c.effect == "rigid_body"; }

double moving_mass(const Side& side) {
  double out = 0.0;
  for (const Inertial& body : side.model.model.inertials(side.model.space.expand(side.model.fit.point)))
    out += body.mass;
  return out;
}

double joint_energy(const Structure& s, const JointFit& at) {
  return rows_at(s.a, at.a, Role::train).squaredNorm() + rows_at(s.b, at.b, Role::train).squaredNorm();
}

/// A load that only one set carries hides in its links' masses, where these are free, and no diagnosis of that set
/// alone can see it: it is offered beside the masses, in the set whose arm came out heavier. The fit with it and all
/// else common; nothing where it is offered already or has no place here.
std::optional<Hypothesised> offer_load(Structure& s, const std::atomic<bool>* stop) {
  const EffectInfo& load = effect_table()[find_effect(kLoadEffect)];
  if (std::ranges::none_of(s.changeables, is_of_masses)) return std::nullopt;
  const bool in_b = moving_mass(s.b) >= moving_mass(s.a);
  const Side& light = in_b ? s.a : s.b;
  Side& heavy = in_b ? s.b : s.a;
  const std::vector<EffectSpec> places = places_of(load, heavy.model, heavy.experiment);
  if (places.empty()) return std::nullopt;
  const std::size_t first = heavy.axes().size(), group = add_in_one(s, places.front(), in_b);
  const std::vector<Axis> axes(heavy.axes().begin() + static_cast<std::ptrdiff_t>(first), heavy.axes().end());
  std::vector<std::pair<double, JointFit>> starts;
  for (const std::vector<double>& own : starting_points(heavy.model.model, heavy.experiment, axes)) {
    JointFit start{light.model.fit.point, light.model.fit.point};
    std::vector<double>& loaded = in_b ? start.b : start.a;
    for (std::size_t k = 0; k < own.size(); ++k) loaded[first + k] = std::clamp(own[k], axes[k].lower, axes[k].upper);
    const double energy = joint_energy(s, start);
    if (std::isfinite(energy)) starts.emplace_back(energy, std::move(start));
  }
  std::stable_sort(starts.begin(), starts.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  ChangedSet changed(s.changeables.size(), 0);
  changed[group] = 1;
  std::optional<Hypothesised> best;
  for (std::size_t k = 0; k < std::min<std::size_t>(kLoadStarts, starts.size()); ++k) {
    JointFit fit = fit_jointly(s.a, s.b, groups_of(s.changeables), changed, starts[k].second, stop, kLoadIterations);
    if (!best || fit.cost < best->fit.cost) best = Hypothesised{changed, std::move(fit)};
  }
  return best;
}

/// The search as it ended.
struct Searched {
  Hypothesised best;
  std::vector<LivingSet> living;
  std::vector<double> probability, of_class;      ///< [group]
  std::vector<std::vector<std::size_t>> members;  ///< [group]
};

/// The common numbers stay as near a fit as its linearisation holds.
CommonPrior held_near(const Structure& s, const JointFit& fit) {
  CommonPrior out{in_priors(s.a, fit.a), Eigen::VectorXd::Ones(fit.a.size())};
  for (std::size_t i = 0; i < fit.a.size(); ++i) {
    const Axis& axis = s.a.axes()[i];
    const bool logarithm = axis.coordinate == Coordinate::logarithm;  // whose own unit is its size
    const double size = logarithm ? 1.0 : coordinate_size(fit.a[i], axis.lower, axis.upper);
    out.deviation(i) = std::clamp(kHoldsWithin * size / axis.prior, kLeastHold, 1.0);
  }
  return out;
}

ChangedSets about(const Structure& s, const ChangeGroups& groups, const JointFit& fit) {
  return {information_at(s.a, fit.a), information_at(s.b, fit.b), groups, held_near(s, fit)};
}

/// Log evidence of a fitted set, by its own curvature.
double fitted_evidence(const Structure& s, const ChangeGroups& groups, const Hypothesised& at) {
  const Quadratic a = information_at(s.a, at.fit.a), b = information_at(s.b, at.fit.b);
  return ChangedSets(a, b, groups).evidence_of_fit(at.changed, at.fit.cost);
}

/// Linearised about the best set's fit, as often as another one is the best.
Searched search_from(const Structure& s, const ChangeGroups& groups, Hypothesised start, const RunControl& control) {
  const ChangedSet all(groups.size(), 1);
  Searched out;
  out.best = std::move(start);
  for (int round = 0; round < kRounds; ++round) {
    const ChangedSets sets = about(s, groups, out.best.fit);
    out.living = search_changes(sets, {all, out.best.changed});
    const ChangedSet chosen = out.living.front().changed;
    out.probability = change_probabilities(out.living);
    out.of_class = out.probability;
    out.members.assign(groups.size(), {});
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (chosen[g] == 0) continue;
      out.members[g] = change_class(sets, chosen, g);
      out.of_class[g] = class_probability(out.living, out.members[g]);
    }
    const bool stands = chosen == out.best.changed;
    out.best.changed = chosen;
    out.best.fit = fit_jointly(s.a, s.b, groups, chosen, out.best.fit, control.stop);
    if (stands) break;
  }
  return out;
}

/// A set with the load in place of all links whose masses changed.
struct Carried {
  Hypothesised set;
  std::vector<std::size_t> in_place_of;
};

/// Nothing where no mass changed.
std::optional<Carried> carried_instead(const Structure& s, const ChangeGroups& groups, const Hypothesised& best,
                                       const Hypothesised& loaded, const RunControl& control) {
  Carried out{best, {}};
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!is_of_masses(s.changeables[g]) && loaded.changed[g] == 0) continue;
    if (best.changed[g] != 0 && loaded.changed[g] == 0) out.in_place_of.push_back(g);
    out.set.changed[g] = loaded.changed[g];
    for (const std::size_t i : s.changeables[g].axes)
      out.set.fit.a[i] = loaded.fit.a[i], out.set.fit.b[i] = loaded.fit.b[i];
  }
  if (out.in_place_of.empty()) return std::nullopt;
  out.set.fit = fit_jointly(s.a, s.b, groups, out.set.changed, out.set.fit, control.stop);
  return out;
}

/// From each set's own fit, all changed. A link that weighs more in one set is the same to the recordings as a load
/// that it carries: called a load, where that says it as well.
Searched search(const Structure& s, const ChangeGroups& groups, const std::optional<Hypothesised>& loaded,
                const RunControl& control, const std::function<void(double)>& progress) {
  const ChangedSet all(groups.size(), 1);
  Hypothesised start{all, fit_jointly(s.a, s.b, groups, all, {s.a.model.fit.point, s.b.model.fit.point}, control.stop)};
  Searched out = search_from(s, groups, std::move(start), control);
  progress(0.5);
  if (!loaded) return out;
  const std::optional<Carried> carried = carried_instead(s, groups, out.best, *loaded, control);
  if (!carried) return out;
  const double odds = fitted_evidence(s, groups, carried->set) - fitted_evidence(s, groups, out.best);
  if (odds < -kNotToldApart) return out;
  out = search_from(s, groups, carried->set, control);
  if (odds > kNotToldApart) return out;
  for (std::size_t g = 0; g < groups.size(); ++g)  // the load, or the links that it stands for
    if (loaded->changed[g] != 0 && out.best.changed[g] != 0)
      for (const std::size_t link : carried->in_place_of)
        if (std::ranges::find(out.members[g], link) == out.members[g].end()) out.members[g].push_back(link);
  return out;
}

/// Values and errors of one coordinate on both sides, in the parameter's own unit.
class InUnits {
 public:
  InUnits(const Structure& s, const JointFit& fit, const ChangePosterior& posterior)
      : s_(s), fit_(fit), posterior_(posterior), a_(s.a.model.space.expand(fit.a)), b_(s.b.model.space.expand(fit.b)) {}

  Estimate of_a(std::size_t i) const { return estimate(s_.a, i, fit_.a, a_, posterior_.error_a(at(i))); }
  Estimate of_b(std::size_t i) const { return estimate(s_.b, i, fit_.b, b_, posterior_.error_b(at(i))); }
  Estimate difference(std::size_t i) const {
    Estimate out = of_b(i);
    const Estimate a = of_a(i);
    const double prior = axis(i).prior, slope_a = slope(s_.a, fit_.a, i), slope_b = slope(s_.b, fit_.b, i);
    const double variance = std::pow(slope_a * posterior_.error_a(at(i)), 2) +
                            std::pow(slope_b * posterior_.error_b(at(i)), 2) -
                            2.0 * slope_a * slope_b * posterior_.covariance_ab(at(i));
    const double error = prior * std::sqrt(std::max(0.0, variance));
    out.value -= a.value;
    out.lower95 = out.value - kErrors95 * error, out.upper95 = out.value + kErrors95 * error;
    out.at_bound = false, out.spans_range = false;
    return out;
  }

 private:
  static Eigen::Index at(std::size_t i) { return static_cast<Eigen::Index>(i); }
  const Axis& axis(std::size_t i) const { return s_.a.axes()[i]; }

  double slope(const Side& side, std::vector<double> point, std::size_t i) const {
    const std::size_t parameter = axis(i).parameter;
    const double x = point[i], h = 1e-5 * axis(i).prior;
    point[i] = x + h;
    const double above = side.model.space.expand(point)[parameter];
    point[i] = x - h;
    return (above - side.model.space.expand(point)[parameter]) / (2.0 * h);
  }

  Estimate estimate(const Side& side, std::size_t i, const std::vector<double>& point,
                    const std::vector<double>& values, double error) const {
    const Parameter& p = side.model.model.parameters()[axis(i).parameter];
    Estimate out{p.name, p.unit, values[axis(i).parameter]};
    const double sigma = kErrors95 * axis(i).prior * error;
    double low = axis(i).value(point[i] - sigma), high = axis(i).value(point[i] + sigma);
    if (!side.model.space.shared_masses().empty() && p.key == "mass") {
      const double half = std::fabs(slope(side, point, i)) * sigma;
      low = out.value - half, high = out.value + half;
    }
    if (axis(i).coordinate == Coordinate::inverse && point[i] - sigma <= 0.0)
      high = HUGE_VAL, low = axis(i).value(point[i] + sigma);
    out.lower95 = std::max(p.lower, std::min(low, high)), out.upper95 = std::min(p.upper, std::max(low, high));
    out.at_bound = point[i] <= axis(i).lower || point[i] >= axis(i).upper;
    out.spans_range = point[i] - sigma <= axis(i).lower && point[i] + sigma >= axis(i).upper;
    out.identifiable = !out.spans_range && (out.upper95 - out.lower95) < 2.0 * std::fabs(out.value);
    return out;
  }

  const Structure& s_;
  const JointFit& fit_;
  const ChangePosterior& posterior_;
  std::vector<double> a_, b_;
};

/// Where efforts are measured and no mass is known, masses and their differences carry the drives' calibration.
void carry_to_difference(const Side& side, ChangedNumber& n) {
  std::vector<Estimate> one{n.a}, other{n.b};
  carry_scale_error(side.model.model, side.model.space, side.experiment, one);
  carry_scale_error(side.model.model, side.model.space, side.experiment, other);
  const bool carried = other.front().upper95 != n.b.upper95 || one.front().upper95 != n.a.upper95;
  n.a = one.front(), n.b = other.front();
  if (!carried) return;
  Estimate unit = n.b;  // the share that the calibration is uncertain by, read off a value known exactly
  unit.value = unit.lower95 = unit.upper95 = 1.0;
  std::vector<Estimate> exact{unit};
  carry_scale_error(side.model.model, side.model.space, side.experiment, exact);
  const double half =
      std::hypot(n.difference.upper95 - n.difference.value, (exact.front().upper95 - 1.0) * n.difference.value);
  n.difference.lower95 = n.difference.value - half, n.difference.upper95 = n.difference.value + half;
}

/// Whether the group acts nowhere on a side: its strength is pinned there.
bool is_absent(const Side& side, const Changeable& c) {
  return std::ranges::any_of(side.pins,
                             [&](const auto& pin) { return std::ranges::find(c.axes, pin.first) != c.axes.end(); });
}

/// Where an effect does not act its strength is neutral, and there is nothing to say of its shape.
void leave_out_absent(const Structure& s, const Changeable& c, std::size_t axis, ChangedNumber& n) {
  const auto say = [&](const Side& side, Estimate& there) {
    const bool pinned = std::ranges::any_of(side.pins, [&](const auto& pin) { return pin.first == axis; });
    if (!pinned) there.value = n.difference.value = n.difference.lower95 = n.difference.upper95 = std::nan("");
    there.lower95 = there.upper95 = there.value;
  };
  if (is_absent(s.a, c)) say(s.a, n.a);
  if (is_absent(s.b, c)) say(s.b, n.b);
}

MachineChange describe(const Structure& s, const Claim& claim, const Searched& found, const InUnits& units) {
  const Changeable& c = s.changeables[claim.group];
  MachineChange out;
  out.name = c.name, out.effect = c.effect, out.place = c.place;
  out.probability = found.probability[claim.group], out.class_probability = found.of_class[claim.group];
  out.look_alikes = c.look_alikes, out.recordings = c.recordings;
  for (const std::size_t g : found.members[claim.group]) out.members.push_back(s.changeables[g].name);
  out.heldout_gain = claim.heldout.gain, out.heldout_error = claim.heldout.error;
  out.heldout_share = claim.heldout.share;
  for (const std::size_t i : c.axes) {
    ChangedNumber n;
    n.key = s.a.model.model.parameters()[s.a.axes()[i].parameter].key;
    n.a = units.of_a(i), n.b = units.of_b(i), n.difference = units.difference(i);
    carry_to_difference(s.b, n);
    leave_out_absent(s, c, i, n);
    out.numbers.push_back(std::move(n));
  }
  return out;
}

std::vector<SharedNumber> shared_numbers(const Structure& s, const Searched& found, const InUnits& units) {
  std::vector<SharedNumber> out;
  for (std::size_t g = 0; g < s.changeables.size(); ++g) {
    // What acts in one set alone has nothing in common to show.
    if (found.best.changed[g] != 0 || is_absent(s.a, s.changeables[g]) || is_absent(s.b, s.changeables[g])) continue;
    for (const std::size_t i : s.changeables[g].axes) {
      std::vector<Estimate> pooled{units.of_a(i)};
      carry_scale_error(s.a.model.model, s.a.model.space, s.a.experiment, pooled);
      out.push_back({pooled.front(), found.probability[g]});
    }
  }
  return out;
}

std::vector<DiffFit> fits_of(const Side& side, const std::vector<double>& a, const std::vector<double>& b,
                             const std::vector<double>& joint) {
  Problem problem = problem_of(side.model, side.context());
  std::vector<DiffFit> out;
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    if (side.experiment.with_role(role).empty()) continue;
    const auto rms = [&](const std::vector<double>& point) {
      return residual_rms(problem, side.model.space.expand(point), role);
    };
    out.push_back({role, rms(a), rms(b), rms(joint)});
  }
  return out;
}

DiffSet describe(const Scenario& scenario, const Diagnosis& d) {
  DiffSet out;
  out.name = scenario.name, out.verdict = d.verdict, out.unexplained = d.unexplained, out.noise = d.noise;
  for (const Finding& f : d.findings) out.findings.push_back(f.place + "." + f.effect);
  return out;
}

HeldoutGainOver record(const HeldoutGainOf& g) { return {g.gain, g.error, g.share}; }

/// Whether each set's own model predicts its held-out recordings so much better than the common one with the changes
/// that something else changed.
bool differs_beyond(const HeldoutGainOf& own) {
  return own.known && own.speaks_for() && own.gain > kWorthLearning && own.share > kOfRestToSay;
}

/// Joints where one set's diagnosis leaves more than the noise, and the other's nothing, or little beside it.
std::vector<std::string> rest_of_one(const DiffSet& one, const DiffSet& other) {
  const auto over_noise = [](const DiffSet& set, const std::string& joint) {
    for (const Unexplained::AtJoint& at : set.unexplained.per_joint)
      if (at.joint == joint && std::isfinite(at.over_noise)) return at.over_noise;
    return 1.0;
  };
  std::vector<std::string> out;
  for (const std::string& joint : one.unexplained.where) {
    const auto& where = other.unexplained.where;
    const bool both = std::ranges::find(where, joint) != where.end();
    if (!both && over_noise(one, joint) > kMoreRest * over_noise(other, joint)) out.push_back(joint);
  }
  return out;
}

void judge(Diff& out, const HeldoutGainOf& own) {
  out.rest_in_a = rest_of_one(out.a, out.b), out.rest_in_b = rest_of_one(out.b, out.a);
  for (const auto& [set, joints] : {std::pair(&out.a, &out.rest_in_a), std::pair(&out.b, &out.rest_in_b)})
    for (const std::string& joint : *joints)
      out.notes.push_back(fmt::format(
          "{}: what is left of {} alone is more than noise: something acts there that has no name in the catalogue and "
          "that the other set has not, or does not show",
          joint, set->name));
  const bool beyond = differs_beyond(own) || !out.rest_in_a.empty() || !out.rest_in_b.empty();
  out.verdict = !out.changes.empty() ? DiffVerdict::changed : beyond ? DiffVerdict::unknown_change : DiffVerdict::same;
  if (differs_beyond(own))
    out.notes.push_back(
        fmt::format("the sets differ in more than is named: each set's own model predicts recordings that were "
                    "not fitted better still, by {:.3g} +- {:.2g} in log-likelihood",
                    own.gain, own.error));
  std::vector<std::string> rest;
  for (const DiffSet* set : {&out.a, &out.b})
    for (const std::string& joint : set->unexplained.where)
      if (std::ranges::find(rest, joint) == rest.end()) rest.push_back(joint);
  if (!rest.empty())
    out.notes.push_back(
        fmt::format("a rest beyond the noise stays at {}: the model is not quite the machine, and a "
                    "change may be that of another law which it stands for",
                    fmt::join(rest, ", ")));
}

/// What changed, what did not, and how probable both are.
void record_numbers(const Structure& s, const ChangeGroups& groups, const Searched& found,
                    const std::vector<Claim>& claims, Diff& out) {
  const Quadratic a = information_at(s.a, found.best.fit.a), b = information_at(s.b, found.best.fit.b);
  const ChangedSets sets(a, b, groups, held_near(s, found.best.fit));
  out.evidence = sets.evidence(found.best.changed) - sets.evidence(sets.none());
  // Intervals are those of the priors, not of how far anything was linearised.
  const ChangePosterior posterior = ChangedSets(a, b, groups).posterior(found.best.changed);
  const InUnits units(s, found.best.fit, posterior);
  for (const Claim& claim : claims) {
    if (claim.refused.empty())
      out.changes.push_back(describe(s, claim, found, units));
    else
      out.refused.push_back({s.changeables[claim.group].name, found.probability[claim.group], claim.refused});
  }
  std::stable_sort(out.changes.begin(), out.changes.end(), [](const MachineChange& x, const MachineChange& y) {
    return x.class_probability > y.class_probability;
  });
  out.shared = shared_numbers(s, found, units);
  for (const LivingSet& set : found.living)
    if (set.changed == sets.none()) out.no_change = set.share;
}

/// Residuals under each set's own model and the joint one, and what they have over each other on held-out recordings.
/// Returns what the own models have over the joint one.
HeldoutGainOf record_fits(const Structure& s, const ChangeGroups& groups, const JointFit& own, const JointFit& joint,
                          const RunControl& control, Diff& out) {
  const JointFit same = fit_jointly(s.a, s.b, groups, ChangedSet(groups.size(), 0), joint, control.stop);
  out.changed_over_same = record(heldout_over(s, joint, same));
  const HeldoutGainOf beyond = heldout_over(s, own, joint);
  out.own_over_joint = record(beyond);
  out.a.fit = fits_of(s.a, own.a, own.b, joint.a);
  out.b.fit = fits_of(s.b, own.a, own.b, joint.b);
  return beyond;
}

}  // namespace

const char* to_string(DiffVerdict verdict) {
  switch (verdict) {
    case DiffVerdict::same: return "same";
    case DiffVerdict::changed: return "changed";
    default: return "unknown_change";
  }
}

Diff compare_sets(const Scenario& a, const Diagnosis& found_a, const Scenario& b, const Diagnosis& found_b,
                  const IdentifyOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const RunControl& control = options.control;
  const auto report = [&](const std::string& stage, double done) {
    if (control.progress) control.progress({stage, done, 0.0, 0});
  };
  Diff out;
  out.a = describe(a, found_a), out.b = describe(b, found_b);
  out.engine = options.simulator.engine, out.seed = options.genetic.seed;
  SimulatorOptions simulator = options.simulator;
  simulator.max_step = std::min(found_a.after.step.step, found_b.after.step.step);
  report("common structure", 0.0);
  Structure s = common_structure({a, found_a}, {b, found_b}, simulator, control, out.notes);
  report("what changed", 0.3);
  const std::optional<Hypothesised> loaded = offer_load(s, control.stop);
  const JointFit own{s.a.model.fit.point, s.b.model.fit.point};
  const ChangeGroups groups = groups_of(s.changeables);
  Searched found = search(s, groups, loaded, control, [&](double d) { report("what changed", 0.4 + 0.3 * d); });
  report("verifying", 0.7);
  const std::vector<Claim> claims = claims_of(s, groups, found.of_class, found.best, control.stop);
  record_numbers(s, groups, found, claims, out);
  report("verifying", 0.85);
  const HeldoutGainOf beyond = record_fits(s, groups, own, found.best.fit, control, out);
  judge(out, beyond);
  out.seconds = found_a.seconds + found_b.seconds +
                std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace lacuna
