// The ranks of one job (`mpirun -n N lacuna ...`): processes that run the same program on the same input.
//
// Every rank takes every decision itself, from the same bits. What is shared is the work between decisions: each rank
// computes some pieces, then all meet and hand each other the results (executor.h). A meeting also tells who was asked
// to stop, who failed and who works on something else, so that all go on, or all end, at the same place. Only the first
// rank writes, prints and shows progress.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "physics/executor.h"
#include "scenarios/error.h"

namespace lacuna {

/// How ranks reach each other: MPI (physics/mpi/), or threads in tests.
class RankTransport {
 public:
  virtual ~RankTransport() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Ranks on this machine, this one included.
  virtual int neighbours() const = 0;
  virtual std::string host() const = 0;
  /// The bytes of all ranks, one after the other; bytes[r] is how many rank r brings. Every rank must call it. Waits
  /// for the others as long as `patient` says so; false if it gave up, after which nothing more may be called. Throws
  /// WorkError where the connection fails.
  virtual bool gather(std::span<const std::byte> mine, std::span<const std::size_t> bytes, std::span<std::byte> all,
                      const std::function<bool()>& patient) = 0;
  /// The regular end, every rank's last call.
  virtual void leave() = 0;
};

/// How the program ends: exit code and message, empty for none.
struct Ending {
  int code = 0;
  std::string message;
};

/// The ranks cannot go on together. Like an interruption, it passes through all that deals with single failures.
class RanksParted : public Interrupted {
 public:
  explicit RanksParted(const Ending& ending) : Interrupted(ending.message), code(ending.code) {}
  int code;
};

class Ranks {
 public:
  /// `asked` is set by this process's signals. A meeting.
  Ranks(std::unique_ptr<RankTransport> transport, const StopFlag& asked);

  int rank() const { return transport_->rank(); }
  int size() const { return transport_->size(); }
  bool first() const { return rank() == 0; }
  int neighbours() const { return transport_->neighbours(); }
  const StopFlag& asked() const { return asked_; }
  /// What the program's own loops look at: set on every rank at the same meeting, after any of them was asked to stop.
  const StopFlag& stop() const { return stop_; }

  /// A meeting, the first: `identity` is what must be alike on all ranks for equal bits (program, instruction set), in
  /// words. Throws RanksParted where it is not.
  void agree_on(const std::string& identity);
  /// A meeting: what every rank brings, by rank; bytes[r] of rank r, known to all. With a `failure` on any rank all
  /// throw the lowest rank's, as std::invalid_argument (bad input) or WorkError. Throws Interrupted if any rank was
  /// asked to stop, RanksParted where the keys differ or a rank has left.
  std::vector<std::vector<std::byte>> share(std::uint64_t key, const std::exception_ptr& failure,
                                            std::span<const std::byte> mine, std::span<const std::size_t> bytes);
  /// The same for what is as long as it comes out. Two meetings.
  std::vector<std::string> share_texts(std::uint64_t key, const std::exception_ptr& failure, const std::string& mine);
  /// The first rank's answer, on every rank. A meeting.
  bool as_first(bool answer);

  /// The last meeting: what all ranks end with. Ranks that have parted, or do not answer, are not waited for.
  Ending part(Ending mine);
  /// The regular end of the transport, after all has been said. False where others were given up: what would wait for
  /// them when the process ends must be passed by.
  bool leave();

 private:
  enum class Kind : std::uint32_t { at_work, asked_to_stop, failed, leaving };
  struct Word {  ///< what each rank says first at a meeting
    Kind kind = Kind::at_work;
    std::int32_t code = 0;
    std::uint64_t key = 0;
  };

  std::vector<Word> words_of_all(const Word& mine);
  std::vector<std::vector<std::byte>> gather(std::span<const std::byte> mine, std::span<const std::size_t> bytes);
  std::vector<std::string> texts(const std::string& mine);
  void judge(const std::vector<Word>& words, const std::vector<std::string>& messages);
  [[noreturn]] void end(int code, const std::string& message);
  std::string name(std::size_t rank) const;

  std::unique_ptr<RankTransport> transport_;
  const StopFlag& asked_;
  StopFlag stop_{false};
  std::vector<std::string> hosts_;
  bool parted_ = false, lost_ = false;
};

/// Whether a launcher (mpirun, srun) started this process as one of several.
bool started_as_rank();

/// Joins the job's other ranks. Loads MPI now, and only here. Throws WorkError where it is missing.
std::unique_ptr<Ranks> join_ranks(const StopFlag& asked);

struct RanksInfo {
  std::string version;  ///< of the MPI library; empty: not available
  std::string reason;   ///< why not
};
RanksInfo ranks_info();

}  // namespace lacuna
