#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "backends/engine.h"
#include "diagnosis/baseline.h"
#include "diagnosis/between_recordings.h"
#include "diagnosis/checkpoint.h"
#include "diagnosis/coarse.h"
#include "diagnosis/effort_search.h"
#include "diagnosis/events.h"
#include "diagnosis/evidence.h"
#include "diagnosis/learned.h"
#include "diagnosis/missing_physics.h"
#include "diagnosis/prior.h"
#include "diagnosis/replay.h"
#include "diagnosis/separate.h"
#include "diagnosis/set_search.h"
#include "diagnosis/unexplained.h"
#include "diagnosis/verify.h"
#include "diagnosis/when.h"
#include "physics/units.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

/// Findings' own estimates, taken out of the fit's under their short names.
void attach_parameters(Diagnosis& out) {
  for (Finding& finding : out.findings) {
    const std::string prefix = finding.place + "." + finding.effect + ".";
    finding.parameters.clear();
    for (const Estimate& estimate : out.after.estimates) {
      if (estimate.name.rfind(prefix, 0) != 0) continue;
      finding.parameters.push_back(estimate);
      finding.parameters.back().name = estimate.name.substr(prefix.size());
    }
  }
}

/// Where the dry friction of one contact stands in several findings, since part of it gives before it slides
/// (bristles): what it is in all.
void note_dry_friction(Diagnosis& out) {
  std::map<std::string, std::vector<const Estimate*>> parts;
  for (const Finding& finding : out.findings)
    for (const Estimate& e : finding.parameters)
      if (e.name == "Fc") parts[finding.place].push_back(&e);
  for (const auto& [joint, sizes] : parts) {
    if (sizes.size() < 2) continue;
    double sum = 0.0;
    for (const Estimate* e : sizes) sum += e->value;
    out.notes.push_back(fmt::format("{}: in steady sliding its dry friction is {:.3g} {} in all, of {} findings", joint,
                                    sum, sizes.front()->unit, sizes.size()));
  }
}

std::vector<Estimate> fit_everything(const CurrentModel& current, const FitContext& context) {
  std::vector<int> all(context.experiment.segments.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  Problem problem = problem_of(current, context);
  LeastSquaresOptions finish;
  finish.polish = false;
  FitResult fit;
  fit.solution = solve_least_squares(problem, current.fit.point, all, finish);
  fit.values = current.space.expand(fit.solution.point);
  describe_fit(current.model, current.space, problem, all, fit);
  carry_scale_error(current.model, current.space, context.experiment, fit.estimates);
  return fit.estimates;
}

/// Effects of `current` beyond those of the plain model, in its order, with all their values.
std::vector<EffectSpec> added_effects(const PlantModel& plain, const CurrentModel& current) {
  std::vector<EffectSpec> out = effects_beyond(plain, current);
  const std::vector<double> values = current.space.expand(current.fit.point);
  for (EffectSpec& spec : out) {
    const std::size_t at = current.model.find_effect_at(spec.effect, spec.place);
    const Component& c = current.model.effects()[at];
    for (int i = c.first; i < c.first + c.count; ++i) spec.parameters[current.model.parameters()[i].key] = values[i];
  }
  return out;
}

/// Whether several findings are at one joint: they may all stand for one law that has no name.
bool has_heap(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings, [&](const Finding& f) {
    return f.place != "arm" &&
           std::ranges::count_if(findings, [&](const Finding& other) { return other.place == f.place; }) > 1;
  });
}

/// Laws are learned like names in as many windows, and at steps as long, as that needs; then fitted to all, as the
/// model was.
LearnedLaws learn_in_enough(const CurrentModel& plain, const CurrentModel& current, const FitContext& context) {
  const Experiment& experiment = context.experiment;
  if (std::holds_alternative<InverseDynamics>(experiment.prediction))  // cheap: all of it
    return learn_laws(plain, current, context);
  const Enough enough(current, context);
  if (enough.is_all()) return learn_laws(plain, current, context);
  const FitContext& here = enough.context();
  LearnedLaws out = learn_laws(seen_in(plain, here), seen_in(current, here), here);
  if (!out.changes_nothing()) refit(out.model, context);
  if (out.changes_names()) refit(out.named, context);
  return out;
}

