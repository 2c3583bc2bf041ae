// What is moved in a comparison: one plant from one start under given commands, in one or two phases.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/engine.h"
#include "physics/experiment.h"
#include "physics/plant_model.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// A stretch of a motion with fixed parameters. Its start is written into the segment when the stretch before it is
/// over.
struct Phase {
  Segment segment;             ///< commands, samples, and (first phase) the start
  std::vector<double> values;  ///< of the plant
};

struct Motion {
  PlantModel model;
  std::vector<Phase> phases;  ///< a second one where a load is picked up
  bool commanded = false;     ///< commands are held from sample to sample, so no step may be longer
  std::string words;          ///< for people

  double duration() const;
  double longest_step() const;  ///< s, the median spacing of the samples
  /// The first `seconds` of it, at least one interval; whole phases are dropped.
  Motion first(double seconds) const;
  std::vector<double> times() const;  ///< s, of all samples; a phase begins with the sample that ends the one before
};

/// An engine with the mass properties and the gravity of the motion's first phase. Throws WorkError where it is
/// missing.
std::unique_ptr<Dynamics> build_engine(const std::string& engine, const Motion& motion);

/// Spacing of the samples of a motion without commands, and so its longest step, s; a short motion has 32 of them.
inline constexpr double kFreeSpacing = 0.064;

/// Whether an effect does nothing but change what a transducer reads.
bool only_reads(const EffectSpec& spec);

/// The scenario's motion: the commands that `motion` names, read here, else commands and start from the scenario's one
/// recording (already chosen and loaded); start, duration and pickup as `motion` states them; where nobody says every
/// joint at 1 rad (0.1 m), at rest. At most `most` seconds unless `motion` states a duration. Effects that only change
/// readings are left out: readings are the same code on all engines. Throws InputError for a plant whose pickup cannot
/// be carried out (states or memories of its own).
Motion motion_of(const Scenario& scenario, double most);

/// The same robot from the same start without any actuator or effect but changed mass properties, for `seconds`; at
/// rest it is given speeds within 0.5 rad/s (m/s), drawn from `seed`. `gravity`: with the scenario's gravity, or none.
Motion free_motion_of(const Scenario& scenario, const Motion& motion, double seconds, bool gravity, std::uint64_t seed);

/// Speeds after the tool has taken hold of a point mass at rest: the joints' momenta M v stay, the mass matrix changes.
std::vector<double> speeds_after_pickup(const PlantModel& model, const std::vector<double>& values_before,
                                        const std::vector<double>& values_after, const std::vector<double>& q,
                                        const std::vector<double>& v);

}  // namespace lacuna
