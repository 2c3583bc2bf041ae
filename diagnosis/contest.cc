#include "diagnosis/contest.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/baseline.h"
#include "diagnosis/decide.h"
#include "diagnosis/evidence.h"
#include "diagnosis/judge.h"
#include "diagnosis/without.h"

namespace lacuna {
namespace {

/// Both residuals of a model, in the weights of another.
struct Seen {
  Seen(const CurrentModel& model, const CurrentModel& weighed_by, const FitContext& context) {
    Problem problem = problem_of(model, context, weighed_by.weights);
    train = problem.residual(model.fit.point, context.experiment.with_role(Role::train));
    const std::vector<int> held_out = context.experiment.with_role(Role::validate);
    if (!held_out.empty()) validate = problem.residual(model.fit.point, held_out);
  }

  Eigen::VectorXd train, validate;
  double energy() const { return train.squaredNorm() + validate.squaredNorm(); }
};

/// Log-likelihood that `other` is worth over `standing`, negative where it is worse, at the effective samples of the
/// better of the two, less Schwarz's penalty for each of its `parameters` more.
double evidence_of(const Seen& standing, const Seen& other, double parameters, const CurrentModel& current,
                   const FitContext& context) {
  const Problem problem = problem_of(current, context);
  const bool better = other.energy() < standing.energy();
  const Seen &worse = better ? standing : other, &best = better ? other : standing;
  const Gain train = residual_gain(worse.train, best.train, problem.layout(context.experiment.with_role(Role::train)));
  double gain = train.log_likelihood;
  const std::vector<int> held_out = context.experiment.with_role(Role::validate);
  if (!held_out.empty()) gain += residual_gain(worse.validate, best.validate, problem.layout(held_out)).log_likelihood;
  return (better ? gain : -gain) - 0.5 * parameters * std::log(std::max(2.0, train.effective));
}

bool is_at_end(const CurrentModel& model, const Rival& rival, const Experiment& experiment) {
  const int at = model.model.find_effect_at(rival.effect, rival.place);
  return at_end(model, model.model.effects()[at], experiment);
}

double more_parameters(const CurrentModel& other, const CurrentModel& standing) {
  return static_cast<double>(other.space.size()) - static_cast<double>(standing.space.size());
}

}  // namespace

double evidence_over(const CurrentModel& standing, const CurrentModel& other, const FitContext& context) {
  const Seen one(standing, standing, context), two(other, standing, context);
  if (!two.train.allFinite() || !two.validate.allFinite()) return -HUGE_VAL;
  return evidence_of(one, two, more_parameters(other, standing), standing, context);
}

std::optional<CurrentModel> exchanged(std::size_t which, const Rival& rival, const CurrentModel& plain,
                                      const CurrentModel& current, const std::vector<Finding>& findings,
                                      const FitContext& context) {
  const bool stands = std::any_of(findings.begin(), findings.end(),
                                  [&](const Finding& f) { return f.effect == rival.effect && f.place == rival.place; });
  if (stands) return std::nullopt;
  const EffectSpec spec{rival.effect, rival.place, rival.fixed, rival.recordings, rival.effect};
  CurrentModel out = rebuilt(plain, current, findings, context.experiment, which, &spec, rival.own);
  if (!refit(out, context)) return std::nullopt;
  return out;
}

std::vector<Entrant> contest(std::size_t which, const CurrentModel& plain, const CurrentModel& current,
                             const std::vector<Finding>& findings, const FitContext& context) {
  const Seen standing(current, current, context);
  std::vector<Entrant> out;
  for (const Rival& rival : findings[which].rivals) {
    std::optional<CurrentModel> model = exchanged(which, rival, plain, current, findings, context);
    if (!model || is_at_end(*model, rival, context.experiment)) continue;
    const Seen other(*model, current, context);
    const double evidence = evidence_of(standing, other, more_parameters(*model, current), current, context);
    if (std::isfinite(evidence)) out.push_back({rival, std::move(*model), evidence});
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.evidence > b.evidence; });
  return out;
}

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
    if (e.rival.place == finding.place && -e.evidence < kNotToldApart) finding.members.push_back(e.rival.effect);
  }
}

}  // namespace lacuna
