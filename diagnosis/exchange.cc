#include "diagnosis/exchange.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/baseline.h"
#include "diagnosis/decide.h"
#include "diagnosis/evidence.h"
#include "diagnosis/where.h"
#include "diagnosis/without.h"
#include "diagnosis/worth.h"

namespace lacuna {
namespace {

constexpr double kLead = 1.0;  ///< log-evidence that a rival must be ahead by to take the place

/// A member of one finding's contest beside the other findings.
struct Entrant {
  Rival rival;
  CurrentModel model;
  double evidence = 0.0;  ///< over that of the finding as it stands
};

/// Both residuals of a model, in the weights of another.
struct Seen {
  Seen(const CurrentModel& model, const CurrentModel& weighed_by, const Experiment& experiment,
       const SimulatorOptions& options) {
    Problem problem(model.model, experiment, model.space, options, weighed_by.weights);
    train = problem.residual(model.fit.point, experiment.with_role(Role::train));
    const std::vector<int> held_out = experiment.with_role(Role::validate);
    if (!held_out.empty()) validate = problem.residual(model.fit.point, held_out);
  }

  Eigen::VectorXd train, validate;
  double energy() const { return train.squaredNorm() + validate.squaredNorm(); }
};

/// Log-likelihood that `other` is worth over `standing`, negative where it is worse, at the effective samples of the
/// better of the two, less Schwarz's penalty for each of its `parameters` more.
double evidence_of(const Seen& standing, const Seen& other, double parameters, const CurrentModel& current,
                   const Experiment& experiment, const SimulatorOptions& options) {
  const Problem problem(current.model, experiment, current.space, options, current.weights);
  const bool better = other.energy() < standing.energy();
  const Seen &worse = better ? standing : other, &best = better ? other : standing;
  const Gain train = residual_gain(worse.train, best.train, problem.layout(experiment.with_role(Role::train)));
  double gain = train.log_likelihood;
  const std::vector<int> held_out = experiment.with_role(Role::validate);
  if (!held_out.empty()) gain += residual_gain(worse.validate, best.validate, problem.layout(held_out)).log_likelihood;
  return (better ? gain : -gain) - 0.5 * parameters * std::log(std::max(2.0, train.effective));
}

double more_parameters(const CurrentModel& other, const CurrentModel& standing) {
  return static_cast<double>(other.space.size()) - static_cast<double>(standing.space.size());
}

class Arena {
 public:
  Arena(const CurrentModel& plain, const Experiment& experiment, const SimulatorOptions& options,
        const RunControl& control)
      : plain_(plain), experiment_(experiment), options_(options), control_(control) {}

  /// The rivals of finding k in its place, those that can be simulated, most evidence first.
  std::vector<Entrant> contest(std::size_t k, const CurrentModel& current, const std::vector<Finding>& findings) const {
    const Seen standing(current, current, experiment_, options_);
    std::vector<Entrant> out;
    for (const Rival& rival : findings[k].rivals) {
      const bool there = std::any_of(findings.begin(), findings.end(), [&](const Finding& f) {
        return f.effect == rival.effect && f.place == rival.place;
      });
      if (there) continue;
      std::optional<CurrentModel> model =
          exchanged(k, rival, plain_, current, findings, experiment_, options_, control_);
      if (!model) continue;
      const Seen other(*model, current, experiment_, options_);
      const double evidence =
          evidence_of(standing, other, more_parameters(*model, current), current, experiment_, options_);
      if (std::isfinite(evidence)) out.push_back({rival, std::move(*model), evidence});
    }
    std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.evidence > b.evidence; });
    return out;
  }

  /// Everything that is said of finding k beside its effect, place and class.
  void judge(std::size_t k, Finding& finding, const CurrentModel& current, const std::vector<Finding>& findings,
             int tries, std::uint64_t seed) const {
    CurrentModel rest = rebuilt(plain_, current, findings, experiment_, k);
    if (!refit(rest, experiment_, options_, control_)) return;
    const Worth worth = worth_over(current, rest, experiment_, options_);
    const HeldoutGain heldout = worth.heldout.value_or(HeldoutGain{});
    finding.p_value = worth.chance(tries);
    finding.heldout_gain = heldout.gain, finding.heldout_error = heldout.error, finding.heldout_share = heldout.share;
    finding.stability = stability(heldout.blocks, std::vector<double>(heldout.blocks.size(), 0.0), seed);
    describe_evidence(finding, rest, current, experiment_, options_);
  }

