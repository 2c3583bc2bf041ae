// Scalar forward dynamics built for CPUs with fused multiply-add, chosen at run time.
#pragma once

#include <memory>

#include "scenarios/robot.h"

namespace lacuna {

/// Tree<double> (tree.h) with the same contracts, compiled for more of the CPU. Not shared between threads.
class ForwardKernel {
 public:
  virtual ~ForwardKernel() = default;
  virtual std::unique_ptr<ForwardKernel> clone() const = 0;
  virtual void set_inertial(int body, const Inertial& inertial) = 0;
  virtual void set_gravity(const Eigen::Vector3d& gravity) = 0;
  virtual void forward_dynamics(const double* q, const double* v, const double* tau, const double* free, double* a,
                                double* imbalance) = 0;
};

/// Null where the build or this CPU lacks AVX2 and FMA.
std::unique_ptr<ForwardKernel> make_fused_kernel(const Robot& robot);

}  // namespace lacuna
