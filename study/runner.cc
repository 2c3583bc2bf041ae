#include "study/runner.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "ga/checkpoint.h"
#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kStudyCheckpoint = "lacuna-study-checkpoint/1";
constexpr std::uint64_t kRestored = 0x7374756479;  // key of the meeting at which the first rank says what is done
constexpr std::size_t kRunsBetweenMeetings = 32;   // of a rank, whatever its threads: machines may differ in CPUs

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

/// The file's lines of finished runs; the file is left with these and no others.
std::string StudyRunner::read_checkpoint() const {
  std::string head = head_of(options_.problem), runs;
  std::error_code ignored;
  if (std::filesystem::exists(options_.checkpoint, ignored)) {
    std::ifstream in(options_.checkpoint);
    std::string line;
    std::getline(in, line);
    const Json found = Json::parse(line, nullptr, false);
    if (!found.is_object() || found.value("format", Json()) != kStudyCheckpoint)
      throw InputError(options_.checkpoint.string(), "no checkpoint of a study", "one; remove the file to start anew");
    if (found.value("problem", Json()) != options_.problem)
      throw InputError(options_.checkpoint.string(), "the checkpoint of another scenario, recording or option",
                       "one of this command; remove the file or name another output folder");
    while (std::getline(in, line)) {
      const Json entry = Json::parse(line, nullptr, false);
      if (!entry.is_object()) break;  // cut off by a crash
      try {
        run_from(entry);
        entry.at("key").get<std::string>();
      } catch (const std::exception&) {
        break;
      }
      runs += line + "\n";
    }
  }
  write_file_atomically(options_.checkpoint, head + runs);
  return runs;
}

void StudyRunner::restore() {
  if (options_.checkpoint.empty()) return;
  std::string runs;
  std::exception_ptr failure;
  try {
    if (first()) runs = read_checkpoint();
  } catch (...) {
    if (options_.ranks == nullptr) throw;
    failure = std::current_exception();
  }
  if (options_.ranks != nullptr) runs = options_.ranks->share_texts(kRestored, failure, runs).front();
  take(runs);
}

void StudyRunner::keep(const std::string& line) const {
  if (options_.checkpoint.empty() || !first()) return;
  append_to_file(options_.checkpoint, line);
}

void StudyRunner::take(const std::string& lines) {
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);) {
    const Json entry = Json::parse(line);
    done_[entry.at("key")] = run_from(entry);
  }
}

void StudyRunner::add(const std::string& key, double weight, std::function<SearchRun()> work) {
  for (const Job& job : jobs_) {
    if (job.key == key) throw std::logic_error("StudyRunner: two runs called " + key);
  }
  jobs_.push_back({key, weight, std::move(work)});
}

/// Lines of these runs, computed here; kept one by one where this process is alone.
std::string StudyRunner::carry_out(const std::vector<const Job*>& mine, const std::function<void(const Job&)>& tell) {
  std::mutex mutex;
  std::string lines;
  parallel_for(
      options_.threads, static_cast<int>(mine.size()),
      [&](int, int piece) {
        const Job& job = *mine[piece];
        const std::string line = to_json(job.key, job.work()).dump() + "\n";
        const std::lock_guard lock(mutex);
        lines += line;
        if (options_.ranks != nullptr) return;
        keep(line);
        tell(job);
      },
      options_.stop);
  return lines;
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
  const auto say = [&](const std::string& stage) {
    if (options_.progress) options_.progress({stage, total > 0.0 ? finished / total : 1.0, 0.0, 0});
  };
  const auto tell = [&](const Job& job) {
    finished += job.weight;
    say(job.key);
  };
  say("searching");
  if (options_.ranks == nullptr) return take(carry_out(left, tell));

  // Ranks meet after some runs each: often enough to lose little to a crash, seldom enough not to wait for each other.
  Ranks& ranks = *options_.ranks;
  const std::size_t size = ranks.size();
  const std::size_t block = size * kRunsBetweenMeetings;
  for (std::size_t begin = 0; begin < left.size(); begin += block) {
    const std::size_t end = std::min(left.size(), begin + block);
    std::vector<const Job*> mine;
    for (std::size_t i = begin + static_cast<std::size_t>(ranks.rank()); i < end; i += size) mine.push_back(left[i]);
    std::string lines;
    std::exception_ptr failure;
    try {
      lines = carry_out(mine, tell);
    } catch (...) {
      failure = std::current_exception();
    }
    const std::uint64_t key = std::hash<std::string>{}(options_.problem + left[begin]->key);
    for (const std::string& of_rank : ranks.share_texts(key, failure, lines)) {
      keep(of_rank);
      take(of_rank);
    }
    for (std::size_t i = begin; i < end; ++i) tell(*left[i]);
  }
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
