#include "diagnosis/missing_physics.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "diagnosis/baseline.h"
#include "diagnosis/coarse.h"
#include "diagnosis/locate.h"
#include "diagnosis/parts.h"
#include "diagnosis/set_search.h"
#include "diagnosis/thinned.h"

namespace lacuna {
namespace {

constexpr int kFewIterations = 6;  ///< of a fit that starts where a look has ended

template <class T>
void append(std::vector<T>& to, std::vector<T> more) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

std::size_t searched_windows(const Experiment& experiment) {
  return experiment.with_role(Role::train).size() + experiment.with_role(Role::validate).size();
}

bool acts_at_a_joint(const EffectSpec& spec) { return effect_info(spec.effect).where == Where::joint; }

/// Goes on with sets of effects where a rest remains; `as`: what the checkpoint knows it by. Whether
/// the model changed.
bool go_on_with_sets(MissingPhysics& found, const FitContext& context, const CurrentModel& before,
                     const SetSearchOptions& options, DiagnosisCheckpoint& saved, const std::string& as,
                     Diagnosis& out) {
  const FitContext here = context.with_step(found.max_step);
  if (!leaves_a_rest(found.model, here)) return false;
  std::optional<SetSearchResult> sets;
  if (!saved.restore_sets(as, before, context.experiment, sets)) {
    sets = search_sets(before, found.model, out.findings, here, options);
    saved.store_sets(as, before.model, sets);
  }
  if (!sets) return false;
  found.model = std::move(sets->model);
  found.max_step = found.step.step = sets->step;
  evaluate_at(found.model, found.model.fit.point, context.with_step(sets->step));  // as a resumed run has it
  out.findings = std::move(sets->findings);
  append(out.rounds, std::move(sets->rounds));
  append(out.notes, std::move(sets->notes));
  return true;
}

/// Where the charts of speed against command show whole valves, several effects at one joint, the search begins with
/// these and goes on with sets; what they have taken away is not looked for by one effect after the other. Whether any
/// of it stands.
bool begin_with_valves(MissingPhysics& found, const FitContext& context, const CurrentModel& before,
                       SetSearchOptions options, DiagnosisCheckpoint& saved, Diagnosis& out) {
  std::erase_if(options.valves, [](const ValveStart& valve) { return valve.effects.size() < 2; });
  if (options.valves.empty()) return false;
  Diagnosis own;
  go_on_with_sets(found, context, before, options, saved, "valves", own);
  if (own.findings.empty()) return false;
  append(out.findings, std::move(own.findings));
  append(out.rounds, std::move(own.rounds));
  append(out.notes, std::move(own.notes));
  return true;
}

MissingPhysics search_in_these(const Scenario& scenario, const FitContext& context, const CurrentModel& before,
                               const std::vector<ValveStart>& valves, DiagnosisCheckpoint& saved, Diagnosis& out,
                               const Report& report) {
  const auto progress = [&](double d) { report("sets of effects", 0.7 + 0.2 * d); };
  MissingPhysics with_valves{before, context.simulator.max_step, out.before.step};
  const auto in_all = [&](double d) { report("valves, then sets of effects", 0.35 + 0.55 * d); };
  SetSearchOptions first{out.seed, in_all, {}, valves};
  if (begin_with_valves(with_valves, context, before, std::move(first), saved, out)) return with_valves;
  Rounds rounds(scenario, context, saved, before, out, report);
  rounds.run();
  report("whether all are needed", 0.9);
  rounds.reconsider();
  MissingPhysics found{rounds.current, rounds.context.simulator.max_step, rounds.step};
  go_on_with_sets(found, context, before, {out.seed, progress}, saved, "sets", out);
  return found;
}

/// By as much of the recordings as that needs; what is found is fitted to all of them.
MissingPhysics search_in_one_piece(const Scenario& scenario, const FitContext& context, const CurrentModel& before,
                                   DiagnosisCheckpoint& saved, Diagnosis& out, const Report& report) {
  const Experiment& experiment = context.experiment;
  const std::vector<ValveStart> valves = valve_starts(before.model, experiment);
  const Experiment enough = thinned(experiment);
  if (enough.segments.size() == experiment.segments.size())
    return search_in_these(scenario, context, before, valves, saved, out, report);
  const FitContext in_enough = context.on(enough);
  const CurrentModel start = seen_in(before, in_enough);
  MissingPhysics found = search_in_these(scenario, in_enough, start, valves, saved, out, report);
  out.notes.push_back(
      fmt::format("missing physics was looked for in {} of {} windows, spread evenly over the train and "
                  "validate recordings; what was found was then fitted to all train windows",
                  searched_windows(enough), searched_windows(experiment)));
  if (found.model.space.size() == before.space.size()) {
    found.model = before;
    return found;
  }
  refit(found.model, context.with_step(found.max_step));
  return found;
}

/// Whether a single effect of the whole arm, the best of them fitted, leaves nothing beyond the noise: then there is
/// nothing to take apart.
bool one_effect_of_the_arm_suffices(const CurrentModel& before, const FitContext& context) {
  ScreenOptions look{[](const std::string&) { return true; }};
  look.skipped = acts_at_a_joint;
  const std::vector<ScreenedEffect> looked = screen_effects(before, context, look);
  const auto best = std::min_element(looked.begin(), looked.end(),
                                     [](const auto& a, const auto& b) { return a.sum_of_squares < b.sum_of_squares; });
  if (best == looked.end()) return false;
  CurrentModel with = extended(before, context.experiment, best->spec, best->point, best->own);
  refine(with, context, kFewIterations);
  return !leaves_a_rest(with, context);
}

/// What acts on the whole arm beside what its parts have, looked for like all else in as many windows as that needs.
void look_for_effects_of_the_arm(MissingPhysics& found, const FitContext& context, const CurrentModel& before,
                                 DiagnosisCheckpoint& saved, Diagnosis& out, const Report& report) {
  SetSearchOptions further{out.seed, [&](double) { report("effects of the whole arm", 0.9); }};
  further.skipped = acts_at_a_joint;
  further.judged = true;
  const Experiment enough = thinned(context.experiment);
  if (enough.segments.size() == context.experiment.segments.size()) {
    go_on_with_sets(found, context, before, further, saved, "sets", out);
    return;
  }
  const FitContext in_enough = context.on(enough).with_step(found.max_step);
  const CurrentModel start = seen_in(before, in_enough);
  MissingPhysics there{seen_in(found.model, in_enough), found.max_step, found.step};
  if (!go_on_with_sets(there, in_enough, start, further, saved, "sets", out)) return;
  found = std::move(there);
  refit(found.model, context.with_step(found.max_step));
}

/// What the search in one part came to.
struct SearchedPart {
  Experiment experiment;
  MissingPhysics found;
};

/// `context`: of the whole.
SearchedPart search_part(const Scenario& scenario, Experiment experiment, const CurrentModel& whole,
                         const FitContext& context, DiagnosisCheckpoint& saved, Diagnosis& out, const Report& report) {
  const FitContext here = context.on(experiment);
  CurrentModel before = part_of(whole, context.experiment, scenario, experiment);
  attach_start_effects(experiment, before.model, here.simulator, before.space.expand(before.fit.point));
  refine(before, here);
  Diagnosis own;
  own.seed = out.seed, own.before.step = out.before.step;
  own.missing = missing_efforts(before, scenario, here.simulator, out.seed);
  MissingPhysics found = search_in_one_piece(scenario, here, before, saved, own, report);
  append(out.findings, std::move(own.findings));
  append(out.rounds, std::move(own.rounds));
  append(out.notes, std::move(own.notes));
  return {std::move(experiment), std::move(found)};
}

}  // namespace

MissingPhysics search_missing_physics(const Scenario& scenario, const FitContext& context, const CurrentModel& before,
                                      DiagnosisCheckpoint& saved, Diagnosis& out, const Report& report) {
  const std::vector<Scenario> scenarios = parts_of(scenario, before, context);
  if (scenarios.empty() || one_effect_of_the_arm_suffices(before, context))
    return search_in_one_piece(scenario, context, before, saved, out, report);
  MissingPhysics found{before, context.simulator.max_step, out.before.step};
  std::vector<CurrentModel> models;
  std::vector<Experiment> experiments;
  for (std::size_t k = 0; k < scenarios.size(); ++k) {
    const auto count = static_cast<double>(scenarios.size()), done = static_cast<double>(k) / count;
    Experiment own = make_experiment(scenarios[k]);
    own.parts = static_cast<int>(scenarios.size());
    DiagnosisCheckpoint kept(saved.part("part_" + std::to_string(k)), context.control.problem + " " + scenarios[k].name,
                             context.control.writes);
    SearchedPart part =
        search_part(scenarios[k], std::move(own), before, context, kept, out, [&](const std::string& stage, double d) {
          report(scenarios[k].name + ": " + stage, 0.35 + 0.55 * (done + d / count));
        });
    found.max_step = found.step.step = std::min(found.max_step, part.found.max_step);
    found.step.error_over_noise = std::max(found.step.error_over_noise, part.found.step.error_over_noise);
    models.push_back(std::move(part.found.model));
    experiments.push_back(std::move(part.experiment));
  }
  found.model = put_together(before, models, experiments, context.with_step(found.max_step));
  // One joint's friction may ask for steps that change nothing beside what the whole still leaves: last, then.
  const double finest = found.max_step;
  found.max_step = coarse_enough(found.model, context.with_step(finest));
  const FitContext coarse = context.with_step(found.max_step);
  evaluate_at(found.model, found.model.fit.point, coarse);
  refit(found.model, coarse);
  look_for_effects_of_the_arm(found, context, before, saved, out, report);
  if (finest >= found.max_step) return found;
  found.max_step = found.step.step = finest;
  refit(found.model, context.with_step(finest), kRefitTolerance, nullptr, kFewIterations);
  return found;
}

}  // namespace lacuna
