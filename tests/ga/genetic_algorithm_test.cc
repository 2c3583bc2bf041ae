#include "ga/genetic_algorithm.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "ga/checkpoint.h"
#include "scenarios/error.h"
#include "tests/ga/test_problems.h"

namespace lacuna {
namespace {

using namespace test;

GeneticOptions small() {
  GeneticOptions options;
  options.population = 31;  // odd, so that a last pair leaves one child only
  options.generations = 25;
  options.seed = 17;
  return options;
}

std::string refusal(const GeneticOptions& options) {
  try {
    validate(options, nine_box());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(GeneticAlgorithm, HasTheSeedsFinalSettingAsDefault) {
  const GeneticOptions options;
  EXPECT_EQ(options.population, 70);
  EXPECT_EQ(options.generations, 200);
  EXPECT_EQ(options.crossover_rate, 0.8);
  EXPECT_EQ(options.mutation_rate, 0.05);
  EXPECT_EQ(options.coding, Coding::mvbs);
  EXPECT_EQ(options.crossover, Crossover::pointwise);
  EXPECT_EQ(options.elite, 1);
  EXPECT_EQ(refusal(options), "");
}

// Medians and worst of 40 seeds: sphere 0.29 and 0.56, Rastrigin 9.2 and 13.8. A random search of the same budget ends
// at 8.8 and 57 (medians).
TEST(GeneticAlgorithm, FindsTheOptimumOfTheSphere) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    GeneticOptions options;
    options.seed = seed;
    const auto result = run_genetic_algorithm(nine_box(), one_by_one(sphere), options);
    EXPECT_LT(result.best_cost, 1.0) << "seed " << seed;
    EXPECT_EQ(result.best_cost, sphere(result.best));
  }
}

TEST(GeneticAlgorithm, FindsTheValleyOfTheRastriginFunction) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    GeneticOptions options;
    options.seed = seed;
    const auto result = run_genetic_algorithm(nine_box(), one_by_one(rastrigin), options);
    EXPECT_LT(result.best_cost, 20.0) << "seed " << seed;
  }
}

TEST(GeneticAlgorithm, ConvergesWithEveryChoiceButTheLiteralRoulette) {
  for (const auto coding : {Coding::mvbs, Coding::integer}) {
    for (const auto selection : {Selection::roulette, Selection::tournament, Selection::rank}) {
      for (const auto crossover : {Crossover::pointwise, Crossover::uniform_gene, Crossover::uniform_bit}) {
        if (coding == Coding::integer && crossover == Crossover::uniform_bit) continue;
        GeneticOptions options;
        options.coding = coding;
        options.selection = selection;
        options.crossover = crossover;
        const auto result = run_genetic_algorithm(nine_box(), one_by_one(sphere), options);
        EXPECT_LT(result.best_cost, 2.0) << to_string(coding) << to_string(selection) << to_string(crossover);
      }
    }
  }
}

TEST(GeneticAlgorithm, LiteralRouletteEndsFarWorse) {
  GeneticOptions options;
  const double corrected = run_genetic_algorithm(nine_box(), one_by_one(sphere), options).best_cost;
  options.selection = Selection::roulette_literal;
  const double literal = run_genetic_algorithm(nine_box(), one_by_one(sphere), options).best_cost;
  EXPECT_GT(literal, 10.0 * corrected);
}

TEST(GeneticAlgorithm, GivesTheSameBitsForAnyNumberOfThreadsAndOrder) {
  const auto options = small();
  const auto reference = run_genetic_algorithm(nine_box(), one_by_one(rastrigin), options);
  EXPECT_TRUE(same_run(reference, run_genetic_algorithm(nine_box(), backwards(rastrigin), options)));
  for (const std::size_t threads : {1u, 2u, 7u}) {
    EXPECT_TRUE(same_run(reference, run_genetic_algorithm(nine_box(), threaded(rastrigin, threads), options)));
  }
}

