#include "diff/structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/baseline.h"
#include "diagnosis/coarse.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/kin.h"
#include "diagnosis/prior.h"
#include "ga/start_effects.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr int kSideIterations = 25;
constexpr double kOfShapeRange = 0.25;          ///< standard deviation
constexpr const char* kNoRecording = "(none)";  ///< acts nowhere: no file is called so

const Finding* finding_of(const Diagnosis& d, const EffectSpec& spec) {
  const auto at = std::find_if(d.findings.begin(), d.findings.end(),
                               [&](const Finding& f) { return f.effect == spec.effect && f.place == spec.place; });
  return at == d.findings.end() ? nullptr : &*at;
}

/// Parameters of an effect of the diagnosed model that were not searched.
std::map<std::string, double> held_parameters(const Diagnosis& d, const EffectSpec& spec) {
  std::map<std::string, double> out = spec.parameters;
  for (const Estimate& e : d.after.estimates) {
    const std::string prefix = spec.place + "." + spec.effect + ".";
    if (e.name.rfind(prefix, 0) == 0) out.erase(e.name.substr(prefix.size()));
  }
  return out;
}

/// How probable a diagnosis holds an effect to be at its place, named or as another's rival.
double probability_in(const Diagnosis& d, const CommonEffect& effect) {
  double out = 0.0;
  for (const Finding& f : d.findings) {
    if (f.place != effect.spec.place) continue;
    if (f.effect == effect.spec.effect) out = std::max(out, f.probability);
    for (const Rival& r : f.rivals)
      if (r.effect == effect.spec.effect && r.place == effect.spec.place) out = std::max(out, r.probability);
  }
  return out;
}

bool are_alike(const CommonEffect& one, const CommonEffect& other) {
  if (one.spec.place != other.spec.place || one.spec.effect == other.spec.effect) return false;
  const auto names = [](const CommonEffect& x, const CommonEffect& y) {
    return std::find(x.look_alikes.begin(), x.look_alikes.end(), y.spec.effect) != x.look_alikes.end();
  };
  return names(one, other) || names(other, one) ||
         overlap(effect_info(one.spec.effect), effect_info(other.spec.effect));
}

void collect(const Diagnosis& d, bool of_b, std::vector<CommonEffect>& out, std::vector<std::string>& notes) {
  std::set<NamedPlace> seen;
  for (const EffectSpec& spec : d.added) {
    if (effect_info(spec.effect).learned || !seen.insert(place_of(spec)).second) {
      notes.push_back(fmt::format("{}: {} at {} is not compared: it stays with what the model does not explain",
                                  d.scenario, spec.effect, spec.place));
      continue;
    }
    auto at = std::find_if(out.begin(), out.end(), [&](const auto& e) { return place_of(e.spec) == place_of(spec); });
    if (at == out.end()) {
      CommonEffect added;
      added.spec = {spec.effect, spec.place, held_parameters(d, spec), {}, spec.effect};
      at = out.insert(out.end(), std::move(added));
    }
    const Finding* finding = finding_of(d, spec);
    CommonEffect::There there{spec.recordings, spec.parameters, finding != nullptr ? finding->probability : 1.0};
    (of_b ? at->b : at->a) = std::move(there);
    // What one set leaves free is free in both.
    const auto held = held_parameters(d, spec);
    std::erase_if(at->spec.parameters, [&](const auto& p) { return !held.contains(p.first); });
    if (finding == nullptr) continue;
    for (const std::string& member : finding->members)
      if (member != spec.effect &&
          std::find(at->look_alikes.begin(), at->look_alikes.end(), member) == at->look_alikes.end())
        at->look_alikes.push_back(member);
  }
}

