#include "reports/blind.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/catalogue.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "study/statistics.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostEffects = 100;    // of a label or a diagnosis
constexpr std::size_t kMostPoints = 100000;  // of a curve, or events
constexpr double kLeastEnergy = 0.02;        // of the noise': below it there is no gain to have a share of
constexpr double kClaimed = 0.9;             // probability from which on a claim is held to 97 %
constexpr double kCalibrationEdges[] = {0.0, 0.5, 0.7, 0.9, 0.97, 1.0 + 1e-9};
constexpr double kStrengthEdges[] = {0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 1e300};

[[noreturn]] void refuse(const std::string& shown, const std::string& found, const std::string& expected) {
  throw InputError(shown, found, expected);
}

Json parse(std::string_view text, const std::string& shown, const std::string& what) {
  try {
    Json out = Json::parse(text);
    if (!out.is_object()) refuse(shown, "no object", what);
    return out;
  } catch (const Json::parse_error& error) {
    refuse(shown, "no JSON at byte " + std::to_string(error.byte), what);
  } catch (const Json::out_of_range&) {
    refuse(shown, "a number that is too large", what);
  }
}

std::string text_in(const Json& object, const char* key, const std::string& shown) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_string())
    refuse(shown, std::string("no text under ") + key, "a text");
  return object[key].get<std::string>();
}

/// NaN where there is no number.
double number_in(const Json& object, const char* key) {
  const auto at = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && at != object.end() && at->is_number() ? at->get<double>() : std::nan("");
}

Json list_in(const Json& object, const char* key, const std::string& shown, std::size_t most = kMostEffects) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_array() || object[key].size() > most)
    refuse(shown, std::string("no list under ") + key, "a list of at most " + std::to_string(most));
  return object[key];
}

double finite_in(const Json& object, const char* key, const std::string& shown) {
  const double out = number_in(object, key);
  if (!std::isfinite(out)) refuse(shown, std::string("no number under ") + key, "a number");
  return out;
}

/// `at` is a number, or a list of one for each variable.
LawRecord::Point point_of(const Json& entry, std::size_t variables, const std::string& shown) {
  LawRecord::Point out;
  out.value = finite_in(entry, "value", shown);
  if (entry.contains("at") && entry["at"].is_array()) {
    for (const Json& x : entry["at"]) out.at.push_back(x.is_number() ? x.get<double>() : std::nan(""));
  } else {
    out.at.push_back(number_in(entry, "at"));
  }
  const bool finite = std::all_of(out.at.begin(), out.at.end(), [](double x) { return std::isfinite(x); });
  if (!finite || out.at.size() != variables)
    refuse(shown, "a curve's point without its place under at", std::to_string(variables) + " number(s)");
  return out;
}

/// Of a label's effect or of an entry under `learned`; curve and events may be left out.
LawRecord law_of(const Json& entry, const std::string& shown) {
  LawRecord out;
  out.stage = text_in(entry, "stage", shown);
  for (const Json& variable : list_in(entry, "over", shown)) {
    if (!variable.is_string()) refuse(shown, "no text in the list under over", "names of variables");
    out.over.push_back(variable.get<std::string>());
  }
  if (out.over.empty() || out.over.size() > 2)
    refuse(shown, std::to_string(out.over.size()) + " variables under over", "one or two");
  if (entry.contains("curve"))
    for (const Json& point : list_in(entry, "curve", shown, kMostPoints))
      out.curve.push_back(point_of(point, out.over.size(), shown));
  if (entry.contains("events"))
    for (const Json& event : list_in(entry, "events", shown, kMostPoints))
      out.events.push_back(
          {text_in(event, "recording", shown), finite_in(event, "from", shown), finite_in(event, "to", shown), {}});
  return out;
}

JointRms rms_under(const Json& object) {
  JointRms out;
  if (!object.is_object()) return out;
  for (const auto& [joint, value] : object.items())
    if (value.is_number()) out.emplace_back(joint, value.get<double>());
  return out;
}

/// fit.<stage>.<role>
JointRms fit_rms(const Json& fit, const char* stage, const char* role) {
  if (!fit.is_object() || !fit.contains(stage) || !fit[stage].is_object() || !fit[stage].contains(role)) return {};
  return rms_under(fit[stage][role]);
}

