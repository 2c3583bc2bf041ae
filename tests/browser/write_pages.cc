// The pages that tests/browser/pages_test.py opens: write_pages FOLDER.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "reports/report.h"
#include "reports/svg.h"
#include "scenarios/files.h"
#include "scenarios/robot.h"
#include "tests/reports/sample.h"
#include "tests/scenarios/mesh_writer.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

const fs::path kArm = fs::path(LACUNA_SOURCE_DIR) / "scenarios/hydrolek/hydrolek.urdf";

/// Twenty seconds of one joint at 100 Hz. The plain model sticks where the joint turns back; `pause`: a gap.
Trace moving(const std::string& recording, const std::string& joint, int index, bool pause) {
  Trace t{recording, joint, "rad", {}, {}, {}, {}};
  for (int i = 0; i < 2000; ++i) {
    const double x = 0.01 * i, w = 0.5 + 0.1 * index, q = 0.3 * std::sin(w * x);
    t.time.push_back(x);
    t.measured.push_back(pause && i > 700 && i < 720 ? sample::kNan : q + 2e-4 * std::sin(371.0 * x));
    t.before.push_back(q + (index == 1 ? 0.02 : 0.002) * std::cos(w * x));
    t.after.push_back(q + 1e-4 * std::sin(3.0 * x));
  }
  return t;
}

Replay::Effort lacking(const std::string& joint, int index) {
  Replay::Effort e{joint, "%", 0.01, {}, {}, {}};
  for (int i = 100; i < 1900; ++i) {
    e.time.push_back(0.01 * i);
    e.before.push_back((index == 1 ? 0.5 : 0.02) * std::cos((0.5 + 0.1 * index) * e.time.back()));
    e.after.push_back(0.01 * std::sin(7.0 * e.time.back()));
  }
  return e;
}

Replay replay(const std::string& recording, Role role, const std::vector<std::string>& joints) {
  Replay out{recording, role, {}, {}};
  for (std::size_t j = 0; j < joints.size(); ++j) {
    out.traces.push_back(moving(recording, joints[j], static_cast<int>(j), j == 0));
    out.missing.push_back(lacking(joints[j], static_cast<int>(j)));
  }
  return out;
}

/// An arm of seven joints, one of which slides, three recordings long.
void add_replays(Diagnosis& d, const std::vector<std::string>& joints, const std::vector<std::string>& recordings) {
  d.replays = {replay(recordings[0], Role::test, joints), replay(recordings[1], Role::validate, joints),
               replay(recordings[2], Role::validate, joints)};
  d.traces = d.replays.front().traces;
}

std::vector<std::string> joint_names(const Robot& robot) {
  std::vector<std::string> out;
  for (const Joint& joint : robot.joints()) out.push_back(joint.name);
  return out;
}

void write(const fs::path& file, const Scenario& scenario, const Diagnosis& d) {
  write_file_atomically(file, diagnosis_page(scenario, d, sample::context(), {}));
}

void write_usual(const fs::path& folder) {
  Scenario scenario;
  scenario.robot = Robot::from_urdf(kArm);
  Diagnosis d = sample::diagnosis();
  add_replays(d, joint_names(*scenario.robot), {"test_1.csv", "validate_1.csv", "validate_2.csv"});
  d.findings.front().times = {{"validate_1.csv", 2.1, 2.4}, {"validate_2.csv", 5.0, 5.5}};
  d.events = {sample::learned_event_in("test_1.csv", Role::test)};
  d.learned = {sample::learned_law()};
  write(folder / "usual.html", scenario, d);

  d.findings.clear(), d.learned.clear(), d.events.clear();
  d.verdict = Verdict::consistent;
  write(folder / "consistent.html", scenario, d);
}

/// The same arm, a cylinder on levers at its second joint.
void write_cylinder(const fs::path& folder) {
  Scenario scenario;
  scenario.robot = Robot::from_urdf(kArm);
  ActuatorSpec cylinder;
  cylinder.joint = scenario.robot->joints()[1].name;
  cylinder.parameters = {{"lever_a", 0.3},  {"lever_b", 0.08},  {"lever_angle", 1.0}, {"middle", 0.5},
                         {"stroke", 0.134}, {"area_a", 0.0013}, {"area_b", 0.0009}};
  scenario.actuators = {cylinder};
  Diagnosis d = sample::diagnosis();
  add_replays(d, joint_names(*scenario.robot), {"test_1.csv", "validate_1.csv", "validate_2.csv"});
  write(folder / "cylinder.html", scenario, d);
}

/// The same arm, every link a mesh of more triangles than the page keeps.
void write_meshed(const fs::path& folder) {
  Scenario scenario;
  const auto plain = Robot::from_urdf(kArm);
  auto links = plain->links();
  const auto mesh = std::make_shared<const Mesh>(test::ball_mesh(0.15f, 60));
  for (Link& link : links)
    for (Visual& visual : link.visuals) visual.shape = Visual::Shape::mesh, visual.size.setZero(), visual.mesh = mesh;
  scenario.robot = std::make_shared<const Robot>("meshed", plain->joints(), links, "meshed");
  Diagnosis d = sample::diagnosis();
  add_replays(d, joint_names(*scenario.robot), {"test_1.csv", "validate_1.csv", "validate_2.csv"});
  write(folder / "meshed.html", scenario, d);
}

/// Every name in it is an attack, those of the robot's joints and of the recordings included.
void write_hostile(const fs::path& folder) {
  const std::string attack = "</script><script>window.hacked=1</script><img src=x onerror='window.hacked=2'>\"&\xff";
  std::vector<Joint> joints(2);
  std::vector<Link> links(3);
  links[0].name = "base";
  for (int i = 0; i < 2; ++i) {
    joints[i].name = attack + std::to_string(i);
    joints[i].parent = i - 1, joints[i].link = i + 1;
    joints[i].origin.translation() = Eigen::Vector3d(0.4 * i, 0.0, 0.2);
    joints[i].axis = Eigen::Vector3d::UnitY();
    links[i + 1].name = attack + "link" + std::to_string(i);
    links[i + 1].body = i;
    links[i + 1].inertial = {1.0, {0.2, 0.0, 0.0}, 0.01 * Eigen::Matrix3d::Identity()};
  }
  Scenario scenario;
  scenario.robot = std::make_shared<const Robot>("hostile", joints, links, "hostile");
  Diagnosis d = sample::hostile_diagnosis();
  const std::string file = attack + ".csv";
  add_replays(d, joint_names(*scenario.robot), {file, file + "2", file + "3"});
  d.findings.front().place = joints[0].name;
  d.findings.front().times = {{file, 1.0, 2.0}};
  for (Replay& r : d.replays) {
    for (Trace& t : r.traces) t.unit = attack;
    for (Replay::Effort& e : r.missing) e.unit = attack;
  }
  write(folder / "hostile.html", scenario, d);
}

}  // namespace
}  // namespace lacuna

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  lacuna::write_usual(folder);
  lacuna::write_cylinder(folder);
  lacuna::write_meshed(folder);
  lacuna::write_hostile(folder);
}
