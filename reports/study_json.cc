#include <nlohmann/json.hpp>

#include "reports/json.h"
#include "reports/json_text.h"
#include "reports/study.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Quartiles& q) { return {{"median", q.median}, {"quartiles", {q.low, q.high}}}; }

Json json_of(const SearchRun& run) {
  return {{"cost", run.cost},
          {"output_error_index", run.errors.output_largest},
          {"output_rms", run.errors.output_rms},
          {"parameter_error_index", run.errors.parameter_index},
          {"combination_error_index", run.errors.combination_index},
          {"evaluations", run.evaluations},
          {"seconds", run.seconds},
          {"point", run.point}};
}

Json runs_of(const std::vector<SearchRun>& runs) {
  Json out = Json::array();
  for (const SearchRun& run : runs) out.push_back(json_of(run));
  return out;
}

Json json_of(const SettingRecord& s) {
  Json curve = Json::array();
  for (const Quartiles& q : s.curve()) curve.push_back({q.low, q.median, q.high});
  return {{"key", s.key},
          {"group", s.group},
          {"title", s.title},
          {"fitness", to_string(s.fitness)},
          {"coding", to_string(s.genetic.coding)},
          {"selection", to_string(s.genetic.selection)},
          {"crossover", to_string(s.genetic.crossover)},
          {"cut_points", s.genetic.cut_points},
          {"crossover_rate", s.genetic.crossover_rate},
          {"mutation", to_string(s.genetic.mutation)},
          {"mutation_rate", s.genetic.mutation_rate},
          {"population", s.genetic.population},
          {"generations", s.genetic.generations},
          {"cost", json_of(quartiles_of(s.each(final_cost)))},
          {"output_error_index", json_of(quartiles_of(s.each(output_largest)))},
          {"output_rms", json_of(quartiles_of(s.each(output_rms)))},
          {"parameter_error_index", json_of(quartiles_of(s.each(parameter_index)))},
          {"combination_error_index", json_of(quartiles_of(s.each(combination_index)))},
          {"generations_to_99_percent", json_of(quartiles_of(s.each(convergence_generation)))},
          {"seconds", json_of(quartiles_of(s.each(run_seconds)))},
          {"curve", curve},
          {"runs", runs_of(s.runs)}};
}

Json json_of(const GridRecord& grid) {
  Json settings = Json::array(), rankings = Json::array();
  for (const SettingRecord& s : grid.settings) settings.push_back(json_of(s));
  for (const RankingCheck& r : grid.rankings)
    rankings.push_back({{"norm", r.norm},
                        {"points", r.points},
                        {"discordant", r.discordant},
                        {"runs", r.runs},
                        {"same_answer", r.same_answer}});
  return {{"settings", settings},
          {"rankings", rankings},
          {"output",
           {{"recording", grid.output.file},
            {"unit", grid.output.unit},
            {"time", grid.output.time},
            {"measured", grid.output.measured},
            {"simulated", grid.output.simulated},
            {"turning_points", grid.output.peaks},
            {"overshot_share", grid.output.overshot}}}};
}

Json json_of(const Excitation& e) {
  Json knowledge = Json::array(), combinations = Json::array(), ellipses = Json::array();
  for (const ParameterKnowledge& k : e.knowledge)
    knowledge.push_back({{"parameter", k.name},
                         {"unit", k.unit},
                         {"value", k.value},
                         {"relative_standard_error", k.moves ? Json(k.relative_error) : Json(nullptr)},
                         {"moves_anything", k.moves}});
  for (std::size_t i = 0; i < e.combinations.size(); ++i)
    combinations.push_back({{"combination", e.combinations[i].name},
                            {"unit", e.combinations[i].unit},
                            {"value", e.combinations[i].value},
                            {"relative_standard_error", e.combination_error[i]}});
  for (const Ellipse& l : e.ellipses)
    ellipses.push_back({{"x", l.x_name},
                        {"y", l.y_name},
                        {"x_unit", l.x_unit},
                        {"y_unit", l.y_unit},
                        {"centre", {l.x, l.y}},
                        {"boundary_x", l.boundary_x},
                        {"boundary_y", l.boundary_y}});
  return {{"excitation", e.name},         {"assumption", e.assumption},     {"rank", e.rank},
          {"of", e.parameters},           {"condition", e.condition},       {"parameters", knowledge},
          {"combinations", combinations}, {"undetermined", e.undetermined}, {"ellipses", ellipses}};
}

Json json_of(const RivalsRecord& r) {
  if (r.methods.empty()) return nullptr;
  Json methods = Json::array(), levels = Json::array();
  for (const Level& level : success_levels()) levels.push_back({{"name", level.name}, {"factor", level.factor}});
  for (const MethodRecord& m : r.methods)
    methods.push_back({{"method", to_string(m.method)},
                       {"title", title_of(m.method)},
                       {"success", m.success},
                       {"evaluations_to_level", m.reached},
                       {"runs", runs_of(m.runs)}});
  return {{"budget", r.budget},
          {"best_cost", r.best},
          {"levels", levels},
          {"methods", methods},
          {"recommended", r.recommended < 0 ? Json(nullptr) : Json(to_string(r.methods[r.recommended].method))},
          {"reason", r.reason}};
}

