#include "bench/lanes/lane_forward.h"

#if defined(__AVX512F__)
#include "physics/lanes.h"
// lanes.h comes first: the kernels below must see the packs' functions.
#include "bench/lanes/lane_forward_impl.h"
#endif

namespace lacuna::bench {

std::unique_ptr<LaneForward> make_lane_forward_avx512([[maybe_unused]] const Robot& robot) {
#if defined(__AVX512F__)
  return std::make_unique<PackForward<xsimd::batch<double, xsimd::avx512dq>>>(robot);
#else
  return nullptr;
#endif
}

}  // namespace lacuna::bench
