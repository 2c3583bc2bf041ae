// The seven-function arm as it is driven: proportional valves, cylinders on levers, rotary actuators, one supply.
//
// Bores, levers, hoses and valves are plausible, as the frames of the arm are: they are nobody's data sheet.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "scenarios/generate/bundle.h"
#include "scenarios/scenario.h"

namespace lacuna::generate {
namespace {

constexpr int kJoints = 7;

/// SI units; a rotary actuator's areas are m^3/rad, its stroke rad.
struct Drive {
  double gain, leakage, area_a, area_b, dead_volume, stroke, middle = 0.0;
  double lever_a = 0.0, lever_b = 0.0, lever_angle = 0.0;
  double damping = 0.0;  ///< of seals and bearings, N m s/rad (N s/m)
  double start = 0.0;    ///< rad (m), where recordings begin
};

double disc(double diameter) { return 0.25 * std::numbers::pi * diameter * diameter; }
double to_digits(double value) { return std::stod(fmt::format("{:.4g}", value)); }

Drive cylinder(double gain, double leakage, double bore, double rod, double dead, double stroke, double middle) {
  return {gain, leakage, to_digits(disc(bore)), to_digits(disc(bore) - disc(rod)), dead, stroke, middle};
}
Drive rotary(double gain, double leakage, double displacement, double dead, double range) {
  return {gain, leakage, displacement, displacement, dead, range};
}
Drive on_lever(Drive drive, double a, double b, double angle) {
  drive.lever_a = a, drive.lever_b = b, drive.lever_angle = angle;
  return drive;
}
Drive with(Drive drive, double damping, double start) {
  drive.damping = damping, drive.start = start;
  return drive;
}

/// Where identification starts.
const std::vector<Drive>& drives() {
  static const std::vector<Drive> all{
      with(rotary(5e-9, 5e-14, 40e-6, 25e-6, 2.2), 220, 0),
      with(on_lever(cylinder(5.7e-9, 5e-14, 0.040, 0.020, 28e-6, 0.134, 0.52), 0.30, 0.078, 1.0472), 231.8, 0.4),
      with(on_lever(cylinder(2.2e-9, 5e-14, 0.032, 0.016, 25e-6, 0.105, -0.83), 0.24, 0.060, 2.3562), 70, -0.8),
      with(rotary(4.2e-9, 1e-14, 20e-6, 20e-6, 5.0), 6, 0),
      with(on_lever(cylinder(1.2e-9, 1e-14, 0.025, 0.012, 22e-6, 0.068, 0), 0.15, 0.040, 1.4835), 8, 0),
      with(rotary(2e-9, 1e-14, 8e-6, 20e-6, 20), 2, 0),
      with(cylinder(3e-10, 1e-15, 0.011, 0.006, 5e-6, 0.1, 0.05), 100, 0.05)};  // throttled
  return all;
}

std::string joint(int number) { return fmt::format("joint_{}", number); }

void put_drive(YamlWriter& yaml, int number, const Drive& d, double gain) {
  const bool lever = d.lever_a > 0.0;
  yaml.key(joint(number)).map().put("model", "hydraulic").put("gain", gain).comment("m^3/(s Pa^0.5)");
  yaml.put("full_command", 10.0).comment("V");
  yaml.put("area_a", d.area_a).put("area_b", d.area_b).comment(lever || number == kJoints ? "m^2" : "m^3/rad");
  yaml.put("dead_volume_a", d.dead_volume).put("dead_volume_b", d.dead_volume).comment("m^3, mostly hoses");
  yaml.put("stroke", d.stroke).put("middle", d.middle);
  if (lever) yaml.put("lever_a", d.lever_a).put("lever_b", d.lever_b).put("lever_angle", d.lever_angle);
  yaml.put("bulk_modulus", 1.4e9).put("hose_compliance", 6.7e-9).comment("Pa, 1/Pa");
  yaml.put("supply_pressure", 1.6e7).put("return_pressure", 5e5).comment("Pa");
  yaml.put("leakage", d.leakage).comment("m^3/(s Pa)").end();
}

void put_friction(YamlWriter& yaml, const std::vector<double>& damping, const std::vector<int>& joints) {
  for (const int i : joints) {
    yaml.short_map().put("effect", "viscous_friction").put("where", joint(i));
    yaml.key("parameters").short_map().put("D", damping[i - 1]).end().end();
  }
}

void put_columns(YamlWriter& yaml, const char* kind, const char* column, const std::vector<int>& joints, bool bar) {
  yaml.key(kind).map();
  for (const int i : joints) {
    const std::string name = fmt::format("{}_{}", column, i);
    if (bar)
      yaml.key(joint(i)).short_map().put("column", name).put("scale", 1e5).end();
    else
      yaml.put(joint(i), name);
  }
  yaml.end();
}

/// Commands, positions and pressures of `joints`.
void put_measured(YamlWriter& yaml, const std::vector<int>& joints, bool pressures) {
  yaml.key("channels").map().put("time", "t").comment("s");
  put_commands(yaml, joints);
  put_columns(yaml, "position", "q", joints, false);
  if (pressures) {
    put_columns(yaml, "pressure_a", "a", joints, true);
    put_columns(yaml, "pressure_b", "b", joints, true);
  }
  yaml.end();
}

const std::vector<int>& all_joints() {
  static const std::vector<int> all{1, 2, 3, 4, 5, 6, 7};
  return all;
}

void put_arm_drives(YamlWriter& yaml, const std::vector<double>& gains, const std::vector<double>& damping) {
  yaml.key("actuators").comment("valve, chambers, linkage: `lacuna effects` has the equations").map();
  for (const int i : all_joints()) put_drive(yaml, i, drives()[i - 1], gains[i - 1]);
  yaml.end();
  yaml.key("effects").comment("seals and bearings; N m s/rad, joint_7: N s/m").list();
  put_friction(yaml, damping, all_joints());
  yaml.end();
}

void put_start(YamlWriter& yaml, const std::vector<int>& joints) {
  yaml.key("motion").comment("rad; joint_7: m").map().key("position").short_map();
  for (const int i : joints) yaml.put(joint(i), drives()[i - 1].start);
  yaml.end().end();
}

void put_wide_masses(YamlWriter& yaml) {
  for (int i = 1; i <= 6; ++i)
    yaml.key(fmt::format("link_{}.mass", i)).short_map().put("bounds", {0.1, 30}).end().comment("kg");
}

using Bounds = std::vector<std::tuple<const char*, double, double, const char*>>;

/// Joint 2 alone, the others locked, with friction of its own where its actuator has none.
void put_effects_of_joint_2(YamlWriter& yaml, double damping) {
  put_brakes(yaml, {"joint_1", "joint_3", "joint_4", "joint_5", "joint_6"}, [&] {
    if (damping > 0.0) put_friction(yaml, {0.0, damping}, {2});
  });
}

/// One model of joint 2 while the others are locked: nine numbers, as the seed paper's.
void add_joint_2(Files& files, const std::string& model, const std::string& remark, const Bounds& free) {
  YamlWriter yaml(kCommentColumn);
  put_sampled_head(yaml, remark, "hydraulic_joint_2_" + model, "../../seed_start.urdf");
  yaml.key("actuators").map();
  if (model == "hydraulic") put_drive(yaml, 2, drives()[1], drives()[1].gain);
  if (model == "torque_source") put_source(yaml, joint(2), {100, 100, 1146, 0.4});
  if (model == "flow_source")
    yaml.key(joint(2)).short_map().put("model", model).put("gain", 0.02).put("damping", 100.0).put("stiffness", 5e4);
  if (model == "flow_source") yaml.end().comment("rad/(s V), N m s/rad, N m/rad");
  yaml.end();
  put_effects_of_joint_2(yaml, model == "hydraulic" ? 100.0 : 0.0);
  yaml.key("identify").map();
  for (const auto& [name, least, most, unit] : free)
    yaml.key(name).short_map().put("bounds", {least, most}).end().comment(unit);
  put_wide_masses(yaml);
  yaml.end();
  put_measured(yaml, {2}, model == "hydraulic");
  put_recordings(yaml, "", {{"train.csv", "train"}, {"validate.csv", "validate"}, {"test.csv", "test"}});
  add(files, "hydrolek/hydraulic/joint_2/" + model + ".yaml", yaml);
}

/// The seed's experiment on a joint that a valve drives: its arm, its commands, and three models of the joint.
void add_models_of_joint_2(Files& files, double gain, double damping) {
  const std::string behind = "\nThe truth behind the recordings is truth.yaml.";
  add_joint_2(files, "torque_source",
              "The seed paper's nine numbers for a joint that a valve and a cylinder drive." + behind,
              {{"joint_2.gain", 2, 1e4, "N m/V"},
               {"joint_2.damping", 10, 1e6, "N m s/rad"},
               {"joint_2.stiffness", 1, 1e4, "N m/rad"}});
  add_joint_2(files, "flow_source",
              "Nine numbers for a joint that a valve and a cylinder drive: a stiff source of speed." + behind,
              {{"joint_2.gain", 0.002, 0.2, "rad/(s V)"},
               {"joint_2.damping", 1, 1e4, "N m s/rad"},
               {"joint_2.stiffness", 1e3, 1e6, "N m/rad"}});
  add_joint_2(files, "hydraulic", "Nine numbers for a joint whose chambers and linkage are known." + behind,
              {{"joint_2.gain", 5e-10, 5e-8, "m^3/(s Pa^0.5)"},
               {"joint_2.viscous_friction.D", 1, 1e4, "N m s/rad"},
               {"joint_2.leakage", 5e-15, 5e-13, "m^3/(s Pa)"}});
  YamlWriter truth(kCommentColumn);
  put_sampled_head(truth, "The truth behind the models of joint 2: never an input to identification.",
                   "hydraulic_joint_2_truth", "../../seed_table1.urdf");
  truth.key("actuators").map();
  put_drive(truth, 2, drives()[1], gain);
  truth.end();
  put_effects_of_joint_2(truth, damping);
  put_measured(truth, {2}, true);
  put_start(truth, {2});
  add(files, "hydrolek/hydraulic/joint_2/truth.yaml", truth);
}

}  // namespace

void add_hydraulic(Files& files) {
  constexpr std::uint64_t kSeed = 2;
  RandomStream stream(kSeed, 0, 0);
  std::vector<double> gains, damping, start_gains, start_damping;
  for (const Drive& d : drives()) {
    start_gains.push_back(d.gain), start_damping.push_back(d.damping);
    gains.push_back(drawn(stream, d.gain)), damping.push_back(drawn(stream, d.damping));
  }
  const auto robot = hydrolek();

  YamlWriter yaml(kCommentColumn);
  put_sampled_head(yaml, "The arm with valves, chambers and cylinders, and their pressures measured.", "hydraulic",
                   "../hydrolek.urdf");
  yaml.put("total_mass", 42.6).comment("kg, known; individual link masses are not");
  put_arm_drives(yaml, start_gains, start_damping);
  yaml.key("identify").comment("start values are the ones above and in the URDF").map();
  put_factors(yaml, "gain", 0.25, 4.0);
  for (const int i : all_joints()) put_factors(yaml, (joint(i) + ".viscous_friction.D").c_str(), 0.25, 4.0);
  put_factors(yaml, "mass", 0.4, 2.5);
  yaml.end();
  put_measured(yaml, all_joints(), true);
  put_recordings(
      yaml, "",
      {{"train_1.csv", "train"}, {"train_2.csv", "train"}, {"validate_1.csv", "validate"}, {"test_1.csv", "test"}});
  put_start(yaml, all_joints());
  add(files, "hydrolek/hydraulic/scenario.yaml", yaml);

  YamlWriter truth(kCommentColumn);
  put_sampled_head(truth, "The truth behind scenario.yaml: never an input to identification.", "hydraulic_truth",
                   "truth.urdf");
  put_arm_drives(truth, gains, damping);
  put_measured(truth, all_joints(), true);
  put_start(truth, all_joints());
  add(files, "hydrolek/hydraulic/truth.yaml", truth);
  files["hydrolek/hydraulic/truth.urdf"] = to_urdf(*robot, drawn_masses(stream, *robot));
  add_models_of_joint_2(files, gains[1], damping[1]);
}

}  // namespace lacuna::generate
