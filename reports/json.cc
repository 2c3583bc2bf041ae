#include "reports/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/json_text.h"
#include "reports/wording.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Context& context) {
  Json engine_versions = Json::object();
  for (const auto& [engine, version_text] : context.engine_versions) engine_versions[engine] = version_text;
  return {{"date", context.date},
          {"host", context.host},
          {"cpu", context.cpu},
          {"cores", context.cores},
          {"compiler", context.compiler},
          {"flags", context.flags},
          {"build_type", context.build_type},
          {"commit", context.commit},
          {"version", context.version},
          {"lanes", context.lanes},
          {"engine_versions", engine_versions},
          {"seed", context.seed},
          {"threads", context.threads},
          {"ranks", context.ranks},
          {"command_line", context.command_line}};
}

Json json_of(const JointRms& rms) {
  Json out = Json::object();
  for (const auto& [joint, value] : rms) out[joint] = value;
  return out;
}

/// rms per role and joint.
Json rms_of(const FitResult& fit) {
  Json out = Json::object();
  for (const auto& [role, rms] : fit.rms) out[to_string(role)] = json_of(rms);
  return out;
}

Json json_of(const Estimate& estimate) {
  Json out{{"value", estimate.value},
           {"ci95", {estimate.lower95, estimate.upper95}},
           {"unit", estimate.unit},
           {"identifiable", estimate.identifiable},
           {"at_bound", estimate.at_bound}};
  if (estimate.derived) out["derived"] = true;
  return out;
}

Json json_of(const std::vector<Estimate>& estimates) {
  Json out = Json::object();
  for (const Estimate& estimate : estimates) out[estimate.name] = json_of(estimate);
  return out;
}

/// `recording` runs parallel to `times`, so that `times` keeps one shape.
Json evidence_of(const Finding& finding) {
  Json times = Json::array(), recordings = Json::array();
  bool named = false;
  for (const Finding::Interval& interval : finding.times) {
    times.push_back({interval.begin, interval.end});
    recordings.push_back(interval.recording);
    named = named || !interval.recording.empty();
  }
  Json out{{"times", times}};
  if (named) out["recording"] = recordings;
  out["regions"] = finding.regions;
  out["p_value"] = finding.p_value;
  out["heldout_gain"] = finding.heldout_gain;
  out["heldout_gain_error"] = finding.heldout_error;
  out["heldout_share"] = finding.heldout_share;
  out["explained_share"] = finding.explained;
  out["stability"] = finding.stability;
  return out;
}

Json separation_of(const Finding& finding, std::size_t number) {
  if (!finding.separation) return nullptr;
  const Separation& s = *finding.separation;
  return {{"file", separation_file(number)},
          {"seconds", s.commands.time.back()},
          {"rival", s.rival},
          {"expected_evidence", s.evidence},
          {"expected_evidence_of_a_repeat", s.recorded}};
}

Json json_of(const Finding& finding, std::size_t number) {
  Json rivals = Json::array();
  for (const Rival& rival : finding.rivals)
    rivals.push_back({{"effect", rival.effect}, {"where", rival.place}, {"probability", rival.probability}});
  Json out{{"effect", finding.effect}, {"where", finding.place},   {"probability", finding.probability},
           {"rivals", rivals},         {"class", finding.members}, {"parameters", json_of(finding.parameters)}};
  if (const int index = find_effect(finding.effect); index >= 0) out["stage"] = to_string(effect_table()[index].stage);
  if (!finding.recordings.empty()) out["recordings"] = finding.recordings;
  out["class_probability"] = class_probability(finding);
  out["evidence"] = evidence_of(finding);
  out["separating_experiment"] = separation_of(finding, number);
  return out;
}

Json json_of(const MissingEffort& m) {
  Json regions = Json::array(), follows = Json::array(), changes = Json::array();
  for (const RegionTest& r : m.regions)
    regions.push_back({{"region", r.region}, {"ratio", r.ratio}, {"p_value", r.p_value}});
  for (const FollowsTest& f : m.follows)
    follows.push_back({{"quantity", f.quantity}, {"correlation", f.correlation}, {"p_value", f.p_value}});
  for (const EffortChange& c : m.changes)
    changes.push_back({{"recording", c.recording},
                       {"time", c.time},
                       {"before", c.before},
                       {"after", c.after},
                       {"p_value", c.p_value}});
  return {{"joint", m.joint},     {"rms", m.rms},       {"noise", m.noise},   {"unit", m.unit},    {"share", m.share},
          {"p_value", m.p_value}, {"regions", regions}, {"follows", follows}, {"changes", changes}};
}

