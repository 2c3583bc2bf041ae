// What a measured signal says of its own noise.
#pragma once

#include <vector>

namespace lacuna {

/// rms of the measuring noise, signal units: what the differences show, and no less than rounding to the signal's
/// quantisation step leaves (step / sqrt(12)): a quantised reading that mostly stands still hides its noise, it has no
/// less of it. NaN where the signal says nothing. NaN samples are left out.
double noise_of(const std::vector<double>& time, const std::vector<double>& signal);

/// rms of the measuring noise from sixth differences: the median over blocks of the rms that a locally polynomial
/// motion leaves, blocks in which the reading does not change left out. Upward biased for coarse sampling, downward for
/// coloured noise, never by a model's misfit.
double noise_from_differences(const std::vector<double>& time, const std::vector<double>& signal);

/// The step that all distances of a signal's values are multiples of; 0 where there is none to be seen.
double quantisation_step(const std::vector<double>& signal);

}  // namespace lacuna
