#include "trial/records.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "scenarios/error.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostEffects = 100;    // of a label or a diagnosis
constexpr std::size_t kMostPoints = 100000;  // of a curve, or events

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

}  // namespace

BlindLabel read_label(std::string_view json, const std::string& shown) {
  const Json record = parse(json, shown, "a label");
  BlindLabel out;
  for (const Json& entry : list_in(record, "effects", shown)) {
    const std::string effect = text_in(entry, "effect", shown);
    if (effect == "background") {  // others' labels list it among the effects
      out.conditions[effect] = number_in(entry, "strength");
      continue;
    }
    out.effects.push_back({effect, text_in(entry, "location", shown), number_in(entry, "strength")});
    if (entry.contains("stage")) out.effects.back().law = law_of(entry, shown);
  }
  if (const auto at = record.find("conditions"); at != record.end()) {
    if (!at->is_object() || at->size() > kMostEffects)
      refuse(shown, "no object under conditions", "at most " + std::to_string(kMostEffects) + " names with numbers");
    for (const auto& [name, value] : at->items()) out.conditions[name] = number_in(*at, name.c_str());
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

}  // namespace lacuna
