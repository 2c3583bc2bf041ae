// The scalar types that the kernels are written over: `double`, a pack of doubles, one lane per parameter set, or
// `long double` for references.
//
// Only operations named here are used by kernels, actuators and effects, so that one source serves both.
// A pack is xsimd::batch<double, Arch>; its functions are found by argument-dependent lookup.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "backends/featherstone/sincos.h"

namespace lacuna {

/// Number of lanes and mask type of a scalar. Packs specialise this (physics/lanes.h).
template <class T>
struct ScalarTraits;

template <>
struct ScalarTraits<double> {
  using Mask = bool;
  static constexpr int lanes = 1;
};

/// Extended precision: no simulation of ours is that slow, but the references of compare/ and physics/truth.h are.
template <>
struct ScalarTraits<long double> {
  using Mask = bool;
  static constexpr int lanes = 1;
};

template <class T>
using Mask = typename ScalarTraits<T>::Mask;
template <class T>
inline constexpr int kLanes = ScalarTraits<T>::lanes;

/// m ? a : b, lane by lane.
inline double select(bool m, double a, double b) { return m ? a : b; }
inline bool any(bool m) { return m; }
inline bool all(bool m) { return m; }
inline double min(double a, double b) { return a < b ? a : b; }
inline double max(double a, double b) { return a > b ? a : b; }
inline double abs(double a) { return std::fabs(a); }
inline double sqrt(double a) { return std::sqrt(a); }
inline double exp(double a) { return std::exp(a); }
inline double log(double a) { return std::log(a); }
inline double tanh(double a) { return std::tanh(a); }
inline double floor(double a) { return std::floor(a); }

inline long double select(bool m, long double a, long double b) { return m ? a : b; }
inline long double min(long double a, long double b) { return a < b ? a : b; }
inline long double max(long double a, long double b) { return a > b ? a : b; }
inline long double abs(long double a) { return std::fabs(a); }
inline long double sqrt(long double a) { return std::sqrt(a); }
inline long double exp(long double a) { return std::exp(a); }
inline long double log(long double a) { return std::log(a); }
inline long double tanh(long double a) { return std::tanh(a); }
inline long double floor(long double a) { return std::floor(a); }

/// One lane read or written. Packs are plain arrays of doubles in memory.
template <class T>
double lane(const T& value, int index) {
  double out;
  std::memcpy(&out, reinterpret_cast<const char*>(&value) + sizeof(double) * static_cast<std::size_t>(index),
              sizeof out);
  return out;
}
template <class T>
void set_lane(T& value, int index, double to) {
  std::memcpy(reinterpret_cast<char*>(&value) + sizeof(double) * static_cast<std::size_t>(index), &to, sizeof to);
}
inline double lane(const long double& value, int) { return static_cast<double>(value); }
inline void set_lane(long double& value, int, double to) { value = to; }

/// Sign as -1, 0 or +1.
template <class T>
T sign(const T& a) {
  return select(a > T(0.0), T(1.0), select(a < T(0.0), T(-1.0), T(0.0)));
}

}  // namespace lacuna
