#include "scenarios/apart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

namespace lacuna {
namespace {

using testing::HasSubstr;

ApartLimits limits(double seconds = 10.0) {
  ApartLimits out;
  out.seconds = seconds, out.memory = std::uintmax_t{1} << 28, out.result = 1 << 24;
  return out;
}

TEST(Apart, HandsBackWhatTheWorkReturned) {
  const std::string large(10'000'000, 'x');
  for (const std::string& result : {std::string(), std::string("a\0b", 3), large}) {
    const ApartOutcome outcome = run_apart([&] { return result; }, limits());
    EXPECT_TRUE(outcome.done) << outcome.failure;
    EXPECT_EQ(outcome.result, result);
  }
}

TEST(Apart, OutlivesACrashAndAnExit) {
  ApartOutcome outcome = run_apart([]() -> std::string { return ::raise(SIGKILL), ""; }, limits());
  EXPECT_FALSE(outcome.done);
  EXPECT_EQ(outcome.failure, "ended by signal 9");
  outcome = run_apart([]() -> std::string { ::_exit(0); }, limits());
  EXPECT_FALSE(outcome.done);
  EXPECT_EQ(outcome.failure, "ended before it was done");
}

TEST(Apart, EndsWhatTakesTooLong) {
  const auto start = std::chrono::steady_clock::now();
  const ApartOutcome outcome = run_apart(
      []() -> std::string {
        while (true) ::pause();
      },
      limits(0.2));
  EXPECT_FALSE(outcome.done);
  EXPECT_THAT(outcome.failure, HasSubstr("not done after"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(Apart, TakesNoMoreThanItMay) {
  ApartLimits few = limits();
  few.result = 1000;
  EXPECT_THAT(run_apart([] { return std::string(100'000, 'x'); }, few).failure, HasSubstr("more than it may"));
#ifndef __SANITIZE_ADDRESS__
  const ApartOutcome outcome = run_apart(
      []() -> std::string {
        try {
          return std::vector<char>(std::size_t{1} << 30, 'x').data();
        } catch (const std::bad_alloc&) {
          return "no memory";
        }
      },
      limits());
  EXPECT_EQ(outcome.result, "no memory");
#endif
}

}  // namespace
}  // namespace lacuna
