// The plant's rigid bodies on their base, which stands still or, under base_compliance, on springs.
//
// On springs the dynamics is that of PlantModel::moving_robot(): two joints under the arm's own turn its base about the
// base frame's x, then about the turned y. What they are is carried as four states of the plant: both tilts, rad, then
// their rates, rad/s. With M(q) the inertia of all joints and h the efforts that gravity and motion ask for, the base
// obeys
//   (M (a_base, a) + h)_base + I a_base = -k tilt - c tilt'.
// Nothing faster than the steps can follow is resolved: I is raised smoothly until the springs' own motion takes that
// long, and that share is damped critically, so that ever stiffer springs end in a base that stands still. A k of
// infinity holds the base exactly, lane by lane.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "physics/component.h"

namespace lacuna {

template <class T, class Dyn>
class Foundation {
 public:
  static constexpr std::size_t kTilts = 2;

  /// `dynamics` is that of an arm of `joints`; with `sprung`, of the two under it as well.
  Foundation(Dyn dynamics, int joints, bool sprung)
      : dynamics_(std::move(dynamics)), n_(joints), under_(sprung ? kTilts : 0) {
    for (std::vector<T>* w : {&q_, &v_, &tau_, &free_, &a_, &imbalance_}) w->assign(under_ + n_, T(0.0));
  }

  Dyn& dynamics() { return dynamics_; }
  int states() const { return static_cast<int>(2 * under_); }

  void set_inertial(int body, int k, const Inertial& inertial) { dynamics_.set_inertial(below() + body, k, inertial); }
  void set_armature(int joint, int k, double inertia) { dynamics_.set_armature(below() + joint, k, inertia); }
  void set_gravity(int k, const Eigen::Vector3d& gravity) { dynamics_.set_gravity(k, gravity); }

  /// Sets the springs up for motions no faster than `resolved` (s; 0: any), and `z` to the tilts at which they carry
  /// the arm at rest at q.
  void begin(const BaseSpring<T>& spring, const T& resolved, const T* q, T* z) {
    if (under_ == 0) return;
    moves_ = select(T(1.0) / spring.k > T(0.0), T(1.0), T(0.0));
    k_ = select(moves_ > T(0.0), spring.k, T(0.0));
    set_base_inertia(spring.I);
    const T own = lightest(q), whole = rounded_max(own, k_ * resolved * resolved), raised = whole - own;
    c_ = spring.c + T(2.0) * sqrt(k_ * whole) * (raised / whole);
    set_base_inertia(spring.I + raised);
    std::fill_n(z, 2 * under_, T(0.0));
    for (int round = 0; round < kRestRounds; ++round) {
      hold(q, z);
      for (std::size_t i = 0; i < under_; ++i)
        z[i] = select(moves_ > T(0.0), T(0.0) - tau_[i] / max(k_, T(kSoftest)), T(0.0));
    }
  }

  /// Accelerations `a` of the arm's joints, as Tree::forward_dynamics, and the rates of the base's states z.
  void forward_dynamics(const T* q, const T* v, const T* tau, const T* free, const T* z, T* a, T* z_rate,
                        T* imbalance) {
    if (under_ == 0) {
      dynamics_.forward_dynamics(q, v, tau, free, a, imbalance);
      return;
    }
    place(q, z);
    for (std::size_t i = 0; i < under_; ++i) {
      v_[i] = z[under_ + i];
      tau_[i] = T(0.0) - k_ * z[i] - c_ * z[under_ + i];
      free_[i] = moves_;
    }
    std::copy_n(v, n_, v_.begin() + below());
    std::copy_n(tau, n_, tau_.begin() + below());
    std::copy_n(free, n_, free_.begin() + below());
    dynamics_.forward_dynamics(q_.data(), v_.data(), tau_.data(), free_.data(), a_.data(), imbalance_.data());
    for (std::size_t i = 0; i < under_; ++i) {
      z_rate[i] = z[under_ + i];
      z_rate[under_ + i] = a_[i];
    }
    std::copy_n(a_.begin() + below(), n_, a);
    std::copy_n(imbalance_.begin() + below(), n_, imbalance);
  }

