// Zero-phase low-pass filter over any scalar type.
#pragma once

#include <vector>

#include "backends/featherstone/scalar.h"

namespace lacuna {

/// Fourth-order Butterworth low-pass as two biquads (bilinear transform, cutoff pre-warped), run forwards and then
/// backwards: no phase, eighth order in magnitude, half power at the cutoff in each direction.
/// Source: A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, 3rd ed., sec. 7.
class ZeroPhaseLowPass {
 public:
  /// cutoff in (0, rate/2), both Hz; throws std::invalid_argument otherwise.
  ZeroPhaseLowPass(double cutoff, double rate);

  /// Filters `signal` (samples `stride` apart, starting at `offset`) in place; ends are extended by point reflection.
  template <class T>
  void apply(std::vector<T>& signal, std::size_t offset = 0, std::size_t stride = 1) const {
    const std::size_t n = (signal.size() - offset + stride - 1) / stride;
    const std::size_t pad = std::min(n - 1, pad_);
    std::vector<T> x(n + 2 * pad);
    auto at = [&](std::size_t i) { return signal[offset + i * stride]; };
    for (std::size_t i = 0; i < n; ++i) x[pad + i] = at(i);
    for (std::size_t i = 1; i <= pad; ++i) {
      x[pad - i] = T(2.0) * at(0) - at(i);
      x[pad + n - 1 + i] = T(2.0) * at(n - 1) - at(n - 1 - i);
    }
    for (const Section& s : sections_) {
      run(s, x.begin(), x.end());
      run(s, x.rbegin(), x.rend());
    }
    for (std::size_t i = 0; i < n; ++i) signal[offset + i * stride] = x[pad + i];
  }

  /// Samples over which it remembers: what lies further away no longer counts.
  std::size_t reach() const { return pad_; }

 private:
  struct Section {
    double b0, b1, b2, a1, a2;
  };
  /// One biquad, started in the steady state of its first input.
  template <class Iterator>
  static void run(const Section& s, Iterator begin, Iterator end) {
    using T = typename std::iterator_traits<Iterator>::value_type;
    T x1 = *begin, x2 = *begin, y1 = *begin, y2 = *begin;
    for (Iterator it = begin; it != end; ++it) {
      const T x0 = *it;
      const T y0 = T(s.b0) * x0 + T(s.b1) * x1 + T(s.b2) * x2 - T(s.a1) * y1 - T(s.a2) * y2;
      x2 = x1, x1 = x0, y2 = y1, y1 = y0;
      *it = y0;
    }
  }

  Section sections_[2];
  std::size_t pad_;
};

/// Samples at which a signal is kept after low-pass filtering: those at least half a cycle of the cutoff from the ends,
/// half a cycle apart.
struct Thinning {
  Thinning(double cutoff, double rate)
      : edge(static_cast<std::size_t>(0.5 * rate / cutoff) + 1),
        stride(std::max<std::size_t>(1, static_cast<std::size_t>(0.5 * rate / cutoff))) {}
  std::size_t edge, stride;  ///< samples
};

}  // namespace lacuna
