// When a residual is more than noise: windows of a second, each tested on its own, with the error of all tests
// controlled. And when what is missing changes.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/evidence.h"
#include "physics/experiment.h"

namespace lacuna {

/// A stretch of a recording in which a joint's residual is beyond the noise.
struct Misfit {
  std::string recording, joint;
  double begin = 0.0, end = 0.0;  ///< s
  double ratio = 1.0;             ///< rms over the noise's
  double p_value = 1.0;           ///< of its strongest second, times all seconds tested
};

/// Seconds of `residual` whose energy the noise reaches in fewer than 1 in 1,000 such diagnoses (chi-square at each
/// second's own effective samples, Bonferroni over seconds and channels); neighbours joined; the most energy first, at
/// most `kMostMisfits`. `noise_over_weight` as in excess_over_noise: channels without a known noise are left out.
/// `channel_joints`: joint of each predicted channel.
constexpr std::size_t kMostMisfits = 12;
std::vector<Misfit> misfits(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks,
                            std::span<const double> noise_over_weight, std::span<const int> channel_joints,
                            const Experiment& experiment);

/// An instant at which the power of a signal changes.
struct PowerChange {
  std::size_t at = 0;                ///< first sample after it
  double before = 0.0, after = 0.0;  ///< rms from the change before to it, and from it to the next
  double p_value = 1.0;              ///< of such a change in a signal of one power, corrected for all tests
};
/// Cumulated squares against a straight line, with their long-run variance, so that neither tails nor colour of the
/// signal feign a change (Sanso, Arago and Carrion, Revista de Economia Financiera 4, 2004; the variance about up to
/// four levels, which a change does not swell), by binary segmentation; in order. Powers that differ by less than half
/// are not told apart. `signals`: how many are tested beside each other.
std::vector<PowerChange> power_changes(std::span<const double> signal, double signals);

}  // namespace lacuna