/// What has no name: laws of the machine, then what happened once in a recording; where something did, the machine is
/// looked at again without it. Names that a law makes needless go. Leaves the model with all of it and the one with the
/// names alone, and returns the recordings with their events in.
Experiment learn(const Scenario& scenario, const FitContext& context, const CurrentModel& plain, CurrentModel& current,
                 CurrentModel& named, Diagnosis& out, const Report& report) {
  const Experiment& experiment = context.experiment;
  if (!out.before.arrived && !std::holds_alternative<InverseDynamics>(experiment.prediction)) return experiment;
  const auto laws = [&](const Experiment& of) {
    if (!out.learned.empty() || !((has_heap(out.findings) && std::holds_alternative<FreeRun>(of.prediction)) ||
                                  leaves_a_rest(current, context.on(of))))
      return;
    LearnedLaws learned = learn_in_enough(plain, current, context.on(of));
    if (learned.changes_nothing()) return;
    out.learned = std::move(learned.laws);
    learned.follow(out.findings);
    current = std::move(learned.model);
    if (learned.changes_names()) named = std::move(learned.named);
  };
  report("laws without a name", 0.89);
  laws(experiment);
  report("events", 0.9);
  EventsFound found = find_events(current, context);
  out.events = std::move(found.events);
  if (out.events.empty()) return experiment;
  for (LearnedEvent& event : out.events)
    if (event.unit.empty()) event.unit = command_unit(scenario, event.place);
  current = std::move(found.model);
  laws(found.experiment);
  return std::move(found.experiment);
}

void note_missing(const Scenario& scenario, Diagnosis& out) {
  std::vector<std::string> given = scenario.notes;
  for (std::string& idle : idle_effects(scenario)) given.push_back(std::move(idle));
  out.notes.insert(out.notes.begin(), given.begin(), given.end());
  if (out.after.step.error_over_noise >= 0.1) {
    out.notes.push_back(fmt::format(
        "integration error is {:.2g} of the noise at steps of {:.2g} ms, and shorter ones do little better: "
        "small effects cannot be told from it",
        out.after.step.error_over_noise, 1e3 * out.after.step.step));
  }
}

/// The model to report at the step that its numbers need; where nothing was found that is the plain one. The fit alone
/// takes that step: what follows it, other engines among it, would take several times as long.
void fit_at_its_own_step(CurrentModel& current, CurrentModel& before, const FitContext& context, Diagnosis& out) {
  const double step = settle(current, context);
  if (step < context.simulator.max_step)
    out.notes.push_back(
        fmt::format("the parameters were fitted at an integration step of {:.2g} s, at which its error moves none of "
                    "them by more than a fifth of its standard error; predictions are simulated at {:.2g} s",
                    step, context.simulator.max_step));
  if (!out.findings.empty()) return;
  before = current;
  record_fit(before, context, out.before);
}

}  // namespace

double class_probability(const Finding& finding) {
  double sum = finding.probability;
  for (const Rival& rival : finding.rivals) {
    const bool member = rival.place == finding.place && std::find(finding.members.begin(), finding.members.end(),
                                                                  rival.effect) != finding.members.end();
    if (member) sum += rival.probability;
  }
  return std::min(sum, 1.0);
}

bool changes_the_model(const Diagnosis& d) {
  const auto is_put_in = [](const LearnedEvent& event) { return event.role != Role::test; };
  return !d.findings.empty() || !d.learned.empty() || std::ranges::any_of(d.events, is_put_in);
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent: return "consistent";
    case Verdict::missing_physics: return "missing_physics";
    default: return "unknown_physics";
  }
}