Json json_of(const Candidate& candidate) {
  return {{"effect", candidate.effect},
          {"where", candidate.place},
          {"parameters", candidate.parameters},
          {"train_gain", candidate.train_gain},
          {"heldout_gain", candidate.heldout_gain},
          {"heldout_gain_error", candidate.heldout_error},
          {"heldout_share", candidate.heldout_share},
          {"p_value", candidate.p_value},
          {"note", candidate.note}};
}

Json rounds_of(const Diagnosis& diagnosis) {
  Json out = Json::array();
  for (const std::vector<Candidate>& round : diagnosis.rounds) {
    Json tried = Json::array();
    for (const Candidate& candidate : round) tried.push_back(json_of(candidate));
    out.push_back(tried);
  }
  return out;
}

Json json_of(const EngineGain& gain) {
  Json out{{"engine", gain.engine}, {"available", gain.available}};
  if (!gain.available) {
    out["reason"] = gain.reason;
    return out;
  }
  out["before"] = json_of(gain.before);
  out["after"] = json_of(gain.after);
  out["kept"] = gain.kept;
  return out;
}

Json identifiability_of(const FitResult& fit) {
  Json out{{"parameters", fit.point.size()},
           {"rank", fit.identifiability.rank},
           {"condition", fit.identifiability.condition},
           {"effective_samples", fit.effective_samples}};
  Json combinations = Json::array();
  for (std::size_t i = 0; i < fit.undetermined.size(); ++i) {
    Json combination{{"combination", fit.undetermined[i]}};
    if (i < fit.identifiability.undetermined.size())
      combination["relative_error"] = fit.identifiability.undetermined[i].relative_error;
    combinations.push_back(combination);
  }
  out["undetermined"] = combinations;
  return out;
}

Json json_of(const StepChoice& step) { return {{"seconds", step.step}, {"error_over_noise", step.error_over_noise}}; }

Json history_of(const std::vector<GenerationRecord>& history) {
  Json best = Json::array(), median = Json::array(), diversity = Json::array(), evaluations = Json::array();
  for (const GenerationRecord& generation : history) {
    best.push_back(generation.best);
    median.push_back(generation.median);
    diversity.push_back(generation.diversity);
    evaluations.push_back(generation.evaluations);
  }
  return {{"best", best}, {"median", median}, {"diversity", diversity}, {"evaluations", evaluations}};
}

Json json_of(const FitResult& fit) {
  return {{"engine", fit.engine},
          {"optimizer", fit.optimizer},
          {"rms", rms_of(fit)},
          {"parameters", json_of(fit.estimates)},
          {"identifiability", identifiability_of(fit)},
          {"solution",
           {{"sum_of_squares", fit.solution.sum_of_squares},
            {"samples", fit.solution.residual.size()},
            {"iterations", fit.solution.iterations},
            {"converged", fit.solution.converged}}},
          {"search_cost", fit.search_cost},
          {"history", history_of(fit.history)},
          {"step", json_of(fit.step)},
          {"evaluations", fit.evaluations},
          {"seconds", fit.seconds}};
}

Json unexplained_of(const Unexplained& unexplained) {
  Json times = Json::array();
  for (const Misfit& m : unexplained.times) {
    times.push_back({{"recording", m.recording},
                     {"where", m.joint},
                     {"time", {m.begin, m.end}},
                     {"rms_over_noise", m.ratio},
                     {"p_value", m.p_value}});
  }
  Json joints = Json::object();
  for (const Unexplained::AtJoint& at : unexplained.per_joint)
    joints[at.joint] = {{"rms_over_noise", at.over_noise}, {"probability", at.probability}};
  Json numbers = Json::array();
  for (const NumberByRecording& n : unexplained.numbers) {
    Json recordings = Json::object();
    for (const auto& [file, beyond] : n.recordings) recordings[file] = beyond;
    numbers.push_back({{"where", n.joint},
                       {"number", n.number},
                       {"unit", n.unit},
                       {"value", n.value},
                       {"standard_deviation", n.deviation},
                       {"evidence", n.evidence},
                       {"share", n.share},
                       {"recordings", recordings}});
  }
  return {{"present", unexplained.present},
          {"where", unexplained.where},
          {"regions", unexplained.regions},
          {"times", times},
          {"share", unexplained.share},
          {"probability", unexplained.probability},
          {"per_joint", joints},
          {"numbers_by_recording", numbers}};
}

