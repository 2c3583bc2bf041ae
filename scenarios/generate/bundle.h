// The bundled scenarios as texts: robots from tables of dimensions, scenario files, excitation commands.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ga/random.h"
#include "scenarios/robot.h"
#include "scenarios/yaml_writer.h"

namespace lacuna::generate {

/// Path below scenarios/ -> content.
using Files = std::map<std::string, std::string>;

/// Masses of links 1 to 6, kg, as the seed paper tables them.
using LinkMasses = std::vector<double>;
inline const LinkMasses kTable1Masses{4.6, 5.1, 22.5, 1.6, 4.1, 4.7};    ///< sum 42.6
inline const LinkMasses kTable5Masses{5.8, 12.7, 6.9, 7.75, 8.31, 4.2};  ///< sum 45.66
inline const LinkMasses kInitialMasses{0.6, 1.3, 2.8, 1.2, 2.2, 1.7};    ///< row "Init."

/// The seven-function arm: six revolute joints and a gripper jaw whose mass is taken out of link 6.
std::shared_ptr<const Robot> hydrolek();
/// The seed's arm: the same six joints, the gripper part of link 6, with the given masses.
std::shared_ptr<const Robot> seed_arm(const std::string& name, const LinkMasses& masses);
/// Uniform rods whose motion has a closed form; all hang or stand along z at q = 0.
std::shared_ptr<const Robot> pendulum();
std::shared_ptr<const Robot> double_pendulum();
std::shared_ptr<const Robot> cartpole();

/// `links` uniform rods, 2 m long together, that hang in a row; joint axes in turn about y and x.
std::shared_ptr<const Robot> chain(int links);
/// The seed's arm whose last link carries a load off its axis, with principal axes askew.
std::shared_ptr<const Robot> skew_arm();

/// Ends the scenario's map and adds its text.
void add(Files& files, const std::string& name, YamlWriter& yaml);
/// URDF text with a comment at its head.
std::string commented_urdf(const Robot& robot, const std::string& comment);
/// CSV of one of the excitations (steps, multisine, staircase, triangle, chirp) or of one step at all joints ("step")
/// or a slow ramp ("ramp"), for joints numbered from 1: columns t and u_N.
std::string command_table(const std::string& course, const std::vector<int>& joints, int samples = 2000);

/// A scenario's beginning, without and with the period of its samples; the caller ends the map.
void put_head(YamlWriter& yaml, const std::string& remark, const std::string& name, const std::string& robot);
void put_sampled_head(YamlWriter& yaml, const std::string& remark, const std::string& name, const std::string& robot);
/// `recordings`: file below `folder`, and its role.
void put_recordings(YamlWriter& yaml, const std::string& folder,
                    const std::vector<std::pair<const char*, const char*>>& files);
/// One joint moves, the others stand locked: dry friction that no effort of the arm overcomes. `besides` puts further
/// effects before them.
void put_brakes(YamlWriter& yaml, const std::vector<const char*>& joints, const std::function<void()>& besides = {});

/// `value` times a factor drawn within 30 % of 1, to three digits.
double drawn(RandomStream& stream, double value);
/// Masses of all links drawn alike, then brought to the known total; the last moving link takes the rounding.
std::vector<double> drawn_masses(RandomStream& stream, const Robot& robot);

/// The arm's actuators: K N m/V, D N m s/rad, S N m/rad, rest rad (joint_7: N/V, N s/m, N/m, m).
struct Source {
  double gain, damping, stiffness, rest;
};
/// Where identification of the seven-function arm starts.
const std::vector<Source>& start_sources();
/// The scenario's `actuators` for joint_`first` and on.
void put_actuators(YamlWriter& yaml, const std::vector<Source>& sources, std::size_t first = 1);
/// Of one joint, into `actuators`.
void put_source(YamlWriter& yaml, const std::string& joint, const Source& source);
/// `command: {joint_1: {column: u_1, unit: V}, ...}`, into `channels`, a line a joint.
void put_commands(YamlWriter& yaml, const std::vector<int>& joints);
/// `relative_bounds` of the parameter, into `identify`.
void put_factors(YamlWriter& yaml, const char* parameter, double least, double most);
/// Where comments stand in the bundled scenarios.
constexpr std::size_t kCommentColumn = 31;

void add_robots(Files& files);
void add_scenarios(Files& files);
/// hydrolek/hydraulic/: the same arm on valves, chambers and cylinders, with pressures.
void add_hydraulic(Files& files);
void add_commands(Files& files);
/// scenarios/compare/: what `lacuna compare` runs.
void add_comparison(Files& files);

}  // namespace lacuna::generate
