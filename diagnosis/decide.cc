#include "diagnosis/decide.h"

#include <algorithm>

#include "diagnosis/baseline.h"
#include "diagnosis/kin.h"
#include "diagnosis/ranking.h"

namespace lacuna {
namespace {

constexpr double kPromising = 0.9;  ///< share of energy left under which a start is re-identified whatever its chance
constexpr std::size_t kShortlist = 4;
constexpr std::size_t kPromisingTried = 5;  ///< of those that the linear look promised most
constexpr int kKinRounds = 3;
constexpr double kNearly = 0.95;         ///< share of the best one's share of energy
constexpr double kChanceLikelier = 0.5;  ///< probability of chance from which nothing is claimed

Candidate candidate_record(const Tried& tried, const std::string& note) {
  return {tried.effect.spec.effect,
          tried.effect.spec.place,
          tried.train.log_likelihood,
          tried.heldout.gain,
          tried.heldout.error,
          tried.heldout.share,
          tried.p_value,
          tried.effect.parameters,
          note};
}

/// Screening follows many candidates for a few cheap steps and may lose one whose parameters lie far off. Those that
/// the linear look promised most are therefore re-identified in full, too.
void refit_promising(Judge& judge, std::vector<Tried>& tried) {
  std::vector<Tried*> order;
  for (Tried& t : tried) order.push_back(&t);
  std::stable_sort(order.begin(), order.end(),
                   [](const Tried* a, const Tried* b) { return a->effect.promise < b->effect.promise; });
  order.resize(std::min(kPromisingTried, order.size()));
  std::erase_if(order, [&](const Tried* t) { return judge.promised_rest(*t) >= kPromising || !judge.disappoints(*t); });
  judge.share(order, [&](Tried& t) { judge.refit_from_first_look(t); });
}

/// Puts it in place of itself where it is the better end.
void take_in(std::vector<Tried>& tried, Tried found) {
  const auto same = std::find_if(tried.begin(), tried.end(), [&](const Tried& t) {
    return t.effect.spec.effect == found.effect.spec.effect && t.effect.spec.place == found.effect.spec.place &&
           t.effect.spec.recordings == found.effect.spec.recordings && t.effect.parameters == found.effect.parameters;
  });
  if (same == tried.end()) {
    tried.push_back(std::move(found));
  } else if (found.effect.residual.squaredNorm() < same->effect.residual.squaredNorm()) {
    *same = std::move(found);
  }
}

/// The strongest one's kin, those that do not do as well yet, from where it stands; and again if one of them is the
/// strongest then.
void refit_kin(Judge& judge, const CurrentModel& current, std::vector<Tried>& tried, double integration_error) {
  std::string last;
  for (int round = 0; round < kKinRounds && !tried.empty(); ++round) {
    const Tried strongest = tried.front();
    const EffectSpec& spec = strongest.effect.spec;
    if (!strongest.refitted || strongest.p_value > kChance || spec.effect == last) return;
    last = spec.effect;
    const EffectInfo& info = effect_table()[find_effect(spec.effect)];
    std::vector<Tried> found;
    for (const EffectInfo& kin : effect_table()) {
      if (!are_kin(info, kin) || current.model.find_effect_at(kin.name, spec.place) >= 0) continue;
      const bool as_good = std::any_of(tried.begin(), tried.end(), [&](const Tried& t) {
        return t.effect.spec.effect == kin.name && t.effect.spec.place == spec.place &&
               t.effect.residual.squaredNorm() <= strongest.effect.residual.squaredNorm();
      });
      if (as_good) continue;
      for (Tried& one : judge.kin_of(strongest, kin)) found.push_back(std::move(one));
    }
    std::vector<Tried*> each;
    for (Tried& one : found) each.push_back(&one);
    std::vector<char> reached(found.size());
    judge.share(each, [&](Tried& one) { reached[&one - found.data()] = judge.refit(one); });
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (reached[k]) take_in(tried, std::move(found[k]));
    }
    sort_by_evidence(tried, integration_error);
  }
}

/// The best candidate and those that explain nearly as much and are no further behind than integration errors could
/// feign.
std::vector<Tried*> rivals_by_a_hair(const Judge& judge, std::vector<Tried>& tried) {
  std::vector<Tried*> out;
  double first_doubt = 0.0;
  for (Tried& t : tried) {
    if (!t.refitted || t.train.share < kNearly * tried.front().train.share || !judge.objection(t).empty()) continue;
    const double doubt = judge.doubt(t);
    if (out.empty()) first_doubt = doubt;
    if (!out.empty() && out.front()->evidence - t.evidence > first_doubt + doubt + kNotToldApart) continue;
    out.push_back(&t);
    if (out.size() == kShortlist) break;
  }
  return out;
}

/// Candidates that are told apart by less than the integration error at the present model's step, because one of them
/// needs a finer one, are re-identified at that. Whether any was.
bool sharpen(Judge& judge, std::vector<Tried>& tried) {
  const std::vector<Tried*> close = rivals_by_a_hair(judge, tried);
  double step = judge.step();
  for (const Tried* t : close) step = std::min(step, judge.step_for(*t));
  if (step >= judge.step()) return false;
  judge.set_step(step);
  if (close.size() < 2) return false;
  judge.share(close, [&](Tried& t) { judge.follow(t); });
  return true;
}

std::optional<Branch> branch_of(const std::vector<Tried>& tried, std::size_t winner, std::uint64_t seed) {
  const EffectSpec& kept = tried[winner].effect.spec;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const Tried& t = tried[k];
    if (t.refitted && t.objection.empty() && t.effect.spec.effect != kept.effect && t.effect.spec.place == kept.place &&
        t.effect.spec.recordings == kept.recordings && t.effect.parameters < tried[winner].effect.parameters)
      return Branch{make_finding(tried, k, seed), t.model};
  }
  return std::nullopt;
}

}  // namespace