TEST(GeneticAlgorithm, GivesAnotherRunForAnotherSeed) {
  auto options = small();
  const auto one = run_genetic_algorithm(nine_box(), one_by_one(sphere), options);
  options.seed = 18;
  EXPECT_FALSE(same_run(one, run_genetic_algorithm(nine_box(), one_by_one(sphere), options)));
}

TEST(GeneticAlgorithm, ResumesToTheSameBitsWhereverItWasStopped) {
  const auto options = small();
  const auto reference = run_genetic_algorithm(nine_box(), one_by_one(rastrigin), options);
  const auto run = [&](const RunControl& control) {
    return run_genetic_algorithm(nine_box(), one_by_one(rastrigin), options, control);
  };
  for (const int generation : {1, 2, 13, 24}) {
    const TemporaryFolder folder;
    const auto file = folder / "run.json";
    const auto part = stopped_after(generation, file, run);
    EXPECT_TRUE(part.interrupted);
    EXPECT_EQ(part.history.size(), static_cast<std::size_t>(generation));
    ASSERT_TRUE(std::filesystem::exists(file));
    RunControl control;
    control.checkpoint = file;
    const auto whole = run(control);
    EXPECT_FALSE(whole.interrupted);
    EXPECT_TRUE(same_run(reference, whole)) << "stopped after " << generation;
    EXPECT_GE(whole.history.back().seconds, part.history.back().seconds);
  }
}

TEST(GeneticAlgorithm, ResumesToTheSameBitsWhenStoppedAgainAndAgain) {
  const auto options = small();
  const TemporaryFolder folder;
  const auto run = [&](const RunControl& control) {
    return run_genetic_algorithm(nine_box(), one_by_one(rastrigin), options, control);
  };
  OptimizerResult result;
  int runs = 0;
  do {
    result = stopped_after(3, folder / "run.json", run);
    ++runs;
  } while (result.interrupted && runs < 100);
  EXPECT_EQ(runs, 9);  // 25 generations by threes
  EXPECT_TRUE(same_run(result, run({})));
}

TEST(GeneticAlgorithm, ResumesAfterTheCostThrewInMidGeneration) {
  const auto options = small();
  const TemporaryFolder folder;
  RunControl control;
  control.checkpoint = folder / "run.json";
  int calls = 0;
  const BatchCost failing = [&](std::span<const std::vector<double>> points, std::span<double> costs) {
    if (++calls == 10) throw WorkError("out of memory");
    one_by_one(sphere)(points, costs);
  };
  EXPECT_THROW(run_genetic_algorithm(nine_box(), failing, options, control), WorkError);
  const auto resumed = run_genetic_algorithm(nine_box(), one_by_one(sphere), options, control);
  EXPECT_TRUE(same_run(resumed, run_genetic_algorithm(nine_box(), one_by_one(sphere), options)));
}

TEST(GeneticAlgorithm, ContinuesAFinishedRunWithMoreGenerations) {
  const TemporaryFolder folder;
  RunControl control;
  control.checkpoint = folder / "run.json";
  auto options = small();
  run_genetic_algorithm(nine_box(), one_by_one(sphere), options, control);
  options.generations = 40;
  const auto longer = run_genetic_algorithm(nine_box(), one_by_one(sphere), options, control);
  EXPECT_TRUE(same_run(longer, run_genetic_algorithm(nine_box(), one_by_one(sphere), options)));
  options.generations = 5;
  EXPECT_THROW(run_genetic_algorithm(nine_box(), one_by_one(sphere), options, control), InputError);
}

