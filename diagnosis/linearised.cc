#include "diagnosis/linearised.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "ga/random.h"

namespace lacuna {
namespace {

constexpr double kEffectShare = 0.3;         ///< h: of one effect more, before any data
constexpr double kSingularNormal = 1e-9;     ///< of a unit normal matrix
constexpr int kActiveRounds = 40;            ///< in which numbers are held at the ends of their ranges
constexpr std::uint32_t kBaggingDraws = 83;  ///< of random draws

}  // namespace

double log_choose(double n, double k) { return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0); }

double log_prior_of_effects(double k, double n) { return k * std::log(kEffectShare) - log_choose(n, k); }

std::vector<std::vector<double>> block_draws(std::size_t blocks, int draws, std::uint64_t seed) {
  std::vector<std::vector<double>> out;
  for (int d = 0; d < draws; ++d) {
    RandomStream random(seed, static_cast<std::uint32_t>(d), 0, kBaggingDraws);
    std::vector<double>& weights = out.emplace_back(blocks, 0.0);
    for (std::size_t k = 0; k < blocks; ++k) weights[random.below(static_cast<std::uint32_t>(blocks))] += 1.0;
  }
  return out;
}

Linearised::Linearised(Eigen::VectorXd train, Eigen::VectorXd validate, std::vector<LinearColumn> plain,
                       std::vector<Part> parts, const std::vector<int>& blocks)
    : parts_(std::move(parts)), plain_(std::move(plain)) {
  for (const LinearColumn& column : plain_) columns_.push_back(&column);
  plain_count_ = static_cast<Eigen::Index>(plain_.size());
  for (const Part& part : parts_) {
    first_column_.push_back(1 + static_cast<Eigen::Index>(columns_.size()));
    for (const LinearColumn& column : part.columns) columns_.push_back(&column);
  }
  offsets_ = 1 + static_cast<Eigen::Index>(columns_.size());
  const Eigen::Index width = offsets_ + static_cast<Eigen::Index>(parts_.size());
  const auto stacked = [&](const Eigen::VectorXd& residual, auto rows_of) {
    Eigen::MatrixXd out(residual.size(), width);
    out.col(0) = residual;
    for (std::size_t k = 0; k < columns_.size(); ++k) out.col(1 + static_cast<Eigen::Index>(k)) = rows_of(*columns_[k]);
    for (std::size_t k = 0; k < parts_.size(); ++k)
      out.col(offsets_ + static_cast<Eigen::Index>(k)) = rows_of(parts_[k]);
    return out;
  };
  const Eigen::MatrixXd all = stacked(train, [](const auto& of) -> const Eigen::VectorXd& { return of.train; });
  validate_ = stacked(validate, [](const auto& of) -> const Eigen::VectorXd& { return of.validate; });
  samples_ = static_cast<double>(train.size());
  std::map<int, std::vector<Eigen::Index>> rows;
  for (std::size_t i = 0; i < blocks.size(); ++i) rows[blocks[i]].push_back(i);
  gram_ = Eigen::MatrixXd::Zero(width, width);
  for (const auto& [block, members] : rows) {
    const Eigen::MatrixXd part = all(members, Eigen::all);
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(width, width);
    gram.selfadjointView<Eigen::Lower>().rankUpdate(part.transpose());
    gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
    gram_ += gram;
    if (rows.size() > 1) block_grams_.push_back(std::move(gram));
  }
}

Linearised::Set Linearised::present() const {
  Set out;
  for (const Part& part : parts_) out.push_back(part.present);
  return out;
}

Linearised::Set Linearised::toggled(Set set, int part) const {
  set[part] = !set[part];
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (!set[part] && parts_[i].needs == part) set[i] = 0;
  return set;
}

double Linearised::log_prior(const Set& set) const {
  std::set<std::pair<std::string, std::string>> all, in;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    if (parts_[k].needs >= 0) continue;
    const auto name = std::make_pair(parts_[k].spec.effect, parts_[k].spec.place);
    all.insert(name);
    if (set[k]) in.insert(name);
  }
  double out = log_prior_of_effects(static_cast<double>(in.size()), static_cast<double>(all.size()));
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (set[i]) out -= std::log(parts_[i].choices);
  return out;
}

