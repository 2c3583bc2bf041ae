// MuJoCo 2.2 as an acceleration oracle.
//
// The robot becomes MJCF text without geometry; mass properties are then written into mjModel directly, so that a
// change of them rebuilds nothing and a body without rotational inertia (a point mass) is welcome too.
//
// MuJoCo answers a fatal error by calling exit(). Nothing here provokes one: the text is generated, so it can only be
// refused by the compiler (reported as WorkError), the scratch stack is sized by MuJoCo for the model it holds, and the
// implicit integrator is not asked to divide by a mass matrix that is singular.
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

#include "backends/registry.h"
#include "scenarios/error.h"
#include "scenarios/xml_writer.h"

namespace lacuna {
namespace {

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPtr = std::unique_ptr<mjModel, Deleter>;
using DataPtr = std::unique_ptr<mjData, Deleter>;

struct Integrator {
  const char* name;
  int code;
};
constexpr std::array<Integrator, 3> integrators = {
    {{"euler", mjINT_EULER}, {"rk4", mjINT_RK4}, {"implicit", mjINT_IMPLICIT}}};

// Everything but rigid-body dynamics.
constexpr int disabled = mjDSBL_CONSTRAINT | mjDSBL_EQUALITY | mjDSBL_FRICTIONLOSS | mjDSBL_LIMIT | mjDSBL_CONTACT |
                         mjDSBL_PASSIVE | mjDSBL_CLAMPCTRL | mjDSBL_WARMSTART | mjDSBL_ACTUATION | mjDSBL_SENSOR;

// The inertial is a placeholder: off the body's origin and rotated by nothing, so that the compiler takes no shortcut
// (mjModel::body_simple) that another inertial would make wrong.
void put_body(XmlWriter& xml, const Robot& robot, const std::vector<std::vector<int>>& children, int body) {
  const Joint& joint = robot.joints()[body];
  const Eigen::Quaterniond turn(joint.origin.linear());
  xml.open("body").set("name", fmt::format("b{}", body)).set("pos", joint.origin.translation());
  xml.set("quat", {turn.w(), turn.x(), turn.y(), turn.z()});
  xml.open("inertial").set("pos", {0.1, 0.2, 0.3}).set("mass", 1.0).set("diaginertia", {1.0, 1.5, 2.0}).close();
  xml.open("joint").set("name", fmt::format("j{}", body)).set("type", joint.prismatic() ? "slide" : "hinge");
  xml.set("axis", joint.axis).close();
  for (int child : children[body]) put_body(xml, robot, children, child);
  xml.close();
}

std::string mjcf(const Robot& robot) {
  std::vector<std::vector<int>> children(robot.dof());
  for (int i = 0; i < robot.dof(); ++i) {
    const int parent = robot.joints()[i].parent;
    if (parent >= 0) children[parent].push_back(i);
  }
  XmlWriter xml;
  xml.open("mujoco").open("compiler").set("angle", "radian").close().open("worldbody");
  for (int i = 0; i < robot.dof(); ++i) {
    if (robot.joints()[i].parent < 0) put_body(xml, robot, children, i);
  }
  return xml.close().close().str();
}

// Loading uses MuJoCo's globals (the last XML, the warning handler), so one thread at a time.
ModelPtr load(const std::string& xml, const std::string& robot) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  // Without a handler every warning would be appended to MUJOCO_LOG.TXT in the working directory.
  if (mju_user_warning == nullptr) mju_user_warning = [](const char*) {};

  struct CloseVfs {
    void operator()(mjVFS* files) const {
      mj_deleteVFS(files);
      delete files;
    }
  };
  const std::unique_ptr<mjVFS, CloseVfs> files(new mjVFS);  // 2 MB: not for the stack
  mj_defaultVFS(files.get());
  if (mj_makeEmptyFileVFS(files.get(), "robot.xml", static_cast<int>(xml.size())) != 0) {
    throw WorkError("mujoco cannot hold robot " + quoted(robot) + ": no room for its description");
  }
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  std::array<char, 500> error{};
  ModelPtr model(mj_loadXML("robot.xml", files.get(), error.data(), static_cast<int>(error.size())));
  if (!model) throw WorkError("mujoco cannot hold robot " + quoted(robot) + ": " + quoted(error.data(), 200));
  return model;
}

class MujocoDynamics final : public Dynamics {
 public:
  MujocoDynamics(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity)
      : Dynamics(robot), model_(load(mjcf(*robot), robot->name())) {
    model_->opt.disableflags = disabled;
    do_set_gravity(gravity);
    for (int i = 0; i < dof(); ++i) {
      body_.push_back(mj_name2id(model_.get(), mjOBJ_BODY, fmt::format("b{}", i).c_str()));
      dof_.push_back(model_->jnt_dofadr[mj_name2id(model_.get(), mjOBJ_JOINT, fmt::format("j{}", i).c_str())]);
      write_inertial(i, robot->body_inertial(i));
    }
    sum_subtrees();
    make_data();
  }
  MujocoDynamics(const MujocoDynamics& other)
      : Dynamics(other), model_(mj_copyModel(nullptr, other.model_.get())), body_(other.body_), dof_(other.dof_) {
    make_data();
  }
  std::unique_ptr<Dynamics> clone() const override { return std::make_unique<MujocoDynamics>(*this); }

