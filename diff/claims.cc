#include "diff/claims.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lacuna {
namespace {

constexpr Eigen::Index kGainBlocks = 40;  ///< stretches of each set whose scatter is the gain's error
constexpr double kClaimedFrom = 0.5;      ///< probability of its class

/// Adds up a set's gains over stretches of its validate recordings.
struct GainSum {
  double gain = 0.0, variance = 0.0, less = 0.0, more = 0.0;
  void add(const Eigen::VectorXd& one, const Eigen::VectorXd& other) {
    if (one.size() == 0) return;
    const Eigen::Index length = std::max<Eigen::Index>(1, one.size() / kGainBlocks);
    double sum = 0.0, squares = 0.0, n = 0.0;
    for (Eigen::Index k = 0; k < one.size(); k += length, ++n) {
      const Eigen::Index count = std::min(length, one.size() - k);
      const double g = 0.5 * (other.segment(k, count).squaredNorm() - one.segment(k, count).squaredNorm());
      sum += g, squares += g * g;
    }
    gain += sum, variance += std::max(0.0, squares - sum * sum / n);
    less += one.squaredNorm(), more += other.squaredNorm();
  }
};

}  // namespace

HeldoutGainOf heldout_over(const Structure& s, const JointFit& one, const JointFit& other) {
  GainSum sum;
  sum.add(rows_at(s.a, one.a, Role::validate), rows_at(s.a, other.a, Role::validate));
  sum.add(rows_at(s.b, one.b, Role::validate), rows_at(s.b, other.b, Role::validate));
  HeldoutGainOf out{sum.gain, std::sqrt(sum.variance), 0.0, sum.more > 0.0};
  if (out.known) out.share = 1.0 - sum.less / sum.more;
  return out;
}

std::vector<Claim> claims_of(const Structure& structure, const ChangeGroups& groups,
                             const std::vector<double>& probability, Hypothesised& best,
                             const std::atomic<bool>* stop) {
  std::vector<Claim> refused;
  for (;;) {
    std::vector<Claim> claims;
    std::optional<std::pair<std::size_t, JointFit>> worst;  // index in claims, the fit without it
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (best.changed[g] == 0) continue;
      ChangedSet without = best.changed;
      without[g] = 0;
      JointFit rest = fit_jointly(structure.a, structure.b, groups, without, best.fit, stop);
      Claim claim{g, heldout_over(structure, best.fit, rest), ""};
      if (probability[g] < kClaimedFrom) {
        claim.refused = "less probable than not";
      } else if (claim.heldout.known && !claim.heldout.speaks_for()) {
        claim.refused = fmt::format("the validate recordings do not confirm it: log-likelihood {:+.3g} +- {:.2g}",
                                    claim.heldout.gain, claim.heldout.error);
      }
      if (!claim.refused.empty() && (!worst || claim.heldout.gain < claims[worst->first].heldout.gain))
        worst.emplace(claims.size(), std::move(rest));
      claims.push_back(std::move(claim));
    }
    if (!worst) {
      claims.insert(claims.end(), refused.begin(), refused.end());
      return claims;
    }
    refused.push_back(claims[worst->first]);
    best.changed[claims[worst->first].group] = 0;
    best.fit = std::move(worst->second);
  }
}

}  // namespace lacuna
