#include "diagnosis/checkpoint.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "diagnosis/baseline.h"
#include "ga/checkpoint.h"
#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kDiagnosisCheckpoint = "lacuna-diagnosis-checkpoint/5";

Json exact(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double x : values) out.push_back(exact_text(x));
  return out;
}
Json exact_by_name(const std::map<std::string, double>& values) {
  Json out = Json::object();
  for (const auto& [name, value] : values) out[name] = exact_text(value);
  return out;
}
std::vector<double> numbers(const Json& list) {
  std::vector<double> out;
  for (const Json& x : list) out.push_back(exact_number(x));
  return out;
}
std::map<std::string, double> named_numbers(const Json& object) {
  std::map<std::string, double> out;
  for (const auto& [name, value] : object.items()) out[name] = exact_number(value);
  return out;
}

Json to_json(const Candidate& c) {
  return {{"effect", c.effect},
          {"place", c.place},
          {"parameters", c.parameters},
          {"note", c.note},
          {"numbers", exact({c.train_gain, c.heldout_gain, c.heldout_error, c.heldout_share, c.p_value})}};
}
Candidate candidate_from(const Json& j) {
  const std::vector<double> n = numbers(j.at("numbers"));
  return {j.at("effect"), j.at("place"), n.at(0), n.at(1), n.at(2), n.at(3), n.at(4), j.at("parameters"), j.at("note")};
}

Json to_json(const Finding& f) {
  Json out = {{"effect", f.effect},
              {"place", f.place},
              {"members", f.members},
              {"recordings", f.recordings},
              {"regions", f.regions},
              {"numbers", exact({f.probability, f.p_value, f.heldout_gain, f.heldout_error, f.heldout_share,
                                 f.stability, f.outside})}};
  for (const Rival& r : f.rivals)
    out["rivals"].push_back(
        {r.effect, r.place, exact_text(r.probability), exact_by_name(r.fixed), exact(r.own), r.recordings});
  out["fixed"] = exact_by_name(f.fixed);
  for (const auto& t : f.times) out["times"].push_back({t.recording, exact_text(t.begin), exact_text(t.end)});
  return out;
}
Finding finding_from(const Json& j) {
  Finding f;
  f.effect = j.at("effect");
  f.place = j.at("place");
  f.members = j.at("members").get<std::vector<std::string>>();
  f.recordings = j.at("recordings").get<std::vector<std::string>>();
  f.regions = j.at("regions").get<std::vector<std::string>>();
  f.fixed = named_numbers(j.at("fixed"));
  const std::vector<double> n = numbers(j.at("numbers"));
  f.probability = n.at(0), f.p_value = n.at(1), f.heldout_gain = n.at(2);
  f.heldout_error = n.at(3), f.heldout_share = n.at(4), f.stability = n.at(5), f.outside = n.at(6);
  for (const Json& r : j.value("rivals", Json::array()))
    f.rivals.push_back({r.at(0), r.at(1), exact_number(r.at(2)), named_numbers(r.at(3)), numbers(r.at(4)),
                        r.at(5).get<std::vector<std::string>>()});
  for (const Json& t : j.value("times", Json::array()))
    f.times.push_back({t.at(0), exact_number(t.at(1)), exact_number(t.at(2))});
  return f;
}

}  // namespace

struct DiagnosisCheckpoint::Content {
  Json json;
};

DiagnosisCheckpoint::DiagnosisCheckpoint(std::filesystem::path file, std::string problem, bool writes)
    : file_(std::move(file)), writes_(writes), content_(std::make_unique<Content>()) {
  content_->json = {{"problem", problem}, {"rounds", Json::array()}};
  if (file_.empty() || !std::filesystem::exists(file_)) return;
  Json found;
  try {
    std::ifstream in(file_);
    Json whole = Json::parse(in);
    if (whole.at("format") != kDiagnosisCheckpoint) throw std::runtime_error("format");
    found = std::move(whole.at("content"));
    if (whole.at("checksum") != checksum(found.dump())) throw std::runtime_error("checksum");
    found.at("rounds").size();
  } catch (const std::exception&) {
    throw InputError(file_.string(), "no readable checkpoint",
                     "one that this program wrote; delete the file to start anew");
  }
  if (found.value("problem", Json()) != problem) {
    throw InputError(file_.string(), "the checkpoint of another scenario, recording or option",
                     "one of this command; delete the file or name another output folder");
  }
  content_->json = std::move(found);
}

DiagnosisCheckpoint::~DiagnosisCheckpoint() = default;

std::filesystem::path DiagnosisCheckpoint::part(const std::string& name) const {
  if (file_.empty()) return {};
  std::filesystem::path out = file_;
  return out.replace_extension("." + name + ".json");
}

bool DiagnosisCheckpoint::restore_baseline(const FitContext& context, CurrentModel& model, FitResult& fit) const {
  if (!content_->json.contains("baseline")) return false;
  const Json& j = content_->json.at("baseline");
  model.weights = numbers(j.at("weights"));
  fit.engine = j.at("engine");
  fit.optimizer = j.at("optimizer");
  fit.evaluations = j.at("evaluations");
  fit.step = {exact_number(j.at("step").at(0)), exact_number(j.at("step").at(1))};
  fit.search_cost = exact_number(j.at("search_cost"));
  fit.doubt = j.at("doubt");
  fit.arrived = fit.doubt.empty();
  fit.seconds = exact_number(j.at("seconds"));
  for (const Json& g : j.at("history")) {
    fit.history.push_back({exact_number(g.at(0)), exact_number(g.at(1)), exact_number(g.at(2)), exact_number(g.at(3)),
                           g.at(4), exact_number(g.at(5))});
  }
  evaluate_at(model, numbers(j.at("point")), context.with_step(fit.step.step));
  return true;
}

