#include "backends/ode/tree_motion.h"

namespace lacuna {
namespace {

struct Frame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d omega = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   // of the origin
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();  // the last two at zero joint accelerations
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();
};

// The child's frame from its parent's: the textbook recursion for a hinge and, with the Coriolis term, a slider.
Frame moved(const Frame& parent, const Joint& joint, double q, double v, Eigen::Vector3d& axis) {
  const Eigen::Matrix3d at_rest = parent.rotation * joint.origin.linear();
  axis = at_rest * joint.axis;
  Frame child;
  Eigen::Vector3d arm = parent.rotation * joint.origin.translation();
  if (joint.prismatic()) {
    arm += q * axis;
    child.rotation = at_rest;
    child.omega = parent.omega;
    child.alpha = parent.alpha;
  } else {
    child.rotation = at_rest * Eigen::AngleAxisd(q, joint.axis).toRotationMatrix();
    child.omega = parent.omega + v * axis;
    child.alpha = parent.alpha + v * parent.omega.cross(axis);
  }
  child.origin = parent.origin + arm;
  child.rate = parent.rate + parent.omega.cross(arm);
  child.drift = parent.drift + parent.alpha.cross(arm) + parent.omega.cross(parent.omega.cross(arm));
  if (joint.prismatic()) {
    child.rate += v * axis;
    child.drift += 2.0 * v * parent.omega.cross(axis);
  }
  return child;
}

}  // namespace

void tree_motion(const Robot& robot, const std::vector<Eigen::Vector3d>& coms, const double* q, const double* v,
                 std::vector<BodyMotion>& motion) {
  const std::size_t n = coms.size();
  motion.resize(n);
  std::vector<Frame> frames(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Joint& joint = robot.joints()[i];
    const Frame parent = joint.parent < 0 ? Frame{} : frames[joint.parent];
    const Frame& frame = frames[i] = moved(parent, joint, q[i], v[i], motion[i].axis);
    const Eigen::Vector3d arm = frame.rotation * coms[i];
    motion[i].rotation = frame.rotation;
    motion[i].origin = frame.origin;
    motion[i].com = frame.origin + arm;
    motion[i].omega = frame.omega;
    motion[i].com_rate = frame.rate + frame.omega.cross(arm);
    motion[i].alpha_drift = frame.alpha;
    motion[i].com_drift = frame.drift + frame.alpha.cross(arm) + frame.omega.cross(frame.omega.cross(arm));
  }
}

}  // namespace lacuna