Diagnosis diagnose(const Scenario& scenario, const DiagnoseOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const RunControl& control = options.identify.control;
  const Report report = [&](const std::string& stage, double done) {
    if (control.progress) control.progress({stage, done, 0.0, 0});
  };
  Diagnosis out;
  out.scenario = scenario.name;
  out.engine = options.identify.simulator.engine;
  out.seed = options.identify.genetic.seed;
  const PlantModel model(scenario);
  Experiment experiment = make_experiment(scenario);
  // Ratios with priors arrive from further off, but candidates of a simulated motion take several times as long in them
  // (docs/method.md, tried and dropped).
  const bool inverse = std::holds_alternative<InverseDynamics>(scenario.prediction);
  const SearchSpace space(model, scenario, inverse ? Coordinates::ratios : Coordinates::values);
  DiagnosisCheckpoint saved(control.checkpoint, control.problem, control.writes);

  report("plain model", 0.02);
  IdentifyOptions identify_options = options.identify;
  identify_options.control.checkpoint = saved.part("search");
  identify_options.control.progress = [&](const Progress& p) {
    report("plain model: " + p.stage, 0.02 + 0.3 * p.done);
  };
  // By inverse dynamics all is nearly linear: least squares arrives from anywhere.
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) identify_options.optimizer = Optimizer::lsq;
  CurrentModel before{model, space, {}, {}};
  FitContext context{experiment, options.identify.simulator, control.quiet()};
  if (!saved.restore_baseline(context, before, out.before)) {
    before = identify_plain(model, experiment, space, identify_options, out.before);
    saved.store_baseline(before, out.before);
  }
  context.simulator.max_step = out.before.step.step;
  if (attach_start_effects(experiment, model, context.simulator, before.space.expand(before.fit.point)))
    refine(before, context);
  record_fit(before, context, out.before);

  out.idim = regress_base_parameters(model, experiment);
  out.missing = missing_efforts(before, scenario, context.simulator, out.seed);

  CurrentModel current = before;
  StepChoice step = out.before.step;
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) {
    EffortSearchResult found =
        search_efforts(before, context, {out.seed, [&](double d) { report("sets of effects", 0.35 + 0.55 * d); }});
    current = std::move(found.model);
    out.findings = std::move(found.findings);
    out.rounds = std::move(found.rounds);
    out.notes = std::move(found.notes);
  } else {
    MissingPhysics found{before, step.step, step};
    if (out.before.arrived) found = search_missing_physics(scenario, context, before, saved, out, report);
    current = std::move(found.model);
    context.simulator.max_step = found.max_step, step = found.step;
    if (out.before.arrived) fit_at_its_own_step(current, before, context, out);
  }
  CurrentModel named = current;
  const Experiment with_events = learn(scenario, context, before, current, named, out, report);
  out.added = added_effects(before.model, current);

  for (LearnedLaw& law : out.learned) law.cloud = cloud_of(law, current, scenario, context.simulator);

  report("motions that separate what is alike", 0.91);
  separate(out.findings, before, named, context, out.seed);

  report("verifying", 0.92);
  const FitContext beside_events = context.on(with_events);
  out.after = out.before;
  if (changes_the_model(out)) record_fit(current, beside_events, out.after);
  out.after.step = step;
  attach_parameters(out);
  note_dry_friction(out);
  out.valves = compare_valves(current, beside_events);
  out.chain = joint_chains(before, current, scenario, beside_events, out.seed);
  judge_rest(out, before, named, context);
  out.unexplained.numbers = numbers_by_recording(current, beside_events, out.unexplained.where);
  note_test_rest(out, current, beside_events);
  const std::vector<double> noise = noise_levels(experiment);
  const std::vector<Channel>& channels = experiment.channels;
  for (std::size_t c = 0; c < channels.size(); ++c)
    out.noise.emplace_back(rms_entry(channels[c], experiment), noise[c] > 0.0 ? noise[c] : std::nan(""));
  verify(out, before, current, beside_events, options.other_engines);
  out.replays = replays(out, before, current, beside_events, scenario);
  note_missing(scenario, out);
  if (!out.before.arrived && !std::holds_alternative<InverseDynamics>(experiment.prediction))
    out.notes.push_back("nothing is claimed, the plain model's best may not have been reached: " + out.before.doubt);
  out.all_recordings = fit_everything(current, beside_events);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace lacuna