TEST(GeneticAlgorithm, RefusesAForeignOrDamagedCheckpoint) {
  const TemporaryFolder folder;
  RunControl control;
  control.checkpoint = folder / "run.json";
  control.problem = "recording A";
  const auto options = small();
  const auto run = [&](const Box& box, const GeneticOptions& o, const RunControl& c) {
    return run_genetic_algorithm(box, one_by_one(sphere), o, c);
  };
  run(nine_box(), options, control);
  auto other_options = options;
  other_options.mutation_rate = 0.06;
  EXPECT_THROW(run(nine_box(), other_options, control), InputError);
  auto other_box = nine_box();
  other_box.upper[3] = 7.0;
  EXPECT_THROW(run(other_box, options, control), InputError);
  auto other_control = control;
  other_control.problem = "recording B";
  EXPECT_THROW(run(nine_box(), options, other_control), InputError);
  std::filesystem::resize_file(control.checkpoint, std::filesystem::file_size(control.checkpoint) / 2);
  EXPECT_THROW(run(nine_box(), options, control), InputError);
}

TEST(GeneticAlgorithm, StoppedBeforeItsFirstGenerationHasNoBest) {
  const std::atomic<bool> stop = true;
  RunControl control;
  control.stop = &stop;
  const auto result = run_genetic_algorithm(nine_box(), one_by_one(sphere), small(), control);
  EXPECT_TRUE(result.interrupted);
  EXPECT_TRUE(result.best.empty());
  EXPECT_EQ(result.evaluations, 0);
}

TEST(GeneticAlgorithm, SurvivesFailedEvaluations) {
  // Fails over most of the box, in all three ways; the optimum lies in the part that works.
  const PointCost partly = [](const std::vector<double>& x) {
    if (x[0] > 1.5) return std::numeric_limits<double>::quiet_NaN();
    if (x[1] < -1.0) return std::numeric_limits<double>::infinity();
    if (x[2] > 3.0) return -std::numeric_limits<double>::infinity();
    return sphere(x);
  };
  const auto result = run_genetic_algorithm(nine_box(), one_by_one(partly), {});
  EXPECT_LT(result.best_cost, 1.5);
  for (const auto& record : result.history) EXPECT_TRUE(std::isfinite(record.median) && std::isfinite(record.mean));
}

TEST(GeneticAlgorithm, EndsInOrderWhenEverythingFails) {
  const TemporaryFolder folder;
  RunControl control;
  control.checkpoint = folder / "run.json";
  const PointCost never = [](const std::vector<double>&) { return std::numeric_limits<double>::quiet_NaN(); };
  for (const auto selection :
       {Selection::roulette, Selection::roulette_literal, Selection::tournament, Selection::rank}) {
    auto options = small();
    options.selection = selection;
    remove_checkpoint(control.checkpoint);
    const auto result = run_genetic_algorithm(nine_box(), one_by_one(never), options, control);
    EXPECT_EQ(result.best_cost, std::numeric_limits<double>::infinity());
    EXPECT_EQ(result.best.size(), 9u);
    EXPECT_TRUE(same_run(result, run_genetic_algorithm(nine_box(), one_by_one(never), options, control)));
  }
}

TEST(GeneticAlgorithm, BestNeverGetsWorseAndEvaluationsOnlyGrow) {
  for (const int elite : {0, 1, 5}) {
    auto options = small();
    options.elite = elite;
    const auto result = run_genetic_algorithm(nine_box(), one_by_one(rastrigin), options);
    for (std::size_t i = 1; i < result.history.size(); ++i) {
      EXPECT_LE(result.history[i].best, result.history[i - 1].best);
      EXPECT_GE(result.history[i].evaluations, result.history[i - 1].evaluations);
    }
    EXPECT_EQ(result.best_cost, result.history.back().best);
    EXPECT_EQ(result.history.size(), 25u);
  }
}

TEST(GeneticAlgorithm, NeverAsksAgainForACostItKnows) {
  std::vector<std::set<std::vector<double>>> batches;
  std::map<std::vector<double>, int> times;
  long asked = 0;
  const BatchCost counting = [&](std::span<const std::vector<double>> points, std::span<double> costs) {
    const std::set<std::vector<double>> batch(points.begin(), points.end());
    EXPECT_EQ(batch.size(), points.size()) << "the same point twice in one generation";
    if (!batches.empty()) {
      for (const auto& point : batch) EXPECT_EQ(batches.back().count(point), 0u) << "evaluated a generation ago";
    }
    batches.push_back(batch);
    asked += static_cast<long>(points.size());
    one_by_one(sphere)(points, costs);
  };
  auto options = small();
  options.crossover_rate = 0.3;  // many unchanged children
  const auto result = run_genetic_algorithm(nine_box(), counting, options);
  EXPECT_EQ(result.evaluations, asked);
  EXPECT_LT(asked, 31 * 25 * 9 / 10);
}

