#include "physics/executor.h"

#include <sched.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "physics/ranks.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

class SerialExecutor final : public Executor {
 public:
  explicit SerialExecutor(const StopFlag* stop) : stop_(stop) {}
  int workers() const override { return 1; }
  void run(int pieces, const PieceWork& work, const PieceResults&, std::uint64_t) override {
    for (int piece = 0; piece < pieces; ++piece) {
      if (stop_ != nullptr && *stop_) throw Interrupted();
      work(0, piece);
    }
  }

 private:
  const StopFlag* stop_;
};

class ThreadExecutor final : public Executor {
 public:
  ThreadExecutor(int threads, const StopFlag* stop) : threads_(threads), stop_(stop) {}
  int workers() const override { return threads_; }
  void run(int pieces, const PieceWork& work, const PieceResults&, std::uint64_t) override {
    parallel_for(threads_, pieces, work, stop_);
  }

 private:
  int threads_;
  const StopFlag* stop_;
};

/// Piece k belongs to rank k modulo their number, so nothing needs to be agreed before the work.
class RankExecutor final : public Executor {
 public:
  RankExecutor(int threads, Ranks& ranks) : ranks_(ranks), own_(make_executor(threads, nullptr, &ranks.asked())) {}
  int workers() const override { return own_->workers(); }

  void run(int pieces, const PieceWork& work, const PieceResults& results, std::uint64_t key) override {
    const int size = ranks_.size(), rank = ranks_.rank();
    const int share = (pieces - rank + size - 1) / size;
    std::exception_ptr failure;
    try {
      own_->run(
          share, [&](int worker, int k) { work(worker, rank + k * size); }, results, key);
    } catch (...) {
      failure = std::current_exception();
    }
    std::vector<std::size_t> bytes(size, 0);
    each_place(pieces, results, [&](std::size_t owner, std::span<std::byte> place) { bytes[owner] += place.size(); });
    std::vector<std::byte> mine;
    mine.reserve(bytes[rank]);
    each_place(pieces, results, [&](std::size_t owner, std::span<std::byte> place) {
      if (owner == static_cast<std::size_t>(rank)) mine.insert(mine.end(), place.begin(), place.end());
    });
    const std::vector<std::vector<std::byte>> all = ranks_.share(key, failure, mine, bytes);
    std::vector<std::size_t> taken(bytes.size(), 0);
    each_place(pieces, results, [&](std::size_t owner, std::span<std::byte> place) {
      if (owner != static_cast<std::size_t>(rank) && !place.empty())
        std::memcpy(place.data(), all[owner].data() + taken[owner], place.size());
      taken[owner] += place.size();
    });
  }

 private:
  template <class Visit>
  void each_place(int pieces, const PieceResults& results, const Visit& visit) const {
    for (int piece = 0; piece < pieces; ++piece)
      for (const std::span<std::byte> place : results(piece))
        visit(static_cast<std::size_t>(piece % ranks_.size()), place);
  }

  Ranks& ranks_;
  std::unique_ptr<Executor> own_;
};

/// oneTBB's threads are as many as the cores unless told so. The most that was ever asked for stays allowed: of several
/// limits in force at once the lowest would count.
void allow_threads(int threads) {
  static std::mutex mutex;
  static std::optional<tbb::global_control> allowed;
  constexpr auto limit = tbb::global_control::max_allowed_parallelism;
  const std::lock_guard lock(mutex);
  if (tbb::global_control::active_value(limit) >= static_cast<std::size_t>(threads)) return;
  allowed.reset();
  allowed.emplace(limit, static_cast<std::size_t>(threads));
}

}  // namespace

int default_threads() {
  cpu_set_t cpus;
  if (::sched_getaffinity(0, sizeof cpus, &cpus) == 0) return std::max(1, CPU_COUNT(&cpus));
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

void parallel_for(int threads, int pieces, const std::function<void(int, int)>& work, const StopFlag* stop) {
  std::atomic<int> next{0};
  const auto run = [&](int worker) {
    for (int piece = next++; piece < pieces && !tbb::is_current_task_group_canceling(); piece = next++) {
      if (stop != nullptr && *stop) throw Interrupted();
      work(worker, piece);
    }
  };
  const int workers = std::min(threads, pieces);
  if (workers <= 1) return run(0);
  allow_threads(workers);
  // A worker is one task, so none works twice at once; an arena and isolation of its own, so that one that waits for a
  // call within a piece takes up nothing of this one meanwhile.
  tbb::task_arena(workers).execute([&] {
    tbb::parallel_for(
        0, workers, [&](int worker) { tbb::this_task_arena::isolate([&] { run(worker); }); },
        tbb::simple_partitioner());
  });
}

std::unique_ptr<Executor> make_executor(int threads, Ranks* ranks, const StopFlag* stop) {
  if (ranks != nullptr) return std::make_unique<RankExecutor>(threads, *ranks);
  if (threads > 1) return std::make_unique<ThreadExecutor>(threads, stop);
  return std::make_unique<SerialExecutor>(stop);
}

std::uint64_t hash_of(std::span<const std::byte> bytes, std::uint64_t hash) {
  for (const std::byte b : bytes) hash = (hash ^ static_cast<std::uint64_t>(b)) * 0x100000001b3U;
  return hash;
}

}  // namespace lacuna
