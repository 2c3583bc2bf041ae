#include "physics/filter.h"

#include <numbers>
#include <stdexcept>

namespace lacuna {

ZeroPhaseLowPass::ZeroPhaseLowPass(double cutoff, double rate) {
  if (!(cutoff > 0.0) || !(cutoff < 0.5 * rate)) {
    throw std::invalid_argument("low-pass cutoff must lie between 0 and half the sampling rate");
  }
  const double w = std::tan(std::numbers::pi * cutoff / rate);
  for (int k = 0; k < 2; ++k) {
    const double q = 2.0 * std::sin(std::numbers::pi * (2.0 * k + 1.0) / 8.0);  // 1/Q of the k-th pole pair
    const double norm = 1.0 / (1.0 + q * w + w * w);
    sections_[k] = {w * w * norm, 2.0 * w * w * norm, w * w * norm, 2.0 * (w * w - 1.0) * norm,
                    (1.0 - q * w + w * w) * norm};
  }
  pad_ = static_cast<std::size_t>(3.0 * rate / cutoff) + 10;
}

}  // namespace lacuna