Linearised::Solved Linearised::solve(const Set& set, const Eigen::MatrixXd& gram, double samples) const {
  Solved out;
  Eigen::VectorXd given = Eigen::VectorXd::Zero(gram.cols());  // what the residual is before any step
  given(0) = 1.0;
  for (Eigen::Index k = 0; k < plain_count_; ++k) out.columns.push_back(1 + k);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const Part& part = parts_[k];
    if (set[k] && part.needs >= 0 && !set[part.needs]) return out;
    if (static_cast<bool>(set[k]) != part.present) given(offsets_ + static_cast<Eigen::Index>(k)) = 1.0;
    if (!set[k]) continue;
    for (std::size_t c = 0; c < part.columns.size(); ++c)
      out.columns.push_back(first_column_[k] + static_cast<Eigen::Index>(c));
  }
  double fixed_cost = 0.0;
  for (int round = 0; round < kActiveRounds; ++round) {
    const Eigen::Index n = out.columns.size();
    const Eigen::VectorXd through = gram * given;
    Eigen::MatrixXd A = gram(out.columns, out.columns);
    Eigen::VectorXd b = through(out.columns);
    double cost = given.dot(through) + fixed_cost, spread = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const LinearColumn& column = *columns_[out.columns[i] - 1];
      const double precision = std::isfinite(column.prior) ? 1.0 / (column.prior * column.prior) : 0.0;
      A(i, i) += precision + 1e-12 * A(i, i) + 1e-300;
      b(i) += precision * column.from_center;
      cost += precision * column.from_center * column.from_center;
      if (precision > 0.0) spread += 2.0 * std::log(column.prior);
    }
    // Scaled to unit size, so that units do not drown what is little determined.
    const Eigen::VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd unit = scale.asDiagonal() * A * scale.asDiagonal();
    unit.diagonal().array() += kSingularNormal;
    const Eigen::LLT<Eigen::MatrixXd> llt(unit);
    if (llt.info() != Eigen::Success) return out;
    out.step = -scale.cwiseProduct(llt.solve(scale.cwiseProduct(b)));
    // Hold what would leave its range at its end.
    Eigen::Index worst = -1;
    double most = 1e-9;
    for (Eigen::Index i = 0; i < n; ++i) {
      const LinearColumn& column = *columns_[out.columns[i] - 1];
      const double beyond = std::max(out.step(i) - column.highest, column.lowest - out.step(i));
      const double scaled = beyond * std::sqrt(A(i, i));
      if (scaled > most) most = scaled, worst = i;
    }
    if (worst < 0) {
      const double determinant = 2.0 * (llt.matrixLLT().diagonal().array().log().sum() - scale.array().log().sum());
      out.energy = cost + b.dot(out.step);
      out.evidence = -0.5 * out.energy - 0.5 * (determinant + spread) + log_prior(set);
      out.possible = std::isfinite(out.evidence) && samples > 0.0;
      // Full vector of steps, those held among them.
      Eigen::VectorXd steps = given;
      for (Eigen::Index i = 0; i < n; ++i) steps(out.columns[i]) += out.step(i);
      out.step = std::move(steps);
      return out;
    }
    const Eigen::Index at = out.columns[worst];
    const LinearColumn& held = *columns_[at - 1];
    const double end = std::clamp(out.step(worst), held.lowest, held.highest);
    given(at) = end;
    if (std::isfinite(held.prior)) fixed_cost += std::pow((held.from_center + end) / held.prior, 2);
    out.columns.erase(out.columns.begin() + worst);
  }
  return out;
}

double Linearised::evidence(const Set& set) const {
  const Solved s = solve(set, gram_, samples_);
  return s.possible ? s.evidence : -HUGE_VAL;
}

double Linearised::evidence(const Set& set, const std::vector<double>& weights) const {
  const Solved s = solve(set, weighed(weights), samples_);
  return s.possible ? s.evidence : -HUGE_VAL;
}

double Linearised::train_energy(const Set& set) const {
  const Solved s = solve(set, gram_, samples_);
  return s.possible ? s.step.dot(gram_ * s.step) : HUGE_VAL;
}

double Linearised::heldout(const Set& set) const {
  const Solved s = solve(set, gram_, samples_);
  return s.possible ? -0.5 * (validate_ * s.step).squaredNorm() : -HUGE_VAL;
}

Eigen::VectorXd Linearised::heldout_rest(const Set& set) const {
  const Solved s = solve(set, gram_, samples_);
  return s.possible ? Eigen::VectorXd(validate_ * s.step) : Eigen::VectorXd();
}

std::vector<double> Linearised::heldout_blocks(const Set& set, Eigen::Index length) const {
  const Solved s = solve(set, gram_, samples_);
  std::vector<double> out;
  if (!s.possible || length < 1) return out;
  const Eigen::VectorXd rest = validate_ * s.step;
  for (Eigen::Index k = 0; k < rest.size(); k += length)
    out.push_back(-0.5 * rest.segment(k, std::min(length, rest.size() - k)).squaredNorm());
  return out;
}

Eigen::MatrixXd Linearised::weighed(const std::vector<double>& weights) const {
  if (block_grams_.empty()) return gram_;  // one block: no resampling
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(gram_.rows(), gram_.cols());
  for (std::size_t b = 0; b < block_grams_.size(); ++b)
    if (weights[b] != 0.0) out += weights[b] * block_grams_[b];
  return out;
}

/// [draw][set]: share of exp(evidence).
std::vector<std::vector<double>> Linearised::shares(const std::vector<Set>& sets, int draws, std::uint64_t seed) const {
  std::vector<std::vector<double>> out;
  const std::size_t blocks = block_grams_.size();
  for (const std::vector<double>& weights : block_draws(blocks, draws, seed)) {
    const Eigen::MatrixXd gram = weighed(weights);
    std::vector<double> logs;
    double most = -HUGE_VAL, total = 0.0;
    for (const Set& set : sets) {
      const Solved s = solve(set, gram, samples_);
      logs.push_back(s.possible ? s.evidence : -HUGE_VAL);
      most = std::max(most, logs.back());
    }
    for (double& x : logs) total += x = std::exp(std::max(x - most, -700.0));
    for (double& x : logs) x /= total;
    out.push_back(std::move(logs));
  }
  return out;
}

std::vector<double> Linearised::bagged(const std::vector<Set>& sets, int draws, std::uint64_t seed) const {
  std::vector<double> out(sets.size(), 0.0);
  for (const std::vector<double>& draw : shares(sets, draws, seed))
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += draw[k] / draws;
  return out;
}

double Linearised::leads(const std::vector<Set>& sets, int draws, std::uint64_t seed) const {
  int wins = 0;
  for (const std::vector<double>& draw : shares(sets, draws, seed))
    wins += std::max_element(draw.begin(), draw.end()) == draw.begin();
  return static_cast<double>(wins) / draws;
}

}  // namespace lacuna
