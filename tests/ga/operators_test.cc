#include "ga/operators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "tests/ga/test_problems.h"

namespace lacuna {
namespace {

using test::infinity;
using test::not_a_number;

/// How often each individual is picked in `draws` draws.
std::vector<int> frequencies(const Selector& selector, std::size_t size, int draws) {
  std::vector<int> picked(size);
  RandomStream stream(42, 0, 0);
  for (int i = 0; i < draws; ++i) ++picked[selector.pick(stream)];
  return picked;
}

/// Five standard deviations of the binomial distribution.
void expect_share(int picked, double p, int draws) {
  EXPECT_NEAR(picked, p * draws, 5 * std::sqrt(draws * p * (1 - p)) + 1e-9) << "share " << p;
}

int different_bits(const Chromosome& a, const Chromosome& b) {
  int count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += std::popcount(static_cast<unsigned>(a[i] ^ b[i]));
  return count;
}

TEST(Ranking, OrdersByCostWithFailedLastAndTiesByIndex) {
  const std::vector<double> costs = {3.0, not_a_number, 1.0, infinity, 1.0, -2.0};
  EXPECT_EQ(ranking(costs), (std::vector<std::size_t>{5, 2, 4, 0, 1, 3}));
}

TEST(Roulette, PicksInProportionToTheDistanceFromTheWorst) {
  const std::vector<double> costs = {1.0, 2.0, 3.0, 5.0};  // weights 4, 3, 2, 0 of 9
  const int draws = 90000;
  const auto picked = frequencies(Selector(Selection::roulette, costs, 2), 4, draws);
  expect_share(picked[0], 4.0 / 9, draws);
  expect_share(picked[1], 3.0 / 9, draws);
  expect_share(picked[2], 2.0 / 9, draws);
  EXPECT_LE(picked[3], 5);  // eps only
}

TEST(Roulette, DoesNotDependOnTheUnitOfTheCost) {
  const std::vector<double> costs = {1.0, 2.0, 3.0, 5.0}, other = {1e-9, 2e-9, 3e-9, 5e-9};
  const auto a = selection_weights(Selection::roulette, costs), b = selection_weights(Selection::roulette, other);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-12);
}

TEST(LiteralRoulette, FavoursTheWorstAsItsFormulaSays) {
  const std::vector<double> costs = {1.0, 2.0, 3.0, 4.0};  // p = Fit / sum(Fit) with Fit = -cost
  const int draws = 100000;
  const auto picked = frequencies(Selector(Selection::roulette_literal, costs, 2), 4, draws);
  for (std::size_t i = 0; i < 4; ++i) expect_share(picked[i], costs[i] / 10.0, draws);
  EXPECT_GT(picked[3], picked[0]);
}

TEST(RankSelection, FallsLinearlyFromBestToWorst) {
  const std::vector<double> costs = {1e9, 0.1, 0.2, 5.0};  // weights 1, 4, 3, 2 of 10
  const int draws = 100000;
  const auto picked = frequencies(Selector(Selection::rank, costs, 2), 4, draws);
  const std::vector<double> shares = {0.1, 0.4, 0.3, 0.2};
  for (std::size_t i = 0; i < 4; ++i) expect_share(picked[i], shares[i], draws);
}

TEST(Tournament, OfTwoPicksTheBestWithTheKnownChance) {
  const std::vector<double> costs = {4.0, 3.0, 2.0, 1.0};
  const int draws = 100000;
  const auto picked = frequencies(Selector(Selection::tournament, costs, 2), 4, draws);
  // Chance that the better of two draws has place k (0 best) of n: ((n-k)^2 - (n-k-1)^2) / n^2.
  const std::vector<double> shares = {1.0 / 16, 3.0 / 16, 5.0 / 16, 7.0 / 16};
  for (std::size_t i = 0; i < 4; ++i) expect_share(picked[i], shares[i], draws);
}

TEST(Selection, NeverPicksFailedIndividualsWhileOthersExist) {
  const std::vector<double> costs = {not_a_number, 2.0, infinity, 1.0, 3.0};
  for (const auto selection : {Selection::roulette, Selection::roulette_literal, Selection::rank}) {
    const auto picked = frequencies(Selector(selection, costs, 2), 5, 20000);
    EXPECT_EQ(picked[0] + picked[2], 0) << to_string(selection);
  }
  // A tournament among failed ones only must have a winner; otherwise a failed one never wins.
  const auto picked = frequencies(Selector(Selection::tournament, costs, 2), 5, 100000);
  expect_share(picked[0] + picked[2], 4.0 / 25, 100000);
}

TEST(Selection, IsUniformWhenCostsGiveNoReason) {
  for (const double value : {0.0, 7.0, infinity, not_a_number}) {
    const std::vector<double> costs(4, value);
    for (const auto selection : {Selection::roulette, Selection::roulette_literal, Selection::rank}) {
      EXPECT_EQ(selection_weights(selection, costs), std::vector<double>(4, 1.0)) << value;
    }
  }
}

TEST(Selection, SurvivesCostsOfAnySize) {
  const double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();
  for (const auto& costs : {std::vector<double>{-huge, huge, 0.0}, {tiny, 2 * tiny, 4 * tiny}, {1e-320, 0.0, 1.0}}) {
    for (const auto selection : {Selection::roulette, Selection::roulette_literal, Selection::rank}) {
      for (const double weight : selection_weights(selection, costs)) {
        EXPECT_TRUE(std::isfinite(weight) && weight >= 0.0) << to_string(selection);
      }
    }
  }
}

TEST(PointwiseCrossover, ExchangesTheSegmentBetweenTwoCutsBitByBit) {
  Chromosome a = {0xFFFF, 0xFFFF, 0xFFFF}, b = {0x0000, 0x0000, 0x0000};
  const std::vector<int> cuts = {4, 36};
  crossover_pointwise(Coding::mvbs, cuts, a, b);
  EXPECT_EQ(a, (Chromosome{0xF000, 0x0000, 0x0FFF}));
  EXPECT_EQ(b, (Chromosome{0x0FFF, 0xFFFF, 0xF000}));
}

TEST(PointwiseCrossover, OneCutExchangesTheTailAndThreeCutsTwoSegments) {
  Chromosome a = {0xFFFF, 0xFFFF}, b = {0x0000, 0x0000};
  crossover_pointwise(Coding::mvbs, std::vector<int>{20}, a, b);
  EXPECT_EQ(a, (Chromosome{0xFFFF, 0xF000}));
  a = {0xFFFF, 0xFFFF}, b = {0x0000, 0x0000};
  crossover_pointwise(Coding::mvbs, std::vector<int>{1, 3, 31}, a, b);
  EXPECT_EQ(a, (Chromosome{0x9FFF, 0xFFFE}));
  EXPECT_EQ(b, (Chromosome{0x6000, 0x0001}));
}

TEST(PointwiseCrossover, OfIntegersCutsBetweenGenesOnly) {
  Chromosome a = {1, 2, 3, 4, 5}, b = {11, 12, 13, 14, 15};
  crossover_pointwise(Coding::integer, std::vector<int>{1, 3}, a, b);
  EXPECT_EQ(a, (Chromosome{1, 12, 13, 4, 5}));
  EXPECT_EQ(b, (Chromosome{11, 2, 3, 14, 15}));
}

TEST(UniformCrossover, ExchangesEveryOtherGeneOrBit) {
  Chromosome a = {1, 2, 3, 4, 5}, b = {11, 12, 13, 14, 15};
  crossover_uniform_gene(a, b);
  EXPECT_EQ(a, (Chromosome{1, 12, 3, 14, 5}));
  EXPECT_EQ(b, (Chromosome{11, 2, 13, 4, 15}));
  a = {0xFFFF, 0x0000}, b = {0x0000, 0xF0F0};
  crossover_uniform_bit(a, b);
  EXPECT_EQ(a, (Chromosome{0xAAAA, 0x5050}));
  EXPECT_EQ(b, (Chromosome{0x5555, 0xA0A0}));
}

TEST(Crossover, KeepsEveryBitOfTheParentsAtItsPlace) {
  RandomStream stream(4, 0, 0);
  for (const auto kind : {Crossover::pointwise, Crossover::uniform_gene, Crossover::uniform_bit}) {
    for (int trial = 0; trial < 200; ++trial) {
      Chromosome a(9), b(9);
      for (std::size_t i = 0; i < 9; ++i) {
        a[i] = static_cast<Gene>(stream.bits32());
        b[i] = static_cast<Gene>(stream.bits32());
      }
      Chromosome child_a = a, child_b = b;
      cross(kind, 3, Coding::mvbs, child_a, child_b, stream);
      for (std::size_t i = 0; i < 9; ++i) {
        ASSERT_EQ(child_a[i] ^ child_b[i], a[i] ^ b[i]);
        ASSERT_EQ(child_a[i] & child_b[i], a[i] & b[i]);
      }
    }
  }
}

TEST(Cuts, AreDifferentAscendingInsideAndEquallyLikely) {
  const int draws = 60000, length = 7;
  std::vector<int> used(length);
  RandomStream stream(8, 0, 0);
  for (int i = 0; i < draws; ++i) {
    const auto cuts = draw_cuts(length, 2, stream);
    ASSERT_EQ(cuts.size(), 2u);
    ASSERT_TRUE(1 <= cuts[0] && cuts[0] < cuts[1] && cuts[1] < length);
    for (const int cut : cuts) ++used[cut];
  }
  for (std::size_t cut = 1; cut < length; ++cut) expect_share(used[cut], 2.0 / 6, draws);
}

TEST(Cuts, AreAllPlacesWhenMoreAreAskedForThanExist) {
  RandomStream stream(8, 0, 0);
  EXPECT_EQ(draw_cuts(4, 10, stream), (std::vector<int>{1, 2, 3}));
  EXPECT_TRUE(draw_cuts(1, 2, stream).empty());
}

TEST(Mutation, FlipBitCountsFromTheMostSignificantBitOfTheFirstGene) {
  Chromosome c = {0, 0};
  flip_bit(c, 0);
  flip_bit(c, 15);
  flip_bit(c, 17);
  EXPECT_EQ(c, (Chromosome{0x8001, 0x4000}));
}

TEST(Mutation, PerGeneFlipsExactlyOneBitOfEachGeneAtRateOne) {
  RandomStream stream(2, 0, 0);
  const Chromosome before(9, 0x1234);
  for (int trial = 0; trial < 200; ++trial) {
    Chromosome after = before;
    mutate(Mutation::per_gene, 1.0, Coding::mvbs, after, stream);
    for (std::size_t i = 0; i < 9; ++i) ASSERT_EQ(different_bits({before[i]}, {after[i]}), 1);
  }
}

TEST(Mutation, PerChromosomeFlipsExactlyOneBitAtRateOne) {
  RandomStream stream(2, 0, 0);
  std::set<Chromosome> children;
  for (int trial = 0; trial < 4000; ++trial) {
    Chromosome after(3, 0);
    mutate(Mutation::per_chromosome, 1.0, Coding::mvbs, after, stream);
    ASSERT_EQ(different_bits(Chromosome(3, 0), after), 1);
    children.insert(after);
  }
  EXPECT_EQ(children.size(), 48u);
}

TEST(Mutation, HappensAtItsRate) {
  const int trials = 2000, genes = 9;
  const double rate = 0.05;
  const auto flips = [&](Mutation kind) {
    RandomStream stream(6, 0, 0);
    int count = 0;
    for (int trial = 0; trial < trials; ++trial) {
      Chromosome after(genes, 0);
      mutate(kind, rate, Coding::mvbs, after, stream);
      count += different_bits(Chromosome(genes, 0), after);
    }
    return count;
  };
  expect_share(flips(Mutation::per_gene), rate, trials * genes);
  expect_share(flips(Mutation::per_bit), rate, trials * genes * bits_per_gene);
  expect_share(flips(Mutation::per_chromosome), rate, trials);
}

TEST(Mutation, OfIntegersAlwaysChangesTheWholeGene) {
  RandomStream stream(2, 0, 0);
  int many_bits = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    Chromosome after(1, 500);
    mutate(Mutation::per_gene, 1.0, Coding::integer, after, stream);
    ASSERT_NE(after[0], 500);
    many_bits += different_bits({500}, after) > 1;
  }
  EXPECT_GT(many_bits, 900);
}

