#include "tests/fuzz/record_loaders.h"

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "diagnosis/checkpoint.h"
#include "ga/checkpoint.h"
#include "reports/blind.h"
#include "reports/comparison.h"
#include "reports/json.h"
#include "tests/reports/sample.h"
#include "study/runner.h"

namespace lacuna::test {
namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kJsonTokens{"{",          "}",           "[",           "]",
                                           ":",          ",",           "\"",          "null",
                                           "true",       "-1",          "1e999",       "{}",
                                           "[]",         "\"0x1p-3\"",  "\"inf\"",     "\"nan\"",
                                           "\"format\"", "\"problem\"", "\"\\u0000\"", "18446744073709551616",
                                           "\n",         "\xff"};

/// A checkpoint's content with the checksum that goes with it, so that mutants get past that; else as it is.
std::string sealed(const char* format, const std::string& content) {
  const Json parsed = Json::parse(content, nullptr, false);
  if (parsed.is_discarded()) return content;
  return Json{{"format", format}, {"checksum", checksum(parsed.dump())}, {"content", parsed}}.dump();
}

const RunIdentity kRun{"tester", {{"seed", "1"}}, {{0}, {1}, {"x"}}, "p"};

std::vector<std::string> seeds_of_search_checkpoint() {
  const fs::path file = fs::temp_directory_path() / ("lacuna_seed_" + std::to_string(::getpid()));
  save_checkpoint(file, kRun,
                  {.best = {0.1},
                   .best_cost = 1.0 / 3.0,
                   .evaluations = 70,
                   .history = {{.1, .2, .3, .4, 70, 1.5}},
                   .population = {{0, 65535}, {1, 2}},
                   .costs = {1.0, 2.0}});
  const Json whole = Json::parse(read(file));
  remove_checkpoint(file);
  return {whole.at("content").dump()};
}

void load_search_checkpoint(const fs::path& folder, const std::string& bytes) {
  // Its reader sorts the keys before it sums up.
  const nlohmann::json sorted = nlohmann::json::parse(bytes, nullptr, false);
  write(folder / "run.json", sorted.is_discarded() ? bytes : sealed("lacuna-optimizer-checkpoint/1", sorted.dump()));
  load_checkpoint(folder / "run.json", kRun);
}

std::vector<std::string> seeds_of_diagnosis_checkpoint() { return {R"({"problem":"p","rounds":[]})"}; }

void load_diagnosis_checkpoint(const fs::path& folder, const std::string& bytes) {
  write(folder / "run.json", sealed("lacuna-diagnosis-checkpoint/5", bytes));
  DiagnosisCheckpoint(folder / "run.json", "p");
}

std::vector<std::string> seeds_of_study_checkpoint() {
  return {R"({"format":"lacuna-study-checkpoint/1","problem":"p"}
{"key":"a","point":["0x1p-3"],"cost":"0x1p+1","evaluations":10,"curve":[[5,"inf"]],"seconds":"0x0p+0","errors":["0x1p-3","nan","inf","0x1p+0"]}
)"};
}

void load_study_checkpoint(const fs::path& folder, const std::string& bytes) {
  RunnerOptions options;
  options.checkpoint = folder / "runs.jsonl";
  options.problem = "p";
  write(options.checkpoint, bytes);
  const StudyRunner runner(options);
}

std::vector<std::string> seeds_of_verdict() { return {to_json(sample::diagnosis(), sample::context())}; }
void load_verdict(const fs::path&, const std::string& bytes) { read_verdict(bytes, "diagnosis.json"); }

std::vector<std::string> seeds_of_label() {
  return {R"({"case": "d03", "effects": [{"effect": "coulomb_friction", "location": "joint_2", "strength": 25}],
  "left_rms_over_noise": 7.2, "truth": {"gain": [1]}})",
          R"({"effects": [{"effect": "tight_spot", "location": "a", "strength": 2, "stage": "link", "over": ["q", "v"],
  "curve": [{"at": [0.5, -1], "value": 3}]},
  {"effect": "repeated_samples", "location": "a", "strength": 0.2, "stage": "reading", "over": ["t"],
  "events": [{"recording": "r.csv", "from": 1.5, "to": 1.7, "value": null}]}]})"};
}
void load_label(const fs::path&, const std::string& bytes) { read_label(bytes, "label.json"); }

std::vector<std::string> seeds_of_comparison() {
  return {
      R"({"format": "lacuna-compare/1", "scenarios": [{"scenario": "a", "engines": [{"engine": "featherstone", "available": true,
  "acceleration_error": {"value": 1e-9}, "forward_dynamics_ns": {"median": 3, "low": 2, "high": 4},
  "methods": [{"native": true, "method": "rk4", "trajectory_error": 1e-8, "ns_per_step": {"median": 4}}]}]}],
  "context": {"date": "today", "commit": "abc"}})"};
}
void load_comparison(const fs::path&, const std::string& bytes) { changes_since(bytes, "old.json", {}); }

}  // namespace

std::vector<Loader> record_loaders() {
  return {
      {"search_checkpoint", kJsonTokens, seeds_of_search_checkpoint, load_search_checkpoint},
      {"diagnosis_checkpoint", kJsonTokens, seeds_of_diagnosis_checkpoint, load_diagnosis_checkpoint},
      {"study_checkpoint", kJsonTokens, seeds_of_study_checkpoint, load_study_checkpoint},
      {"verdict", kJsonTokens, seeds_of_verdict, load_verdict},
      {"label", kJsonTokens, seeds_of_label, load_label},
      {"comparison", kJsonTokens, seeds_of_comparison, load_comparison},
  };
}

}  // namespace lacuna::test
