// A learned law in a scenario: `{effect: learned_effort, where: elbow, over: [q, v], knots: [[...], [...]], values:
// [[...], ...]}`, of one variable (then `knots` and `values` are plain lists) or two.
//
// Variables: q and v, the joint's own position and speed; u, its command; t, the session's time (s); JOINT.q and
// JOINT.v, another joint's. Knots are even, 4 to 256 of the first variable and 2 to 16 of the second; values are a row
// for each knot of the first. `period`, of a law of one variable, makes it repeat itself: then the knots lie all over
// one period, the last one spacing before its end. To the plant they are the numbers of
// physics/effects/learned_curve.h.
#pragma once

#include <map>
#include <string>

#include "scenarios/robot.h"
#include "scenarios/scenario.h"
#include "scenarios/yaml_reader.h"

namespace lacuna {

class YamlWriter;

/// learned_effort, learned_command, learned_reading.
bool is_learned(const std::string& effect);

/// As the parameters of the effect. Throws InputError.
std::map<std::string, double> parse_curve(const YamlCursor& entry, const Robot& robot);

/// Into the map of its effect: `over: [q], knots: [...], values: [...]`. Throws WorkError for a law without knots.
void put_curve(YamlWriter& yaml, const EffectSpec& spec, const Robot& robot);

/// A variable by its name in a scenario: whose it is ("": the joint's at which the law stands), and which.
struct VariableName {
  std::string joint;
  std::string quantity;  ///< "position", "speed", "command" or "time"
};
VariableName variable_named(const std::string& name);

/// A law's variables by name ("q", "elbow.v"): one or two.
std::vector<std::string> variables_of(const EffectSpec& spec, const Robot& robot);

}  // namespace lacuna