/// Largest sizes of both, so that what one set does not move is still measured by something.
Experiment sizes_of_both(const Experiment& a, const Experiment& b) {
  Experiment out = a;
  const auto larger = [](std::vector<double>& x, const std::vector<double>& y) {
    for (std::size_t j = 0; j < std::min(x.size(), y.size()); ++j) x[j] = std::max(x[j], y[j]);
  };
  larger(out.command_rms, b.command_rms), larger(out.speed_rms, b.speed_rms);
  larger(out.position_rms, b.position_rms), larger(out.effort_rms, b.effort_rms);
  for (std::size_t j = 0; j < std::min(a.position_middle.size(), b.position_middle.size()); ++j) {
    const double low = std::min(a.position_middle[j] - a.position_reach[j], b.position_middle[j] - b.position_reach[j]);
    const double high =
        std::max(a.position_middle[j] + a.position_reach[j], b.position_middle[j] + b.position_reach[j]);
    out.position_middle[j] = 0.5 * (low + high), out.position_reach[j] = 0.5 * (high - low);
  }
  out.span = std::max(a.span, b.span);
  return out;
}

Scenario with_events(const Scenario& scenario, const Diagnosis& d) {
  Scenario out = scenario;
  for (const LearnedEvent& event : d.events)
    if (event.role != Role::test) out.events.insert(out.events.end(), event.pieces.begin(), event.pieces.end());
  return out;
}

Side plain_side(const DiagnosedSet& set, const SimulatorOptions& simulator) {
  const PlantModel model(set.scenario);
  const bool inverse = std::holds_alternative<InverseDynamics>(set.scenario.prediction);
  const SearchSpace space(model, set.scenario, inverse ? Coordinates::ratios : Coordinates::values);
  Side out{make_experiment(with_events(set.scenario, set.diagnosis)), {model, space, {}, {}}, simulator, {}};
  out.model.weights = first_weights(model, out.experiment);
  const auto& found = set.diagnosis.after.point;
  out.model.fit.point.assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(space.size()));
  return out;
}

/// Search coordinates of an effect's own axes at `values`, where given, else at neutral; `strengths` at neutral anyway.
std::vector<double> own_point(const PlantModel& model, const std::vector<Axis>& axes,
                              const std::map<std::string, double>& values, bool neutral) {
  std::vector<double> out;
  for (const Axis& axis : axes) {
    const Parameter& p = model.parameters()[axis.parameter];
    const auto at = values.find(p.key);
    const bool given = at != values.end() && !(neutral && is_strength(*p.info));
    const double x = axis.at(given ? at->second : p.neutral);
    out.push_back(std::clamp(std::isnan(x) ? axis.start : x, axis.lower, axis.upper));
  }
  return out;
}

/// Grows one side's model by an effect; its own axes start at 0 and are set by the caller.
void grow(Side& side, const Experiment& sizes, EffectSpec spec, const std::vector<std::string>& recordings) {
  spec.recordings = recordings;
  const CurrentModel before = side.model;
  const std::vector<double> point = before.fit.point;
  side.model = extended(before, sizes, spec, point, {});
  side.model.weights = before.weights;
}

std::vector<Axis> last_axes(const Side& side, std::size_t count) {
  return {side.axes().end() - static_cast<std::ptrdiff_t>(count), side.axes().end()};
}

/// Neutral, on a side where the effect acts nowhere.
void pin_at_neutral(Side& side, std::size_t first) {
  const auto& axes = side.axes();
  const auto parameter = [&](std::size_t a) -> const Parameter& {
    return side.model.model.parameters()[axes[a].parameter];
  };
  bool any = false;
  for (std::size_t a = first; a < axes.size(); ++a) any = any || is_strength(*parameter(a).info);
  for (std::size_t a = first; a < axes.size(); ++a) {
    if (any && !is_strength(*parameter(a).info)) continue;
    const double x = axes[a].at(parameter(a).neutral);
    side.pins.emplace_back(a, std::clamp(std::isnan(x) ? axes[a].start : x, axes[a].lower, axes[a].upper));
  }
}

std::vector<Changeable> plain_changeables(const Side& side) {
  std::vector<Changeable> out;
  for (std::size_t a = 0; a < side.axes().size(); ++a) {
    const Parameter& p = side.model.model.parameters()[side.axes()[a].parameter];
    const std::string place =
        p.name.size() > p.key.size() ? p.name.substr(0, p.name.size() - p.key.size() - 1) : p.name;
    out.push_back({p.name, "", place, p.key, {a}, {}, {}});
  }
  return out;
}

