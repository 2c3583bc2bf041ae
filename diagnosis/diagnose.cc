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
#include "diagnosis/thinned.h"
#include "diagnosis/verify.h"
#include "diagnosis/when.h"
#include "physics/units.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double kColourError = 1e-3;       ///< of one joint called coloured whose rest is white
constexpr double kMoreLikelyThanNot = 0.5;  ///< of a class, for the verdict to rest on it

/// What the findings have explained at a joint of the recordings that were not fitted, and what is left there, both as
/// energy over the noise's. NaN: its noise is unknown.
struct JointEnergy {
  double removed = 0.0, rest = 0.0, samples = 0.0;
};

/// [joint]
std::vector<JointEnergy> explained_by_joint(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                                            std::span<const ResidualBlock> blocks, const std::vector<double>& noise,
                                            const Experiment& experiment) {
  std::vector<JointEnergy> out(experiment.joint_names.size());
  for (const ResidualBlock& b : blocks) {
    const std::size_t c = b.channel;
    JointEnergy& at = out[experiment.channels[c].joint];
    const double unit = noise[c] > 0.0 ? 1.0 / (noise[c] * noise[c]) : std::nan("");
    const double left = unit * after.segment(b.first, b.count).squaredNorm();
    at.removed += unit * before.segment(b.first, b.count).squaredNorm() - left;
    at.rest += left - static_cast<double>(b.count);
    at.samples += static_cast<double>(b.count);
  }
  return out;
}

/// Of what was missing; 0 where the noise is unknown.
double unknown_share(const JointEnergy& e) { return e.rest > 0.0 ? e.rest / (e.rest + std::max(0.0, e.removed)) : 0.0; }

/// What is left joint by joint; a rest that is no more than noise is none.
std::vector<Unexplained::AtJoint> rest_by_joint(const std::vector<JointEnergy>& joints, const Unexplained& unexplained,
                                                const Experiment& experiment) {
  std::vector<Unexplained::AtJoint> out;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const JointEnergy& e = joints[j];
    if (!(e.samples > 0.0)) continue;
    const std::string& name = experiment.joint_names[j];
    const bool left = std::ranges::find(unexplained.where, name) != unexplained.where.end();
    const double power = 1.0 + e.rest / e.samples;  // over the noise's; NaN where that is unknown
    out.push_back({name, power < 0.0 ? 0.0 : std::sqrt(power), left ? unknown_share(e) : 0.0});
  }
  return out;
}

/// While a rest stays unexplained the model is known to be wrong: what explains it may explain a finding as well. How
/// likely is the rest's share of what was missing at the finding's joint; of the arm, at all of them together. Joints
/// are separate questions: a rest at one says nothing of what was removed at another.
void leave_room(Diagnosis& out, const std::vector<JointEnergy>& joints, const Experiment& experiment) {
  JointEnergy all;
  for (const JointEnergy& e : joints)
    if (!std::isnan(e.rest)) all.removed += std::max(0.0, e.removed), all.rest += std::max(0.0, e.rest);
  out.unexplained.probability = unknown_share(all);
  for (Finding& finding : out.findings) {
    const auto& names = experiment.joint_names;
    const auto at = std::find(names.begin(), names.end(), finding.place);
    const double room = 1.0 - unknown_share(at == names.end() ? all : joints[at - names.begin()]);
    finding.probability *= room;
    for (Rival& rival : finding.rivals) rival.probability *= room;
  }
}

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

/// Channels of unknown noise whose rest is anything but white: there colour alone says that something is left.
std::vector<int> coloured_beyond_noise(const Eigen::VectorXd& rest, std::span<const ResidualBlock> blocks,
                                       const std::vector<double>& noise, const std::vector<std::string>& said,
                                       const Experiment& experiment) {
  std::vector<int> out;
  const std::vector<Autocorrelation> all = autocorrelations(rest, blocks);
  for (const Autocorrelation& a : all) {
    const std::size_t c = a.channel;
    const std::string& joint = experiment.joint_names[experiment.channels[c].joint];
    const bool known = noise[c] > 0.0 || std::find(said.begin(), said.end(), joint) != said.end();
    if (!known && a.p_value * static_cast<double>(all.size()) < kColourError) out.push_back(a.channel);
  }
  return out;
}

