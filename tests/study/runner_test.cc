#include "study/runner.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <limits>

#include "scenarios/error.h"
#include "tests/physics/rank_threads.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

SearchRun run_of(double value) {
  SearchRun run;
  run.point = {value, 1.0 / 3.0};
  run.cost = value / 7.0;
  run.evaluations = 10;
  run.curve = {{5, std::numeric_limits<double>::infinity()}, {10, value / 7.0}};
  run.errors = {0.1, 0.2, std::nan(""), 1e-300};
  return run;
}

TEST(StudyRunner, CarriesOutEveryRunOnceOnAnyNumberOfThreads) {
  for (const int threads : {1, 3}) {
    RunnerOptions options;
    options.threads = threads;
    double last = -1.0;
    options.progress = [&](const Progress& p) {
      EXPECT_GE(p.done, last);
      last = p.done;
    };
    StudyRunner runner(options);
    std::atomic<int> calls{0};
    for (int k = 0; k < 20; ++k)
      runner.add("run" + std::to_string(k), 1.0 + k, [&calls, k] {
        ++calls;
        return run_of(k);
      });
    runner.execute();
    EXPECT_EQ(calls, 20);
    EXPECT_EQ(last, 1.0);
    for (int k = 0; k < 20; ++k) EXPECT_EQ(runner.at("run" + std::to_string(k)).cost, k / 7.0);
    EXPECT_EQ(runner.spent().first, 200);
  }
}

TEST(StudyRunner, RefusesTwoRunsOfOneName) {
  StudyRunner runner({});
  runner.add("a", 1.0, [] { return run_of(1.0); });
  EXPECT_THROW(runner.add("a", 1.0, [] { return run_of(1.0); }), std::logic_error);
  EXPECT_THROW(runner.at("b"), std::logic_error);
}

TEST(StudyRunner, TakesUpWhereItWasStoppedWithTheSameBits) {
  const test::TemporaryFolder folder;
  RunnerOptions options;
  options.checkpoint = folder.path() / "runs.jsonl";
  options.problem = "one";
  {
    StudyRunner runner(options);
    runner.add("done", 1.0, [] { return run_of(0.1); });
    runner.add("fails", 1.0, []() -> SearchRun { throw Interrupted(); });
    EXPECT_THROW(runner.execute(), Interrupted);
  }
  // A crash in the middle of a line.
  std::ofstream(options.checkpoint, std::ios::app) << R"({"key":"fails","point":["0x1p)";
  StudyRunner runner(options);
  int again = 0;
  runner.add("done", 1.0, [&again] {
    ++again;
    return run_of(5.0);
  });
  runner.add("fails", 1.0, [&again] {
    ++again;
    return run_of(0.3);
  });
  runner.execute();
  EXPECT_EQ(again, 1);
  const SearchRun &restored = runner.at("done"), fresh = run_of(0.1);
  EXPECT_EQ(restored.point, fresh.point);
  EXPECT_EQ(restored.cost, fresh.cost);
  EXPECT_EQ(restored.curve.front().best, fresh.curve.front().best);
  EXPECT_EQ(restored.errors.combination_index, 1e-300);
  EXPECT_TRUE(std::isnan(restored.errors.parameter_index));
}

TEST(StudyRunner, RefusesTheCheckpointOfAnotherProblem) {
  const test::TemporaryFolder folder;
  RunnerOptions options;
  options.checkpoint = folder.path() / "runs.jsonl";
  options.problem = "one";
  { const StudyRunner runner(options); }
  options.problem = "two";
  EXPECT_THROW(StudyRunner{options}, InputError);
  std::ofstream(options.checkpoint) << "nonsense\n";
  EXPECT_THROW(StudyRunner{options}, InputError);
}

TEST(StudyRunner, RanksShareTheRunsAndTheFirstKeepsThem) {
  const test::TemporaryFolder folder;
  RunnerOptions options;
  options.checkpoint = folder.path() / "runs.jsonl";
  {
    StudyRunner alone(options);
    alone.add("run0", 1.0, [] { return run_of(0.0); });
    alone.execute();
  }
  std::atomic<int> calls{0};
  test::on_ranks(3, [&](Ranks& ranks, StopFlag&) {
    RunnerOptions mine = options;
    mine.ranks = &ranks;
    if (!ranks.first()) mine.checkpoint = folder.path() / "elsewhere" / "unseen.jsonl";  // another machine's disk
    StudyRunner runner(mine);
    for (int k = 0; k < 20; ++k)
      runner.add("run" + std::to_string(k), 1.0, [&calls, k] {
        ++calls;
        return run_of(k);
      });
    runner.execute();
    for (int k = 0; k < 20; ++k)
      EXPECT_EQ(runner.at("run" + std::to_string(k)).cost, k / 7.0) << "rank " << ranks.rank();
  });
  EXPECT_EQ(calls, 19) << "each run once, the one on disk not again";
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "elsewhere"));
  std::ifstream in(options.checkpoint);
  int lines = 0;
  for (std::string line; std::getline(in, line);) ++lines;
  EXPECT_EQ(lines, 1 + 20);
}

TEST(StudyRunner, ARunThatFailsOnOneRankFailsOnAll) {
  std::atomic<int> failures{0};
  test::on_ranks(2, [&](Ranks& ranks, StopFlag&) {
    RunnerOptions options;
    options.ranks = &ranks;
    StudyRunner runner(options);
    for (int k = 0; k < 6; ++k)
      runner.add("run" + std::to_string(k), 1.0, [k]() -> SearchRun {
        if (k == 3) throw WorkError("it broke");
        return run_of(k);
      });
    try {
      runner.execute();
    } catch (const WorkError&) {
      ++failures;
    }
  });
  EXPECT_EQ(failures, 2);
}

}  // namespace
}  // namespace lacuna