Decision decide(const CurrentModel& current, const FitContext& context, std::vector<ScreenedEffect> screened,
                const DecideOptions& options) {
  const double tries = options.choices * static_cast<double>(screened.size());
  Judge judge(current, context, static_cast<int>(std::ceil(tries)));
  std::vector<Tried> tried;
  for (ScreenedEffect& effect : screened) tried.push_back(judge.weigh(std::move(effect)));
  sort_by_evidence(tried, options.integration_error);
  std::vector<Tried*> shortlist;
  for (std::size_t k = 0; k < std::min(kShortlist, tried.size()); ++k) {
    if (tried[k].p_value < kChance || tried[k].train.share > 1.0 - kPromising) shortlist.push_back(&tried[k]);
  }
  judge.share(shortlist, [&](Tried& t) { judge.refit(t); });
  refit_promising(judge, tried);
  sort_by_evidence(tried, options.integration_error);
  if (!tried.empty() && tried.front().refitted) {
    if (std::optional<Tried> free = judge.freed(tried.front())) tried.push_back(std::move(*free));
  }
  sort_by_evidence(tried, options.integration_error);
  refit_kin(judge, current, tried, options.integration_error);
  const bool sharpened = sharpen(judge, tried);
  sort_by_evidence(tried, options.integration_error);
  // At a finer step one of them may have come much further: its kin follow.
  if (sharpened) refit_kin(judge, current, tried, options.integration_error);
  Decision out{{}, std::nullopt, current, context.simulator.max_step, std::nullopt};
  const std::optional<std::size_t> winner = strongest_that_can(judge, tried, options.integration_error);
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const bool could = tried[k].objection.empty() && k != winner;
    out.candidates.push_back(candidate_record(tried[k], could ? kLessEvidence : tried[k].objection));
  }
  if (!winner) return out;
  Finding finding = make_finding(tried, *winner, options.seed);
  if (finding.outside > kChanceLikelier) {
    out.candidates[*winner].note = "more probably chance";
    return out;
  }
  out.finding = std::move(finding);
  // A rival's finer step served the comparison only.
  out.step = std::max(judge.step(), std::min(out.step, judge.step_for(tried[*winner])));
  out.branch = branch_of(tried, *winner, options.seed);
  out.model = tried[*winner].model;
  refine(out.model, context.with_step(out.step));
  return out;
}

}  // namespace lacuna
