#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A constant effort on the joint: a slack spring, a cable, the zero of a drive's current. Where there is a valve, its
/// null is the other cause (valve_offset). Neutral at tau0 = 0.
struct TorqueOffset {
  static EffectInfo info() {
    EffectInfo info{
        "torque_offset",
        "Effort offset",
        Where::joint,
        Stage::link,
        "tau += tau0",
        "a constant push",
        "valve_offset, rest, gravity",
        "A. Janot, M. Gautier, M. Brunot, Data set and reference models of EMPS, 2019 (offset of drive and friction)",
        {{"tau0", "N m", 0.0, -1e9, 1e9, "effort added", Scale::effort, {0.03}}}};
    info.in_efforts = true;
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>&) {
    return p[0];
  }
};

}  // namespace lacuna
