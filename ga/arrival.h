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
  bool met = false;      ///< the best is down to the noise, or came to its end, and another one ended beside it
  bool arrived = false;  ///< so it is, and no bound cuts the way on
  std::string doubt;     ///< why not, in words; empty where it has arrived
  long evaluations = 0;
  int starts = 0;  ///< all together
};

/// What descents are compared by: what each has minimised.
inline double energy(const LeastSquaresResult& end) { return end.sum_of_squares + end.prior_cost; }

/// What may be spent on further starts.
struct FurtherStarts {
  int drawn = 4;       ///< at most
  int followed = 150;  ///< iterations from the best end on, where it has not come to its end: a narrow valley is long
};

/// `ends`: descents made already, at least one. Draws further starts from the axes' priors (without one, about the
/// start, bounds read as priors' are) until the residual is down to the noise (`noise_known`: the problem's weights are
/// it), or two descents end within kSameEnd of the best; arrived then, unless least squares did not come to an end or a
/// bound cuts the way on.
SeveralStarts from_several_starts(Problem& problem, std::span<const int> segments, std::vector<LeastSquaresResult> ends,
                                  bool noise_known, std::uint64_t seed, const LeastSquaresOptions& options,
                                  const FurtherStarts& further = {});

/// Names of coordinates at a bound beyond which the energy would fall by more than kSameEnd; empty for none. By the
/// linear look from the solution's end.
std::string pushed_against_bounds(const PlantModel& model, const SearchSpace& space,
                                  const LeastSquaresResult& solution);

/// Whether `sum` of `n` squared residuals, in units of the noise, is no more than noise leaves.
bool down_to_noise(double sum, double n);

/// Whether first_weights() are the noise in every channel that is predicted.
bool noise_is_known(const Experiment& experiment);

}  // namespace lacuna
