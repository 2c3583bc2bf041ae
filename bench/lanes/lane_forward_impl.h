// Included by the sources of this folder only, after physics/lanes.h.
#pragma once

#include <vector>

#include "backends/featherstone/tree.h"
#include "bench/lanes/lane_forward.h"

namespace lacuna::bench {

template <class Pack>
class PackForward final : public LaneForward {
 public:
  explicit PackForward(const Robot& robot)
      : tree_(robot), free_(robot.dof(), Pack(1.0)), q_(free_), v_(q_), tau_(q_), a_(q_), i_(q_) {}
  double run(const double* q, const double* v, const double* tau) override {
    for (std::size_t j = 0; j < q_.size(); ++j) q_[j] = Pack(q[j]), v_[j] = Pack(v[j]), tau_[j] = Pack(tau[j]);
    tree_.forward_dynamics(q_.data(), v_.data(), tau_.data(), free_.data(), a_.data(), i_.data());
    return lane(a_[0], 0);
  }

 private:
  Tree<Pack> tree_;
  std::vector<Pack> free_, q_, v_, tau_, a_, i_;
};

}  // namespace lacuna::bench
