// Lanes of this instruction set; the flags stand in cmake/library.cmake. Nothing here runs where the CPU lacks it.
#include "physics/predictor.h"

#if defined(__AVX512F__)
#include "physics/lanes.h"
// lanes.h comes first: the kernels below must see the packs' functions.
#include "backends/featherstone/tree.h"
#include "physics/predictor_impl.h"
#endif

namespace lacuna {

std::unique_ptr<Predictor> make_predictor_avx512([[maybe_unused]] const PlantModel& model,
                                                 [[maybe_unused]] const Experiment& experiment) {
#if defined(__AVX512F__)
  using Pack = xsimd::batch<double, xsimd::avx512dq>;
  return std::make_unique<LanePredictor<Pack, Tree<Pack>>>(model, experiment, Tree<Pack>(*model.moving_robot()));
#else
  return nullptr;
#endif
}

}  // namespace lacuna
