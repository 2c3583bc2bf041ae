#pragma once

#include <algorithm>
#include <cmath>

#include "physics/catalogue.h"

namespace lacuna {

/// A proportional valve on a cylinder or a rotary actuator, from the spool to the effort on the joint.
///
/// The spool opens one edge from the supply and one to the return by x = u / full_command, |x| <= 1. Through each,
///   Q = gain |x| dp / (dp^2 + dp0^2)^(1/4),   dp0 = 2 bar:
/// the square root of turbulent flow, laminar and smooth about dp = 0. With V_A the oil in chamber A at stroke s, hose
/// and ports included, and B its bulk modulus,
///   V_A p_A' / B = Q_A - A_A s' - leakage (p_A - p_B) - leakage_out (p_A - p_return) - relief(p_A),   chamber B
///   likewise,
/// and the joint gets (p_A A_A - p_B A_B) ds/dq. s is `ratio` q, or the length of a cylinder between two pins that lie
/// lever_a and lever_b from the joint's axis, phi = q + lever_angle apart: c^2 = a^2 + b^2 - 2 a b cos(phi),
/// ds/dq = a b sin(phi) / c; an angle from -pi to 0 has the cylinder on the other side. Pressures stay between the
/// vacuum's and the relief valve's or the supply's: a cylinder against a load that it cannot move stops taking oil in.
/// Pressures are gauge ones. States: p_A, p_B in kPressureUnit. Sources: H. E. Merritt, Hydraulic Control Systems,
/// 1967, ch. 3, 5, 6; M. Jelali, A. Kroll, Hydraulic Servo-systems, 2003, ch. 4.
struct Hydraulic {
  static constexpr int states = 2;

  static ActuatorInfo info() {
    ActuatorInfo info{"hydraulic",
                      "V_A p_A'/B = Q_A - A_A s' - leaks, V_B p_B'/B = -Q_B + A_B s' - leaks, "
                      "Q = gain u/full_command sqrt(dp); tau = (p_A A_A - p_B A_B) ds/dq",
                      "valve, chambers and linkage known; pressures measured or wanted",
                      parameters(),
                      {.gain = kGain},
                      Stage::valve,
                      true,
                      states};
    info.chambers = true;
    return info;
  }

  template <class T>
  static void rate(const T* p, const JointView<T>& s, T* out) {
    const Linkage<T> link(p, s.q);
    const T a = s.z[0] * T(kPressureUnit), b = s.z[1] * T(kPressureUnit), open = opening(p, s.u);
    const T width = abs(open), swept = link.arm * s.v, across = p[kLeakage] * (a - b);
    const T port_a = select(open > T(0.0), p[kSupply], p[kReturn]);
    const T port_b = select(open > T(0.0), p[kReturn], p[kSupply]);
    const T flow_a = width * orifice(port_a - a) - p[kAreaA] * swept - across - outward(p, a);
    const T flow_b = width * orifice(port_b - b) + p[kAreaB] * swept + across - outward(p, b);
    out[0] = T(1.0 / kPressureUnit) * flow_a * stiffness(p, kVolumeA, kAreaA, link.stroke);
    out[1] = T(1.0 / kPressureUnit) * flow_b * stiffness(p, kVolumeB, kAreaB, T(0.0) - link.stroke);
  }

  /// Oil springs and the pressures' own settling.
  template <class T>
  static FastPart<T> fast(const T* p, const JointView<T>& s) {
    const Linkage<T> link(p, s.q);
    const T a = s.z[0] * T(kPressureUnit), b = s.z[1] * T(kPressureUnit), open = opening(p, s.u), width = abs(open);
    const T port_a = select(open > T(0.0), p[kSupply], p[kReturn]);
    const T port_b = select(open > T(0.0), p[kReturn], p[kSupply]);
    const T rise_a = stiffness(p, kVolumeA, kAreaA, link.stroke);
    const T rise_b = stiffness(p, kVolumeB, kAreaB, T(0.0) - link.stroke);
    const T out_a = width * orifice_slope(port_a - a) + p[kLeakage] + outward_slope(p, a);
    const T out_b = width * orifice_slope(port_b - b) + p[kLeakage] + outward_slope(p, b);
    FastPart<T> fast;
    fast.effort = {T(kPressureUnit) * p[kAreaA] * link.arm, T(-kPressureUnit) * p[kAreaB] * link.arm};
    fast.from_speed = {T(-1.0 / kPressureUnit) * rise_a * p[kAreaA] * link.arm,
                       T(1.0 / kPressureUnit) * rise_b * p[kAreaB] * link.arm};
    fast.among = {T(0.0) - rise_a * out_a, rise_a * p[kLeakage], rise_b * p[kLeakage], T(0.0) - rise_b * out_b};
    return fast;
  }

  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return T(kPressureUnit) * (s.z[0] * p[kAreaA] - s.z[1] * p[kAreaB]) * arm_at(p, s.q);
  }

