// The state of an unfinished optimisation on disk: JSON, replaced atomically after every generation, numbers stored
// exactly (doubles as hexadecimal floating point), so that a resumed run continues bit for bit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ga/coding.h"
#include "ga/optimizer.h"

namespace lacuna {

/// What a run is. A checkpoint is resumed only by a run of the same identity.
struct RunIdentity {
  std::string optimizer;
  std::vector<std::pair<std::string, std::string>> options;  ///< everything that influences the result, as exact text
  Box box;
  std::string problem;  ///< RunControl::problem
};

/// Where a run is, after `history.size()` generations.
struct Checkpoint {
  std::vector<double> best;
  double best_cost = 0.0;
  long evaluations = 0;
  std::vector<GenerationRecord> history;
  std::vector<Chromosome> population;  ///< genetic algorithm: the last generation
  std::vector<double> costs;           ///< genetic algorithm: of `population`; library optimisers: of all evaluations
};

/// A double as text that reads back to the same bits, infinities included ("0x1.8p+1", "inf").
std::string exact_text(double value);
/// The double that it stands for. Throws std::runtime_error where it is none.
double exact_number(const std::string& text);
/// Of a checkpoint's compact text: finds damage, not intent.
std::string checksum(const std::string& text);

/// Writes to a file beside it, syncs and renames: a reader, also after a crash, sees the old or the new file, whole.
/// Throws WriteError, naming the file and the system's reason.
void save_checkpoint(const std::filesystem::path& file, const RunIdentity& identity, const Checkpoint& checkpoint);

/// Nothing if the file does not exist. Throws InputError if it is damaged, of another optimiser, box, problem or option
/// (naming which), or not readable.
std::optional<Checkpoint> load_checkpoint(const std::filesystem::path& file, const RunIdentity& identity);

/// For callers to call once their result is safe elsewhere; with what killed runs left beside it. No error if there is
/// no such file.
void remove_checkpoint(const std::filesystem::path& file);

}  // namespace lacuna
