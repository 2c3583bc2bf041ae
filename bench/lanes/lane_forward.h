// The kernel's forward dynamics over a full pack of lanes, one instruction set a source, as physics/predictor_*.cc.
#pragma once

#include <memory>

#include "scenarios/robot.h"

namespace lacuna::bench {

class LaneForward {
 public:
  virtual ~LaneForward() = default;
  /// One evaluation in every lane; q, v, tau hold dof() numbers, the same for all lanes. Returns a[0] of lane 0.
  virtual double run(const double* q, const double* v, const double* tau) = 0;
};

/// Null where the build lacks the instruction set.
std::unique_ptr<LaneForward> make_lane_forward_sse2(const Robot& robot);
std::unique_ptr<LaneForward> make_lane_forward_avx2(const Robot& robot);
std::unique_ptr<LaneForward> make_lane_forward_avx512(const Robot& robot);

}  // namespace lacuna::bench
