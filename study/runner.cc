#include "study/runner.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "ga/checkpoint.h"
#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kStudyCheckpoint = "lacuna-study-checkpoint/1";

Json to_json(const std::string& key, const SearchRun& run) {
  Json point = Json::array(), curve = Json::array();
  for (const double x : run.point) point.push_back(exact_text(x));
  for (const SearchRun::Entry& entry : run.curve) curve.push_back({entry.evaluations, exact_text(entry.best)});
  return {{"key", key},
          {"point", point},
          {"cost", exact_text(run.cost)},
          {"evaluations", run.evaluations},
          {"curve", curve},
          {"seconds", exact_text(run.seconds)},
          {"errors",
           {exact_text(run.errors.output_largest), exact_text(run.errors.output_rms),
            exact_text(run.errors.parameter_index), exact_text(run.errors.combination_index)}}};
}

SearchRun run_from(const Json& line) {
  SearchRun run;
  for (const Json& x : line.at("point")) run.point.push_back(exact_number(x));
  run.cost = exact_number(line.at("cost"));
  run.evaluations = line.at("evaluations");
  for (const Json& entry : line.at("curve")) run.curve.push_back({entry.at(0), exact_number(entry.at(1))});
  run.seconds = exact_number(line.at("seconds"));
  const Json& e = line.at("errors");
  run.errors = {exact_number(e.at(0)), exact_number(e.at(1)), exact_number(e.at(2)), exact_number(e.at(3))};
  return run;
}

std::string head_of(const std::string& problem) {
  return Json{{"format", kStudyCheckpoint}, {"problem", problem}}.dump() + "\n";
}

}  // namespace

StudyRunner::StudyRunner(RunnerOptions options) : options_(std::move(options)) { restore(); }

void StudyRunner::restore() {
  if (options_.checkpoint.empty()) return;
  std::string whole = head_of(options_.problem);
  std::error_code ignored;
  if (std::filesystem::exists(options_.checkpoint, ignored)) {
    std::ifstream in(options_.checkpoint);
    std::string line;
    std::getline(in, line);
    const Json head = Json::parse(line, nullptr, false);
    if (!head.is_object() || head.value("format", "") != kStudyCheckpoint)
      throw InputError(options_.checkpoint.string(), "no checkpoint of a study", "one; remove the file to start anew");
    if (head.value("problem", "") != options_.problem)
      throw InputError(options_.checkpoint.string(), "the checkpoint of another scenario, recording or option",
                       "one of this command; remove the file or name another output folder");
    while (std::getline(in, line)) {
      const Json entry = Json::parse(line, nullptr, false);
      if (!entry.is_object()) break;  // cut off by a crash
      try {
        done_[entry.at("key")] = run_from(entry);
      } catch (const std::exception&) {
        break;
      }
      whole += line + "\n";
    }
  }
  write_file_atomically(options_.checkpoint, whole);
}

void StudyRunner::keep(const std::string& key, const SearchRun& run) {
  if (options_.checkpoint.empty()) return;
  std::ofstream out(options_.checkpoint, std::ios::app);
  out << to_json(key, run).dump() + "\n" << std::flush;
  if (!out) throw WorkError(options_.checkpoint.string() + ": cannot write the checkpoint");
}

void StudyRunner::add(const std::string& key, double weight, std::function<SearchRun()> work) {
  for (const Job& job : jobs_) {
    if (job.key == key) throw std::logic_error("StudyRunner: two runs called " + key);
  }
  jobs_.push_back({key, weight, std::move(work)});
}

void StudyRunner::execute() {
  double total = 0.0, finished = 0.0;
  std::vector<const Job*> left;
  for (const Job& job : jobs_) {
    total += job.weight;
    if (done_.count(job.key) > 0) {
      finished += job.weight;
    } else {
      left.push_back(&job);
    }
  }
  std::mutex mutex;
  const auto tell = [&](const std::string& stage) {
    if (options_.progress) options_.progress({stage, total > 0.0 ? finished / total : 1.0, 0.0, 0});
  };
  tell("searching");
  parallel_for(
      options_.threads, static_cast<int>(left.size()),
      [&](int, int piece) {
        const Job& job = *left[static_cast<std::size_t>(piece)];
        SearchRun run = job.work();
        const std::lock_guard lock(mutex);
        keep(job.key, run);
        done_[job.key] = std::move(run);
        finished += job.weight;
        tell(job.key);
      },
      options_.stop);
}

const SearchRun& StudyRunner::at(const std::string& key) const {
  const auto found = done_.find(key);
  if (found == done_.end()) throw std::logic_error("StudyRunner: no run called " + key);
  return found->second;
}

std::pair<long, double> StudyRunner::spent() const {
  std::pair<long, double> out{0, 0.0};
  for (const Job& job : jobs_) {
    const SearchRun& run = at(job.key);
    out.first += run.evaluations;
    out.second += run.seconds;
  }
  return out;
}

}  // namespace lacuna
