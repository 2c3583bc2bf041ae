// Predictions for all lanes of a scalar type, behind a virtual call that knows nothing of lanes.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "physics/experiment.h"
#include "physics/linear_motion.h"
#include "physics/plant_model.h"

namespace lacuna {

/// What one lane simulates: a parameter vector on a segment.
struct LaneTask {
  const std::vector<double>* values;
  const Segment* segment;
};

/// Scratch of one thread. `predict` takes up to lanes() tasks, in inverse dynamics of one segment, and gives
/// [task][channel][sample].
class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual int lanes() const = 0;
  virtual void predict(std::span<const LaneTask> tasks, double max_step,
                       std::vector<std::vector<std::vector<double>>>& out) = 0;
  /// The plant linearised along a motion of its own.
  virtual LinearMotion linearise(const LaneTask& task, double max_step, const std::vector<double>& effort_sizes) = 0;
  /// [task][joint][interval]: what drives each joint beyond what a motion needs, N m (N): efforts in the middle of the
  /// intervals of `motion`, all tasks on its segment.
  virtual void excess(std::span<const LaneTask> tasks, const LinearMotion& motion,
                      std::vector<std::vector<std::vector<double>>>& out) = 0;
};

using PredictorMaker = std::unique_ptr<Predictor> (*)(const PlantModel&, const Experiment&);

// One translation unit each, compiled for its instruction set; null where the compiler or machine type has none.
std::unique_ptr<Predictor> make_predictor_sse2(const PlantModel&, const Experiment&);
std::unique_ptr<Predictor> make_predictor_avx2(const PlantModel&, const Experiment&);
std::unique_ptr<Predictor> make_predictor_avx512(const PlantModel&, const Experiment&);

/// One lane, any engine.
std::unique_ptr<Predictor> make_engine_predictor(const std::string& engine, const PlantModel&, const Experiment&);

}  // namespace lacuna
