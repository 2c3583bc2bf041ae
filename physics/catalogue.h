// The tables of actuator models and of effects: what exists, in words and numbers. `lacuna effects` prints the second.
#pragma once

#include <string>
#include <vector>

#include "physics/component.h"
#include "physics/stage.h"

namespace lacuna {

inline constexpr double kPressureUnit = 1e6;  ///< Pa: states are of order 1

/// Which of an actuator's parameters play the parts that the rest of the plant asks for: indices; -1: it has none.
struct ActuatorRoles {
  int gain = -1;       ///< what a command is multiplied by: efforts divided by it are in units of the command
  int damping = -1;    ///< N m s/rad (N s/m), effort lost per speed
  int stiffness = -1;  ///< N m/rad (N/m), effort per way
  int rest = -1;       ///< rad (m), position at which that spring is slack
};

struct ActuatorInfo {
  const char* name;
  const char* equation;
  const char* use;
  std::vector<ParameterInfo>
      parameters;  ///< neutral: the default where a scenario leaves the parameter out; NaN: required
  ActuatorRoles roles;
  /// Where its command enters the chain. Before that point there is only the command's own way (Stage::command):
  /// an actuator whose command is an effort has no valve.
  Stage input;
  bool hydraulic = false;  ///< stands for a valve and a cylinder: effects whose cause these are may act
  int states = 0;          ///< of its own, integrated with the motion
  bool chambers = false;   ///< its first two states are the pressures of chambers A and B, in kPressureUnit
};

enum class Where { joint, arm };

/// One row of the catalogue (source: the project's physics notes, section 3; equations in the file of each effect).
struct EffectInfo {
  const char* name;   ///< identifier in files
  const char* title;  ///< for people
  Where where;
  Stage stage;  ///< where in the chain it acts
  const char* equation;
  const char* shows_as;   ///< what a user sees
  const char* hidden_by;  ///< what mimics it
  const char* source;
  std::vector<ParameterInfo> parameters;
  bool per_recording = false;  ///< may act in some recordings only
  /// The effect that is left of it where what is its own cannot be seen: of a spring too stiff to be followed, the
  /// inertia behind it. Null: none.
  const char* contains = nullptr;
  bool metering = false;   ///< a law of the flow through a valve: sought where the command lets a flow, not an effort
  bool hydraulic = false;  ///< its cause is a valve's or cylinder's: not sought where the effort itself is commanded
  /// Sought where efforts are predicted: of positions alone, its numbers and those of others that do the same to a
  /// motion (a valve's offset, an actuator's damping, a shifted centre of mass) are hardly told apart. A scenario may
  /// hold it anywhere.
  bool in_efforts = false;
  /// The effect that this one is where its numbers agree (beside those told by equal names); null: none.
  const char* generalises = nullptr;
  /// It may stand beside what it contains, as one more element in parallel: part of a contact slides while another part
  /// still gives (Maxwell slip; V. Lampaert, F. Al-Bender, J. Swevers, MMAR 2003).
  bool in_parallel = false;
  bool learned = false;  ///< its law is found, not given (diagnosis/learned.h): no candidate where names are sought
  bool shares = false;   ///< joints take from each other: sought where several are commanded at once
  /// Of what joints share: the effect at a joint that it looks like where that joint moves alone, as large as its own
  /// part of it; null: none.
  const char* alone = nullptr;
  bool as_one = false;  ///< its parameters are parts of one departure from neutral: stronger are all of them together
};

const std::vector<ActuatorInfo>& actuator_table();
const std::vector<EffectInfo>& effect_table();

/// The parameter that is an effect's strength: its first, or for a contact, whose first says only where, its second.
const ParameterInfo& leading_parameter(const EffectInfo& effect);
/// Value of the effect's parameter p when the effect is made `factor` times as strong: the leading one moves from its
/// neutral value, those of its scale (of an effect `as_one`: all) with it; one that is searched by its logarithm goes
/// towards the 0 or the infinity that is its neutral value; the rest stay.
double strengthened(const EffectInfo& effect, const ParameterInfo& p, double value, double factor);

/// Whether an actuator (index in the table; -1: none) integrates the flow of its valve.
bool integrates_flow(int actuator);
/// Whether its command lets a flow: into the position that it integrates, or into chambers.
bool lets_flow(int actuator);
/// Whether an effect acts on that flow alone: it means nothing to other actuators.
bool needs_flow(int effect);
/// Whether an effect at a joint means anything to the joint's actuator.
bool suits(int effect, int actuator);
/// Whether it changes the command, or adds an effort, by a law that a machine may have a little otherwise along its
/// way: no mass, delay or reading.
bool acts_by_a_law(int effect);

/// Index in the table, or -1.
int find_actuator(const std::string& name);
int find_effect(const std::string& name);
/// Whether the effect acts on the whole arm; a joint may be named "arm", too.
bool of_whole_arm(const std::string& effect);

}  // namespace lacuna
