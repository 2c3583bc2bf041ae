#include "diagnosis/ranking.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lacuna {

void sort_by_evidence(std::vector<Tried>& tried, double integration_error) {
  if (tried.empty()) return;
  auto own = [](const Tried& t) {
    const double both = t.train.log_likelihood + t.heldout.gain;
    return std::isfinite(both) ? both : -HUGE_VAL;
  };
  const Tried& strongest =
      *std::max_element(tried.begin(), tried.end(), [&](const Tried& a, const Tried& b) { return own(a) < own(b); });
  const Gain train = strongest.train, heldout = strongest.heldout.whole;
  const double resolution =
      0.5 * (train.effective + heldout.effective) * std::log1p(integration_error * integration_error);
  double most = -HUGE_VAL;
  for (Tried& t : tried) {
    t.evidence = t.train.at(train) + t.heldout.whole.at(heldout);
    if (!std::isfinite(t.evidence)) t.evidence = -HUGE_VAL;  // diverges on a recording that was not fitted
    most = std::max(most, t.evidence);
  }
  const double worth = 0.5 * std::log(std::max(2.0, train.effective));  // of one parameter
  for (Tried& t : tried) {
    t.over_chance = t.evidence - worth * t.effect.parameters;
    t.evidence = std::min(t.evidence + resolution, most) - worth * t.effect.parameters;
  }
  std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) { return a.evidence > b.evidence; });
}

namespace {

/// A special case that cannot be told from what it is a case of has its evidence, and stands before it.
void lift_special_cases(const Judge& judge, std::vector<Tried>& tried) {
  std::vector<double> lifted;
  for (const Tried& special : tried) {
    lifted.push_back(special.evidence);
    if (!special.objection.empty() || !special.refitted) continue;
    for (const Tried& rich : tried)
      if (rich.objection.empty() && judge.cannot_tell(special, rich))
        lifted.back() = std::max(lifted.back(), rich.evidence);
  }
  for (std::size_t k = 0; k < tried.size(); ++k) tried[k].evidence = lifted[k];
  std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) {
    return a.evidence > b.evidence || (a.evidence == b.evidence && a.effect.parameters < b.effect.parameters);
  });
}

}  // namespace

std::optional<std::size_t> strongest_that_can(Judge& judge, std::vector<Tried>& tried, double integration_error) {
  for (;;) {
    for (Tried& t : tried) t.objection = judge.objection(t);
    lift_special_cases(judge, tried);
    const auto first = std::find_if(tried.begin(), tried.end(), [](const Tried& t) { return t.objection.empty(); });
    if (first == tried.end()) return std::nullopt;
    if (first->refitted) return static_cast<std::size_t>(first - tried.begin());
    // What it is worth once re-identified may be another's place.
    judge.refit(*first);
    sort_by_evidence(tried, integration_error);
  }
}

std::vector<double> probabilities(const std::vector<Tried>& tried) {
  double most = -HUGE_VAL, over_chance = -HUGE_VAL;
  for (const Tried& t : tried) {
    if (!t.objection.empty()) continue;
    most = std::max(most, t.evidence), over_chance = std::max(over_chance, t.over_chance);
  }
  double total = static_cast<double>(tried.size()) * std::exp(std::clamp(-over_chance, -700.0, 600.0));
  std::vector<double> out;
  for (const Tried& t : tried) {
    out.push_back(t.objection.empty() ? std::exp(std::max(t.evidence - most, -700.0)) : 0.0);
    total += out.back();
  }
  for (double& p : out) p /= total;
  return out;
}

Finding make_finding(const std::vector<Tried>& tried, std::size_t winner, std::uint64_t seed) {
  const Tried& best = tried[winner];
  const std::vector<double> probability = probabilities(tried);
  Finding out;
  out.effect = best.effect.spec.effect;
  out.place = best.effect.spec.place;
  out.recordings = best.effect.spec.recordings;
  out.fixed = best.effect.spec.parameters;
  out.probability = probability[winner];
  out.outside = 1.0 - std::accumulate(probability.begin(), probability.end(), 0.0);
  out.p_value = best.p_value;
  out.heldout_gain = best.heldout.gain;
  out.heldout_error = best.heldout.error;
  out.heldout_share = best.heldout.share;
  out.members.push_back(out.effect);
  const std::vector<double>* elsewhere = nullptr;  // the strongest rival at another place
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const EffectSpec& spec = tried[k].effect.spec;
    const bool same = spec.effect == out.effect && spec.place == out.place;
    if (k == winner) continue;
    if (same) {  // the same effect in other recordings: one hypothesis with the winner
      out.probability += probability[k];
      continue;
    }
    if (!tried[k].objection.empty()) continue;
    const auto listed = std::find_if(out.rivals.begin(), out.rivals.end(), [&](const Rival& rival) {
      return rival.effect == spec.effect && rival.place == spec.place;
    });
    if (listed != out.rivals.end()) {  // another variant of it, behind the first
      listed->probability += probability[k];
      continue;
    }
    if (out.rivals.size() < 5)
      out.rivals.push_back(
          {spec.effect, spec.place, probability[k], spec.parameters, tried[k].effect.own, spec.recordings});
    if (spec.place == out.place && best.evidence - tried[k].evidence < kNotToldApart)
      out.members.push_back(spec.effect);
    if (spec.place != out.place && !elsewhere) elsewhere = &tried[k].heldout.blocks;
  }
  const std::vector<double> nothing(best.heldout.blocks.size(), 0.0);
  out.stability = stability(best.heldout.blocks, elsewhere != nullptr ? *elsewhere : nothing, seed);
  return out;
}

}  // namespace lacuna