void DiagnosisCheckpoint::store_baseline(const CurrentModel& model, const FitResult& fit) {
  Json j = {{"weights", exact(model.weights)},
            {"point", exact(model.fit.point)},
            {"engine", fit.engine},
            {"doubt", fit.doubt},
            {"optimizer", fit.optimizer},
            {"evaluations", fit.evaluations},
            {"step", exact({fit.step.step, fit.step.error_over_noise})},
            {"search_cost", exact_text(fit.search_cost)},
            {"seconds", exact_text(fit.seconds)},
            {"history", Json::array()}};
  for (const GenerationRecord& g : fit.history) {
    j["history"].push_back({exact_text(g.best), exact_text(g.median), exact_text(g.mean), exact_text(g.diversity),
                            g.evaluations, exact_text(g.seconds)});
  }
  content_->json["baseline"] = std::move(j);
  write();
}

bool DiagnosisCheckpoint::restore_round(int round, FitContext& context, CurrentModel& model,
                                        std::optional<Finding>& finding, std::vector<Candidate>& candidates) const {
  const Json& rounds = content_->json.at("rounds");
  if (static_cast<std::size_t>(round) >= rounds.size()) return false;
  const Json& j = rounds.at(static_cast<std::size_t>(round));
  for (const Json& c : j.at("candidates")) candidates.push_back(candidate_from(c));
  if (!j.contains("finding")) return true;
  finding = finding_from(j.at("finding"));
  const EffectSpec spec{finding->effect, finding->place, finding->fixed, finding->recordings, "checkpoint"};
  model = extended(model, context.experiment, spec, model.fit.point, {});
  model.weights = numbers(j.at("weights"));
  context.simulator.max_step = exact_number(j.at("step"));
  evaluate_at(model, numbers(j.at("point")), context);
  return true;
}

void DiagnosisCheckpoint::store_round(const CurrentModel& model, const std::optional<Finding>& finding,
                                      const std::vector<Candidate>& candidates, double step) {
  Json j = {{"candidates", Json::array()}};
  for (const Candidate& c : candidates) j["candidates"].push_back(to_json(c));
  if (finding) {
    j["finding"] = to_json(*finding);
    j["step"] = exact_text(step);
    j["weights"] = exact(model.weights);
    j["point"] = exact(model.fit.point);
  }
  content_->json["rounds"].push_back(std::move(j));
  write();
}

bool DiagnosisCheckpoint::restore_sets(const std::string& which, const CurrentModel& plain,
                                       const Experiment& experiment, std::optional<SetSearchResult>& sets) const {
  if (!content_->json.contains(which)) return false;
  const Json& j = content_->json.at(which);
  sets.reset();
  if (j.is_null()) return true;
  SetSearchResult out{plain, {}, {}, j.at("notes").get<std::vector<std::string>>(), exact_number(j.at("step"))};
  for (const Json& e : j.at("effects")) {
    const EffectSpec spec{e.at(0), e.at(1), named_numbers(e.at(2)), e.at(3).get<std::vector<std::string>>(),
                          "checkpoint"};
    out.model = extended(out.model, experiment, spec, out.model.fit.point, {});
  }
  out.model.weights = numbers(j.at("weights"));
  out.model.fit.point = numbers(j.at("point"));
  for (const Json& f : j.at("findings")) out.findings.push_back(finding_from(f));
  for (const Json& round : j.at("rounds")) {
    out.rounds.emplace_back();
    for (const Json& c : round) out.rounds.back().push_back(candidate_from(c));
  }
  sets = std::move(out);
  return true;
}

void DiagnosisCheckpoint::store_sets(const std::string& which, const PlantModel& plain,
                                     const std::optional<SetSearchResult>& sets) {
  Json j;
  if (sets) {
    j = {{"notes", sets->notes},
         {"step", exact_text(sets->step)},
         {"effects", Json::array()},
         {"weights", exact(sets->model.weights)},
         {"point", exact(sets->model.fit.point)},
         {"findings", Json::array()},
         {"rounds", Json::array()}};
    for (const EffectSpec& spec : effects_beyond(plain, sets->model))
      j["effects"].push_back({spec.effect, spec.place, exact_by_name(spec.parameters), spec.recordings});
    for (const Finding& f : sets->findings) j["findings"].push_back(to_json(f));
    for (const std::vector<Candidate>& round : sets->rounds) {
      Json list = Json::array();
      for (const Candidate& c : round) list.push_back(to_json(c));
      j["rounds"].push_back(std::move(list));
    }
  }
  content_->json[which] = std::move(j);
  write();
}

void DiagnosisCheckpoint::write() const {
  if (!writes_ || file_.empty()) return;
  const Json whole{
      {"format", kDiagnosisCheckpoint}, {"checksum", checksum(content_->json.dump())}, {"content", content_->json}};
  write_file_atomically(file_, whole.dump());
}

void DiagnosisCheckpoint::remove(const std::filesystem::path& file) {
  const auto beside = [&](const std::string& end) { return std::filesystem::path(file).replace_extension(end); };
  const auto part = [&](int k) { return beside(fmt::format(".part_{}.json", k)); };
  // This file last, the last part first: a removal that is cut short can be done again.
  int parts = 0;
  while (std::filesystem::exists(part(parts))) ++parts;
  while (parts-- > 0) remove_checkpoint(part(parts));
  remove_checkpoint(beside(".search.json"));
  remove_checkpoint(file);
}

}  // namespace lacuna