TEST(GeneticAlgorithm, StartPointsJoinTheFirstPopulationOnTheGrid) {
  auto options = small();
  options.generations = 1;
  options.start_points = {std::vector<double>(9, optimum)};
  const auto result = run_genetic_algorithm(nine_box(), one_by_one(sphere), options);
  const double half_step = 10.0 / 131070.0;
  for (const double x : result.best) EXPECT_NEAR(x, optimum, half_step);
}

TEST(GeneticAlgorithm, ReportsProgressAfterEveryGeneration) {
  std::vector<Progress> seen;
  RunControl control;
  control.progress = [&](const Progress& p) { seen.push_back(p); };
  const auto result = run_genetic_algorithm(nine_box(), one_by_one(sphere), small(), control);
  ASSERT_EQ(seen.size(), 25u);
  EXPECT_EQ(seen.back().done, 1.0);
  EXPECT_EQ(seen.back().best_cost, result.best_cost);
  EXPECT_EQ(seen.back().evaluations, result.evaluations);
}

TEST(GeneticAlgorithm, WorksOnOneParameterWithEitherCoding) {
  for (const auto coding : {Coding::mvbs, Coding::integer}) {
    GeneticOptions options;
    options.coding = coding;
    const auto result = run_genetic_algorithm({{-4.0}, {6.0}, {}}, one_by_one(sphere), options);
    EXPECT_LT(result.best_cost, 1e-4) << to_string(coding);
  }
}

TEST(GeneticOptions, RefusedWithNameValueAndRange) {
  const auto with = [](auto change) {
    GeneticOptions options;
    change(options);
    return refusal(options);
  };
  using O = GeneticOptions&;
  EXPECT_EQ(with([](O o) { o.population = 1; }), "population = 1, allowed: 2 .. 1000000");
  EXPECT_EQ(with([](O o) { o.generations = 0; }), "generations = 0, allowed: 1 .. 1000000000");
  EXPECT_EQ(with([](O o) { o.crossover_rate = 1.5; }), "crossover_rate = 1.5, allowed: 0 .. 1");
  EXPECT_EQ(with([](O o) { o.mutation_rate = -0.1; }), "mutation_rate = -0.1, allowed: 0 .. 1");
  EXPECT_EQ(with([](O o) { o.mutation_rate = std::nan(""); }), "mutation_rate = nan, allowed: 0 .. 1");
  EXPECT_EQ(with([](O o) { o.elite = 70; }), "elite = 70, allowed: 0 .. 69");
  EXPECT_EQ(with([](O o) { o.cut_points = 0; }), "cut_points = 0, allowed: 1 .. 1000000");
  EXPECT_EQ(with([](O o) { o.selection = Selection::tournament, o.tournament_size = 71; }),
            "tournament_size = 71, allowed: 1 .. 70");
  EXPECT_NE(with([](O o) { o.coding = Coding::integer, o.crossover = Crossover::uniform_bit; }).find("uniform_bit"),
            std::string::npos);
  EXPECT_NE(with([](O o) { o.coding = Coding::integer, o.mutation = Mutation::per_bit; }).find("per_bit"),
            std::string::npos);
  EXPECT_NE(with([](O o) { o.start_points = {{1.0}}; }).find("point 0 has 1 values"), std::string::npos);
  EXPECT_NE(with([](O o) { o.start_points = {std::vector<double>(9, 6.5)}; }).find("6.5, allowed: -4 .. 6"),
            std::string::npos);
}

}  // namespace
}  // namespace lacuna
