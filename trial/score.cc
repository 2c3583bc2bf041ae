#include "trial/score.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>

#include "physics/catalogue.h"
#include "study/statistics.h"

namespace lacuna {
namespace {

constexpr double kLeastEnergy = 0.02;  // of the noise': below it there is no gain to have a share of
constexpr double kClaimed = 0.9;       // probability from which on a claim is held to 97 %
constexpr double kCalibrationEdges[] = {0.0, 0.5, 0.7, 0.9, 0.97, 1.0 + 1e-9};
constexpr double kStrengthEdges[] = {0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 1e300};

bool is_foreign(const BlindLabel::Effect& hidden) { return find_effect(hidden.effect) < 0; }

bool is_outside(const BlindLabel& label) { return std::any_of(label.effects.begin(), label.effects.end(), is_foreign); }

bool covers(const BlindVerdict::Claim& claim, const BlindLabel::Effect& hidden) {
  const bool member = std::find(claim.members.begin(), claim.members.end(), hidden.effect) != claim.members.end();
  return claim.place == hidden.place && (claim.effect == hidden.effect || member);
}

/// Which claims are true; each hidden effect makes at most one claim true.
std::vector<bool> true_claims(const BlindVerdict& verdict, const BlindLabel& label) {
  std::vector<bool> out(verdict.claims.size(), false), used(label.effects.size(), false);
  for (const bool exact : {true, false}) {
    for (std::size_t c = 0; c < out.size(); ++c) {
      for (std::size_t h = 0; h < used.size() && !out[c]; ++h) {
        const BlindVerdict::Claim& claim = verdict.claims[c];
        if (used[h] || !covers(claim, label.effects[h])) continue;
        if (exact && claim.effect != label.effects[h].effect) continue;
        out[c] = used[h] = true;
      }
    }
  }
  return out;
}

/// Whether a claim that covers nothing hidden is true all the same.
bool true_besides(const BlindVerdict::Claim& claim, const BlindLabel& label) {
  const int type = find_effect(claim.effect);
  if (type < 0) return false;
  if (label.has("misplaced") && (claim.effect == "com_shift" || claim.effect == "rigid_body")) return true;
  if (!label.has("uneven") && !label.has("drift")) return false;
  const auto stage = [](int effect) { return effect_table()[effect].stage; };
  return std::ranges::any_of(label.effects, [&](const BlindLabel::Effect& hidden) {
    const int law = find_effect(hidden.effect);
    return law >= 0 && hidden.place == claim.place && stage(law) == stage(type);
  });
}

/// Share of the energy above the noise that the diagnosed model removes; an oracle would leave the noise alone.
double gain_share(const BlindVerdict& verdict) {
  double gained = 0.0, possible = 0.0, joints = 0.0;
  for (const auto& [joint, before] : verdict.before) {
    const double noise = entry_of(verdict.noise, joint), after = entry_of(verdict.after, joint);
    if (!(noise > 0.0) || !std::isfinite(after)) continue;
    gained += (before * before - after * after) / (noise * noise);
    possible += before * before / (noise * noise) - 1.0;
    joints += 1.0;
  }
  return possible > kLeastEnergy * joints ? gained / possible : std::nan("");
}

CaseKind kind_of(const BlindLabel& label) {
  if (label.effects.empty()) return CaseKind::null;
  if (is_outside(label)) return CaseKind::outside;
  return label.effects.size() == 1 ? CaseKind::single : CaseKind::several;
}

std::string largest_residual(const BlindVerdict& verdict) {
  std::string out;
  double most = 0.0;
  for (const auto& [joint, rms] : verdict.train) {
    const double ratio = rms / entry_of(verdict.noise, joint);
    if (ratio > most) most = ratio, out = joint;
  }
  return out;
}

/// The candidate of the best Schwarz criterion on the train recordings; null where none beats the plain model.
const BlindVerdict::Tried* best_by_bic(const BlindVerdict& verdict) {
  const BlindVerdict::Tried* out = nullptr;
  double most = 0.0;
  for (const BlindVerdict::Tried& tried : verdict.first_round) {
    const double value = tried.train_gain - 0.5 * tried.parameters * std::log(std::max(2.0, verdict.effective_samples));
    if (value > most) most = value, out = &tried;
  }
  return out;
}

void add_baselines(const BlindCase& one, CaseKind kind, Baselines& out) {
  if (!one.verdict) return;
  const BlindVerdict::Tried* bic = best_by_bic(*one.verdict);
  if (kind == CaseKind::null) out.bic_false_alarms.add(bic != nullptr);
  if (kind != CaseKind::single) return;
  const BlindLabel::Effect& hidden = one.label->effects.front();
  if (!of_whole_arm(hidden.effect)) out.largest_residual_location.add(largest_residual(*one.verdict) == hidden.place);
  out.bic_location.add(bic != nullptr && bic->place == hidden.place);
  out.bic_effect.add(bic != nullptr && bic->place == hidden.place && bic->effect == hidden.effect);
}

/// The first claim, or the verdict where there is none; "elsewhere" keeps a wrong place from looking right.
std::string said(const BlindCase& one) {
  if (!one.verdict) return "no verdict";
  if (one.verdict->claims.empty()) return one.verdict->verdict;
  const BlindVerdict::Claim& claim = one.verdict->claims.front();
  const bool single = one.label->effects.size() == 1;
  return claim.effect + (single && claim.place != one.label->effects.front().place ? ", elsewhere" : "");
}

void add_law(const BlindLabel::Effect& hidden, const LawScore& law, const CaseScore& score, bool verdict,
             LawTotals& out) {
  out.unknown.add(score.correct);
  out.place.add(law.place);
  if (!verdict || std::isfinite(score.rest_over_noise)) out.at_noise.add(verdict && score.rest_over_noise <= kAtNoise);
  if (!hidden.law) return;
  out.stage.add(law.stage);
  out.over.add(law.over);
  out.curves += !hidden.law->curve.empty();
  if (std::isfinite(law.curve_error)) out.curve_errors.push_back(law.curve_error);
  for (int k = 0; k < law.events; ++k) out.events.add(k < law.found);
}

void add_laws(const BlindCase& one, const CaseScore& score, BlindTotals& out) {
  const bool verdict = one.verdict.has_value(), learned = verdict && !one.verdict->learned.empty();
  const bool exact = !one.label->inexact();
  if (exact && score.kind == CaseKind::null) out.false_laws_null.add(learned);
  if (exact && (score.kind == CaseKind::single || score.kind == CaseKind::several)) out.false_laws_exact.add(learned);
  if (score.kind != CaseKind::outside) return;
  std::size_t k = 0;
  int found = 0, claimed = 0;
  for (const BlindLabel::Effect& hidden : one.label->effects) {
    if (!is_foreign(hidden)) continue;
    const LawScore& law = score.laws[k++];
    found += law.found;
    add_law(hidden, law, score, verdict, out.laws);
    add_law(hidden, law, score, verdict, out.laws_of[hidden.effect]);
  }
  for (std::size_t i = 0; learned && i < one.verdict->learned.size(); ++i)
    claimed += static_cast<int>(one.verdict->learned[i].law.events.size());
  for (int i = 0; i < claimed; ++i) out.events_true.add(i < found);
}

void add_case(const BlindCase& one, BlindTotals& out) {
  const CaseScore score = score_case(one);
  const bool verdict = one.verdict.has_value();
  ++out.labelled;
  out.correct.add(score.correct);
  if (score.kind == CaseKind::null) out.null_false_alarms.add(verdict && !score.correct);
  if (score.kind == CaseKind::outside) out.abstained_correctly.add(score.correct);
  if (score.kind == CaseKind::single) {
    out.location_top1.add(score.location);
    out.effect_top1.add(score.effect);
    out.class_top1.add(score.in_class);
    for (StrengthBin& bin : out.strength) {
      const double left = one.label->left_rms_over_noise;
      if (!(left >= bin.from && left < bin.to)) continue;
      bin.location.add(score.location);
      bin.in_class.add(score.in_class);
    }
  }
  if (score.kind == CaseKind::several) out.set_f1 += score.f1, ++out.several;
  if ((score.kind == CaseKind::single || score.kind == CaseKind::several) && std::isfinite(score.gain_share))
    out.heldout_gain_share += score.gain_share, ++out.shared;
  for (std::size_t c = 0; c < score.claim_true.size(); ++c) {
    const double p = one.verdict->claims[c].probability;
    if (p > kClaimed) out.claims_above_09.add(score.claim_true[c]);
    for (CalibrationBin& bin : out.calibration) {
      if (!(p >= bin.from && p < bin.to)) continue;
      bin.probability_sum += p;
      bin.truth.add(score.claim_true[c]);
    }
  }
  add_baselines(one, score.kind, out.baselines);
  add_laws(one, score, out);
  if (score.kind == CaseKind::several) return;
  const auto foreign = std::find_if(one.label->effects.begin(), one.label->effects.end(), is_foreign);
  const std::string hidden = score.kind == CaseKind::null      ? "nothing"
                             : score.kind == CaseKind::outside ? foreign->effect
                                                               : one.label->effects.front().effect;
  ++out.confusion[hidden][said(one)];
}

}  // namespace

const char* to_string(Seal seal) {
  switch (seal) {
    case Seal::none: return "none";
    case Seal::intact: return "intact";
    default: return "broken";
  }
}

const char* to_string(CaseKind kind) {
  switch (kind) {
    case CaseKind::null: return "null";
    case CaseKind::single: return "single";
    case CaseKind::several: return "several";
    default: return "outside";
  }
}

CaseScore score_case(const BlindCase& one) {
  CaseScore out;
  out.kind = kind_of(*one.label);
  out.gain_share = out.rest_over_noise = std::nan("");
  for (const BlindLabel::Effect& hidden : one.label->effects)
    if (is_foreign(hidden))
      out.laws.push_back(score_law(hidden.place, hidden.law ? &*hidden.law : nullptr,
                                   one.verdict ? one.verdict->learned : std::vector<LearnedRecord>{}));
  if (!one.verdict) return out;
  const BlindVerdict& verdict = *one.verdict;
  const bool happens = std::ranges::any_of(one.label->effects, [](const BlindLabel::Effect& hidden) {
    return is_foreign(hidden) && hidden.law && !hidden.law->events.empty();
  });
  out.rest_over_noise =
      over_noise(happens && !verdict.validate.empty() ? verdict.validate : verdict.after, verdict.noise);
  out.claim_true = true_claims(verdict, *one.label);
  out.gain_share = gain_share(verdict);
  const auto hits = std::count(out.claim_true.begin(), out.claim_true.end(), true);
  std::size_t both = verdict.claims.size() + one.label->effects.size();
  std::vector<bool> besides(verdict.claims.size(), false);
  for (std::size_t c = 0; c < verdict.claims.size(); ++c) {
    if (out.claim_true[c] || !true_besides(verdict.claims[c], *one.label)) continue;
    out.claim_true[c] = besides[c] = true;
    --both;
  }
  out.f1 = both > 0 ? 2.0 * static_cast<double>(hits) / static_cast<double>(both) : 1.0;
  std::size_t asked = 0;  // the first claim but for those that are true besides
  while (asked < verdict.claims.size() && besides[asked]) ++asked;
  for (const BlindLabel::Effect& hidden : one.label->effects) {
    if (asked == verdict.claims.size()) break;
    const BlindVerdict::Claim& first = verdict.claims[asked];
    out.location = out.location || first.place == hidden.place;
    out.effect = out.effect || (first.place == hidden.place && first.effect == hidden.effect);
    out.in_class = out.in_class || covers(first, hidden);
  }
  const bool inexact = one.label->inexact();
  switch (out.kind) {
    case CaseKind::null:
      out.correct = inexact ? std::ranges::count(out.claim_true, false) == 0 : verdict.verdict == "consistent";
      break;
    case CaseKind::outside: out.correct = verdict.verdict == "unknown_physics"; break;
    default:
      out.correct =
          out.f1 == 1.0 && (verdict.verdict == "missing_physics" || (inexact && verdict.verdict == "unknown_physics"));
  }
  return out;
}

double Rate::share() const { return of > 0 ? static_cast<double>(hits) / of : std::nan(""); }

std::pair<double, double> Rate::ci95() const {
  using Binomial = boost::math::binomial_distribution<>;
  if (of == 0) return {0.0, 1.0};
  constexpr double kEachSide = 0.025;
  return {hits == 0 ? 0.0 : Binomial::find_lower_bound_on_p(of, hits, kEachSide),
          hits == of ? 1.0 : Binomial::find_upper_bound_on_p(of, hits, kEachSide)};
}

double LawTotals::median_error() const { return quartiles_of(curve_errors).median; }

BlindTotals total(const std::vector<BlindCase>& cases) {
  BlindTotals out;
  for (std::size_t k = 0; k + 1 < std::size(kCalibrationEdges); ++k)
    out.calibration.push_back({kCalibrationEdges[k], kCalibrationEdges[k + 1], 0.0, {}});
  for (std::size_t k = 0; k + 1 < std::size(kStrengthEdges); ++k)
    out.strength.push_back({kStrengthEdges[k], kStrengthEdges[k + 1], {}, {}});
  for (const BlindCase& one : cases) {
    ++out.cases;
    out.failed += !one.verdict.has_value();
    if (one.verdict && std::isfinite(one.verdict->seconds)) {
      out.seconds += one.verdict->seconds;
      out.longest = std::max(out.longest, one.verdict->seconds);
    }
    if (one.label && one.seal != Seal::broken) add_case(one, out);
  }
  out.set_f1 = out.several > 0 ? out.set_f1 / out.several : std::nan("");
  out.heldout_gain_share = out.shared > 0 ? out.heldout_gain_share / out.shared : std::nan("");
  return out;
}

std::vector<std::pair<std::string, BlindTotals>> totals_by_condition(const std::vector<BlindCase>& cases) {
  constexpr int kSeveral = 2;
  std::map<std::string, std::vector<BlindCase>> under;
  for (const BlindCase& one : cases) {
    if (!one.label || one.seal == Seal::broken) continue;
    std::map<std::string, int> places;
    for (const BlindLabel::Effect& hidden : one.label->effects) ++places[hidden.effect];
    const bool everywhere = std::ranges::any_of(places, [](const auto& p) { return p.second >= kSeveral; });
    for (const auto& [name, much] : one.label->conditions) under[name].push_back(one);
    if (everywhere) under["everywhere"].push_back(one);
    if (!everywhere && one.label->conditions.empty()) under["none"].push_back(one);
  }
  std::vector<std::pair<std::string, BlindTotals>> out;
  if (under.size() == under.count("none")) return out;
  for (const auto& [name, those] : under)
    if (name != "everywhere" && name != "none") out.emplace_back(name, total(those));
  for (const char* name : {"everywhere", "none"})
    if (under.contains(name)) out.emplace_back(name, total(under[name]));
  return out;
}

}  // namespace lacuna
