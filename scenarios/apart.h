// Work in a process of its own: what breaks there breaks nothing here.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace lacuna {

struct ApartLimits {
  double seconds = 15.0;      ///< of the clock on the wall; then the process is ended
  std::uintmax_t memory = 0;  ///< bytes that it may ask for beyond what it begins with
  std::uintmax_t result = 0;  ///< bytes of what it gives back
};

/// What became of the work.
struct ApartOutcome {
  bool done = false;
  std::string result;   ///< what it gave back
  std::string failure;  ///< else what ended it, in words ("ended by signal 11")
};

/// Runs `work` in a forked process, with standard error shut and no core dump, and hands back what it returned. For
/// libraries that crash, spin or eat memory on hostile files. `work` must not throw, take locks that other threads may
/// hold, or write anything. Throws WorkError where no process can be started.
ApartOutcome run_apart(const std::function<std::string()>& work, const ApartLimits& limits);

}  // namespace lacuna
