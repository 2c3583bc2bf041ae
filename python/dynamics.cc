// Engines as acceleration oracles, many states a call.
#include <fmt/format.h>

#include "backends/engine.h"
#include "scenarios/error.h"
#include "scenarios/mjcf.h"
#include "python/convert.h"
#include "python/room.h"

namespace lacuna {
namespace {

py::dict as_dict(const EngineInfo& info) {
  py::dict capabilities;
  for (const Capability& one : info.capabilities) {
    py::dict what;
    what["native"] = one.native;
    what["words"] = one.words;
    capabilities[py::str(one.name)] = what;
  }
  py::dict out;
  out["name"] = info.name;
  out["version"] = info.version;
  out["available"] = info.available;
  out["reason"] = info.reason;
  out["capabilities"] = capabilities;
  out["native_integrators"] = info.native_integrators;
  return out;
}

py::list engine_list() {
  py::list out;
  for (const Engine* engine : engines()) out.append(as_dict(engine->info()));
  return out;
}

py::list joint_list(const Robot& robot) {
  py::list out;
  for (const Joint& joint : robot.joints()) {
    py::dict one;
    one["name"] = joint.name;
    one["type"] = joint.type == JointType::prismatic    ? "prismatic"
                  : joint.type == JointType::continuous ? "continuous"
                                                        : "revolute";
    one["parent"] = joint.parent;
    one["lower"] = joint.lower;
    one["upper"] = joint.upper;
    out.append(one);
  }
  return out;
}

/// One robot in one engine. A call takes one state, arrays of dof numbers, or several, arrays of shape (n, dof).
class PythonDynamics {
 public:
  PythonDynamics(const std::string& engine, std::shared_ptr<Robot> robot, const Eigen::Vector3d& gravity)
      : dynamics_(find_engine(engine).build(std::move(robot), gravity)) {}

  Array forward_dynamics(const Array& q, const Array& v, const Array& tau) {
    return each({&q, &v, &tau}, [&](auto in, auto out) { dynamics_->forward_dynamics(in[0], in[1], in[2], out); });
  }
  Array inverse_dynamics(const Array& q, const Array& v, const Array& a) {
    return each({&q, &v, &a}, [&](auto in, auto out) { dynamics_->inverse_dynamics(in[0], in[1], in[2], out); });
  }

  Array mass_matrix(const Array& q) {
    Eigen::MatrixXd mass;
    dynamics_->mass_matrix(span_of(q), mass);
    Array out({dof(), dof()});
    auto entries = out.mutable_unchecked<2>();
    for (py::ssize_t r = 0; r < dof(); ++r)
      for (py::ssize_t c = 0; c < dof(); ++c) entries(r, c) = mass(r, c);
    return out;
  }

  /// (dof, 4, 4)
  Array body_poses(const Array& q) {
    std::vector<Eigen::Isometry3d> poses;
    dynamics_->body_poses(span_of(q), poses);
    Array out({dof(), py::ssize_t{4}, py::ssize_t{4}});
    auto entries = out.mutable_unchecked<3>();
    for (py::ssize_t i = 0; i < dof(); ++i)
      for (py::ssize_t r = 0; r < 4; ++r)
        for (py::ssize_t c = 0; c < 4; ++c) entries(i, r, c) = poses[i].matrix()(r, c);
    return out;
  }

  py::dict energy(const Array& q, const Array& v) {
    const Energy energy = dynamics_->energy(span_of(q), span_of(v));
    py::dict out;
    out["kinetic"] = energy.kinetic;
    out["potential"] = energy.potential;
    return out;
  }

  py::tuple step(const std::string& integrator, const Array& q, const Array& v, const Array& tau, double seconds) {
    std::vector<double> next_q(q.data(), q.data() + q.size()), next_v(v.data(), v.data() + v.size());
    dynamics_->native_step(integrator, next_q, next_v, span_of(tau), seconds);
    return py::make_tuple(array_of(next_q), array_of(next_v));
  }

  void set_inertial(int body, double mass, const Eigen::Vector3d& com, const Eigen::Matrix3d& inertia) {
    dynamics_->set_inertial(body, {mass, com, inertia});
  }
  void set_gravity(const Eigen::Vector3d& gravity) { dynamics_->set_gravity(gravity); }

 private:
  py::ssize_t dof() const { return dynamics_->dof(); }

