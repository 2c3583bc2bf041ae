// Carries out a study's runs on all threads and ranks, keeps every finished one on disk, and takes up an interrupted
// study again.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "physics/ranks.h"
#include "study/search.h"

namespace lacuna {

struct RunnerOptions {
  int threads = 1;
  Ranks* ranks = nullptr;  ///< that share the runs; null: this process does them all
  const StopFlag* stop = nullptr;
  std::filesystem::path checkpoint;               ///< empty: nothing is kept; of several ranks the first one keeps it
  std::string problem;                            ///< what the runs are about; a file of another problem is refused
  std::function<void(const Progress&)> progress;  ///< called after every run, from any thread, one call at a time
};

/// Runs are added under unique keys, then executed together; what is on disk is not run again. Every run is computed by
/// one thread from its own seed, so results depend neither on the numbers of threads and ranks nor on
/// interruptions.
///
/// The file holds one line a finished run, numbers exact; a line cut off by a crash is dropped.
class StudyRunner {
 public:
  explicit StudyRunner(RunnerOptions options);

  /// `weight`: the run's expected cost in any unit, for the progress.
  void add(const std::string& key, double weight, std::function<SearchRun()> work);
  /// Throws Interrupted (finished runs are kept), or what a run throws.
  void execute();
  const SearchRun& at(const std::string& key) const;
  /// Evaluations and seconds of all runs that were added.
  std::pair<long, double> spent() const;

 private:
  struct Job {
    std::string key;
    double weight = 0.0;
    std::function<SearchRun()> work;
  };
  bool first() const { return options_.ranks == nullptr || options_.ranks->first(); }
  std::string read_checkpoint() const;
  void restore();
  void keep(const std::string& line) const;
  void take(const std::string& line);
  std::string carry_out(const std::vector<const Job*>& mine, const std::function<void(const Job&)>& tell);

  RunnerOptions options_;
  std::vector<Job> jobs_;
  std::map<std::string, SearchRun> done_;
};

}  // namespace lacuna