  /// N m/V (N/V): stall effort at half stroke over full command.
  template <class T>
  static T strength(const T* p) {
    const T most =
        max(p[kSupply] * p[kAreaA] - p[kReturn] * p[kAreaB], p[kSupply] * p[kAreaB] - p[kReturn] * p[kAreaA]);
    return most * arm_at(p, p[kMiddle]) * sign(p[kGain]) / p[kFull];
  }

  /// Pressures that hold the joint: in motion those of a steady one that way, at rest midway between those at which it
  /// would creep up and down under an all but closed valve; where that leaves the range from return to supply, the
  /// nearest that does not; where none holds it, A at the range's end.
  template <class T>
  static void initial(const T* p, const JointView<T>& s, const T& holding, T* out) {
    const T arm = arm_at(p, s.q), low = p[kReturn], high = p[kSupply], a = p[kAreaA], b = p[kAreaB];
    const T force = select(abs(arm) > T(1e-9), holding / select(abs(arm) > T(1e-9), arm, T(1.0)), T(0.0));
    const T cubes = a * a * a + b * b * b;
    // Creeping, both edges pass flows in the ratio of the areas: drops across them go with the areas' squares.
    const T up = (high * a - low * b - force) / cubes, down = (force - low * a + high * b) / cubes;
    const T slow = T(kSlow) * abs(p[kGain]) * sqrt(high) / a;
    const T way = max(min(arm * s.v / slow, T(1.0)), T(-1.0));
    const T middle = T(0.5) * ((T(1.0) + way) * (low + up * b * b) + (T(1.0) - way) * (high - down * b * b));
    const T least = max(low, (low * a - force) / b), most = min(high, (high * a - force) / b);
    const T below = max(min(middle, most), least);
    const T chosen = min(max(below, low), high);
    out[0] = min(max((force + chosen * b) / a, low), high) / T(kPressureUnit);
    out[1] = chosen / T(kPressureUnit);
  }

  /// Leaks from chamber to chamber so much more that a load `creep` (N m or N), at the middle of the stroke and on the
  /// mean of both areas, makes the joint move at unit speed.
  static void leak(double* p, double creep) {
    const double swept = swept_at_middle(p);
    p[kLeakage] += swept * swept / creep;
  }
  /// Opens the relief valves no later than at that load of a lone chamber, likewise.
  static void relieve(double* p, double load) {
    const double swept = swept_at_middle(p);
    if (swept > 0.0) p[kRelief] = std::min(p[kRelief], load / swept);
  }

 private:
  enum : int {
    kGain,
    kFull,
    kAreaA,
    kAreaB,
    kVolumeA,
    kVolumeB,
    kStroke,
    kMiddle,
    kRatio,
    kLeverA,
    kLeverB,
    kLeverAngle,
    kBulk,
    kHose,
    kSupply,
    kReturn,
    kRelief,
    kLeakage,
    kLeakageOut
  };
  static constexpr double kLaminar = 2e5;  ///< Pa, dp0
  static constexpr double kReliefWidth =
      5e-3;                                 ///< 1/Pa^0.5: 8 bar beyond, relief valves pass what the valve does at 160
  static constexpr double kCorner = 1.6e5;  ///< Pa, within which they open
  static constexpr double kSlow = 0.02;     ///< of the speed at full drop: rather in motion than at rest
  static constexpr double kLeastShare = 0.01;  ///< of the stroke: what oil the end of travel leaves

  static std::vector<ParameterInfo> parameters() {
    const double required = std::nan("");
    std::vector<ParameterInfo> out{
        {"gain", "m^3/(s Pa^0.5)", required, -10.0, 10.0,
         "flow through either edge of the fully open valve over the root of the drop; negative: hoses swapped"},
        {"full_command", "V", required, 1e-9, 1e9, "command at which the valve is fully open"},
        {"area_a", "m^2", required, 1e-8, 10.0, "piston area whose pressure lengthens s; rotary: m^3/rad"},
        {"area_b", "m^2", required, 1e-8, 10.0, "piston area on the other side; rotary: m^3/rad"},
        {"dead_volume_a", "m^3", required, 1e-9, 1.0, "oil in hose and ports of A, besides that in the stroke"},
        {"dead_volume_b", "m^3", required, 1e-9, 1.0, "oil in hose and ports of B, besides that in the stroke"},
        {"stroke", "m", required, 1e-6, 1e3, "of the piston; rotary: rad"},
        {"middle", "rad", 0.0, -1e3, 1e3, "the joint's position at half of the stroke"},
        {"ratio", "m/rad", 1.0, -1e3, 1e3, "stroke per joint position, where there is no lever"},
        {"lever_a", "m", 0.0, 0.0, 1e3, "distance of one pin from the joint's axis; 0: no lever"},
        {"lever_b", "m", 0.0, 0.0, 1e3, "distance of the other pin"},
        {"lever_angle", "rad", 0.0, -7.0, 7.0, "angle between the pins, seen from the axis, at position 0"},
        {"bulk_modulus", "Pa", 1.4e9, 1e5, 1e12, "of the oil"},
        {"hose_compliance", "1/Pa", 0.0, 0.0, 1e-5, "share by which hoses widen per pressure, of the dead volumes"},
        {"supply_pressure", "Pa", required, 1e4, 1e9, "before the valve"},
        {"return_pressure", "Pa", 0.0, 0.0, 1e9, "behind it"},
        {"relief_pressure", "Pa", 1e10, 1e4, 1e10, "at which either chamber opens to the return"},
        {"leakage", "m^3/(s Pa)", 0.0, 0.0, 1e-6, "from chamber to chamber"},
        {"leakage_out", "m^3/(s Pa)", 0.0, 0.0, 1e-6, "from either chamber to the return"}};
    for (const int i : {kGain, kFull, kVolumeA, kVolumeB, kStroke, kMiddle, kBulk, kHose, kSupply, kReturn, kRelief,
                        kLeakage, kLeakageOut})
      out[i].fills = true;
    return out;
  }

