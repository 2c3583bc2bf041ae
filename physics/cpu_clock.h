// What a computation costs, whoever else runs on the machine.
#pragma once

#include <ctime>

namespace lacuna {

/// CPU time of the calling thread, s.
inline double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace lacuna