  /// Efforts that hold the arm's joints still at q, the base tilted by z (null: not at all). Where not null, `z_off`
  /// takes what of the base's states is not at rest: rates, then efforts (of a base that is held, the states
  /// themselves).
  void holding_efforts(const T* q, const T* z, T* holding, T* z_off) {
    if (under_ == 0) {
      const std::vector<T>& still = a_;  // zero: written by forward_dynamics on springs only
      dynamics_.inverse_dynamics(q, still.data(), still.data(), holding);
      return;
    }
    hold(q, z);
    std::copy_n(tau_.begin() + below(), n_, holding);
    if (z_off == nullptr) return;
    for (std::size_t i = 0; i < under_; ++i) {
      z_off[i] = z[under_ + i];
      z_off[under_ + i] = select(moves_ > T(0.0), T(0.0) - k_ * z[i] - tau_[i], z[i]);
    }
  }

  /// Inertia of the arm's joints, row by row, the base still.
  void mass_matrix(const T* q, T* mass) {
    if (under_ == 0) {
      dynamics_.mass_matrix(q, mass);
      return;
    }
    const std::size_t whole = under_ + n_;
    std::vector<T> all(whole * whole);
    place(q, nullptr);
    dynamics_.mass_matrix(q_.data(), all.data());
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t j = 0; j < n_; ++j) mass[i * n_ + j] = all[(under_ + i) * whole + under_ + j];
  }

  /// Efforts for a measured motion, of which the base is no part.
  void inverse_dynamics(const T* q, const T* v, const T* a, T* tau) {
    if (under_ == 0) {
      dynamics_.inverse_dynamics(q, v, a, tau);
      return;
    }
    place(q, nullptr);
    std::fill_n(v_.begin(), under_, T(0.0));
    std::fill_n(a_.begin(), under_, T(0.0));
    std::copy_n(v, n_, v_.begin() + below());
    std::copy_n(a, n_, a_.begin() + below());
    dynamics_.inverse_dynamics(q_.data(), v_.data(), a_.data(), tau_.data());
    std::copy_n(tau_.begin() + below(), n_, tau);
  }

 private:
  static constexpr int kRestRounds = 4;        ///< each leaves the share gravity times height over k of the error
  static constexpr double kSoftest = 1e-12;    ///< N m/rad
  static constexpr double kLeastGive = 1e-12;  ///< 1/(kg m^2)

  int below() const { return static_cast<int>(under_); }

  void place(const T* q, const T* z) {
    for (std::size_t i = 0; i < under_; ++i) q_[i] = z != nullptr ? z[i] : T(0.0);
    std::copy_n(q, n_, q_.begin() + below());
  }

  /// tau_: what holds everything still at q and the tilts in z.
  void hold(const T* q, const T* z) {
    place(q, z);
    std::fill(v_.begin(), v_.end(), T(0.0));
    std::fill(a_.begin(), a_.end(), T(0.0));
    dynamics_.inverse_dynamics(q_.data(), v_.data(), a_.data(), tau_.data());
  }

  void set_base_inertia(const T& inertia) {
    for (int k = 0; k < kLanes<T>; ++k) {
      for (int i = 0; i < below(); ++i) dynamics_.set_armature(i, k, static_cast<double>(lane(inertia, k)));
    }
  }

  /// Inertia, kg m^2, that the base shows at q while every joint of the arm may give way; of the axis that has least of
  /// it.
  T lightest(const T* q) {
    place(q, nullptr);
    std::fill(v_.begin(), v_.end(), T(0.0));
    std::fill(free_.begin(), free_.end(), T(1.0));
    std::fill(tau_.begin(), tau_.end(), T(0.0));
    dynamics_.forward_dynamics(q_.data(), v_.data(), tau_.data(), free_.data(), a_.data(), imbalance_.data());
    const std::vector<T> alone = a_;
    T give(kLeastGive);
    for (std::size_t i = 0; i < under_; ++i) {
      std::fill(tau_.begin(), tau_.end(), T(0.0));
      tau_[i] = T(1.0);
      dynamics_.forward_dynamics(q_.data(), v_.data(), tau_.data(), free_.data(), a_.data(), imbalance_.data());
      give = give + (a_[i] - alone[i]);
    }
    return T(1.0) / give;
  }

  Dyn dynamics_;
  std::size_t n_, under_;
  T k_ = T(0.0), c_ = T(0.0);  ///< N m/rad, N m s/rad
  T moves_ = T(0.0);           ///< 1 where the base stands on springs, 0 where it is held
  std::vector<T> q_, v_, tau_, free_, a_, imbalance_;
};

}  // namespace lacuna
