#include "physics/executor.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "scenarios/error.h"

namespace lacuna {

int default_threads() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

void parallel_for(int threads, int pieces, const std::function<void(int, int)>& work, const StopFlag* stop) {
  std::atomic<int> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr error;
  std::mutex error_mutex;
  auto run = [&](int worker) {
    for (int piece = next++; piece < pieces && !failed; piece = next++) {
      try {
        if (stop != nullptr && *stop) throw Interrupted();
        work(worker, piece);
      } catch (...) {
        const std::lock_guard lock(error_mutex);
        if (!failed.exchange(true)) error = std::current_exception();
      }
    }
  };
  std::vector<std::thread> pool;
  for (int worker = 1; worker < std::min(threads, pieces); ++worker) pool.emplace_back(run, worker);
  run(0);
  for (std::thread& thread : pool) thread.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace lacuna