  /// `call(rows, out)` for every row of three arrays of one shape, (dof) or (n, dof).
  template <class Call>
  Array each(const std::array<const Array*, 3>& in, const Call& call) {
    const Array& first = *in.front();
    for (const Array* array : in) {
      const bool alike = array->ndim() == first.ndim() && array->size() == first.size();
      if (!alike || array->ndim() < 1 || array->ndim() > 2 || array->shape(array->ndim() - 1) != dof())
        throw py::value_error(fmt::format("states have one shape, ({0},) or (n, {0})", dof()));
    }
    Array out(std::vector<py::ssize_t>(first.shape(), first.shape() + first.ndim()));
    const std::size_t n = dof();
    const std::size_t rows = static_cast<std::size_t>(first.size()) / n;
    double* const written = out.mutable_data();
    for (std::size_t k = 0; k < rows; ++k) {
      std::array<std::span<const double>, 3> row;
      for (std::size_t i = 0; i < 3; ++i) row[i] = span_of(*in[i]).subspan(k * n, n);
      call(row, std::span<double>(written + k * n, n));
    }
    return out;
  }

  std::unique_ptr<Dynamics> dynamics_;
};

Eigen::Vector3d vector_of(const std::array<double, 3>& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

std::shared_ptr<Robot> robot_of(const std::filesystem::path& file) {
  return std::const_pointer_cast<Robot>(read_robot_file(file).robot);  // nothing bound here changes it
}

void add_robot(py::module_& module) {
  py::class_<Robot, std::shared_ptr<Robot>>(
      module, "Robot",
      "A tree of rigid bodies, read from a URDF or MJCF file; of MJCF the mechanism alone (a Scenario takes its "
      "drives, too).")
      .def(py::init(&robot_of), py::arg("file"))
      .def(py::init(&robot_of), py::arg("urdf"))  // its name before MJCF was read
      .def_property_readonly("name", &Robot::name)
      .def_property_readonly("dof", &Robot::dof)
      .def_property_readonly("joints", &joint_list, "List of dicts: name, type, parent, lower, upper (rad, m).")
      .def_property_readonly("moving_mass", &Robot::moving_mass, "kg");
}

}  // namespace

void add_dynamics(py::module_& module) {
  module.def("engines", &engine_list, "Every engine as a dict: name, version, available, reason, capabilities, ...");
  add_robot(module);
  py::class_<PythonDynamics>(module, "Dynamics",
                             "One robot in one engine. Not to be used by two threads at once. SI units.")
      .def(py::init([](const std::string& engine, const std::shared_ptr<Robot>& robot, std::array<double, 3> gravity) {
             return PythonDynamics(engine, robot, vector_of(gravity));
           }),
           py::arg("engine"), py::arg("robot"), py::arg("gravity") = std::array<double, 3>{0.0, 0.0, -9.81})
      .def("forward_dynamics", &PythonDynamics::forward_dynamics, py::arg("q"), py::arg("v"), py::arg("tau"),
           "Accelerations; arrays of shape (dof,) or (n, dof).")
      .def("inverse_dynamics", &PythonDynamics::inverse_dynamics, py::arg("q"), py::arg("v"), py::arg("a"),
           "Efforts, gravity included; arrays of shape (dof,) or (n, dof).")
      .def("mass_matrix", &PythonDynamics::mass_matrix, py::arg("q"))
      .def("body_poses", &PythonDynamics::body_poses, py::arg("q"), "World poses, (dof, 4, 4).")
      .def("energy", &PythonDynamics::energy, py::arg("q"), py::arg("v"), "Dict: kinetic, potential (J).")
      .def("step", &PythonDynamics::step, py::arg("integrator"), py::arg("q"), py::arg("v"), py::arg("tau"),
           py::arg("seconds"), "(q, v) after one step of the engine's own integrator.")
      .def(
          "set_inertial",
          [](PythonDynamics& self, int body, double mass, std::array<double, 3> com, const Array& inertia) {
            if (inertia.ndim() != 2 || inertia.shape(0) != 3 || inertia.shape(1) != 3)
              throw py::value_error("inertia has the shape (3, 3)");
            Eigen::Matrix3d matrix;
            for (int r = 0; r < 3; ++r)
              for (int c = 0; c < 3; ++c) matrix(r, c) = inertia.at(r, c);
            self.set_inertial(body, mass, vector_of(com), matrix);
          },
          py::arg("body"), py::arg("mass"), py::arg("com"), py::arg("inertia"),
          "kg; m and kg m^2 about the centre of mass, in the body's frame.")
      .def(
          "set_gravity",
          [](PythonDynamics& self, std::array<double, 3> gravity) { self.set_gravity(vector_of(gravity)); },
          py::arg("gravity"));
}

}  // namespace lacuna