 private:
  const CurrentModel& plain_;
  const Experiment& experiment_;
  const SimulatorOptions& options_;
  const RunControl& control_;
};

/// The finding as a rival of whatever takes its place.
Rival as_rival(const Finding& finding, const CurrentModel& current) {
  Rival out{finding.effect, finding.place, 0.0, finding.fixed, {}, finding.recordings};
  const int at = current.model.find_effect_at(finding.effect, finding.place);
  const Component& component = current.model.effects()[static_cast<std::size_t>(at)];
  for (std::size_t a = 0; a < current.space.size(); ++a) {
    const int parameter = current.space.axes()[a].parameter;
    if (parameter >= component.first && parameter < component.first + component.count)
      out.own.push_back(current.fit.point[a]);
  }
  return out;
}

/// Probability, rivals and class of `finding`, whose evidence is 0, among it and the entrants; the share of what
/// takes no part stays what it was.
void settle(Finding& finding, const std::vector<Entrant>& entrants) {
  double most = 0.0;
  for (const Entrant& e : entrants) most = std::max(most, e.evidence);
  const auto weight = [&](double evidence) { return std::exp(std::max(evidence - most, -700.0)); };
  double total = weight(0.0);
  for (const Entrant& e : entrants) total += weight(e.evidence);
  total /= 1.0 - std::min(finding.outside, 0.999);
  finding.probability = weight(0.0) / total;
  finding.members = {finding.effect};
  finding.rivals.clear();
  for (const Entrant& e : entrants) {
    finding.rivals.push_back(e.rival);
    finding.rivals.back().probability = weight(e.evidence) / total;
    if (e.rival.place == finding.place && -e.evidence < kClassLoss) finding.members.push_back(e.rival.effect);
  }
}

}  // namespace

double evidence_over(const CurrentModel& standing, const CurrentModel& other, const Experiment& experiment,
                     const SimulatorOptions& options) {
  const Seen one(standing, standing, experiment, options), two(other, standing, experiment, options);
  if (!two.train.allFinite() || !two.validate.allFinite()) return -HUGE_VAL;
  return evidence_of(one, two, more_parameters(other, standing), standing, experiment, options);
}

std::optional<CurrentModel> exchanged(std::size_t which, const Rival& rival, const CurrentModel& plain,
                                      const CurrentModel& current, const std::vector<Finding>& findings,
                                      const Experiment& experiment, const SimulatorOptions& options,
                                      const RunControl& control) {
  const EffectSpec spec{rival.effect, rival.place, rival.fixed, rival.recordings, rival.effect};
  CurrentModel out = rebuilt(plain, current, findings, experiment, which, &spec, rival.own);
  if (!refit(out, experiment, options, control)) return std::nullopt;
  return out;
}

std::vector<std::string> exchange(const CurrentModel& plain, CurrentModel& current, std::vector<Finding>& findings,
                                  const Experiment& experiment, const SimulatorOptions& options,
                                  const RunControl& control, int tries, std::uint64_t seed) {
  std::vector<std::string> changes;
  if (findings.size() < 2) return changes;
  const Arena arena(plain, experiment, options, control);
  // The first pass exchanges, the second looks once more at what stands then.
  for (const bool last : {false, true}) {
    for (std::size_t k = 0; k < findings.size(); ++k) {
      Finding& finding = findings[k];
      std::vector<Entrant> entrants = arena.contest(k, current, findings);
      if (entrants.empty()) continue;
      if (!last && entrants.front().evidence > kLead) {
        const Entrant winner = entrants.front();
        entrants.front() = {as_rival(finding, current), current, 0.0};
        for (Entrant& e : entrants) e.evidence -= winner.evidence;
        changes.push_back(fmt::format("{} at {} gave way to {} at {}, which explains more beside the other findings",
                                      finding.effect, finding.place, winner.rival.effect, winner.rival.place));
        finding.effect = winner.rival.effect, finding.place = winner.rival.place;
        finding.fixed = winner.rival.fixed, finding.recordings = winner.rival.recordings;
        current = winner.model;
        arena.judge(k, finding, current, findings, tries, seed);
      }
      settle(finding, entrants);
    }
    if (changes.empty()) break;
  }
  return changes;
}

}  // namespace lacuna
