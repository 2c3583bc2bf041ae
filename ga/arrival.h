// Whether least squares has arrived: several starts that meet, and no way on that a bound cuts off.
#pragma once

#include <cstdint>
#include <string>

#include "ga/least_squares.h"

namespace lacuna {

/// Share of the energy that two ends may differ by and still be one, and that a bound may keep from being gained.
constexpr double kSameEnd = 0.02;

/// The best of several descents.
struct SeveralStarts {
  LeastSquaresResult best;
  bool arrived = false;
  std::string doubt;  ///< why not, in words; empty where it has arrived
  long evaluations = 0;
  int starts = 0;  ///< all together
};

/// `ends`: descents made already, at least one. Draws further starts from the axes' priors (without one, from the
/// middle half of the range) until the residual is down to the noise (`noise_known`: the problem's weights are it), or
/// two descents end within kSameEnd of the best; arrived then, unless least squares did not come to an end or a bound
/// cuts the way on. At most four are drawn.
SeveralStarts from_several_starts(Problem& problem, std::span<const int> segments, std::vector<LeastSquaresResult> ends,
                                  bool noise_known, std::uint64_t seed, const LeastSquaresOptions& options);

/// Names of coordinates at a bound beyond which the energy would fall by more than kSameEnd; empty for none. By the
/// linear look from the solution's end.
std::string pushed_against_bounds(const PlantModel& model, const SearchSpace& space,
                                  const LeastSquaresResult& solution);

/// Whether `sum` of `n` squared residuals, in units of the noise, is no more than noise leaves.
bool down_to_noise(double sum, double n);

/// Whether first_weights() are the noise in every channel that is predicted.
bool noise_is_known(const Experiment& experiment);

}  // namespace lacuna
