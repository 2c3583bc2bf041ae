// A measured motion as inverse dynamics needs it: positions, speeds and accelerations on one even clock, low-passed.
#pragma once

#include <memory>
#include <vector>

#include "physics/filter.h"
#include "scenarios/resample.h"

namespace lacuna {

/// What the transducers of one recording gave, before any filtering. Only what was measured is filled; NaN where a
/// sample is missing.
struct RawMotion {
  std::vector<double> time;                   ///< s, increasing; may be uneven
  std::vector<std::vector<double>> position;  ///< [joint][sample], rad (m); empty: not measured
  std::vector<std::vector<double>> velocity;  ///< [joint][sample], rad/s (m/s); empty: not measured
  std::vector<double> position_noise;         ///< [joint], rms, white; NaN: unknown
  std::vector<double> velocity_noise;
};

/// [joint][sample] each, on even samples. A joint without measured position stands still at 0.
struct MeasuredMotion {
  double rate = 0.0;         ///< Hz
  std::vector<double> time;  ///< s, even
  std::vector<std::vector<double>> q, v, a;
  std::vector<double> v_error;  ///< [joint], rms of the speeds' noise after the filter; 0 where unknown
  /// [joint][sample]: -1, 0, 1, the way in which the joint slides, or slid last before it came to rest: what rests may
  /// be held by friction either way, most likely still as it was when it stopped. A speed within three times its noise
  /// is rest; 0 before the first motion.
  std::vector<std::vector<double>> direction;

  std::size_t samples() const { return time.size(); }
};

/// Whether neighbouring samples lie within 1 % of one period.
bool is_even(const std::vector<double>& time);

/// Even times over the same span, as far apart as the samples are in the mean.
std::vector<double> even_times(const std::vector<double>& time);

/// An uneven clock is brought onto an even one on its own times: positions by cubics through the samples (with measured
/// speeds as their slopes), all else by straight lines. Then positions and measured speeds are low-passed, speeds not
/// measured are central differences of the filtered positions, accelerations those of the filtered speeds (of the
/// positions, second differences).
/// Throws std::invalid_argument where the cutoff is not below half the rate.
MeasuredMotion measured_motion(const RawMotion& raw, double cutoff_hz);

/// rms that white noise of rms 1 keeps through the filter, and that its central difference keeps, times the period.
struct FilterGain {
  double value = 1.0, slope = 1.0;
};
FilterGain filter_gain(const ZeroPhaseLowPass& filter, int passes);

}  // namespace lacuna
