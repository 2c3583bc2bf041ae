// Evidence of sets of effects about one fit, against the closed form of a linear Gaussian problem.
#include "diagnosis/linearised.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/diagnosis/noise.h"

namespace lacuna {
namespace {

using namespace test;

constexpr Eigen::Index kRows = 120;
constexpr double kEvidenceError = 1e-4;  // of log evidences of some hundred; the solver adds 1e-9 to a unit matrix

LinearColumn column_of(Eigen::VectorXd train, Eigen::VectorXd validate, double prior, double from_center = 0.0) {
  LinearColumn out;
  out.train = std::move(train), out.validate = std::move(validate);
  out.prior = prior, out.from_center = from_center;
  return out;
}

/// A part of one number: absent, it is toggled to where its number is 0.
Part part_of(const std::string& effect, const std::string& place, std::vector<LinearColumn> columns) {
  Part out;
  out.spec = {effect, place, {}, {}, ""};
  out.train = Eigen::VectorXd::Zero(columns.front().train.size());
  out.validate = Eigen::VectorXd::Zero(columns.front().validate.size());
  out.columns = std::move(columns);
  return out;
}

/// One plain number and three effects, the second of two numbers; the residual holds the first's and the second's part.
struct Problem3 {
  Eigen::VectorXd train, validate;
  std::vector<LinearColumn> plain;
  std::vector<Part> parts;
  std::vector<int> blocks;

  Problem3() {
    const std::vector<double> prior{0.5, 0.4, 0.7, 0.3};
    const auto column = [](std::uint64_t seed, double deviation) {
      return column_of(white(kRows, seed), white(kRows, seed + 100), deviation);
    };
    plain = {column(1, 2.0)};
    parts = {part_of("first", "j", {column(2, prior[0])}),
             part_of("second", "j", {column(3, prior[1]), column(4, prior[2])}),
             part_of("third", "k", {column(5, prior[3])})};
    train = white(kRows, 6) - 0.8 * plain[0].train - 1.1 * parts[0].columns[0].train;
    validate = white(kRows, 7) - 0.8 * plain[0].validate - 1.1 * parts[0].columns[0].validate;
    for (Eigen::Index k = 0; k < kRows; ++k) blocks.push_back(static_cast<int>(k / 10));
  }
  Linearised linearised() const { return Linearised(train, validate, plain, parts, blocks); }

