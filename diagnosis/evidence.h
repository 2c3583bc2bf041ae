// How strong a change of the residual is: gains in log-likelihood, their errors, and chances under no effect.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ga/problem.h"

namespace lacuna {

/// Two residuals of the same samples, before and after an effect was added.
struct Gain {
  struct Channel {
    double effective = 0.0;  ///< samples
    double log_ratio = 0.0;  ///< log(energy before / energy after)
  };
  std::vector<Channel> channels;
  /// The gain at another residual's effective samples: candidates are compared at one count, that of the best of them.
  double at(const Gain& reference) const;

  double log_likelihood = 0.0;  ///< sum over channels of (n_eff / 2) log(energy before / energy after), each channel's
                                ///< noise level profiled out; n_eff of the residual after
  double effective = 0.0;       ///< samples, all channels
  double share = 0.0;           ///< of the whitened energy removed
};
Gain residual_gain(const Eigen::VectorXd& before, const Eigen::VectorXd& after, std::span<const ResidualBlock> blocks);

/// The gain on held-out recordings, and whether it is more than luck. How the prediction changes, d, was settled on
/// other recordings: without any effect its sum of products with the residual before has mean 0 and the variance of
/// noise sent through it. `standard_errors` is that sum over its standard deviation, channels weighed by the noise that
/// they are left with, slow noise counted at its effective samples, and the model's own errors (`spread`) sent through
/// d besides; `p_value` its one-sided normal chance. It asks for the direction only: whether the size is right, too,
/// says the sign of `gain`.
struct HeldoutGain {
  double gain = 0.0, share = 0.0;
  double error = 0.0;  ///< standard error of the gain if the effect is there
  double standard_errors = 0.0, p_value = 1.0;
  std::vector<double> blocks;  ///< gains of about one second each, at least 20 of them
  Gain whole;
};
HeldoutGain heldout_gain(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                         std::span<const ResidualBlock> blocks, const Eigen::MatrixXd& spread = {});

/// What the errors of a fit do to its predictions elsewhere: a matrix E, one row a predicted sample, with E E^T their
/// covariance. From both whitened Jacobians and what the fit leaves, slow rests counted at their effective samples.
/// `floor`: least_curvatures() of the fit's coordinates.
Eigen::MatrixXd prediction_spread(const Eigen::MatrixXd& fitted, const Eigen::VectorXd& residual,
                                  std::span<const ResidualBlock> blocks, const Eigen::MatrixXd& elsewhere,
                                  const Eigen::VectorXd& floor);

/// Chance that an effect with `parameters` free numbers gains this much log-likelihood where there is none
/// (Wilks: twice the gain is chi-square), times `tries` (Bonferroni).
double chance(double gain, int parameters, int tries);
/// The same together with what held-out recordings say: the product of both chances (Fisher), times `tries`.
double chance(double gain, int parameters, const HeldoutGain& heldout, int tries);

/// Share of block resamples in which the first one's held-out sum exceeds the second's.
double stability(std::span<const double> first, std::span<const double> second, std::uint64_t seed);

/// Chance that noise alone has `ratio` times its usual energy over n effective samples: chi-square by the cube-root
/// normal approximation, which holds for any n (Wilson and Hilferty, PNAS 17, 1931).
double chance_of_energy(double ratio, double n);

/// Joints whose residual exceeds the noise beyond chance: variance against noise with the effective sample size,
/// Holm over the channels at 1 in 1000; and by a weight worth mentioning (`kNegligible` of the noise's energy).
struct ExcessNoise {
  int channel = 0;
  double ratio = 1.0;    ///< rms over noise
  double p_value = 1.0;  ///< after Holm
};
std::vector<ExcessNoise> excess_over_noise(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks,
                                           std::span<const double> noise_over_weight);

/// Log evidence within which two are not told apart: odds 20 to 1.
constexpr double kNotToldApart = 3.0;

/// Log evidence from which something that has no name was learned and not made up.
constexpr double kWorthLearning = 10.0;

/// Of the measured efforts' rest at a joint on the validate recordings: what takes less away is no explanation of it.
constexpr double kLeastOfEfforts = 0.1;

/// How a channel's residual goes with itself: white noise does not.
struct Autocorrelation {
  int channel = 0;
  double samples = 0.0;
  std::vector<double> by_lag;  ///< from lag 1 to `kLags`; segments do not run into each other
  double p_value = 1.0;        ///< of so much colour in white noise: Ljung and Box, Biometrika 65 (1978)
};
/// One entry per channel with samples enough (two per lag) and any energy.
constexpr int kLags = 25;
std::vector<Autocorrelation> autocorrelations(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks);

/// Smallest chance over channels, corrected for their number (Bonferroni), that residuals so coloured come from white
/// noise.
double chance_of_white(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks);

}  // namespace lacuna