/// Simulates one side at the longest steps that do not matter beside what its own diagnosis leaves.
void choose_coarse_step(Side& side, const std::vector<double>& own) {
  CurrentModel model = side.model;
  const FitContext context = side.context();
  evaluate_at(model, own, context);
  change_weights(model, context, weights_from(model, context));
  side.simulator.max_step = coarse_enough(model, context);
}

/// Fits one side from each of the starts; the fit that leaves least stays.
void fit_side(Side& side, const std::vector<std::vector<double>>& starts, const RunControl& control,
              const std::string& name) {
  const CurrentModel before = side.model;
  const Hypotheses fits(before, {side.experiment, side.simulator, control});
  std::optional<CurrentModel> best;
  const auto left = [](const CurrentModel& m) {
    double out = 0.0;
    for (const double w : m.weights) out += std::log(w);
    return out;
  };
  for (const std::vector<double>& start : starts) {
    if (control.stop != nullptr && *control.stop) throw Interrupted();
    CurrentModel model = before;
    model.fit.point = start;
    if (fits.fit(model, kSideIterations) && (!best || left(model) < left(*best))) best = std::move(model);
  }
  if (!best) throw WorkError(name + " cannot be simulated with what the two sets need together");
  side.model = std::move(*best);
}

/// Of an effect that nobody has fitted yet, how it is shaped (the place of a load) is known by its range only.
void widen_shapes(Side& side, std::size_t first) {
  std::vector<Axis> axes = side.axes();
  for (std::size_t a = first; a < axes.size(); ++a) {
    const Parameter& p = side.model.model.parameters()[axes[a].parameter];
    if (!is_strength(*p.info)) axes[a].prior = std::max(axes[a].prior, kOfShapeRange * (axes[a].upper - axes[a].lower));
  }
  side.model.space.replace(std::move(axes));
}

/// Both sides' axes made one: bounds of either, so that no number of the other's diagnosis falls outside.
void share_axes(Side& a, Side& b, const Experiment& sizes, const std::vector<double>& point) {
  std::vector<Axis> axes = a.axes();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    axes[i].lower = std::min(axes[i].lower, b.axes()[i].lower);
    axes[i].upper = std::max(axes[i].upper, b.axes()[i].upper);
  }
  a.model.space.replace(axes);
  set_priors(a.model.model, sizes, a.model.space, point);
  b.model.space.replace(a.axes());
}

}  // namespace

std::vector<CommonEffect> common_effects(const Diagnosis& a, const Diagnosis& b, std::vector<std::string>& notes) {
  std::vector<CommonEffect> out;
  collect(a, false, out, notes);
  collect(b, true, out, notes);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t j = i + 1; j < out.size(); ++j) {
      const bool apart = (out[i].a && !out[i].b && out[j].b && !out[j].a);
      if (!apart || !are_alike(out[i], out[j])) continue;
      const auto weight = [&](const CommonEffect& e) { return probability_in(a, e) + probability_in(b, e); };
      const std::size_t goes = weight(out[j]) > weight(out[i]) ? i : j, stays = i + j - goes;
      out[stays].look_alikes.push_back(out[goes].spec.effect);
      notes.push_back(fmt::format(
          "{}: one set was said to need {}, the other {}; they are hardly told apart, and the first stands for both",
          out[stays].spec.place, out[stays].spec.effect, out[goes].spec.effect));
      out.erase(out.begin() + static_cast<std::ptrdiff_t>(goes));
      i = static_cast<std::size_t>(-1);  // looked at anew
      break;
    }
  }
  for (CommonEffect& e : out) {
    std::sort(e.look_alikes.begin(), e.look_alikes.end());
    e.look_alikes.erase(std::unique(e.look_alikes.begin(), e.look_alikes.end()), e.look_alikes.end());
  }
  return out;
}