Json json_of(const LearnedLaw& law) {
  Json curve = Json::array();
  Json over = Json::array(), units = Json::array();
  for (const LearnedLaw::Variable& variable : law.over) over.push_back(variable.name), units.push_back(variable.unit);
  for (const LearnedLaw::Point& p : law.curve) {
    const Json at = law.over.size() > 1 ? Json::array({p.at, p.beside}) : Json(p.at);
    curve.push_back({{"at", at}, {"value", p.value}, {"lower95", p.lower95}, {"upper95", p.upper95}});
  }
  return {{"where", law.place},
          {"stage", to_string(law.stage)},
          {"over", over},
          {"unit", law.unit},
          {"over_unit", units.size() == 1 ? units.front() : units},
          {"curve", curve},
          {"events", Json::array()},
          {"period", law.period > 0.0 ? Json(law.period) : Json(nullptr)},
          {"description", law.description},
          {"tells_more", law.tells_more.empty() ? Json(nullptr) : Json(law.tells_more)},
          {"resembles", {{"law", law.resembles}, {"share", law.share}}},
          {"probability", law.probability},
          {"evidence", law.evidence},
          {"heldout", {{"gain", law.heldout_gain}, {"share", law.heldout_share}}}};
}

/// Stage of the chain at which an event enters it.
Stage stage_of(EventSpec::Kind kind) {
  switch (kind) {
    case EventSpec::Kind::effort: return Stage::link;
    case EventSpec::Kind::command: return Stage::command;
    default: return Stage::reading;
  }
}

Json json_of(const LearnedEvent& event) {
  return {{"recording", event.recording}, {"role", to_string(event.role)},
          {"from", event.from},           {"to", event.to},
          {"value", event.value},         {"unit", event.unit},
          {"resembles", event.resembles}, {"evidence", event.evidence}};
}

/// Events of one kind at one joint, as something learned over time.
Json json_of(const std::vector<LearnedEvent>& events) {
  const LearnedEvent& first = events.front();
  Json list = Json::array();
  double evidence = -HUGE_VAL;
  for (const LearnedEvent& event : events) {
    list.push_back(json_of(event));
    evidence = std::max(evidence, event.evidence);
  }
  return {{"where", first.place},
          {"stage", to_string(stage_of(first.kind))},
          {"over", {"t"}},
          {"unit", first.unit},
          {"over_unit", "s"},
          {"curve", Json::array()},
          {"events", list},
          {"period", nullptr},
          {"description", description_of(events)},
          {"tells_more", nullptr},
          {"resembles", {{"law", first.resembles}, {"share", nullptr}}},
          {"probability", 1.0 / (1.0 + std::exp(-evidence))},
          {"evidence", evidence},
          {"heldout", nullptr}};
}

/// Rms by role as in `fit`, and what the regression says of every joint.
Json idim_of(const std::optional<Idim>& idim) {
  if (!idim) return nullptr;
  Json rms = Json::object(), joints = Json::object();
  for (const auto& [role, values] : idim->rms) rms[to_string(role)] = json_of(values);
  for (const IdimJoint& j : idim->joints)
    joints[j.joint] = {{"viscous", j.viscous}, {"coulomb", j.coulomb}, {"offset", j.offset}, {"armature", j.armature}};
  return {{"rms", rms},
          {"test", rms.contains("test") ? rms["test"] : Json(nullptr)},
          {"rank", idim->rank},
          {"columns", idim->columns},
          {"joints", joints}};
}

Json json_of(const ValveChart& chart) {
  Json rms = Json::object();
  for (const auto& [role, value] : chart.rms) rms[to_string(role)] = value;
  const auto stop = [](double at) { return std::isfinite(at) ? Json(at) : Json(nullptr); };
  return {{"delay", chart.delay},
          {"lag", chart.lag},
          {"command", chart.command},
          {"speed", chart.speed},
          {"seconds", chart.seen},
          {"stops", {stop(chart.stops[0]), stop(chart.stops[1])}},
          {"rms", rms}};
}
/// [joint]: speed against command as recorded, and as the final model simulates it.
Json valves_of(const Diagnosis& diagnosis) {
  Json out = Json::object();
  for (const ValveComparison& v : diagnosis.valves)
    out[v.recorded.name] = {{"recorded", json_of(v.recorded)}, {"simulated", json_of(v.simulated)}};
  return out;
}

