// `lacuna engines`: what is built in, what it can do, and why something is missing.
#include "backends/engine.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/table.h"
#include "physics/simulator.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const EngineInfo& info) {
  Json out = {{"name", info.name}, {"available", info.available}};
  if (!info.available) {
    out["reason"] = info.reason;
    return out;
  }
  out["version"] = info.version;
  out["capabilities"] = Json::array();
  for (const Capability& capability : info.capabilities)
    out["capabilities"].push_back(
        {{"name", capability.name}, {"native", capability.native}, {"words", capability.words}});
  out["native_integrators"] = info.native_integrators;
  return out;
}

std::string describe(const EngineInfo& info) {
  std::string out = fmt::format("{}: ", info.name);
  if (!info.available) return out + "not available: " + info.reason + "\n\n";
  out += "version " + info.version + "\n";
  TextTable table({"  can", "how"});
  for (const Capability& capability : info.capabilities)
    table.add({"  " + capability.name, capability.native
                                           ? "itself" + (capability.words.empty() ? "" : ": " + capability.words)
                                           : "derived: " + capability.words});
  out += table.str();
  std::string integrators;
  for (const std::string& name : info.native_integrators) integrators += (integrators.empty() ? "" : ", ") + name;
  return out + "  native integrators: " + (integrators.empty() ? "none" : integrators) + "\n\n";
}

void run(const Session& session) {
  const LaneInfo lanes = lane_info();
  const RanksInfo ranks = ranks_info();
  if (session.json) {
    Json out = {{"format", "lacuna-engines/1"},
                {"version", version()},
                {"lanes", {{"name", lanes.name}, {"width", lanes.width}}},
                {"ranks", ranks.version.empty() ? Json{{"available", false}, {"reason", ranks.reason}}
                                                : Json{{"available", true}, {"version", ranks.version}}},
                {"engines", Json::array()}};
    for (const Engine* engine : engines()) out["engines"].push_back(to_json(engine->info()));
    print(out.dump(2) + "\n");
    return;
  }
  std::string out;
  for (const Engine* engine : engines()) out += describe(engine->info());
  out += fmt::format("lanes: {} x {} (parameter sets simulated at once on featherstone, per thread)\n", lanes.name,
                     lanes.width);
  print(out + "ranks: " + (ranks.version.empty() ? "not available: " + ranks.reason : ranks.version + " (mpirun)") +
        "\n");
}

}  // namespace

void add_engines(CLI::App& app, Session& session) {
  add_command(app, session, "engines", "Engines built in, what they can do, or why one is missing",
              "lacuna engines --json", [&session] { run(session); });
}

}  // namespace lacuna
