// Plants over any engine: all that is made of them in one unit, which is compiled once.
#include "backends/featherstone/tree.h"
#include "physics/engine_dynamics.h"
#include "physics/predictor_impl.h"

namespace lacuna {

std::unique_ptr<Predictor> make_engine_predictor(const std::string& engine, const PlantModel& model,
                                                 const Experiment& experiment) {
  EngineDynamics dynamics(find_engine(engine).build(model.moving_robot(), model.gravity()));
  return std::make_unique<LanePredictor<double, EngineDynamics>>(model, experiment, std::move(dynamics));
}

std::vector<ChamberBalance> chamber_balances(const PlantModel& model, const std::string& engine,
                                             const std::vector<double>& values, const Segment& segment) {
  EngineDynamics dynamics(find_engine(engine).build(model.moving_robot(), model.gravity()));
  Plant<double, EngineDynamics> plant(model, std::move(dynamics));
  plant.bind(0, values);
  std::vector<ChamberBalance> out;
  InverseDynamicsRun<double, EngineDynamics>(plant, segment).balance(out);
  return out;
}

}  // namespace lacuna
