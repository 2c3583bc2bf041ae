// Noise of unit size as a residual.
#pragma once

#include <Eigen/Core>

#include "tests/physics/plants.h"

namespace lacuna::test {

inline Eigen::VectorXd white(Eigen::Index n, std::uint64_t seed) {
  Noise random(seed);
  Eigen::VectorXd out(n);
  for (Eigen::Index k = 0; k < n; ++k) out(k) = random();
  return out;
}

}  // namespace lacuna::test
