// `lacuna effects`: the catalogue of what a diagnosis can find.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/table.h"
#include "physics/catalogue.h"
#include "physics/units.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kWidth = 118, kIndent = 13;

const char* place_of(const EffectInfo& effect) { return effect.where == Where::joint ? "joint" : "arm"; }

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const std::vector<ParameterInfo>& parameters) {
  Json out = Json::array();
  for (const ParameterInfo& p : parameters)
    out.push_back({{"name", p.name},
                   {"unit", unit_at(p.unit, false, kAnyCommand)},
                   {"meaning", p.meaning},
                   {"neutral", finite(p.neutral)},
                   {"lower", finite(p.lower)},
                   {"upper", finite(p.upper)}});
  return out;
}

Json catalogue_json() {
  Json out = {
      {"format", "lacuna-effects/1"}, {"version", version()}, {"effects", Json::array()}, {"actuators", Json::array()}};
  for (const EffectInfo& e : effect_table())
    out["effects"].push_back({{"name", e.name},
                              {"title", e.title},
                              {"where", place_of(e)},
                              {"stage", to_string(e.stage)},
                              {"equation", e.equation},
                              {"parameters", to_json(e.parameters)},
                              {"shows_as", e.shows_as},
                              {"hidden_by", e.hidden_by},
                              {"source", e.source},
                              {"per_recording", e.per_recording}});
  for (const ActuatorInfo& a : actuator_table())
    out["actuators"].push_back({{"name", a.name},
                                {"equation", a.equation},
                                {"use", a.use},
                                {"input", to_string(a.input)},
                                {"parameters", to_json(a.parameters)}});
  return out;
}

std::string parameters_of(const std::vector<ParameterInfo>& parameters) {
  std::string out;
  for (const ParameterInfo& p : parameters)
    out += fmt::format("{}{} [{}] {}", out.empty() ? "" : "; ", p.name, unit_at(p.unit, false, kAnyCommand), p.meaning);
  return out;
}

std::string row(const char* label, const std::string& text) {
  return fmt::format("  {:<{}}{}\n", label, kIndent - 2, wrapped(text, kWidth, kIndent));
}

std::string catalogue_text() {
  std::string out =
      "Effects, by name, place and stage of the chain command > valve > flow > effort > transmission > link > "
      "reading\n\n";
  for (const EffectInfo& e : effect_table()) {
    out += fmt::format("{}  ({}, stage {}{})\n", e.name, place_of(e), to_string(e.stage),
                       e.per_recording ? ", possibly in some recordings only" : "");
    out += row("equation", e.equation) + row("parameters", parameters_of(e.parameters)) + row("shows as", e.shows_as) +
           row("hidden by", e.hidden_by) + row("source", e.source) + "\n";
  }
  out += "Actuator models\n\n";
  for (const ActuatorInfo& a : actuator_table())
    out += fmt::format("{}\n", a.name) + row("equation", a.equation) + row("parameters", parameters_of(a.parameters)) +
           row("command", fmt::format("enters at stage {}", to_string(a.input))) + row("use", a.use) + "\n";
  return out + "Units are those of a turning joint; for a sliding one N for N m and m for rad.\n";
}

}  // namespace

void add_effects(CLI::App& app, Session& session) {
  add_command(app, session, "effects", "The catalogue of effects that a diagnosis can find, and the actuator models",
              "lacuna effects",
              [&session] { print(session.json ? catalogue_json().dump(2) + "\n" : catalogue_text()); });
}

}  // namespace lacuna
