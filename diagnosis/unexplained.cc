#include "diagnosis/unexplained.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "diagnosis/baseline.h"
#include "diagnosis/coarse.h"
#include "diagnosis/evidence.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/when.h"

namespace lacuna {
namespace {

constexpr double kColourError = 1e-3;       ///< of one joint called coloured whose rest is white
constexpr double kMoreLikelyThanNot = 0.5;  ///< of a class, for the verdict to rest on it
constexpr double kOddsOfNoShare = 1.3;      ///< that a finding is there whose share is next to none
constexpr double kStandInsFall = 2.1;       ///< power of 1 - share with which stand-ins become rarer
constexpr int kFewIterations = 4;           ///< of a set that one finding was taken out of: energies alone are compared

/// The recordings that decide: those that were not fitted, where there are any.
std::vector<int> steering(const Experiment& experiment) {
  const std::vector<int> unseen = experiment.with_role(Role::validate);
  return unseen.empty() ? experiment.with_role(Role::train) : unseen;
}

double energy_of_noise(std::span<const ResidualBlock> blocks, const std::vector<double>& noise) {
  double out = 0.0;
  for (const ResidualBlock& block : blocks) {
    const double one = noise[block.channel];
    if (one > 0.0) out += one * one * static_cast<double>(block.count);
  }
  return out;
}

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

/// Energy over the noise's that a model leaves on some recordings, less what the noise alone would; [joint]. NaN: its
/// noise is unknown.
std::vector<double> excess_by_joint(const CurrentModel& model, const std::vector<double>& weights,
                                    const std::vector<int>& on, const FitContext& context) {
  const Experiment& experiment = context.experiment;
  Problem problem = problem_of(model, context, weights);
  const Eigen::VectorXd r = problem.residual(model.fit.point, on);
  std::vector<double> out;
  for (const JointEnergy& e :
       explained_by_joint(r, r, problem.layout(on), noise_over_weight(experiment, weights), experiment))
    out.push_back(e.rest);
  return out;
}

/// Of one joint; of the arm, all those whose noise is known.
double at_place(const std::vector<double>& by_joint, const std::string& place, const Experiment& experiment) {
  const auto& names = experiment.joint_names;
  const auto at = std::ranges::find(names, place);
  if (at != names.end()) return by_joint[at - names.begin()];
  double sum = 0.0;
  for (const double e : by_joint)
    if (!std::isnan(e)) sum += e;
  return sum;
}

/// A finding's effect, and what is left at its place when it is taken out and all else fitted again.
struct TakenOut {
  std::string effect;
  double left = HUGE_VAL;  ///< as energy over the noise's; infinite where the motion cannot be simulated without it
  std::optional<Hypothesis> without;
};

using Shares = std::map<NamedPlace, double>;  ///< of findings, each in what would be missing at its place without it

/// Of the findings of a place, the largest while they are taken out one after the other, first the one that is missed
/// least. `full`: settled in `sets`.
void add_shares_at(const std::string& place, std::vector<std::string> effects, const Hypothesis& full,
                   const Hypotheses& sets, const std::vector<double>& weights, Shares& out) {
  const Experiment& experiment = sets.context().experiment;
  const std::vector<int> unseen = steering(experiment);
  const auto left = [&](const Hypothesis& set) {
    return at_place(excess_by_joint(set.model, weights, unseen, sets.context()), place, experiment);
  };
  const double rest = left(full);
  double now = rest;
  Hypothesis standing = full;
  while (!effects.empty() && rest > 0.0) {  // not where the noise is unknown
    TakenOut least;
    for (const std::string& effect : effects) {
      TakenOut loss{effect, HUGE_VAL, sets.changed(standing, {{}, {}, {{effect, place}}, {}, {}}, kFewIterations)};
      if (loss.without) loss.left = left(*loss.without);
      const double removed = std::max(0.0, loss.left - now);
      double& share = out[{effect, place}];
      share = std::max(share, std::isfinite(removed) ? removed / (removed + rest) : 1.0);
      if (loss.left < least.left) least = std::move(loss);
    }
    if (!least.without) break;  // none of these can be missed
    now = least.left, standing = std::move(*least.without);
    std::erase(effects, least.effect);
  }
}

/// Those beside a rest whose size is known.
Shares shares_explained(const std::vector<Finding>& findings, const CurrentModel& before, const CurrentModel& after,
                        const FitContext& context) {
  const Enough enough(after, context);
  const FitContext& here = enough.context();
  const CurrentModel plain = seen_in(before, here);
  const Hypothesis full{effects_beyond(before.model, after), seen_in(after, here)};
  Hypotheses sets(plain, here);
  sets.settle(full);
  std::map<std::string, std::vector<std::string>> at;
  for (const Finding& finding : findings) at[finding.place].push_back(finding.effect);
  Shares out;
  for (const auto& [place, effects] : at) add_shares_at(place, effects, full, sets, plain.weights, out);
  return out;
}

/// That a finding of that share is there, and not what explains the rest in its place.
double chance_of_being_there(double share) {
  return 1.0 / (1.0 + std::pow(std::max(0.0, 1.0 - share), kStandInsFall) / kOddsOfNoShare);
}

void leave_room(std::vector<Finding>& findings, const Shares& shares) {
  for (Finding& finding : findings) {
    const auto share = shares.find({finding.effect, finding.place});
    if (share == shares.end()) continue;
    finding.explained = share->second;
    const double chance = chance_of_being_there(share->second);
    finding.probability *= chance;
    for (Rival& rival : finding.rivals) rival.probability *= chance;
  }
}

/// The rest's share of what was missing at all joints together.
double unknown_share(const std::vector<JointEnergy>& joints) {
  JointEnergy all;
  for (const JointEnergy& e : joints)
    if (!std::isnan(e.rest)) all.removed += std::max(0.0, e.removed), all.rest += std::max(0.0, e.rest);
  return unknown_share(all);
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

/// The joints whose rest is more than noise, by its energy or, where that is unknown, by its colour; and when.
void say_where(Unexplained& out, const Eigen::VectorXd& rest, std::span<const ResidualBlock> blocks,
               const std::vector<double>& noise, const Experiment& experiment) {
  const std::vector<Channel>& channels = experiment.channels;
  const auto say = [&](int channel) -> const std::string& {
    const std::string& joint = experiment.joint_names[channels[channel].joint];
    if (std::ranges::find(out.where, joint) == out.where.end()) out.where.push_back(joint);  // of several channels once
    return joint;
  };
  for (const ExcessNoise& excess : excess_over_noise(rest, blocks, noise)) say(excess.channel);
  if (!out.where.empty()) {
    std::vector<int> joints;
    for (const Channel& channel : channels) joints.push_back(channel.joint);
    out.times = misfits(rest, blocks, noise, joints, experiment);
  }
  for (const int c : coloured_beyond_noise(rest, blocks, noise, out.where, experiment))
    out.regions.push_back(say(c) + ": the rest is not white; its noise level is unknown");
}

}  // namespace

void judge_rest(Diagnosis& out, const CurrentModel& before, const CurrentModel& after, const FitContext& context) {
  const Experiment& experiment = context.experiment;
  const std::vector<int> unseen = steering(experiment);
  Problem a = problem_of(before, context);
  Problem b = problem_of(after, context, before.weights);
  const Eigen::VectorXd r0 = a.residual(before.fit.point, unseen), r1 = b.residual(after.fit.point, unseen);
  const auto blocks = a.layout(unseen);
  const std::vector<double> noise = noise_over_weight(experiment, before.weights);
  say_where(out.unexplained, r1, blocks, noise, experiment);
  out.unexplained.share =
      std::max(0.0, r1.squaredNorm() - energy_of_noise(blocks, noise)) / std::max(r0.squaredNorm(), 1e-300);
  out.unexplained.present = !out.unexplained.where.empty();
  const std::vector<JointEnergy> energies = explained_by_joint(r0, r1, blocks, noise, experiment);
  out.unexplained.per_joint = rest_by_joint(energies, out.unexplained, experiment);
  if (out.unexplained.present) {
    out.unexplained.probability = unknown_share(energies);
    leave_room(out.findings, shares_explained(out.findings, before, after, context));
  }
  const bool claimed = std::ranges::any_of(
      out.findings, [](const Finding& f) { return class_probability(f) > kMoreLikelyThanNot && explains_most(f); });
  out.verdict = out.unexplained.present && !claimed ? Verdict::unknown_physics
                : out.findings.empty()              ? Verdict::consistent
                                                    : Verdict::missing_physics;
}

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

}  // namespace lacuna
