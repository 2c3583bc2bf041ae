#pragma once

#include "physics/effects/cap.h"

namespace lacuna {

/// One pump for all valves, at the limit of its flow. Every valve asks a flow in proportion to the command that has
/// come through its own curve and lag. While the flows asked for sum to less than the pump gives nothing happens;
/// beyond that all get the same share of what they ask, and together what the pump gives. A valve alone is limited by
/// it, too: what `actuator_saturation` sees of it. Neutral where every `full` is infinite; a joint whose own is
/// infinite takes next to nothing, and loses all the same.
struct SharedSupply {
  static EffectInfo info() {
    ParameterInfo full{"full",
                       "V",
                       HUGE_VAL,
                       1e-3,
                       HUGE_VAL,
                       "command of that joint alone, after its valve's curve, which takes all the pump gives",
                       Scale::command,
                       {0.7, 2.0},
                       Coordinate::inverse};
    full.per_joint = true;
    ParameterInfo sharpness = cap_sharpness();  // a pump at its limit gives no more: nearly a corner
    sharpness.neutral = 8.0, sharpness.starts = {4.0};
    EffectInfo info{
        "shared_supply",
        "Shared supply",
        Where::arm,
        Stage::flow,
        "u_j -> u_j (1 + x^n)^(-1/n), x = sum over joints of |u_i|/full_i",
        "a joint falls short when all together ask more than the pump gives, and only then",
        "actuator_saturation, supply_pressure_sag",
        "flow saturation of a pump with valves in parallel: H. E. Merritt, Hydraulic Control Systems, 1967, "
        "ch. 11",
        {full, sharpness}};
    info.hydraulic = true;
    info.shares = true;
    info.alone = "actuator_saturation";
    return info;
  }
  template <class T>
  static T share(const T* p, const T* asked, int joints) {
    T x(0.0);
    for (int i = 0; i < joints; ++i) x = x + abs(asked[i]) / p[1 + i];
    return capped_share(x, p[0]);
  }
  template <class T>
  static T command(const T*, const JointView<T>& s) {
    return s.u * s.share;
  }
};

}  // namespace lacuna
