#include "backends/featherstone/tree.h"
#include "physics/engine_dynamics.h"
#include "physics/predictor_impl.h"

namespace lacuna {

std::unique_ptr<Predictor> make_engine_predictor(const std::string& engine, const PlantModel& model,
                                                 const Experiment& experiment) {
  EngineDynamics dynamics(find_engine(engine).build(model.moving_robot(), model.gravity()));
  return std::make_unique<LanePredictor<double, EngineDynamics>>(model, experiment, std::move(dynamics));
}

}  // namespace lacuna
