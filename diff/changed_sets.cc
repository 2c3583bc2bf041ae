#include "diff/changed_sets.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "diagnosis/evidence.h"
#include "diagnosis/linearised.h"

namespace lacuna {
namespace {

constexpr double kOneMoreChange = 0.3;          ///< h: of one change more, before any data
constexpr double kOccamsWindow = 8.0;           ///< nats within which a subset lives
constexpr std::size_t kMostExpandedSets = 200;  ///< sets whose neighbours are looked at

ChangedSet with_toggled(ChangedSet set, std::size_t group) {
  set[group] = static_cast<char>(set[group] == 0);
  return set;
}

/// One group put in or taken out; with `swaps` also one exchanged for another.
std::vector<ChangedSet> changed_by_one(const ChangedSet& set, bool swaps) {
  std::vector<ChangedSet> out;
  for (std::size_t g = 0; g < set.size(); ++g) out.push_back(with_toggled(set, g));
  if (!swaps) return out;
  for (std::size_t in = 0; in < set.size(); ++in)
    for (std::size_t from = 0; from < set.size(); ++from)
      if (set[in] == 0 && set[from] != 0) out.push_back(with_toggled(with_toggled(set, in), from));
  return out;
}

/// Evidence of subsets, each worked out once.
class KnownSets {
 public:
  explicit KnownSets(const ChangedSets& sets) : sets_(sets) {}
  double operator()(const ChangedSet& set) {
    const auto found = known_.find(set);
    return found != known_.end() ? found->second : known_.emplace(set, sets_.evidence(set)).first->second;
  }
  const std::map<ChangedSet, double>& all() const { return known_; }

 private:
  const ChangedSets& sets_;
  std::map<ChangedSet, double> known_;
};

void climb_from(KnownSets& known, ChangedSet set) {
  for (double best = known(set);;) {
    ChangedSet next;
    for (ChangedSet& other : changed_by_one(set, true)) {
      const double evidence = known(other);
      if (evidence > best) best = evidence, next = std::move(other);
    }
    if (next.empty()) return;
    set = std::move(next);
  }
}

/// The best set that is known and not yet expanded, if it lives.
const ChangedSet* best_unexpanded(const KnownSets& known, const std::map<ChangedSet, bool>& expanded) {
  const ChangedSet* out = nullptr;
  double best = -std::numeric_limits<double>::infinity(), evidence = best;
  for (const auto& [set, value] : known.all()) {
    best = std::max(best, value);
    if (value > evidence && !expanded.contains(set)) evidence = value, out = &set;
  }
  return evidence > best - kOccamsWindow ? out : nullptr;
}

}  // namespace

JointColumns::JointColumns(Eigen::Index size, const ChangeGroups& groups, const ChangedSet& changed)
    : columns_(size), b_(size) {
  for (Eigen::Index i = 0; i < size; ++i) b_[i] = i;
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (changed[g] != 0)
      for (const Eigen::Index i : groups[g]) b_[i] = columns_++;
}

Eigen::MatrixXd JointColumns::joined(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                     const Eigen::VectorXd& common) const {
  const Eigen::Index n = a.rows();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(columns_, columns_);
  out.topLeftCorner(n, n) = a;
  out.diagonal().head(n) += common;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) out(of_b(i), of_b(j)) += b(i, j);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!apart(i)) continue;
    out(i, i) += 1.0, out(of_b(i), of_b(i)) += 1.0;  // (y_B - y_A)^2
    out(i, of_b(i)) -= 1.0, out(of_b(i), i) -= 1.0;
  }
  return out;
}

Eigen::VectorXd JointColumns::joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(columns_);
  out.head(a.size()) = a;
  for (Eigen::Index i = 0; i < b.size(); ++i) out(of_b(i)) += b(i);
  return out;
}

ChangedSets::ChangedSets(Quadratic a, Quadratic b, ChangeGroups groups)
    : ChangedSets(a, b, std::move(groups),
                  {Eigen::VectorXd::Zero(a.linear.size()), Eigen::VectorXd::Ones(a.linear.size())}) {}

ChangedSets::ChangedSets(Quadratic a, Quadratic b, ChangeGroups groups, const CommonPrior& common)
    : a_(std::move(a)),
      b_(std::move(b)),
      groups_(std::move(groups)),
      common_(common.deviation.cwiseProduct(common.deviation).cwiseInverse()),
      from_center_(common_.cwiseProduct(common.center)) {
  const Eigen::Index n = a_.linear.size();
  const auto fits = [&](const Quadratic& q) {
    return q.linear.size() == n && q.information.rows() == n && q.information.cols() == n;
  };
  if (!fits(a_) || !fits(b_)) throw std::invalid_argument("ChangedSets: informations of different sizes");
}

