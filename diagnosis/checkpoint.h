// A diagnosis on disk after each step, so that a killed run goes on where it was, to the same result.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "diagnosis/screen.h"
#include "diagnosis/set_search.h"

namespace lacuna {

/// Steps are stored in order and restored in order. Without a file nothing is stored and nothing restored.
/// A file of another problem (scenario, data, options) is refused with an InputError.
class DiagnosisCheckpoint {
 public:
  /// `writes` false: another process (rank) writes the file.
  DiagnosisCheckpoint(std::filesystem::path file, std::string problem, bool writes = true);
  ~DiagnosisCheckpoint();

  /// Path for a search's own checkpoint beside this one; empty without a file.
  std::filesystem::path part(const std::string& name) const;

  /// The plain model's fit is evaluated anew at the stored point: same point, same bits.
  bool restore_baseline(const FitContext& context, CurrentModel& model, FitResult& fit) const;
  void store_baseline(const CurrentModel& model, const FitResult& fit);

  /// The context takes on the step of what was found.
  bool restore_round(int round, FitContext& context, CurrentModel& model, std::optional<Finding>& finding,
                     std::vector<Candidate>& candidates) const;
  void store_round(const CurrentModel& model, const std::optional<Finding>& finding,
                   const std::vector<Candidate>& candidates, double step);

  /// What the search with sets came to; nothing: that all stands as it is. `plain` is what its model is grown from.
  bool restore_sets(const std::string& which, const CurrentModel& plain, const Experiment& experiment,
                    std::optional<SetSearchResult>& sets) const;
  void store_sets(const std::string& which, const PlantModel& plain, const std::optional<SetSearchResult>& sets);

  /// For the caller, once the result is safe: removes this file and its parts.
  static void remove(const std::filesystem::path& file);

 private:
  struct Content;
  void write() const;
  std::filesystem::path file_;
  bool writes_;
  std::unique_ptr<Content> content_;
};

}  // namespace lacuna