 protected:
  void do_set_inertial(int body, const Inertial& inertial) override {
    write_inertial(body, inertial);
    sum_subtrees();
    if (own_losses()) derive_constants();
  }

  // Nothing but mj_step reads them. A constraint's softness is scaled by what mj_setConst derives from the masses.
  void do_set_own_losses(std::span<const JointLoss> losses) override {
    model_->opt.disableflags = disabled;
    for (std::size_t i = 0; i < dof_.size(); ++i) {
      model_->dof_damping[dof_[i]] = losses.empty() ? 0.0 : losses[i].damping;
      model_->dof_frictionloss[dof_[i]] = losses.empty() ? 0.0 : losses[i].friction;
    }
    if (losses.empty()) return;
    model_->opt.disableflags &= ~(mjDSBL_CONSTRAINT | mjDSBL_FRICTIONLOSS | mjDSBL_PASSIVE);
    reserve_constraints();
    derive_constants();
  }

  void do_set_gravity(const Eigen::Vector3d& gravity) override {
    Eigen::Map<Eigen::Vector3d>(model_->opt.gravity) = gravity;
  }

  // The part of mj_forward that rigid-body dynamics needs; the rest (actuators, constraints, sensors) is off anyway.
  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    place(q);
    move(v);
    mj_crb(model_.get(), data_.get());
    mj_factorM(model_.get(), data_.get());
    mj_rne(model_.get(), data_.get(), 0, data_->qfrc_bias);
    for (std::size_t i = 0; i < dof_.size(); ++i) data_->qfrc_smooth[dof_[i]] = tau[i] - data_->qfrc_bias[dof_[i]];
    mj_solveM(model_.get(), data_.get(), data_->qacc, data_->qfrc_smooth, 1);
    gather(data_->qacc, a);
  }

  void do_inverse_dynamics(const double* q, const double* v, const double* a, double* tau) override {
    place(q);
    move(v);
    scatter(a, data_->qacc);
    mj_rne(model_.get(), data_.get(), 1, data_->qfrc_inverse);
    gather(data_->qfrc_inverse, tau);
  }

  void do_mass_matrix(const double* q, Eigen::MatrixXd& mass) override {
    place(q);
    mj_crb(model_.get(), data_.get());
    full_.resize(dof_.size() * dof_.size());
    mj_fullM(model_.get(), full_.data(), data_->qM);
    const Eigen::Map<const Eigen::MatrixXd> ordered(full_.data(), dof(), dof());
    mass = ordered(dof_, dof_);
  }

