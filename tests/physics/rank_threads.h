// Ranks as threads of the test's own process: what MPI does between processes, without a launcher.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "physics/ranks.h"

namespace lacuna::test {

/// Where the threads of one job meet.
class MeetingPlace {
 public:
  explicit MeetingPlace(int size) : size_(size) {}
  int size() const { return size_; }

  bool gather(int rank, std::span<const std::byte> mine, std::span<std::byte> all,
              const std::function<bool()>& patient) {
    std::unique_lock lock(mutex_);
    const int meeting = done_;
    brought_[rank].assign(mine.begin(), mine.end());
    if (static_cast<int>(brought_.size()) == size_) {
      together_.clear();
      for (const auto& [unused, bytes] : brought_) together_.insert(together_.end(), bytes.begin(), bytes.end());
      brought_.clear();
      ++done_;
      changed_.notify_all();
    }
    while (done_ == meeting) {
      if (changed_.wait_for(lock, std::chrono::milliseconds(1)) == std::cv_status::timeout && !patient()) return false;
    }
    // The next meeting ends only when this rank has come to it, so `together_` is still that of this one.
    std::copy(together_.begin(), together_.end(), all.begin());
    return together_.size() == all.size();
  }

 private:
  const int size_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int, std::vector<std::byte>> brought_;
  std::vector<std::byte> together_;
  int done_ = 0;
};

class ThreadTransport final : public RankTransport {
 public:
  ThreadTransport(MeetingPlace& place, int rank) : place_(place), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return place_.size(); }
  int neighbours() const override { return place_.size(); }
  std::string host() const override { return "here"; }
  bool gather(std::span<const std::byte> mine, std::span<const std::size_t>, std::span<std::byte> all,
              const std::function<bool()>& patient) override {
    return place_.gather(rank_, mine, all, patient);
  }
  void leave() override {}

 private:
  MeetingPlace& place_;
  int rank_;
};

/// Runs `program` on every rank of a job of `size`; each has a stop flag of its own.
inline void on_ranks(int size, const std::function<void(Ranks&, StopFlag&)>& program) {
  MeetingPlace place(size);
  std::vector<std::thread> processes;
  processes.reserve(size);
  for (int rank = 0; rank < size; ++rank) {
    processes.emplace_back([&, rank] {
      StopFlag asked{false};
      Ranks ranks(std::make_unique<ThreadTransport>(place, rank), asked);
      program(ranks, asked);
    });
  }
  for (std::thread& process : processes) process.join();
}

}  // namespace lacuna::test
