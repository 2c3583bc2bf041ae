// Any engine behind the plant's dynamics concept, one lane. Held joints are made from the engine's mass matrix.
#pragma once

#include <memory>

#include "backends/engine.h"

namespace lacuna {

class EngineDynamics {
 public:
  explicit EngineDynamics(std::unique_ptr<Dynamics> dynamics);

  /// The engine itself; it knows of no armature.
  Dynamics& engine() { return *dynamics_; }

  void set_inertial(int body, int, const Inertial& inertial) { dynamics_->set_inertial(body, inertial); }
  void set_armature(int joint, int, double inertia) { armature_(joint) = inertia; }
  void set_gravity(int, const Eigen::Vector3d& gravity) { dynamics_->set_gravity(gravity); }

  /// As Tree::forward_dynamics: a = 0 where free is 0, and imbalance there is the effort that the holder takes up.
  void forward_dynamics(const double* q, const double* v, const double* tau, const double* free, double* a,
                        double* imbalance);
  void mass_matrix(const double* q, double* mass);  ///< row by row, armatures in it
  void inverse_dynamics(const double* q, const double* v, const double* a, double* tau);

 private:
  std::unique_ptr<Dynamics> dynamics_;
  Eigen::MatrixXd mass_;
  Eigen::VectorXd armature_;  ///< kg m^2 (kg), added to the mass matrix' diagonal: no engine needs to know it
};

}  // namespace lacuna
