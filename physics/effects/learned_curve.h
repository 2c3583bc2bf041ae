#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "physics/catalogue.h"

namespace lacuna {

/// A law that nobody wrote down: a function of one or two variables, as its values at evenly spaced knots, with cubic
/// convolution between them (R. G. Keys, IEEE Trans. ASSP 29, 1981); two knots are a straight line. Beyond the
/// outermost it stays as it is there, or begins anew where it has a period. Zero where all values are zero or there are
/// none.
struct LearnedCurve {
  /// What a variable is, as parameters `over` say it. `of` says whose: 0 the joint at which the law stands, else the
  /// number of a joint, from 1 on.
  enum Variable { kPosition, kSpeed, kCommand, kTime };
  /// Where its numbers stand: five a variable, then the values, those of the last variable next to each other.
  enum { kOver, kOf, kFrom, kTo, kKnots, kSecond, kPeriod = 2 * kSecond, kValues };

  /// Of an effect at a joint that adds such a law to a quantity of this unit and size.
  static EffectInfo info(const char* name, const char* title, Stage stage, const char* equation, const char* unit,
                         Scale scale) {
    EffectInfo info{name,
                    title,
                    Where::joint,
                    stage,
                    equation,
                    "whatever it was learned from",
                    "nothing that has a name",
                    "cubic convolution: R. G. Keys, IEEE Trans. ASSP 29 (1981)",
                    parameters(unit, scale)};
    info.learned = true;
    return info;
  }
  static std::vector<ParameterInfo> parameters(const char* unit, Scale scale) {
    constexpr const char* kUnit = "rad, rad/s, V, s";
    ParameterInfo value{"value", unit, 0.0, -1e9, 1e9, "the law at a knot", scale, {0.05}};
    value.per_knot = true;
    std::vector<ParameterInfo> out{
        {"over", "1", 0.0, 0.0, kTime, "variable: 0 a position, 1 a speed, 2 the command, 3 the session's time"},
        {"of", "1", 0.0, 0.0, 1e3, "of which joint, from 1 on; 0: its own"},
        {"from", kUnit, 0.0, -1e9, 1e9, "first knot"},
        {"to", kUnit, 1.0, -1e9, 1e9, "last knot"},
        {"knots", "1", 0.0, 0.0, kMostKnots, "how many there are"},
        {"over_2", "1", 0.0, 0.0, kTime, "second variable, where there is one"},
        {"of_2", "1", 0.0, 0.0, 1e3, "of which joint"},
        {"from_2", kUnit, 0.0, -1e9, 1e9, "first knot"},
        {"to_2", kUnit, 1.0, -1e9, 1e9, "last knot"},
        {"knots_2", "1", 0.0, 0.0, kMostBeside, "how many there are; 0: a law of one variable"},
        {"period", kUnit, 0.0, 0.0, 1e9,
         "of the first variable, the knots all over it; 0: the law does not repeat itself"},
        value};
    for (ParameterInfo& p : out) p.structural = !p.per_knot;
    return out;
  }

  template <class T>
  static T at(const T* p, const JointView<T>& s) {
    const int knots = most(p[kKnots]);
    if (knots < 2) return T(0.0);
    const T* second = p + kSecond;
    const int columns = std::max(most(second[kKnots]), 1);
    T across[kMostBeside];
    const bool repeats = largest(p[kPeriod]) > 0.0;
    const T first = repeats ? in_period(p, s) : in_knots(p, s);
    const T other = columns > 1 ? in_knots(second, s) : T(0.0);
    for (int k = 0; k < columns; ++k) across[k] = columns > 1 ? weight(other, k, columns, false) : T(1.0);
    T out(0.0);
    for (int row = 0; row < knots; ++row) {
      const T* value = p + kValues + row * columns;
      T sum = across[0] * value[0];
      for (int k = 1; k < columns; ++k) sum = sum + across[k] * value[k];
      out = out + weight(first, row, knots, repeats) * sum;
    }
    return out;
  }

  /// How much the value at a knot counts at a place within the knots, both in knots. Beyond either end one more knot
  /// stands on the line through the last two; of a law that `repeats` itself the knots form a ring.
  template <class T>
  static T weight(const T& at, int knot, int knots, bool repeats) {
    T out = kernel(at - T(knot));
    if (repeats) return out + kernel(at - T(knot + knots)) + kernel(at - T(knot - knots));
    if (knot < 2) out = out + T(knot == 0 ? 2.0 : -1.0) * kernel(at + T(1.0));
    if (knot >= knots - 2) out = out + T(knot == knots - 1 ? 2.0 : -1.0) * kernel(at - T(knots));
    return out;
  }

 private:
  /// Keys' kernel, C1 and of third order; `distance` in knots.
  template <class T>
  static T kernel(const T& distance) {
    const T x = abs(distance);
    const T near = T(1.0) + x * x * (T(1.5) * x - T(2.5));
    const T far = T(2.0) + x * (T(-4.0) + x * (T(2.5) - T(0.5) * x));
    return select(x < T(1.0), near, select(x < T(2.0), far, T(0.0)));
  }
  /// Lanes have the same knots or, in recordings in which the law does not act, none.
  template <class T>
  static double largest(const T& number) {
    double out = 0.0;
    for (int k = 0; k < kLanes<T>; ++k) out = std::max(out, static_cast<double>(lane(number, k)));
    return out;
  }
  template <class T>
  static int most(const T& number) {
    return static_cast<int>(largest(number));
  }
  template <class T>
  static T in_knots(const T* v, const JointView<T>& s) {
    const T x = min(max(variable(v, s), v[kFrom]), v[kTo]);
    return (x - v[kFrom]) / (v[kTo] - v[kFrom]) * T(most(v[kKnots]) - 1.0);
  }
  template <class T>
  static T in_period(const T* v, const JointView<T>& s) {
    const T turns = (variable(v, s) - v[kFrom]) / select(v[kPeriod] > T(0.0), v[kPeriod], T(1.0));
    return (turns - floor(turns)) * T(most(v[kKnots]));
  }
  template <class T>
  static T variable(const T* v, const JointView<T>& s) {
    const int of = most(v[kOf]);
    switch (most(v[kOver])) {
      case kPosition: return of > 0 ? s.positions[of - 1] : s.q;
      case kSpeed: return of > 0 ? s.speeds[of - 1] : s.v;
      case kCommand: return s.u;
      default: return s.t;
    }
  }
};

}  // namespace lacuna
