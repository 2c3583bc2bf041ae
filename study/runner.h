// Carries out a study's runs on all threads, keeps every finished one on disk, and takes up an interrupted study again.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "study/search.h"

namespace lacuna {

struct RunnerOptions {
  int threads = 1;
  const StopFlag* stop = nullptr;
  std::filesystem::path checkpoint;               ///< empty: nothing is kept
  std::string problem;                            ///< what the runs are about; a file of another problem is refused
  std::function<void(const Progress&)> progress;  ///< called after every run, from any thread, one call at a time
};

/// Runs are added under unique keys, then executed together; what is on disk is not run again. Every run is computed by
/// one thread from its own seed, so results depend neither on the number of threads nor on interruptions.
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
  void restore();
  void keep(const std::string& key, const SearchRun& run);

  RunnerOptions options_;
  std::vector<Job> jobs_;
  std::map<std::string, SearchRun> done_;
};

}  // namespace lacuna