  void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) override {
    scatter(q, data_->qpos);
    mj_kinematics(model_.get(), data_.get());
    for (std::size_t i = 0; i < body_.size(); ++i) {
      using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
      poses[i].linear() = Eigen::Map<const Rotation>(data_->xmat + 9 * body_[i]);
      poses[i].translation() = Eigen::Map<const Eigen::Vector3d>(data_->xpos + 3 * body_[i]);
      poses[i].makeAffine();
    }
  }

  Energy do_energy(const double* q, const double* v) override {
    place(q);
    move(v);
    mj_crb(model_.get(), data_.get());
    model_->opt.enableflags = mjENBL_ENERGY;  // else both are zero; off again, since steps would compute it too
    mj_energyPos(model_.get(), data_.get());
    mj_energyVel(model_.get(), data_.get());
    model_->opt.enableflags = 0;
    return {data_->energy[1], data_->energy[0]};
  }

  void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) override {
    model_->opt.integrator = integrator_code(integrator);
    model_->opt.timestep = step;
    data_->time = 0.0;
    scatter(q, data_->qpos);
    scatter(v, data_->qvel);
    scatter(tau, data_->qfrc_applied);
    mju_zero(data_->qacc_warmstart, model_->nv);
    std::memset(data_->warning, 0, sizeof data_->warning);
    const bool lost = model_->opt.integrator == mjINT_IMPLICIT && !positive_definite(q);
    if (!lost) mj_step(model_.get(), data_.get());
    gather(data_->qpos, q);
    gather(data_->qvel, v);
    if (lost || diverged()) {
      std::fill_n(q, dof(), std::numeric_limits<double>::quiet_NaN());
      std::fill_n(v, dof(), std::numeric_limits<double>::quiet_NaN());
    }
  }

 private:
  void make_data() {
    data_.reset(mj_makeData(model_.get()));
    if (!data_) throw WorkError("mujoco cannot hold robot " + quoted(robot().name()) + ": no memory for its state");
  }

  bool own_losses() const { return (model_->opt.disableflags & mjDSBL_PASSIVE) == 0; }

  // The compiler counted on no constraint: one row a joint, and what the solver keeps on the stack for them.
  void reserve_constraints() {
    const int rows = model_->nv + 8, stack = 64 * rows * rows + 4096 * rows;
    if (model_->njmax >= rows && model_->nstack >= stack) return;
    model_->njmax = std::max(model_->njmax, rows);
    model_->nstack = std::max(model_->nstack, stack);
    make_data();
  }

  void derive_constants() { mj_setConst(model_.get(), data_.get()); }

  static int integrator_code(const std::string& name) {
    for (const Integrator& known : integrators) {
      if (name == known.name) return known.code;
    }
    throw std::invalid_argument("mujoco: integrator " + quoted(name) + ", expected euler, rk4 or implicit");
  }

  // MuJoCo wants the inertia along its principal axes, in a frame of its own at the centre of mass.
  void write_inertial(int body, const Inertial& inertial) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertial.inertia);
    Eigen::Matrix3d axes = principal.eigenvectors();
    if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
    const Eigen::Quaterniond turn(axes);
    const int id = body_[body];
    model_->body_mass[id] = inertial.mass;
    Eigen::Map<Eigen::Vector3d>(model_->body_ipos + 3 * id) = inertial.com;
    Eigen::Map<Eigen::Vector3d>(model_->body_inertia + 3 * id) = principal.eigenvalues().cwiseMax(0.0);
    Eigen::Map<Eigen::Vector4d>(model_->body_iquat + 4 * id) << turn.w(), turn.x(), turn.y(), turn.z();
  }

  // Of what mj_setConst derives from masses the smooth dynamics reads only the subtree masses.
  void sum_subtrees() {
    mju_copy(model_->body_subtreemass, model_->body_mass, model_->nbody);
    for (int id = model_->nbody - 1; id > 0; --id) {
      model_->body_subtreemass[model_->body_parentid[id]] += model_->body_subtreemass[id];
    }
  }

  void place(const double* q) {
    scatter(q, data_->qpos);
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
  }
  void move(const double* v) {
    scatter(v, data_->qvel);
    mj_comVel(model_.get(), data_.get());
  }

  // The implicit integrator ends the program where a joint moves no inertia; the plain factorization only warns.
  bool positive_definite(const double* q) {
    place(q);
    mj_crb(model_.get(), data_.get());
    mj_factorM(model_.get(), data_.get());
    return data_->warning[mjWARN_INERTIA].number == 0;
  }

  // mj_step answers numbers that are not finite (or beyond 1e10) by going back to q = 0, and counts a warning.
  bool diverged() const {
    return data_->warning[mjWARN_BADQPOS].number + data_->warning[mjWARN_BADQVEL].number +
               data_->warning[mjWARN_BADQACC].number >
           0;
  }

  // MuJoCo numbers bodies and joints depth first; every joint has one number in qpos and the same one in qvel.
  void scatter(const double* ours, mjtNum* theirs) const {
    for (std::size_t i = 0; i < dof_.size(); ++i) theirs[dof_[i]] = ours[i];
  }
  void gather(const mjtNum* theirs, double* ours) const {
    for (std::size_t i = 0; i < dof_.size(); ++i) ours[i] = theirs[dof_[i]];
  }

  ModelPtr model_;
  DataPtr data_;
  std::vector<int> body_, dof_;  // MuJoCo's numbers of our bodies and joints
  std::vector<double> full_;
};

class MujocoEngine final : public Engine {
 public:
  EngineInfo info() const override {
    EngineInfo info;
    info.name = "mujoco";
    info.version = mj_versionString();
    info.available = true;
    info.capabilities = {
        {"forward_dynamics", true, "composite-rigid-body inertia, factored sparsely, and recursive Newton-Euler"},
        {"inverse_dynamics", true, "recursive Newton-Euler"},
        {"mass_matrix", true, "composite-rigid-body algorithm"},
        {"inertials_in_place", true, "written into the compiled model, nothing is rebuilt"},
        {"gravity_in_place", true, "nothing is rebuilt"},
    };
    info.own_models = {
        {"joint damping", "effort -b v, implicit under the Euler integrator (M + h b); off: mjDSBL_PASSIVE, b = 0"},
        {"friction loss",
         "a constraint of bounded effort, softened by solref and solimp, so that a stuck joint creeps; off: "
         "mjDSBL_FRICTIONLOSS"},
        {"joint limits", "one-sided constraints, softened by solref and solimp; off: mjDSBL_LIMIT"},
        {"armature", "added to the diagonal of M; 0 here"},
    };
    info.own_losses = true;
    for (const Integrator& integrator : integrators) info.native_integrators.emplace_back(integrator.name);
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const override {
    return std::make_unique<MujocoDynamics>(std::move(robot), gravity);
  }
};

}  // namespace

const Engine& mujoco_engine() {
  static const MujocoEngine engine;
  return engine;
}

}  // namespace lacuna