Json json_of(const RobustnessRecord& r) {
  if (r.cells.empty()) return nullptr;
  Json cells = Json::array();
  for (const RobustnessCell& c : r.cells)
    cells.push_back({{"condition", c.condition.name}, {"searcher", to_string(c.searcher)}, {"runs", runs_of(c.runs)}});
  return {{"data", r.data}, {"planted", r.planted}, {"cells", cells}};
}

Json json_of(const RecoveryRecord& r) {
  if (r.parameters.empty()) return nullptr;
  Json parameters = Json::array();
  for (const Recovered& p : r.parameters)
    parameters.push_back({{"parameter", p.name},
                          {"unit", p.unit},
                          {"truth", p.truth},
                          {"value", p.value},
                          {"lower95", p.lower95},
                          {"upper95", p.upper95},
                          {"identifiable", p.identifiable}});
  return {{"parameters", parameters}, {"held", r.held}, {"asked", r.asked}};
}

Json json_of(const Conclusion& c) {
  return {{"source", c.source},
          {"claim", c.claim},
          {"verdict", to_string(c.verdict)},
          {"finding", c.finding},
          {"rule", c.rule}};
}

Json cited() {
  Json values = Json::array(), fitness = Json::array();
  for (const paper::Values& v : paper::kValues)
    values.push_back({{"table", v.table}, {"row", v.row}, {"numbers", v.numbers}});
  for (const paper::FitnessRow& f : paper::kFitness)
    fitness.push_back({{"fitness", f.fitness},
                       {"relative_errors_percent", f.relative_errors},
                       {"lowest_fitness", f.lowest_fitness},
                       {"output_error_index", f.output_error_index},
                       {"parameter_error_index_percent", f.parameter_error_index}});
  return {{"parameters", paper::kParameters}, {"values", values}, {"fitness", fitness}};
}

Json json_of(const Study& s) {
  Json engines = Json::array(), excitations = Json::array(), conclusions = Json::array(), skipped = Json::array();
  for (const EngineRecord& e : s.engines)
    engines.push_back({{"engine", e.engine},
                       {"reason", e.reason},
                       {"setting", e.setting.runs.empty() ? Json(nullptr) : json_of(e.setting)}});
  for (const Excitation& e : s.identifiability) excitations.push_back(json_of(e));
  for (const Conclusion& c : s.conclusions) conclusions.push_back(json_of(c));
  for (const SkippedPart& p : s.skipped) skipped.push_back({{"part", p.part}, {"reason", p.reason}});
  return {{"scenario", s.scenario},
          {"data", s.data},
          {"parameters", s.parameters},
          {"units", s.units},
          {"start", s.start},
          {"lower", s.lower},
          {"upper", s.upper},
          {"truth", s.truth.empty() ? Json(nullptr) : Json(s.truth)},
          {"fixed_joints", s.fixed},
          {"output_unit", s.output_unit},
          {"step", {{"seconds", s.step.step}, {"error_over_noise", s.step.error_over_noise}}},
          {"seeds", s.seeds},
          {"population", s.population},
          {"generations", s.generations},
          {"conclusions", conclusions},
          {"grid", s.grid.settings.empty() ? Json(nullptr) : json_of(s.grid)},
          {"engines", engines},
          {"identifiability", excitations},
          {"rivals", json_of(s.rivals)},
          {"robustness", json_of(s.robustness)},
          {"recovery", json_of(s.recovery)},
          {"skipped", skipped},
          {"evaluations", s.evaluations},
          {"run_seconds", s.run_seconds}};
}

Json json_of(const Design& d) {
  return {
      {"name", d.name},     {"log_det", d.log_det}, {"peak_command", d.peak_command},     {"peak_speed", d.peak_speed},
      {"lowest", d.lowest}, {"highest", d.highest}, {"determines", json_of(d.excitation)}};
}

}  // namespace

std::string to_json(std::span<const Study> studies, const Context& context) {
  Json records = Json::array();
  for (const Study& study : studies) records.push_back(json_of(study));
  return json_text({{"format", "lacuna-study/1"},
                    {"seed", context.seed},
                    {"version", context.version},
                    {"paper", cited()},
                    {"scenarios", records},
                    {"context", Json::parse(to_json(context))}});
}

std::string to_json(const DesignResult& result, const std::string& scenario, const std::string& file,
                    const Context& context) {
  Json recordings = Json::array(), history = Json::array();
  for (const Design& d : result.recordings) recordings.push_back(json_of(d));
  for (const GenerationRecord& g : result.history) history.push_back(g.best);
  return json_text({{"format", "lacuna-excitation/1"},
                    {"scenario", scenario},
                    {"seed", context.seed},
                    {"version", context.version},
                    {"commands", file},
                    {"best", json_of(result.best)},
                    {"step", json_of(result.step)},
                    {"recordings", recordings},
                    {"evaluations", result.evaluations},
                    {"history", history},
                    {"context", Json::parse(to_json(context))}});
}

}  // namespace lacuna
