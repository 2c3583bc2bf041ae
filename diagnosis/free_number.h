// Optional numbers of a set's members: held at their neutral values until a search frees them.
//
// The opposite stop of a cylinder, the sharpness of a bend: refinements of an effect's shape that its first fit does
// without (ParameterInfo::optional).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/hypothesis.h"

namespace lacuna {

/// An optional number of a member, at one of its starts.
struct FreeNumber {
  EffectSpec member, with;   ///< as it stands, and with the number free
  std::string key;           ///< of the parameter
  double start = 0.0;        ///< search coordinate
  Eigen::VectorXd residual;  ///< whitened, on the train recordings, all else as it stands; may be not finite
};

/// Every start of every optional number that a member of the set holds fixed, simulated on `experiment`.
std::vector<FreeNumber> numbers_to_free(const Hypothesis& set, const FitContext& context);

/// A member's own coordinates, with the number that `with` has free besides at `start`.
std::vector<double> own_point_with(const CurrentModel& now, const Experiment& experiment, const EffectSpec& member,
                                   const EffectSpec& with, double start);

}  // namespace lacuna