BlindVerdict::Claim claim_of(const Json& finding, const std::string& shown) {
  BlindVerdict::Claim out{
      text_in(finding, "effect", shown), text_in(finding, "where", shown), number_in(finding, "probability"), {}};
  if (finding.contains("class") && finding["class"].is_array()) {
    for (const Json& member : finding["class"])
      if (member.is_string()) out.members.push_back(member.get<std::string>());
  }
  return out;
}

std::vector<BlindVerdict::Tried> first_round_of(const Json& record) {
  std::vector<BlindVerdict::Tried> out;
  const auto rounds = record.find("candidates");
  if (rounds == record.end() || !rounds->is_array() || rounds->empty() || !rounds->front().is_array()) return out;
  for (const Json& tried : rounds->front()) {
    if (!tried.is_object() || !tried.contains("effect") || !tried["effect"].is_string() || !tried.contains("where") ||
        !tried["where"].is_string())
      continue;
    out.push_back({tried["effect"].get<std::string>(), tried["where"].get<std::string>(),
                   number_in(tried, "train_gain"),
                   static_cast<int>(std::clamp(number_in(tried, "parameters"), 0.0, 1e6))});
  }
  return out;
}

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
  if (score.kind == CaseKind::null) out.false_laws_null.add(learned);
  if (score.kind == CaseKind::single || score.kind == CaseKind::several) out.false_laws_exact.add(learned);
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

BlindLabel read_label(std::string_view json, const std::string& shown) {
  const Json record = parse(json, shown, "a label");
  BlindLabel out;
  for (const Json& entry : list_in(record, "effects", shown)) {
    out.effects.push_back(
        {text_in(entry, "effect", shown), text_in(entry, "location", shown), number_in(entry, "strength")});
    if (entry.contains("stage")) out.effects.back().law = law_of(entry, shown);
  }
  out.left_rms_over_noise = number_in(record, "left_rms_over_noise");
  return out;
}

BlindVerdict read_verdict(std::string_view json, const std::string& shown) {
  const Json record = parse(json, shown, "a diagnosis");
  if (text_in(record, "format", shown) != "lacuna-diagnosis/1") refuse(shown, "another format", "lacuna-diagnosis/1");
  BlindVerdict out;
  out.verdict = text_in(record, "verdict", shown);
  for (const Json& finding : list_in(record, "findings", shown)) out.claims.push_back(claim_of(finding, shown));
  if (record.contains("learned"))
    for (const Json& entry : list_in(record, "learned", shown))
      out.learned.push_back({text_in(entry, "where", shown), law_of(entry, shown)});
  out.first_round = first_round_of(record);
  const Json fit = record.value("fit", Json::object());
  out.noise = fit.is_object() ? rms_under(fit.value("noise", Json::object())) : JointRms{};
  out.train = fit_rms(fit, "before", "train");
  for (const char* role : {"test", "validate"}) {
    if (!out.before.empty()) break;
    out.before = fit_rms(fit, "before", role);
    out.after = fit_rms(fit, "after", role);
  }
  out.validate = fit_rms(fit, "after", "validate");
  if (record.contains("identifiability"))
    out.effective_samples = number_in(record["identifiability"], "effective_samples");
  out.seconds = number_in(record, "seconds");
  return out;
}

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
  const std::size_t both = verdict.claims.size() + one.label->effects.size();
  out.f1 = both > 0 ? 2.0 * static_cast<double>(hits) / static_cast<double>(both) : 1.0;
  for (const BlindLabel::Effect& hidden : one.label->effects) {
    if (verdict.claims.empty()) break;
    const BlindVerdict::Claim& first = verdict.claims.front();
    out.location = out.location || first.place == hidden.place;
    out.effect = out.effect || (first.place == hidden.place && first.effect == hidden.effect);
    out.in_class = out.in_class || covers(first, hidden);
  }
  switch (out.kind) {
    case CaseKind::null: out.correct = verdict.verdict == "consistent"; break;
    case CaseKind::outside: out.correct = verdict.verdict == "unknown_physics"; break;
    default: out.correct = verdict.verdict == "missing_physics" && out.f1 == 1.0;
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

}  // namespace lacuna
