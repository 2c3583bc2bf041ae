#include "diagnosis/rounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "diagnosis/anew.h"
#include "diagnosis/baseline.h"
#include "diagnosis/contest.h"
#include "diagnosis/decide.h"
#include "diagnosis/evidence.h"
#include "diagnosis/exchange.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/prune.h"
#include "diagnosis/where.h"
#include "diagnosis/without.h"

namespace lacuna {
namespace {

constexpr double kWhite = 0.01;        ///< chance of white noise looking as coloured, any channel
constexpr double kAsGood = 1.5;        ///< energy that a pair's linear look leaves over what the one kept leaves
constexpr int kMostFindings = 4;       ///< or, where these are more,
constexpr int kMostAtAJoint = 2;       ///< findings, on average: every joint of a machine may miss something
constexpr int kExchanges = 4;          ///< passes, at most: each must gain evidence
constexpr int kRefinedIterations = 6;  ///< of least squares after a finer step; the start is nearly there

/// Whether the fit leaves anything on the recordings that steered it: more than the noise, or anything but white.
bool leaves_something(const CurrentModel& current, const FitContext& context) {
  std::vector<int> seen = context.experiment.with_role(Role::train);
  for (const int s : context.experiment.with_role(Role::validate)) seen.push_back(s);
  Problem problem = problem_of(current, context);
  const Eigen::VectorXd r = problem.residual(current.fit.point, seen);
  const auto blocks = problem.layout(seen);
  const std::vector<double> noise = noise_over_weight(context.experiment, current.weights);
  return !excess_over_noise(r, blocks, noise).empty() || chance_of_white(r, blocks) < kWhite;
}

/// An effect that was just found may need a finer step than the plain model did; then the fit is repeated with it.
void refine_step(CurrentModel& current, FitContext& context, StepChoice& step) {
  step = choose_step(current.model, context.experiment, context.simulator, current.space.expand(current.fit.point));
  if (step.step >= context.simulator.max_step) return;
  context.simulator.max_step = step.step;
  refine(current, context, kRefinedIterations);
}

/// One round: every effect at `joints`, where effort is missing, and on the arm; elsewhere, too, only if nothing is
/// found there. `joints` empty: everywhere at once.
Decision next_decision(const CurrentModel& current, const FitContext& context, const std::vector<std::string>& joints,
                       DecideOptions options, const Report& report) {
  const Experiment& experiment = context.experiment;
  const auto first = [&](const std::string& place) {
    return joints.empty() || place == "arm" || std::find(joints.begin(), joints.end(), place) != joints.end();
  };
  const auto progress = [&](double d) { report("every effect at every place", 0.5 * d); };
  std::vector<ScreenedEffect> screened = screen_effects(current, context, {first, progress});
  const double all = static_cast<double>(experiment.joint_names.size());
  options.choices = experiment.parts * (joints.empty() ? 1.0 : all / static_cast<double>(joints.size()));
  report("weighing on held-out recordings", 0.5);
  Decision decision = decide(current, context, screened, options);
  if (decision.finding || joints.empty()) return decision;
  const auto elsewhere = [&](const std::string& place) { return !first(place); };
  for (ScreenedEffect& effect : screen_effects(current, context, {elsewhere, progress}))
    screened.push_back(std::move(effect));
  options.choices = experiment.parts;
  report("weighing on held-out recordings", 0.5);
  return decide(current, context, std::move(screened), options);
}

/// Where the one kept could be two simpler effects at its joint: log-odds of the branch together with the best of all
/// effects there, no more numbers than the one kept. The second is one of many that were tried, and costs their number;
/// and two causes at one joint are beforehand less likely than one.
double odds_of_pair(const Decision& decision, const FitContext& context, const DecideOptions& options) {
  if (!decision.branch || effect_info(decision.branch->finding.effect).where == Where::arm) return -HUGE_VAL;
  const CurrentModel& first = decision.branch->model;
  const FitContext here = context.with_step(decision.step);
  const auto there = [&](const std::string& place) { return place == decision.branch->finding.place; };
  std::vector<ScreenedEffect> screened = screen_effects(first, here, {there});
  const auto room = static_cast<int>(decision.model.space.size() - first.space.size());
  std::erase_if(screened, [&](const ScreenedEffect& s) { return s.parameters > room; });
  Problem kept = problem_of(decision.model, here, first.weights);
  const double enough =
      kAsGood * kept.residual(decision.model.fit.point, context.experiment.with_role(Role::train)).squaredNorm();
  const bool promising = std::any_of(screened.begin(), screened.end(), [&](const ScreenedEffect& s) {
    return std::min(s.promise, s.sum_of_squares) < enough;
  });
  if (!promising) return -HUGE_VAL;
  const Decision second = decide(first, here, std::move(screened), options);
  if (!second.finding || second.model.space.size() > decision.model.space.size()) return -HUGE_VAL;
  return evidence_over(decision.model, second.model, context.with_step(second.step)) -
         std::log(static_cast<double>(second.candidates.size())) - kNotToldApart;
}

/// The branch in place of the one kept; its second effect is the next round's to find.
void follow_branch(Decision& decision) {
  const Finding& chosen = decision.branch->finding;
  for (Candidate& c : decision.candidates) {
    if (c.note.empty())
      c.note = "two simpler effects have more evidence";
    else if (c.effect == chosen.effect && c.place == chosen.place && c.note == kLessEvidence)
      c.note.clear();
  }
  decision.finding = std::move(decision.branch->finding);
  decision.model = std::move(decision.branch->model);
  decision.finding->probability = 1.0, decision.finding->outside = 0.0;
}

/// Follows the more probable of both, which the other's probability is taken off.
void weigh_pair(Decision& decision, const FitContext& context, const DecideOptions& options) {
  const double odds = odds_of_pair(decision, context, options);
  if (odds > 0.0) follow_branch(decision);
  if (!decision.finding) return;
  const double other = 1.0 / (1.0 + std::exp(std::fabs(odds)));
  decision.finding->probability *= 1.0 - other;
  decision.finding->outside = 1.0 - (1.0 - decision.finding->outside) * (1.0 - other);
}

}  // namespace

Rounds::Rounds(const Scenario& scenario, const FitContext& in, DiagnosisCheckpoint& saved, const CurrentModel& before,
               Diagnosis& out, const Report& report)
    : current(before),
      context(in),
      step(out.before.step),
      scenario_(scenario),
      saved_(saved),
      plain_(before),
      out_(out),
      report_(report) {}

void Rounds::run() {
  while (static_cast<int>(out_.findings.size()) < most_effects() && leaves_something(current, context)) {
    if (!round()) break;
  }
}

int Rounds::most_effects() const {
  return std::max(kMostFindings, kMostAtAJoint * static_cast<int>(context.experiment.joint_names.size()));
}

bool Rounds::round() {
  const int most = most_effects();
  const double share = 0.35 + 0.55 * std::min(done_, most - 1) / most, width = 0.55 / most;
  CurrentModel next = current;
  std::optional<Finding> finding;
  std::vector<Candidate> candidates;
  if (!saved_.restore_round(done_, context, next, finding, candidates)) {
    const std::vector<std::string> joints =
        likely_joints(done_ == 0 ? out_.missing : missing_efforts(current, scenario_, context.simulator, out_.seed));
    const DecideOptions decide_options{out_.seed, static_cast<double>(context.experiment.parts), step.error_over_noise};
    Decision decision = next_decision(current, context, joints, decide_options,
                                      [&](const std::string& stage, double d) { report_(stage, share + width * d); });
    weigh_pair(decision, context, decide_options);
    finding = std::move(decision.finding);
    candidates = std::move(decision.candidates);
    next = std::move(decision.model);
    if (finding) {
      context.simulator.max_step = decision.step;
      describe_evidence(*finding, current, next, context);
    }
    saved_.store_round(next, finding, candidates, context.simulator.max_step);
  }
  ++done_;
  out_.rounds.push_back(std::move(candidates));
  if (!finding) return false;
  out_.findings.push_back(std::move(*finding));
  current = std::move(next);
  refine_step(current, context, step);
  return true;
}

void Rounds::reconsider() {
  // What gave way may have stood for what another finding does: looked at again until nothing gives way.
  for (int pass = 0; pass < kExchanges && exchange_findings(); ++pass) run();
  if (find_anew()) run();
  const std::vector<std::string> unneeded = prune(plain_, current, out_.findings, context);
  for (const std::string& one : unneeded)
    out_.notes.push_back(one + " was found first and taken out again: beside the other findings it is not needed");
  // The only one there ever was has been judged in its round.
  if (out_.findings.size() < 2 && unneeded.empty()) return;
  std::size_t tries = 0;
  for (const std::vector<Candidate>& round : out_.rounds) tries += round.size();
  judge_anew(plain_, current, out_.findings, context, static_cast<int>(tries), out_.seed);
}

bool Rounds::exchange_findings() {
  const std::vector<std::string> changes = exchange(plain_, current, out_.findings, context);
  out_.notes.insert(out_.notes.end(), changes.begin(), changes.end());
  if (changes.empty()) return false;
  refine(current, context, kRefinedIterations);
  refine_step(current, context, step);
  return true;
}

/// What was found before another effect that contains it may stand for what a third one does: an inertia found before
/// its spring, for a lag beside that spring. It is taken out, its numbers go to the other, and one more round says what
/// is missing then; that stands unless the evidence was better before. Whether anything was found anew.
bool Rounds::find_anew() {
  for (std::size_t k = 0; k < out_.findings.size(); ++k) {
    const std::optional<std::size_t> heir = heir_of(k, out_.findings);
    if (!heir) continue;
    const Finding taken = out_.findings[k];
    Without rest = handed_over(k, *heir, plain_, current, out_.findings, context.experiment);
    if (!refit(rest.model, context)) continue;
    const std::tuple before{current, out_.findings, context.simulator.max_step, step};
    current = std::move(rest.model), out_.findings = std::move(rest.findings);
    if (round() && evidence_over(std::get<0>(before), current, context) > -kNotToldApart) {
      const Finding& found = out_.findings.back();
      out_.notes.push_back(fmt::format("{} at {} was looked for anew with its numbers in {}: {} at {}", taken.effect,
                                       taken.place, std::get<1>(before)[*heir].effect, found.effect, found.place));
      return true;
    }
    std::tie(current, out_.findings, context.simulator.max_step, step) = before;
  }
  return false;
}

}  // namespace lacuna