ChangedSets::Root ChangedSets::root_of(const JointColumns& columns) const {
  return Root(columns.joined(a_.information, b_.information, common_));
}

double ChangedSets::log_volume(const Root& root, const ChangedSet& changed) const {
  // The priors' own determinant is the same for all: each change adds a unit variance to what it changes.
  const double log_root = root.matrixLLT().diagonal().array().log().sum();
  const double k = static_cast<double>(std::count_if(changed.begin(), changed.end(), [](char c) { return c != 0; }));
  return k * std::log(kOneMoreChange) + std::log(1.0 - kOneMoreChange) -
         log_choose(static_cast<double>(groups_.size()), k) - log_root;
}

double ChangedSets::evidence(const ChangedSet& changed) const {
  const JointColumns columns(a_.linear.size(), groups_, changed);
  const Root root = root_of(columns);
  if (root.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  const Eigen::VectorXd half = root.matrixL().solve(columns.joined(a_.linear + from_center_, b_.linear));
  return 0.5 * half.squaredNorm() + log_volume(root, changed);
}

double ChangedSets::evidence_of_fit(const ChangedSet& changed, double cost) const {
  const Root root = root_of(JointColumns(a_.linear.size(), groups_, changed));
  if (root.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  return -0.5 * cost + log_volume(root, changed);
}

ChangePosterior ChangedSets::posterior(const ChangedSet& changed) const {
  const Eigen::Index n = a_.linear.size();
  const JointColumns columns(n, groups_, changed);
  const Root root = root_of(columns);
  const Eigen::MatrixXd covariance = root.solve(Eigen::MatrixXd::Identity(columns.size(), columns.size()));
  const Eigen::VectorXd mean = root.solve(columns.joined(a_.linear + from_center_, b_.linear));
  ChangePosterior out{mean.head(n), Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index b = columns.of_b(i);
    out.b(i) = mean(b);
    out.error_a(i) = std::sqrt(covariance(i, i)), out.error_b(i) = std::sqrt(covariance(b, b));
    out.covariance_ab(i) = covariance(i, b);
  }
  return out;
}

std::vector<LivingSet> search_changes(const ChangedSets& sets, const std::vector<ChangedSet>& starts) {
  KnownSets known(sets);
  climb_from(known, sets.none());
  for (const ChangedSet& start : starts) climb_from(known, start);
  std::map<ChangedSet, bool> expanded;
  while (expanded.size() < kMostExpandedSets) {
    const ChangedSet* next = best_unexpanded(known, expanded);
    if (next == nullptr) break;
    const ChangedSet set = *next;
    expanded[set] = true;
    for (const ChangedSet& other : changed_by_one(set, false)) known(other);
  }
  std::vector<LivingSet> out;
  for (const auto& [set, evidence] : known.all()) out.push_back({set, evidence, 0.0});
  std::stable_sort(out.begin(), out.end(), [](const auto& x, const auto& y) { return x.evidence > y.evidence; });
  std::erase_if(out,
                [best = out.front().evidence](const LivingSet& s) { return !(s.evidence > best - kOccamsWindow); });
  double sum = 0.0;
  for (LivingSet& s : out) sum += s.share = std::exp(s.evidence - out.front().evidence);
  for (LivingSet& s : out) s.share /= sum;
  return out;
}

std::vector<double> change_probabilities(const std::vector<LivingSet>& living) {
  std::vector<double> out(living.front().changed.size(), 0.0);
  for (const LivingSet& s : living)
    for (std::size_t g = 0; g < out.size(); ++g) out[g] += s.changed[g] != 0 ? s.share : 0.0;
  return out;
}

std::vector<std::size_t> change_class(const ChangedSets& sets, const ChangedSet& best, std::size_t group) {
  std::vector<std::pair<double, std::size_t>> near;
  const double evidence = sets.evidence(best);
  for (std::size_t g = 0; g < best.size(); ++g) {
    if (best[g] != 0) continue;
    const double other = sets.evidence(with_toggled(with_toggled(best, g), group));
    if (other > evidence - kNotToldApart) near.emplace_back(-other, g);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::size_t> out{group};
  for (const auto& [unused, g] : near) out.push_back(g);
  return out;
}

double class_probability(const std::vector<LivingSet>& living, const std::vector<std::size_t>& members) {
  double out = 0.0;
  for (const LivingSet& s : living)
    if (std::any_of(members.begin(), members.end(), [&](std::size_t g) { return s.changed[g] != 0; })) out += s.share;
  return std::min(out, 1.0);
}

}  // namespace lacuna