Structure common_structure(const DiagnosedSet& set_a, const DiagnosedSet& set_b, const SimulatorOptions& simulator,
                           const RunControl& control, std::vector<std::string>& notes) {
  Structure out{plain_side(set_a, simulator), plain_side(set_b, simulator), {}};
  Side &a = out.a, &b = out.b;
  const Experiment sizes = sizes_of_both(a.experiment, b.experiment);
  out.changeables = plain_changeables(a);
  std::vector<double> own_a = a.model.fit.point, own_b = b.model.fit.point, other_a = own_a, other_b = own_b;
  for (const CommonEffect& effect : common_effects(set_a.diagnosis, set_b.diagnosis, notes)) {
    const std::size_t first = a.axes().size();
    const bool only_a = effect.a && !effect.a->recordings.empty() && !effect.b;
    const bool only_b = effect.b && !effect.b->recordings.empty() && !effect.a;
    const std::vector<std::string> none{kNoRecording};
    grow(a, sizes, effect.spec, only_b ? none : effect.a ? effect.a->recordings : std::vector<std::string>());
    grow(b, sizes, effect.spec, only_a ? none : effect.b ? effect.b->recordings : std::vector<std::string>());
    const std::vector<Axis> axes = last_axes(a, a.axes().size() - first);
    const auto append = [&](std::vector<double>& point, const CommonEffect::There& there, bool neutral) {
      const std::vector<double> own = own_point(a.model.model, axes, there.values, neutral);
      point.insert(point.end(), own.begin(), own.end());
    };
    append(own_a, effect.a ? *effect.a : *effect.b, !effect.a);
    append(own_b, effect.b ? *effect.b : *effect.a, !effect.b);
    append(other_a, effect.b ? *effect.b : *effect.a, only_b);
    append(other_b, effect.a ? *effect.a : *effect.b, only_a);
    if (only_b) pin_at_neutral(a, first);
    if (only_a) pin_at_neutral(b, first);
    Changeable changeable{effect.spec.place + "." + effect.spec.effect,
                          effect.spec.effect,
                          effect.spec.place,
                          "",
                          {},
                          effect.look_alikes,
                          only_b   ? effect.b->recordings
                          : only_a ? effect.a->recordings
                                   : std::vector<std::string>()};
    for (std::size_t i = first; i < a.axes().size(); ++i) changeable.axes.push_back(i);
    out.changeables.push_back(std::move(changeable));
    a.model.fit.point = own_a, b.model.fit.point = own_b;
  }
  share_axes(a, b, sizes, own_a);
  for (Side* side : {&a, &b})
    attach_start_effects(side->experiment, side->model.model, side->simulator,
                         side->model.space.expand(side == &a ? own_a : own_b));
  choose_coarse_step(a, own_a), choose_coarse_step(b, own_b);
  fit_side(a, {own_a, other_a}, control, set_a.scenario.name);
  fit_side(b, {own_b, other_b}, control, set_b.scenario.name);
  return out;
}

std::size_t add_in_one(Structure& s, const EffectSpec& spec, bool in_b) {
  const Experiment sizes = sizes_of_both(s.a.experiment, s.b.experiment);
  const std::size_t first = s.a.axes().size();
  const std::vector<std::string> none{kNoRecording};
  std::vector<double> point_a = s.a.model.fit.point, point_b = s.b.model.fit.point;
  grow(s.a, sizes, spec, in_b ? none : std::vector<std::string>());
  grow(s.b, sizes, spec, in_b ? std::vector<std::string>() : none);
  const std::vector<double> own = own_point(s.a.model.model, last_axes(s.a, s.a.axes().size() - first), {}, true);
  point_a.insert(point_a.end(), own.begin(), own.end());
  point_b.insert(point_b.end(), own.begin(), own.end());
  share_axes(s.a, s.b, sizes, point_a);
  widen_shapes(s.a, first), s.b.model.space.replace(s.a.axes());
  s.a.model.fit.point = std::move(point_a), s.b.model.fit.point = std::move(point_b);
  pin_at_neutral(in_b ? s.a : s.b, first);
  Changeable changeable{spec.place + "." + spec.effect, spec.effect, spec.place, "", {}, {}, {}};
  for (std::size_t i = first; i < s.a.axes().size(); ++i) changeable.axes.push_back(i);
  s.changeables.push_back(std::move(changeable));
  return s.changeables.size() - 1;
}

}  // namespace lacuna
