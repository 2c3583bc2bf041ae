// Where independent pieces of work run: in the caller, on threads, or on the threads of several ranks of one job.
// Results never depend on which.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace lacuna {

class Ranks;

/// Set by a signal handler or a caller; long work looks at it between pieces and throws Interrupted.
using StopFlag = std::atomic<bool>;

/// Calls work(worker, piece) for every piece in [0, pieces), each once, `worker` in [0, threads) naming the thread's
/// own scratch. The first exception stops the rest and is rethrown. threads <= 1 runs in the caller.
void parallel_for(int threads, int pieces, const std::function<void(int worker, int piece)>& work,
                  const StopFlag* stop = nullptr);

/// Threads to use where the user names none: the CPUs that this process may run on.
int default_threads();

/// Computes one piece; `worker` in [0, workers()) names scratch of its own.
using PieceWork = std::function<void(int worker, int piece)>;
/// The memory, plain bytes, into which a piece writes all that is wanted of it. Its size must not depend on the
/// results.
using PieceResults = std::function<std::vector<std::span<std::byte>>(int piece)>;

class Executor {
 public:
  virtual ~Executor() = default;

  /// Pieces that this process computes at once.
  virtual int workers() const = 0;

  /// Computes every piece in [0, pieces) once, somewhere. On return all results stand in their places in every process.
  /// `key` is a hash of what the pieces are made of: ranks that were asked for different work end the job (ranks.h).
  /// The first exception of a piece ends the rest and is thrown in every process, Interrupted included.
  virtual void run(int pieces, const PieceWork& work, const PieceResults& results, std::uint64_t key) = 0;
};

/// In the caller for one thread, else on threads; with ranks, each computes its share so. Both must outlive it.
std::unique_ptr<Executor> make_executor(int threads, Ranks* ranks, const StopFlag* stop);

/// FNV-1a, 64 bits, over bytes, going on from `hash`.
std::uint64_t hash_of(std::span<const std::byte> bytes, std::uint64_t hash = 0xcbf29ce484222325U);

}  // namespace lacuna
