// Lanes of this instruction set; the flags stand in cmake/library.cmake. Nothing here runs where the CPU lacks it.
#include "physics/predictor.h"

#if defined(__AVX2__)
#include "physics/lanes.h"
// lanes.h comes first: the kernels below must see the packs' functions.
#include "backends/featherstone/tree.h"
#include "physics/predictor_impl.h"
#endif

namespace lacuna {

std::unique_ptr<Predictor> make_predictor_avx2([[maybe_unused]] const PlantModel& model,
                                               [[maybe_unused]] const Experiment& experiment) {
#if defined(__AVX2__)
  using Pack = xsimd::batch<double, xsimd::fma3<xsimd::avx2>>;
  return std::make_unique<LanePredictor<Pack, Tree<Pack>>>(model, experiment, Tree<Pack>(*model.moving_robot()));
#else
  return nullptr;
#endif
}

}  // namespace lacuna