  /// m^3/rad (m^3/m), of the geometric mean of both areas at the middle of the stroke.
  static double swept_at_middle(const double* p) {
    return std::sqrt(p[kAreaA] * p[kAreaB]) * std::fabs(arm_at(p, p[kMiddle]));
  }

  /// How the stroke grows with the joint's position, m/rad.
  template <class T>
  static T arm_at(const T* p, const T& q) {
    const Mask<T> lever = p[kLeverA] * p[kLeverB] > T(0.0);
    if (!any(lever)) return p[kRatio];  // saves an angle and a root; changes no number
    return select(lever, Pins<T>(p, q).arm, p[kRatio]);
  }
  /// The stroke from its middle, m, and how it grows.
  template <class T>
  struct Linkage {
    T stroke, arm;

    Linkage(const T* p, const T& q) : stroke(p[kRatio] * (q - p[kMiddle])), arm(p[kRatio]) {
      const Mask<T> lever = p[kLeverA] * p[kLeverB] > T(0.0);
      if (!any(lever)) return;
      const Pins<T> here(p, q), middle(p, p[kMiddle]);
      stroke = select(lever, here.length - middle.length, stroke);
      arm = select(lever, here.arm, arm);
    }
  };
  /// The triangle of the cylinder's two pins and the joint's axis.
  template <class T>
  struct Pins {
    T length, arm;

    Pins(const T* p, const T& q) {
      T sine, cosine;
      sincos(q + p[kLeverAngle], sine, cosine);
      const T a = p[kLeverA], b = p[kLeverB], twice = T(2.0) * a * b;
      length = sqrt(max(a * a + b * b - twice * cosine, T(1e-12)));
      arm = a * b * sine / length;
    }
  };

  /// m^3/(s Pa^0.5), with the sign of the way in which A is fed.
  template <class T>
  static T opening(const T* p, const T& u) {
    return p[kGain] * max(min(u / p[kFull], T(1.0)), T(-1.0));
  }
  template <class T>
  static T orifice(const T& drop) {
    return drop / sqrt(sqrt(drop * drop + T(kLaminar * kLaminar)));
  }
  template <class T>
  static T orifice_slope(const T& drop) {
    const T squares = drop * drop + T(kLaminar * kLaminar);
    return (T(0.5) * drop * drop + T(kLaminar * kLaminar)) / (squares * sqrt(sqrt(squares)));
  }
  /// m^3/s from a chamber to the return past seals and the relief valve; into it where the pressure would fall below
  /// the vacuum's. Both valves open with a rounded corner.
  template <class T>
  static T outward(const T* p, const T& pressure) {
    const T leak = p[kLeakageOut] * (pressure - p[kReturn]), past = beyond(p, pressure), size = abs(past);
    if (!any(size > T(0.0))) return leak;  // saves a division; changes no number
    return leak + T(kReliefWidth) * abs(p[kGain]) * past * size / (size + T(kCorner));
  }
  template <class T>
  static T outward_slope(const T* p, const T& pressure) {
    const T size = abs(beyond(p, pressure)), whole = size + T(kCorner);
    return p[kLeakageOut] + T(kReliefWidth) * abs(p[kGain]) * size * (size + T(2.0 * kCorner)) / (whole * whole);
  }
  /// Pa, above the relief pressure or (negative) below the vacuum's.
  template <class T>
  static T beyond(const T* p, const T& pressure) {
    return max(pressure - p[kRelief], T(0.0)) + min(pressure, T(0.0));
  }
  /// 1/(m^3/Pa): how fast a chamber's pressure rises with the oil that it takes in; `out`: stroke from its middle
  /// towards more oil.
  template <class T>
  static T stiffness(const T* p, int dead, int area, const T& out) {
    const T swept = max(T(0.5) * p[kStroke] + out, T(kLeastShare) * p[kStroke]);
    return p[kBulk] / (p[dead] * (T(1.0) + p[kBulk] * p[kHose]) + p[area] * swept);
  }
};

}  // namespace lacuna