TEST(Mutation, NeverHappensAtRateZero) {
  RandomStream stream(2, 0, 0);
  for (const auto kind : {Mutation::per_gene, Mutation::per_bit, Mutation::per_chromosome}) {
    Chromosome after(9, 77);
    for (int trial = 0; trial < 100; ++trial) mutate(kind, 0.0, Coding::mvbs, after, stream);
    EXPECT_EQ(after, Chromosome(9, 77));
  }
}

TEST(Operators, NamesRoundTripAndOthersAreRefusedWithTheChoices) {
  for (const auto s : {Selection::roulette, Selection::roulette_literal, Selection::tournament, Selection::rank}) {
    EXPECT_EQ(selection_from_name(to_string(s)), s);
  }
  for (const auto c : {Crossover::pointwise, Crossover::uniform_gene, Crossover::uniform_bit}) {
    EXPECT_EQ(crossover_from_name(to_string(c)), c);
  }
  for (const auto m : {Mutation::per_gene, Mutation::per_bit, Mutation::per_chromosome}) {
    EXPECT_EQ(mutation_from_name(to_string(m)), m);
  }
  try {
    crossover_from_name("arithmetic");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "crossover = arithmetic, allowed: pointwise, uniform_gene, uniform_bit");
  }
}

}  // namespace
}  // namespace lacuna
