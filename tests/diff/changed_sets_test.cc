// The evidence of changed subsets on Gaussians whose answer is known, and how often it is right.
#include "diff/changed_sets.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

namespace lacuna {
namespace {

constexpr Eigen::Index kNumbers = 12;
constexpr int kDraws = 400;

ChangeGroups each_alone(Eigen::Index n) {
  ChangeGroups out;
  for (Eigen::Index i = 0; i < n; ++i) out.push_back({i});
  return out;
}

/// Recordings that measure y through random sensitivities with unit noise, `samples` of them.
Quadratic measured(const Eigen::VectorXd& y, Eigen::Index samples, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(random); };
  const Eigen::MatrixXd J = Eigen::MatrixXd::NullaryExpr(samples, y.size(), draw);
  const Eigen::VectorXd noise = Eigen::VectorXd::NullaryExpr(samples, draw);
  return {J.transpose() * J, J.transpose() * (J * y + noise)};
}

Eigen::VectorXd drawn(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(kNumbers, [&] { return normal(random); });
}

TEST(ChangedSets, EvidenceIsTheGaussianIntegral) {
  // One number, seen once in each set with unit noise as x_a, x_b: both are jointly normal, with or without a change.
  const double xa = 0.7, xb = -1.1;
  const Quadratic a{Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Constant(1, xa)};
  const Quadratic b{Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Constant(1, xb)};
  const ChangedSets sets(a, b, each_alone(1));
  const auto log_normal = [&](double variance_b) {
    Eigen::Matrix2d S;
    S << 2.0, 1.0, 1.0, variance_b;
    const Eigen::Vector2d x(xa, xb);
    return -0.5 * x.dot(S.inverse() * x) - 0.5 * std::log(S.determinant());
  };
  const double odds = log_normal(3.0) - log_normal(2.0) + std::log(0.3);
  EXPECT_NEAR(sets.evidence({1}) - sets.evidence({0}), odds, 1e-12);
}

TEST(ChangedSets, WhatNeitherSetDeterminesSaysNothing) {
  Quadratic a{Eigen::MatrixXd::Zero(2, 2), Eigen::VectorXd::Zero(2)}, b = a;
  a.information(0, 0) = b.information(0, 0) = 1e4;
  const ChangedSets sets(a, b, each_alone(2));
  // Only the prior of a set speaks: two sets of one change, the change of nothing known costs as any other.
  EXPECT_NEAR(sets.evidence({0, 1}) - sets.evidence({0, 0}), std::log(0.3) - std::log(2.0), 1e-9);
  EXPECT_LT(sets.evidence({1, 0}), sets.evidence({0, 1}));
}

TEST(ChangedSets, ClaimsNoMoreThanThePriorAllowsWhereNothingChanged) {
  std::mt19937_64 random(1);
  int claims = 0, best_is_empty = 0;
  for (int k = 0; k < kDraws; ++k) {
    const Eigen::VectorXd y = drawn(random);
    const auto a = measured(y, 60, random), b = measured(y, 40, random);
    const std::vector<LivingSet> living = search_changes(ChangedSets(a, b, each_alone(kNumbers)));
    best_is_empty += living.front().changed == ChangedSet(kNumbers, 0);
    for (const double p : change_probabilities(living)) claims += p > 0.9;
  }
  // A change of one number has 3 % of the prior odds of none here; a claim above .9 needs data that have less than one
  // chance in nine times 1/.025 of coming by noise.
  EXPECT_LE(claims, 3);
  EXPECT_GT(best_is_empty, kDraws * 96 / 100);
}

TEST(ChangedSets, FindsWhatChangedAndAsOftenAsItSays) {
  std::mt19937_64 random(2);
  std::uniform_int_distribution<Eigen::Index> which(0, kNumbers - 1);
  int found = 0;
  double said = 0.0, right = 0.0, total = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    const Eigen::VectorXd y = drawn(random);
    Eigen::VectorXd changed = y;
    const Eigen::Index i = which(random);
    std::normal_distribution<double> normal;
    changed(i) += normal(random);
    const auto a = measured(y, 60, random), b = measured(changed, 40, random);
    const std::vector<double> p = change_probabilities(search_changes(ChangedSets(a, b, each_alone(kNumbers))));
    for (Eigen::Index j = 0; j < kNumbers; ++j) {
      const double probability = p[j];
      if (probability < 0.5) continue;
      ++total, said += probability, right += j == i;
    }
    found += p[i] > 0.5;
  }
  EXPECT_GT(found, kDraws / 2);  // a change below two standard errors of its own cannot be seen
  EXPECT_NEAR(right / total, said / total, 0.04);
}

TEST(ChangedSets, ThoseThatTheRecordingsDoNotTellApartAreOneClass) {
  // Two numbers that only show as their sum; the sum changed.
  Quadratic a{Eigen::MatrixXd::Zero(3, 3), Eigen::VectorXd::Zero(3)};
  a.information.topLeftCorner(2, 2).setConstant(400.0);
  a.information(2, 2) = 400.0;
  Quadratic b = a;
  b.linear.head(2).setConstant(400.0);  // sum of 1 in place of 0
  const ChangedSets sets(a, b, each_alone(3));
  const auto living = search_changes(sets);
  const ChangedSet& best = living.front().changed;
  const std::size_t named = best[0] != 0 ? 0 : 1;
  EXPECT_EQ(change_class(sets, best, named), (std::vector<std::size_t>{named, 1 - named}));
  EXPECT_GT(class_probability(living, {0, 1}), 0.99);
  EXPECT_LT(change_probabilities(living)[named], 0.7);
}

}  // namespace
}  // namespace lacuna
