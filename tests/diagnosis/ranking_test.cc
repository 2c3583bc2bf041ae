// Probabilities of candidates and of chance, from evidence that is given.
#include "diagnosis/ranking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kEffective = 1000.0;  ///< effective, of both train and validate recordings

/// Candidates on one pendulum whose gains are given in nats.
class Ranking : public ::testing::Test {
 protected:
  void add(const std::string& effect, double train, double heldout, int parameters,
           const std::string& place = "swing") {
    Tried t{{}, current, {}, {}};
    t.effect.spec.effect = effect;
    t.effect.spec.place = place;
    t.effect.parameters = parameters;
    t.train = of(train);
    t.heldout.whole = of(heldout);
    t.heldout.gain = heldout;
    t.heldout.blocks.assign(20, heldout / 20.0);
    tried.push_back(t);
  }
  static Gain of(double nats) {
    Gain out;
    out.channels = {{kEffective, 2.0 * nats / kEffective}};
    out.log_likelihood = nats;
    out.effective = kEffective;
    return out;
  }

  Scenario scenario = pendulum_problem({}, {"gain"}, 1e-3);
  PlantModel model{scenario};
  SearchSpace space{model, scenario};
  CurrentModel current{model, space, {1.0}, {}};
  std::vector<Tried> tried;
};

const double kWorth = 0.5 * std::log(kEffective);  ///< of one parameter

TEST_F(Ranking, CountsGainsLessHalfALogarithmAParameter) {
  add("coulomb_friction", 20.0, 10.0, 1);
  add("stribeck_friction", 22.0, 11.0, 3);
  sort_by_evidence(tried, 0.0);
  EXPECT_EQ(tried[0].effect.spec.effect, "coulomb_friction");
  EXPECT_NEAR(tried[0].evidence, 30.0 - kWorth, 1e-9);
  EXPECT_NEAR(tried[1].evidence, 33.0 - 3.0 * kWorth, 1e-9);
  EXPECT_EQ(tried[0].over_chance, tried[0].evidence);
}

TEST_F(Ranking, OddsAreThoseOfTheEvidence) {
  add("coulomb_friction", 20.0, 10.0, 1);
  add("quadratic_damping", 19.0, 9.0, 1);
  sort_by_evidence(tried, 0.0);
  const std::vector<double> p = probabilities(tried);
  EXPECT_NEAR(p[0] / p[1], std::exp(2.0), 1e-9);
  EXPECT_NEAR(1.0 - p[0] - p[1], 2.0 * std::exp(-tried[0].evidence) * p[0], 1e-15) << "two at evidence 0";
}

TEST_F(Ranking, GainsWithinTheIntegrationErrorAreATieThatTheFewerNumbersWin) {
  add("stribeck_friction", 22.0, 11.0, 3);
  add("coulomb_friction", 12.0, 6.0, 1);
  const double error = 0.15;  // of the noise: worth 22 nats over 2,000 samples
  sort_by_evidence(tried, error);
  EXPECT_EQ(tried[0].effect.spec.effect, "coulomb_friction");
  EXPECT_NEAR(tried[0].evidence - tried[1].evidence, 2.0 * kWorth, 1e-9);
}

TEST_F(Ranking, ATieLiftsNoCandidateOverChance) {
  add("base_compliance", 300.0, 200.0, 2);
  tried.back().objection = "a parameter at the end of its range";
  add("coulomb_friction", 0.1, 1.4, 1);
  sort_by_evidence(tried, 2.0);  // worth more than all gains
  EXPECT_GT(tried[0].evidence, 400.0) << "tied with the strongest";
  const std::vector<double> p = probabilities(tried);
  const std::size_t weak = tried[0].effect.spec.effect == "coulomb_friction" ? 0 : 1;
  EXPECT_LT(p[weak], 0.5);
  EXPECT_NEAR(p[weak], 1.0 / (1.0 + 2.0 * std::exp(kWorth - 1.5)), 1e-9);
  EXPECT_GT(make_finding(tried, weak, 1).outside, 0.5) << "chance is the likelier explanation";
}

TEST_F(Ranking, WhatCannotBeItHasNoShareAndIsNoRival) {
  add("coulomb_friction", 20.0, 10.0, 1);
  add("quadratic_damping", 30.0, 20.0, 1);
  tried.back().objection = "a parameter at the end of its range";
  sort_by_evidence(tried, 0.0);
  EXPECT_EQ(probabilities(tried)[0], 0.0);
  const Finding finding = make_finding(tried, 1, 1);
  EXPECT_EQ(finding.effect, "coulomb_friction");
  EXPECT_GT(finding.probability, 0.99);
  EXPECT_TRUE(finding.rivals.empty());
}

TEST_F(Ranking, ThoseWithinOddsOfTwentyAtOnePlaceAreOneClass) {
  add("coulomb_friction", 20.0, 10.0, 1);
  add("quadratic_damping", 19.0, 10.0, 1);
  add("armature", 16.0, 10.0, 1);
  add("valve_deadband", 20.0, 10.0, 1, "elsewhere");
  sort_by_evidence(tried, 0.0);
  const Finding finding = make_finding(tried, 0, 1);
  EXPECT_EQ(finding.members, (std::vector<std::string>{"coulomb_friction", "quadratic_damping"}));
  EXPECT_EQ(finding.rivals.size(), 3u);
}

TEST_F(Ranking, VariantsOfOneEffectAreOneRival) {
  add("coulomb_friction", 100.0, 50.0, 1);
  add("stribeck_friction", 101.0, 50.0, 2);
  add("stribeck_friction", 103.0, 50.0, 3);
  sort_by_evidence(tried, 0.0);
  const std::vector<double> shares = probabilities(tried);
  const Finding finding = make_finding(tried, 0, 1);
  ASSERT_EQ(finding.effect, "coulomb_friction");
  ASSERT_EQ(finding.rivals.size(), 1u);
  EXPECT_NEAR(finding.rivals.front().probability, shares[1] + shares[2], 1e-12);
  EXPECT_LE(std::count(finding.members.begin(), finding.members.end(), "stribeck_friction"), 1);
}

TEST_F(Ranking, ADivergedCandidateComesLast) {
  add("input_delay", std::nan(""), 1.0, 1);
  add("coulomb_friction", 1.0, 1.0, 1);
  sort_by_evidence(tried, 0.0);
  EXPECT_EQ(tried[0].effect.spec.effect, "coulomb_friction");
  EXPECT_LT(probabilities(tried)[1], 1e-300);
}

}  // namespace
}  // namespace lacuna
