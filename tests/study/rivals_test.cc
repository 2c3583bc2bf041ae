#include "study/rivals.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/study/problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr RivalsPlan kSmallRace{2, 1, 14, 420, 3};

struct Raced {
  RivalsRecord rivals;
  RecoveryRecord recovery;
};
Raced raced(const Trial& trial, int threads = 1) {
  RunnerOptions options;
  options.threads = threads;
  StudyRunner runner(options);
  plan_rivals(trial, kSmallRace, nullptr, runner);
  plan_recovery(trial, kSmallRace, nullptr, runner);
  runner.execute();
  return {summarise_rivals(trial, kSmallRace, runner), summarise_recovery(trial, kSmallRace, runner)};
}

void expect_budget_kept(const RivalsRecord& record) {
  ASSERT_EQ(record.methods.size(), all_methods().size());
  for (const MethodRecord& m : record.methods) {
    SCOPED_TRACE(to_string(m.method));
    for (const SearchRun& run : m.runs) {
      // The last start or generation may overshoot by itself; nothing beyond the budget counts.
      EXPECT_LE(run.evaluations, kSmallRace.evaluations + 600);
      for (std::size_t k = 1; k < run.curve.size(); ++k) {
        EXPECT_LE(run.curve[k].best, run.curve[k - 1].best);
        EXPECT_GE(run.curve[k].evaluations, run.curve[k - 1].evaluations);
      }
      EXPECT_EQ(run.curve.back().best, run.cost);
    }
    for (const auto& level : m.reached) {
      for (const double at : level) EXPECT_TRUE(std::isinf(at) || at <= kSmallRace.evaluations);
    }
    EXPECT_LE(m.success[0], m.success[2]);
  }
}

void expect_recommendation_follows(const RivalsRecord& record) {
  ASSERT_GE(record.recommended, 0);
  const MethodRecord& best = record.methods[record.recommended];
  for (const MethodRecord& m : record.methods) {
    EXPECT_GE(best.success[0], m.success[0]);
    if (m.success[0] != best.success[0]) continue;
    EXPECT_LE(quartiles_of(best.reached[0]).median, quartiles_of(m.reached[0]).median) << to_string(m.method);
  }
  EXPECT_NE(record.reason.find(title_of(best.method)), std::string::npos);
}

void expect_many_starts_reach_the_noise(const RivalsRecord& record) {
  for (const MethodRecord& m : record.methods) {
    if (m.method != SearchMethod::multi_start) continue;
    EXPECT_EQ(m.success[0], 1.0);
  }
}

void expect_intervals_counted(const RecoveryRecord& record) {
  ASSERT_EQ(record.parameters.size(), 3u);
  EXPECT_EQ(record.asked, 6) << "all three are determined, in both runs";
  int held = 0;
  for (const Recovered& r : record.parameters) {
    for (std::size_t k = 0; k < 2; ++k) {
      held += r.lower95[k] <= r.truth && r.truth <= r.upper95[k];
      // Five standard errors: two make the half interval.
      EXPECT_NEAR(r.value[k], r.truth, 2.5 * 0.5 * (r.upper95[k] - r.lower95[k])) << r.name;
    }
  }
  EXPECT_EQ(record.held, held);
}

/// One race for all that is asked of it: a run costs most of a minute under sanitizers.
TEST(Rivals, OfOneRaceAreJudgedByTheirRunsAndTheSameOnThreeThreads) {
  const Trial trial = pendulum_trial();
  const Raced one = raced(trial, 1), three = raced(trial, 3);
  const RivalsRecord &a = one.rivals, &b = three.rivals;
  expect_budget_kept(a);
  expect_recommendation_follows(a);
  expect_many_starts_reach_the_noise(a);
  expect_intervals_counted(one.recovery);
  for (std::size_t m = 0; m < a.methods.size(); ++m)
    for (std::size_t k = 0; k < a.methods[m].runs.size(); ++k)
      EXPECT_TRUE(same_bits(a.methods[m].runs[k].point, b.methods[m].runs[k].point)) << to_string(a.methods[m].method);
}

TEST(Recovery, WithoutATruthThereIsNone) {
  EXPECT_TRUE(raced(make_trial(swinging(), nullptr)).recovery.parameters.empty());
}

}  // namespace
}  // namespace lacuna