  std::vector<const LinearColumn*> free_in(const Linearised::Set& set) const {
    std::vector<const LinearColumn*> out{&plain[0]};
    for (std::size_t k = 0; k < parts.size(); ++k)
      for (const LinearColumn& c : parts[k].columns)
        if (set[k]) out.push_back(&c);
    return out;
  }
  /// log N(r; J (x - center), I + J S J'), with the prior over sets as the header says.
  double closed_form(const Linearised::Set& set, const Eigen::VectorXd& residual) const {
    Eigen::MatrixXd C = Eigen::MatrixXd::Identity(kRows, kRows);
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(kRows);
    for (const LinearColumn* c : free_in(set)) {
      C += c->prior * c->prior * c->train * c->train.transpose();
      mean += c->from_center * c->train;
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(C);
    // The residual at which a number's own step stands at its prior's centre.
    const Eigen::VectorXd off = residual - mean;
    const Eigen::MatrixXd L = llt.matrixL();
    const double n = static_cast<double>(parts.size()), k = static_cast<double>(std::count(set.begin(), set.end(), 1));
    const double sets = std::tgamma(n + 1.0) / std::tgamma(k + 1.0) / std::tgamma(n - k + 1.0);
    return -0.5 * off.dot(llt.solve(off)) - L.diagonal().array().log().sum() + k * std::log(0.3) - std::log(sets);
  }
};

std::vector<Linearised::Set> all_sets() {
  std::vector<Linearised::Set> out;
  for (int bits = 0; bits < 8; ++bits)
    out.push_back({static_cast<char>(bits & 1), static_cast<char>(bits >> 1 & 1), static_cast<char>(bits >> 2 & 1)});
  return out;
}

TEST(Linearised, EvidenceOfEverySetIsTheClosedForms) {
  const Problem3 problem;
  const Linearised near = problem.linearised();
  const Linearised::Set none{0, 0, 0};
  EXPECT_EQ(near.present(), none);
  for (const Linearised::Set& set : all_sets()) {
    EXPECT_NEAR(near.evidence(set) - near.evidence(none),
                problem.closed_form(set, problem.train) - problem.closed_form(none, problem.train), kEvidenceError);
  }
}

TEST(Linearised, WhereTheModelStandsDoesNotMatter) {
  // The same problem seen from where the first effect stands at 0.9 and the plain number at 0.3.
  const Problem3 from_zero;
  Problem3 moved = from_zero;
  constexpr double kFirst = 0.9, kPlain = 0.3;
  const auto move = [](Eigen::VectorXd& r, const Eigen::VectorXd& column, double by) { r += by * column; };
  move(moved.train, from_zero.parts[0].columns[0].train, kFirst);
  move(moved.validate, from_zero.parts[0].columns[0].validate, kFirst);
  move(moved.train, from_zero.plain[0].train, kPlain);
  move(moved.validate, from_zero.plain[0].validate, kPlain);
  moved.plain[0].from_center = kPlain;
  moved.parts[0].present = true;
  moved.parts[0].columns[0].from_center = kFirst;
  moved.parts[0].train = -kFirst * from_zero.parts[0].columns[0].train;
  moved.parts[0].validate = -kFirst * from_zero.parts[0].columns[0].validate;
  const Linearised a = from_zero.linearised(), b = moved.linearised();
  for (const Linearised::Set& set : all_sets()) {
    EXPECT_NEAR(a.evidence(set), b.evidence(set), kEvidenceError);
    EXPECT_NEAR(a.heldout(set), b.heldout(set), kEvidenceError);
    EXPECT_NEAR(a.train_energy(set), b.train_energy(set), kEvidenceError);
  }
}

TEST(Linearised, ANumberBeyondItsRangeIsHeldAtItsEnd) {
  // The data ask for +1.1; the range ends at 0.2: as if the number stood there and were not free.
  Problem3 problem;
  constexpr double kEnd = 0.2;
  problem.parts[0].columns[0].highest = kEnd;
  const Linearised near = problem.linearised();
  const Linearised::Set first{1, 0, 0};
  const Eigen::VectorXd left = problem.train + kEnd * problem.parts[0].columns[0].train;
  // Energy of the plain number's own best step then.
  const LinearColumn& p = problem.plain[0];
  const double step = -p.train.dot(left) / (p.train.squaredNorm() + 1.0 / (p.prior * p.prior));
  EXPECT_NEAR(near.train_energy(first), (left + step * p.train).squaredNorm(), kEvidenceError);
  EXPECT_LT(near.evidence(first), Problem3().linearised().evidence(first));
  // What the range does not touch is as it was.
  EXPECT_NEAR(near.evidence({0, 1, 0}), Problem3().linearised().evidence({0, 1, 0}), kEvidenceError);
  problem.parts[0].columns[0].highest = 5.0;
  EXPECT_NEAR(problem.linearised().evidence(first), Problem3().linearised().evidence(first), kEvidenceError);
}

TEST(Linearised, HeldOutRowsAreWeighedAtTheNumbersOfTheOthers) {
  const Problem3 problem;
  const Linearised near = problem.linearised();
  for (const Linearised::Set& set : all_sets()) {
    const auto columns = problem.free_in(set);
    Eigen::MatrixXd J(kRows, columns.size()), V = J;
    Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(J.cols(), J.cols());
    for (Eigen::Index i = 0; i < J.cols(); ++i) {
      const LinearColumn& c = *columns[i];
      J.col(i) = c.train, V.col(i) = c.validate, precision(i, i) = 1.0 / (c.prior * c.prior);
    }
    const Eigen::VectorXd step = -(J.transpose() * J + precision).ldlt().solve(J.transpose() * problem.train);
    EXPECT_NEAR(near.heldout(set), -0.5 * (problem.validate + V * step).squaredNorm(), kEvidenceError);
    double sum = 0.0;
    for (const double part : near.heldout_blocks(set, 17)) sum += part;
    EXPECT_NEAR(sum, near.heldout(set), kEvidenceError);
  }
}

TEST(Linearised, BlocksCountAsOftenAsTheirWeights) {
  const Problem3 problem;
  const Linearised near = problem.linearised();
  const std::vector<double> once(12, 1.0);
  for (const Linearised::Set& set : all_sets())
    EXPECT_NEAR(near.evidence(set, once), near.evidence(set), kEvidenceError);
  // Weight 4 is every row twice as large.
  const std::vector<double> fourfold(12, 4.0);
  Problem3 larger = problem;
  larger.train *= 2.0;
  for (LinearColumn& c : larger.plain) c.train *= 2.0;
  for (Part& part : larger.parts)
    for (LinearColumn& c : part.columns) c.train *= 2.0;
  for (const Linearised::Set& set : all_sets())
    EXPECT_NEAR(near.evidence(set, fourfold), larger.linearised().evidence(set), kEvidenceError);
}

TEST(Linearised, BaggedSharesSumToOneAndPreferTheTrueSet) {
  const Problem3 problem;
  const Linearised near = problem.linearised();
  const std::vector<Linearised::Set> sets{{1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}};
  constexpr int kDraws = 200;
  const std::vector<double> shares = near.bagged(sets, kDraws, 1);
  double sum = 0.0;
  for (const double s : shares) sum += s;
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_EQ(std::max_element(shares.begin(), shares.end()), shares.begin());
  EXPECT_GT(shares[0], 0.6);
  EXPECT_GT(near.leads(sets, kDraws, 1), 0.6);
  EXPECT_TRUE(same_bits(shares, near.bagged(sets, kDraws, 1)));
}

TEST(Linearised, ToggledDropsWhatNeedsThePart) {
  Problem3 problem;
  problem.parts[2].needs = 0;
  const Linearised near = problem.linearised();
  using Set = Linearised::Set;
  EXPECT_EQ(near.toggled({1, 0, 1}, 0), (Set{0, 0, 0}));
  EXPECT_EQ(near.toggled({1, 1, 1}, 1), (Set{1, 0, 1}));
  EXPECT_EQ(near.toggled({0, 0, 0}, 0), (Set{1, 0, 0}));
  EXPECT_EQ(near.toggled({1, 0, 0}, 2), (Set{1, 0, 1}));
  EXPECT_EQ(near.evidence({0, 0, 1}), -HUGE_VAL);  // it cannot be without
  EXPECT_TRUE(std::isfinite(near.evidence({1, 0, 1})));
}

}  // namespace
}  // namespace lacuna
