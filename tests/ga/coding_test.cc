#include "ga/coding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "ga/random.h"

namespace lacuna {
namespace {

TEST(Coding, EveryGeneSurvivesDecodingAndEncoding) {
  for (const auto& [lower, upper] : {std::pair{0.0, 1.0}, {-250.0, 731.5}, {1e-9, 3e-9}}) {
    for (int gene = 0; gene <= largest_gene; ++gene) {
      const auto g = static_cast<Gene>(gene);
      ASSERT_EQ(encode_gene(decode_gene(g, lower, upper), lower, upper), g) << lower << " .. " << upper;
    }
  }
}

TEST(Coding, EndsOfTheIntervalAreExact) {
  for (const auto& [lower, upper] : {std::pair{0.1, 0.7}, {-1.0 / 3.0, 1e6}, {53.4, 87.4}}) {
    EXPECT_EQ(decode_gene(0, lower, upper), lower);
    EXPECT_EQ(decode_gene(largest_gene, lower, upper), upper);
  }
}

TEST(Coding, EncodingIsOffByAtMostHalfAStep) {
  RandomStream stream(1, 0, 0);
  const double lower = -2.0, upper = 9.0, half_step = (upper - lower) / 131070.0;
  for (int i = 0; i < 10000; ++i) {
    const double value = stream.uniform(lower, upper);
    EXPECT_NEAR(decode_gene(encode_gene(value, lower, upper), lower, upper), value, half_step * (1 + 1e-9));
  }
}

TEST(Coding, ValuesOutsideTheIntervalBecomeItsEnds) {
  EXPECT_EQ(encode_gene(-5.0, 0.0, 1.0), 0);
  EXPECT_EQ(encode_gene(1e300, 0.0, 1.0), largest_gene);
}

TEST(Coding, DecodedValuesRiseWithTheGene) {
  for (int gene = 1; gene <= largest_gene; ++gene) {
    ASSERT_LT(decode_gene(static_cast<Gene>(gene - 1), 0.1, 0.3), decode_gene(static_cast<Gene>(gene), 0.1, 0.3));
  }
}

TEST(Coding, NineGenesAreTheSeeds144Bits) {
  EXPECT_EQ(string_length(Coding::mvbs, 9), 144);
  EXPECT_EQ(string_length(Coding::integer, 9), 9);
}

TEST(Coding, NamesRoundTripAndOthersAreRefused) {
  for (const auto coding : {Coding::mvbs, Coding::integer}) EXPECT_EQ(coding_from_name(to_string(coding)), coding);
  EXPECT_THROW(coding_from_name("gray"), std::invalid_argument);
}

}  // namespace
}  // namespace lacuna
