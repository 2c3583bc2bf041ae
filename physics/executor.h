// Runs independent pieces of work on threads. Results never depend on how many.
#pragma once

#include <atomic>
#include <functional>

namespace lacuna {

/// Set by a signal handler or a caller; long work looks at it between pieces and throws Interrupted.
using StopFlag = std::atomic<bool>;

/// Calls work(worker, piece) for every piece in [0, pieces), each once, `worker` in [0, threads) naming the thread's
/// own scratch. The first exception stops the rest and is rethrown. threads <= 1 runs in the caller.
void parallel_for(int threads, int pieces, const std::function<void(int worker, int piece)>& work,
                  const StopFlag* stop = nullptr);

/// Threads to use where the user names none.
int default_threads();

}  // namespace lacuna
