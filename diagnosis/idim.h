// The field's yardstick: the inverse dynamic identification model by base parameters, with viscous and Coulomb
// friction, offset and armature at every joint, by linear least squares. M. Gautier, W. Khalil, IEEE Trans. Robotics
// Autom. 6 (1990). Ten inertial numbers a link, no prior, no physics but what is linear: a diagnosis in efforts that
// predicts worse than this has no use.
#pragma once

#include <optional>

#include "ga/identify.h"

namespace lacuna {

/// One joint's part that is no rigid body's.
struct IdimJoint {
  std::string joint;
  double viscous = 0.0;   ///< N m s/rad (N s/m)
  double coulomb = 0.0;   ///< N m (N)
  double offset = 0.0;    ///< N m (N)
  double armature = 0.0;  ///< kg m^2 (kg); beside the link's own inertia about the joint it is one number with it
};

struct Idim {
  int rank = 0, columns = 0;  ///< base parameters among those of all links and joints
  std::vector<IdimJoint> joints;
  std::vector<std::pair<Role, JointRms>> rms;  ///< in the compared channels' units
};

/// Fitted to the train recordings as they were measured, with the model's gravity; nothing where the prediction is no
/// inverse dynamics, or a compared joint's command is no effort.
std::optional<Idim> regress_base_parameters(const PlantModel& model, const Experiment& experiment);

}  // namespace lacuna
