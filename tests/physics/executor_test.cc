// Serial, threads and ranks: every piece once, the same results everywhere, failures and interruptions alike.
#include "physics/executor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/physics/plants.h"
#include "tests/physics/rank_threads.h"

namespace lacuna {
namespace {

using namespace test;

constexpr int kPieces = 23;
using Rows = std::vector<std::vector<double>>;

/// Piece k leaves k + 1 numbers.
Rows empty_rows() {
  Rows rows;
  for (int k = 0; k < kPieces; ++k) rows.emplace_back(static_cast<std::size_t>(k) + 1, -1.0);
  return rows;
}

Rows filled(Executor& executor, std::atomic<int>& computed) {
  Rows rows = empty_rows();
  executor.run(
      kPieces,
      [&](int worker, int piece) {
        EXPECT_LT(worker, executor.workers());
        ++computed;
        for (double& x : rows[piece]) x = std::sin(piece + 0.1 * x);
      },
      [&](int piece) -> std::vector<std::span<std::byte>> {
        std::span<double> row(rows[piece]);
        // Two places, the first of them empty for piece 0.
        return {std::as_writable_bytes(row.first(row.size() / 2)), std::as_writable_bytes(row.subspan(row.size() / 2))};
      },
      7);
  return rows;
}

TEST(Executor, SerialThreadsAndRanksLeaveTheSameResults) {
  std::atomic<int> computed{0};
  const Rows expected = filled(*make_executor(1, nullptr, nullptr), computed);
  EXPECT_EQ(computed, kPieces);
  EXPECT_EQ(filled(*make_executor(2, nullptr, nullptr), computed), expected);
  EXPECT_EQ(computed, 2 * kPieces);
  for (const int size : {1, 2, 3, kPieces + 2}) {
    computed = 0;
    on_ranks(size, [&](Ranks& ranks, StopFlag&) {
      EXPECT_EQ(filled(*make_executor(ranks.rank() == 0 ? 2 : 1, &ranks, nullptr), computed), expected);
    });
    EXPECT_EQ(computed, kPieces) << size << " ranks";
  }
}

TEST(Executor, AFailureOnOneRankIsThrownOnAll) {
  std::atomic<int> caught{0};
  on_ranks(3, [&](Ranks& ranks, StopFlag&) {
    const auto executor = make_executor(1, &ranks, nullptr);
    const auto nothing = [](int) { return std::vector<std::span<std::byte>>(); };
    const auto fail_at = [](int which, bool input) {
      return [=](int, int piece) {
        if (piece == which && input) throw InputError("piece", "four", "three");
        if (piece == which) throw WorkError("piece " + std::to_string(piece));
      };
    };
    try {
      executor->run(9, fail_at(4, false), nothing, 1);
    } catch (const WorkError& error) {
      if (std::string(error.what()) == "piece 4") ++caught;
    }
    try {
      executor->run(9, fail_at(8, true), nothing, 1);
    } catch (const std::invalid_argument& error) {
      if (std::string(error.what()).find("piece: found four") == 0) ++caught;
    }
    EXPECT_NO_THROW(executor->run(9, fail_at(-1, false), nothing, 1));  // they go on together
  });
  EXPECT_EQ(caught, 6);
}

TEST(Executor, AnInterruptionOfOneRankEndsAllAtTheSameCall) {
  std::array<int, 3> calls{};
  on_ranks(3, [&](Ranks& ranks, StopFlag& asked) {
    const auto executor = make_executor(1, &ranks, nullptr);
    int& done = calls[ranks.rank()];
    EXPECT_THROW(
        for (;; ++done) {
          EXPECT_FALSE(ranks.stop());
          if (done == 5 && ranks.rank() == 1) asked = true;
          executor->run(
              6, [](int, int) {}, [](int) { return std::vector<std::span<std::byte>>(); }, 1);
        },
        Interrupted);
    EXPECT_TRUE(ranks.stop());
    EXPECT_EQ(ranks.asked(), ranks.rank() == 1);
  });
  EXPECT_EQ(calls, (std::array<int, 3>{5, 5, 5}));
}

TEST(Executor, SerialAndThreadsStopWhenAsked) {
  const StopFlag stop{true};
  for (const int threads : {1, 2})
    EXPECT_THROW(make_executor(threads, nullptr, &stop)
                     ->run(
                         3, [](int, int) { FAIL(); }, [](int) { return std::vector<std::span<std::byte>>(); }, 1),
                 Interrupted);
}

/// Costs and residuals as a search sees them, on 1, 2 and 3 ranks with different numbers of threads.
TEST(Executor, RanksSimulateAPopulationToTheSameBitsOnEveryEngine) {
  Scenario scenario = driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), {},
                                      constant_drive(2, 0.5, 0.01, 0.0), {{0.3, -0.2}, {0.0, 0.0}, false});
  scenario.prediction = Windows{0.2};
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  std::vector<std::vector<double>> values(2 * static_cast<std::size_t>(lane_info().width) + 1, model.values());
  for (std::size_t i = 0; i < values.size(); ++i)
    for (double& x : values[i])
      if (std::isfinite(x)) x *= 1.0 + 0.01 * static_cast<double>(i);
  std::vector<int> segments(experiment.segments.size());
  for (std::size_t s = 0; s < segments.size(); ++s) segments[s] = static_cast<int>(s);
  const auto last_positions = [&](const SimulatorOptions& options) {
    Rows out(values.size(), std::vector<double>(segments.size(), -1.0));
    const auto at = [&](int i, int s) -> double& { return out[i][s]; };
    make_simulator(model, experiment, options)
        ->run(
            values, segments, [&](int i, int s, const auto& predicted) { at(i, s) = predicted[1].back(); },
            [&](int i, int s) { return std::as_writable_bytes(std::span(&at(i, s), 1)); });
    return out;
  };
  for (const std::string& engine : available_engines()) {
    const Rows alone = last_positions(on(engine, 0.005));
    for (const int size : {2, 3}) {
      on_ranks(size, [&](Ranks& ranks, StopFlag&) {
        SimulatorOptions options = on(engine, 0.005, 1 + ranks.rank() % 2);
        options.ranks = &ranks;
        EXPECT_EQ(last_positions(options), alone) << engine << " on " << size << " ranks";
      });
    }
  }
}

}  // namespace
}  // namespace lacuna