/// Which joints' residual is still beyond the noise on recordings that were not fitted, and how much of it.
void judge_rest(Diagnosis& out, const CurrentModel& before, const CurrentModel& after, const FitContext& context) {
  const Experiment& experiment = context.experiment;
  std::vector<int> unseen = experiment.with_role(Role::validate);
  if (unseen.empty()) unseen = experiment.with_role(Role::train);
  Problem a = problem_of(before, context);
  Problem b = problem_of(after, context, before.weights);
  const Eigen::VectorXd r0 = a.residual(before.fit.point, unseen), r1 = b.residual(after.fit.point, unseen);
  const auto blocks = a.layout(unseen);
  const std::vector<double> noise = noise_over_weight(experiment, before.weights);
  double floor = 0.0;
  for (std::size_t c = 0; c < noise.size(); ++c) {
    for (const ResidualBlock& block : blocks) {
      if (block.channel == static_cast<int>(c) && noise[c] > 0.0)
        floor += noise[c] * noise[c] * static_cast<double>(block.count);
    }
  }
  const std::vector<Channel> channels = experiment.channels;
  const auto say = [&](int channel) -> const std::string& {
    const int j = channels[channel].joint;
    const std::string& joint = experiment.joint_names[j];
    std::vector<std::string>& where = out.unexplained.where;
    if (std::ranges::find(where, joint) == where.end()) where.push_back(joint);  // of several channels once
    return joint;
  };
  for (const ExcessNoise& excess : excess_over_noise(r1, blocks, noise)) say(excess.channel);
  if (!out.unexplained.where.empty()) {
    std::vector<int> joints;
    for (const Channel& channel : channels) joints.push_back(channel.joint);
    out.unexplained.times = misfits(r1, blocks, noise, joints, experiment);
  }
  for (const int c : coloured_beyond_noise(r1, blocks, noise, out.unexplained.where, experiment)) {
    out.unexplained.regions.push_back(say(c) + ": the rest is not white; its noise level is unknown");
  }
  const double energy = std::max(r0.squaredNorm(), 1e-300), rest = std::max(0.0, r1.squaredNorm() - floor);
  out.unexplained.share = rest / energy;
  out.unexplained.present = !out.unexplained.where.empty();
  const std::vector<JointEnergy> energies = explained_by_joint(r0, r1, blocks, noise, experiment);
  out.unexplained.per_joint = rest_by_joint(energies, out.unexplained, experiment);
  if (out.unexplained.present) leave_room(out, energies, experiment);
  const bool claimed = std::any_of(out.findings.begin(), out.findings.end(),
                                   [](const Finding& f) { return class_probability(f) > kMoreLikelyThanNot; });
  const bool unknown = out.unexplained.present && (out.findings.empty() || !claimed);
  out.verdict = unknown                ? Verdict::unknown_physics
                : out.findings.empty() ? Verdict::consistent
                                       : Verdict::missing_physics;
}

/// A rest on the test recordings that those which decide do not have: it changes no verdict, but is said.
void note_test_rest(Diagnosis& out, const CurrentModel& after, const FitContext& context) {
  const Experiment& experiment = context.experiment;
  const std::vector<int> test = experiment.with_role(Role::test);
  if (test.empty() || out.unexplained.present) return;
  Problem problem = problem_of(after, context);
  const std::vector<double> noise = noise_over_weight(experiment, after.weights);
  const std::vector<Channel> channels = experiment.channels;
  for (const ExcessNoise& excess :
       excess_over_noise(problem.residual(after.fit.point, test), problem.layout(test), noise)) {
    const int joint = channels[excess.channel].joint;
    out.notes.push_back(fmt::format(
        "{}: the test recordings leave {:.2g} times the noise (chance {:.1g}), the others no more than it: something "
        "acts there that the recordings used do not show",
        experiment.joint_names[joint], excess.ratio, excess.p_value));
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
  const Experiment enough = thinned(experiment);
  const bool fewer = enough.segments.size() < experiment.segments.size();
  const FitContext in_enough = context.on(enough);
  const CurrentModel start = fewer ? seen_in(current, in_enough) : current;
  const FitContext here = in_enough.with_step(coarse_enough(start, in_enough));
  if (!fewer && here.simulator.max_step == context.simulator.max_step) return learn_laws(plain, current, context);
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
