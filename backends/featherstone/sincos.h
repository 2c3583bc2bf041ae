// Sine and cosine over any scalar type, without branches: one source for `double` and packs.
//
// The argument is reduced by multiples of pi/2 in three parts (W. J. Cody, W. Waite, Software Manual for the Elementary
// Functions, 1980), its rounding carried along; the kernels are Taylor's series, whose rest is below 1e-18 within
// +-pi/4. (A pack's abs() and select() are found by argument-dependent lookup.) Within +-1e5 rad both are accurate to 2
// ulp (tested). Beyond, a pack's accuracy fades, and NaN or infinity gives NaN.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace lacuna::trigonometry {

/// 1.5 * 2^52: what is added to it is rounded to a whole number, which stands in its lowest bits.
inline constexpr double kRounder = 6755399441055744.0;

/// Highest power first.
template <class T, class... Coefficient>
T polynomial(const T& z, double highest, Coefficient... others) {
  T sum(highest);
  ((sum = z * sum + T(others)), ...);
  return sum;
}

/// Sine and cosine of r + rest, |r| <= pi/4.
template <class T>
void kernels(const T& r, const T& rest, T& s, T& c) {
  const T z = r * r;
  const T p = polynomial(z, 1.0 / 355687428096000.0, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0,
                         1.0 / 362880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0);
  const T q = polynomial(z, 1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0,
                         1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0);
  s = r + ((r * z) * p + rest);
  // 1 - z/2 with what its rounding loses.
  const T half = T(0.5) * z, near = T(1.0) - half;
  c = near + (((T(1.0) - near) - half) + ((z * z) * q - r * rest));
}

/// Turns the kernels' pair by whole quarters; `rounded` is kRounder + quarters.
inline void turn(double rounded, double& s, double& c) {
  const auto quarters = std::bit_cast<std::uint64_t>(rounded);
  const auto bits_s = std::bit_cast<std::uint64_t>(s), bits_c = std::bit_cast<std::uint64_t>(c);
  const std::uint64_t swap = std::uint64_t{0} - (quarters & 1), mixed = (bits_s ^ bits_c) & swap;
  s = std::bit_cast<double>((bits_s ^ mixed) ^ ((quarters & 2) << 62));
  c = std::bit_cast<double>((bits_c ^ mixed) ^ (((quarters + 1) & 2) << 62));
}
template <class T>
void turn(const T& rounded, T& s, T& c) {
  const T quarters = rounded - T(kRounder);
  const T round = (T(0.25) * quarters + T(kRounder)) - T(kRounder);
  const T j = quarters - T(4.0) * round;  // -2 .. 2
  const auto odd = abs(j) == T(1.0);
  const T sine = select(odd, c, s), cosine = select(odd, s, c);
  s = select((j == T(-1.0)) || (abs(j) == T(2.0)), T(0.0) - sine, sine);
  c = select((j == T(1.0)) || (abs(j) == T(2.0)), T(0.0) - cosine, cosine);
}

template <class T>
void sincos_of(const T& x, T& s, T& c) {
  // pi/2 in 33 + 33 + 53 bits: products with up to 20 bits of quarters are exact in the first two.
  const T high(0x1.921fb544p+0), middle(0x1.0b4611a6p-34), low(0x1.3198a2e037073p-69);
  const T rounded = x * T(0.6366197723675814) + T(kRounder);
  const T quarters = rounded - T(kRounder);
  const T first = x - quarters * high, second = quarters * middle;
  const T near = first - second;
  const T lost = ((first - near) - second) - quarters * low;
  const T r = near + lost;
  kernels(r, (near - r) + lost, s, c);
  turn(rounded, s, c);
}

}  // namespace lacuna::trigonometry

namespace lacuna {

inline void sincos(double x, double& s, double& c) {
  if (std::fabs(x) < 1e5) {
    trigonometry::sincos_of(x, s, c);
  } else {
    s = std::sin(x);
    c = std::cos(x);
  }
}
/// Extended precision, by the C library.
inline void sincos(long double x, long double& s, long double& c) {
  s = std::sin(x);
  c = std::cos(x);
}

}  // namespace lacuna