Json json_of(const PartFit& part) {
  if (!part.why_not.empty()) return {{"part", to_string(part.part)}, {"why_not", part.why_not}};
  return {{"part", to_string(part.part)}, {"unit", part.unit},     {"samples", part.samples},
          {"signal", part.signal},        {"noise", part.noise},   {"expected", part.expected_before},
          {"before", part.before},        {"after", part.after},   {"p_before", part.p_before},
          {"p_after", part.p_after},      {"fails", part.fails()}, {"still_fails", part.still_fails()}};
}
/// Where the chain from command to motion fails, joint by joint whose pressures are measured.
Json chain_of(const Diagnosis& diagnosis) {
  Json out = Json::array();
  for (const JointChain& chain : diagnosis.chain) {
    Json parts = Json::array();
    for (const PartFit& part : chain.parts) parts.push_back(json_of(part));
    out.push_back({{"joint", chain.joint}, {"areas_given", chain.areas_given}, {"parts", std::move(parts)}});
  }
  return out;
}

/// Which file holds what of which test recording.
Json predictions_of(const Diagnosis& diagnosis) {
  Json out = Json::array();
  for (std::size_t k = 0; k < diagnosis.predictions.size(); ++k)
    out.push_back({{"recording", diagnosis.predictions[k].front().recording}, {"file", prediction_file(k + 1)}});
  return out;
}

Json json_of(const Whiteness& w) {
  return {{"where", w.joint},
          {"role", to_string(w.role)},
          {"samples", w.samples},
          {"before", {{"autocorrelation", w.before}, {"p_value", w.p_before}}},
          {"after", {{"autocorrelation", w.after}, {"p_value", w.p_after}}}};
}

}  // namespace

std::string prediction_file(std::size_t number) { return fmt::format("predicted_{}.csv", number); }
std::string separation_file(std::size_t number) { return fmt::format("separating_{}.csv", number); }

std::string to_json(const Diagnosis& diagnosis, const Context& context) {
  Json learned = Json::array();
  for (const LearnedLaw& law : diagnosis.learned) learned.push_back(json_of(law));
  for (const std::vector<LearnedEvent>& events : alike(diagnosis.events)) learned.push_back(json_of(events));
  Json findings = Json::array(), gains = Json::array(), missing = Json::array(), colours = Json::array();
  for (const Whiteness& w : diagnosis.whiteness) colours.push_back(json_of(w));
  for (const MissingEffort& m : diagnosis.missing) missing.push_back(json_of(m));
  for (std::size_t k = 0; k < diagnosis.findings.size(); ++k) findings.push_back(json_of(diagnosis.findings[k], k + 1));
  for (const EngineGain& gain : diagnosis.engines) gains.push_back(json_of(gain));
  const Json out{
      {"format", "lacuna-diagnosis/1"},
      {"scenario", diagnosis.scenario},
      {"engine", diagnosis.engine},
      {"seed", diagnosis.seed},
      {"version", context.version},
      {"verdict", to_string(diagnosis.verdict)},
      {"findings", findings},
      {"learned", learned},
      {"unexplained", unexplained_of(diagnosis.unexplained)},
      {"worse", diagnosis.worse},
      {"worse_besides_starts", diagnosis.worse_besides_starts},
      {"idim", idim_of(diagnosis.idim)},
      {"speed_against_command", valves_of(diagnosis)},
      {"chain", chain_of(diagnosis)},
      {"missing_effort", missing},
      {"whiteness", colours},
      {"fit",
       {{"noise", json_of(diagnosis.noise)}, {"before", rms_of(diagnosis.before)}, {"after", rms_of(diagnosis.after)}}},
      {"parameters", json_of(diagnosis.after.estimates)},
      {"parameters_from_all_recordings", json_of(diagnosis.all_recordings)},
      {"candidates", rounds_of(diagnosis)},
      {"engines", gains},
      {"identifiability", identifiability_of(diagnosis.after)},
      {"step", json_of(diagnosis.after.step)},
      {"predictions", predictions_of(diagnosis)},
      {"notes", diagnosis.notes},
      {"seconds", diagnosis.seconds},
      {"context", json_of(context)}};
  return json_text(out);
}

std::string to_json(const Context& context) { return json_text(json_of(context)); }

std::string to_json(std::span<const FitResult> fits, const std::string& scenario, const Context& context) {
  Json records = Json::array();
  for (const FitResult& fit : fits) records.push_back(json_of(fit));
  return json_text({{"format", "lacuna-fit/1"},
                    {"scenario", scenario},
                    {"seed", context.seed},
                    {"version", context.version},
                    {"engines", records},
                    {"context", json_of(context)}});
}

std::string to_json(const FitResult& fit, const std::string& scenario, const Context& context) {
  return to_json(std::span(&fit, 1), scenario, context);
}

}  // namespace lacuna
