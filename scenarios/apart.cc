#include "scenarios/apart.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>

#include "scenarios/error.h"

namespace lacuna {
namespace {

/// Written before and behind the result: what lacks either is no result.
constexpr char kBegun = 'b', kEnded = 'e';

void restrain([[maybe_unused]] const ApartLimits& limits) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
#ifndef __SANITIZE_ADDRESS__  // whose shadow is larger than any limit
  unsigned long pages = 0;
  if (std::FILE* own = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(own, "%lu", &pages) != 1) pages = 0;
    std::fclose(own);
  }
  const auto most = static_cast<rlim_t>(pages * static_cast<std::uintmax_t>(sysconf(_SC_PAGESIZE)) + limits.memory);
  const rlimit memory{most, most};
  if (pages > 0) setrlimit(RLIMIT_AS, &memory);
#endif
  const int nowhere = ::open("/dev/null", O_WRONLY);
  if (nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
  for (const int number : {SIGINT, SIGTERM, SIGSEGV, SIGBUS, SIGABRT, SIGFPE}) ::signal(number, SIG_DFL);
}

void write_all(int descriptor, const char* data, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t written = ::write(descriptor, data, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    data += written, bytes -= static_cast<std::size_t>(written);
  }
}

[[noreturn]] void work_here(const std::function<std::string()>& work, const ApartLimits& limits, int descriptor) {
  restrain(limits);
  write_all(descriptor, &kBegun, 1);
  const std::string result = work();
  write_all(descriptor, result.data(), result.size());
  write_all(descriptor, &kEnded, 1);
  ::_exit(0);
}

/// Reads until the other side closes; false where the time is up or there is too much.
bool listen(int descriptor, const ApartLimits& limits, std::string& heard, std::string& failure) {
  using Clock = std::chrono::steady_clock;
  const auto end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits.seconds));
  std::array<char, std::size_t{1} << 16> block;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd one{descriptor, POLLIN, 0};
    const int ready = ::poll(&one, 1, static_cast<int>(std::clamp<long long>(left, 0, 1000)));
    if (ready < 0 && errno != EINTR) return failure = std::strerror(errno), false;
    if (ready <= 0 && left <= 0) return failure = fmt::format("not done after {:.0f} s", limits.seconds), false;
    if (ready <= 0) continue;
    const ssize_t got = ::read(descriptor, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    heard.append(block.data(), static_cast<std::size_t>(got));
    if (heard.size() > limits.result + 2) return failure = "more than it may give back", false;
  }
}

}  // namespace

ApartOutcome run_apart(const std::function<std::string()>& work, const ApartLimits& limits) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw WorkError(std::string("no pipe: ") + std::strerror(errno));
  const pid_t process = ::fork();
  if (process < 0) {
    ::close(ends[0]), ::close(ends[1]);
    throw WorkError(std::string("no second process: ") + std::strerror(errno));
  }
  if (process == 0) work_here(work, limits, ends[1]);
  ::close(ends[1]);
  ApartOutcome out;
  std::string heard;
  if (!listen(ends[0], limits, heard, out.failure)) ::kill(process, SIGKILL);
  ::close(ends[0]);
  int state = 0;
  while (::waitpid(process, &state, 0) < 0 && errno == EINTR) {
  }
  if (!out.failure.empty()) return out;
  if (heard.size() < 2 || heard.front() != kBegun || heard.back() != kEnded) {
    out.failure = WIFSIGNALED(state) ? fmt::format("ended by signal {}", WTERMSIG(state)) : "ended before it was done";
    return out;
  }
  heard.pop_back();
  out.done = true, out.result = heard.erase(0, 1);
  return out;
}

}  // namespace lacuna
