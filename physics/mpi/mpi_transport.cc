// Ranks over MPI. A library of its own (liblacuna_mpi.so), loaded by load.cc when a launcher started us as a rank:
// nobody else needs MPI installed, let alone initialised.
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <ctime>

#include "physics/ranks.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

/// Tests of a request before the CPU is left to others, some 100 us; then looks every 50 us.
constexpr int kSpins = 300;
constexpr long kNap = 50'000;  // ns

/// Largest message, all ranks together: MPI counts in int.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

void check(int code, const char* call) {
  if (code == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  throw WorkError(std::string("the connection to the other ranks failed: ") + call + ": " + text.data());
}

class MpiTransport final : public RankTransport {
 public:
  MpiTransport() {
    int level = 0;
    // One thread, that of main(), talks to MPI.
    check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level), "MPI_Init_thread");
    check(MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    check(MPI_Comm_rank(MPI_COMM_WORLD, &rank_), "MPI_Comm_rank");
    check(MPI_Comm_size(MPI_COMM_WORLD, &size_), "MPI_Comm_size");
    MPI_Comm machine = MPI_COMM_NULL;
    check(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine), "MPI_Comm_split_type");
    check(MPI_Comm_size(machine, &neighbours_), "MPI_Comm_size");
    check(MPI_Comm_free(&machine), "MPI_Comm_free");
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int neighbours() const override { return neighbours_; }

  std::string host() const override {
    std::array<char, MPI_MAX_PROCESSOR_NAME> name{};
    int length = 0;
    check(MPI_Get_processor_name(name.data(), &length), "MPI_Get_processor_name");
    return name.data();
  }

  bool gather(std::span<const std::byte> mine, std::span<const std::size_t> bytes, std::span<std::byte> all,
              const std::function<bool()>& patient) override {
    const std::size_t ranks = bytes.size(), most = kMostBytes / ranks;
    const std::size_t longest = *std::max_element(bytes.begin(), bytes.end());
    std::vector<std::byte> part;
    for (std::size_t done = 0; done < longest; done += most) {
      std::vector<int> counts, places;
      int total = 0;
      for (const std::size_t n : bytes) {
        counts.push_back(static_cast<int>(std::min(n - std::min(n, done), most)));
        places.push_back(total);
        total += counts.back();
      }
      part.resize(total);
      MPI_Request request = MPI_REQUEST_NULL;
      check(MPI_Iallgatherv(mine.data() + std::min(done, mine.size()), counts[rank_], MPI_BYTE, part.data(),
                            counts.data(), places.data(), MPI_BYTE, MPI_COMM_WORLD, &request),
            "MPI_Iallgatherv");
      if (!wait(request, patient)) return false;
      std::size_t start = 0;
      for (std::size_t r = 0; r < ranks; start += bytes[r++])
        std::copy_n(part.data() + places[r], counts[r], all.data() + start + std::min(done, bytes[r]));
    }
    return true;
  }

  void leave() override { check(MPI_Finalize(), "MPI_Finalize"); }

 private:
  static bool wait(MPI_Request& request, const std::function<bool()>& patient) {
    int done = 0;
    for (int looks = 0;; ++looks) {
      check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test");
      if (done != 0) return true;
      if (!patient()) return false;
      if (looks < kSpins) continue;
      const timespec nap{0, kNap};
      ::nanosleep(&nap, nullptr);
    }
  }

  int rank_ = 0, size_ = 1, neighbours_ = 1;
};

}  // namespace
}  // namespace lacuna

extern "C" {

lacuna::RankTransport* lacuna_mpi_transport() { return new lacuna::MpiTransport; }

const char* lacuna_mpi_version() {
  static std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  if (MPI_Get_library_version(text.data(), &length) != MPI_SUCCESS) return "unknown";
  text[std::min(static_cast<std::size_t>(length), std::strcspn(text.data(), ",\n"))] = '\0';
  return text.data();
}

}  // extern "C"
