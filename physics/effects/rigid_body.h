#pragma once

#include <algorithm>

#include "physics/catalogue.h"
#include "physics/pseudo_inertia.h"

namespace lacuna {

/// The body that a joint moves is another one than the URDF says: the URDF's, deformed. All ten inertial parameters may
/// change, and whatever the numbers are, the body stays one that matter can make. With the matrix U below in the body's
/// frame, mass' = exp(2 alpha) mass, centre of mass' = A c + t with A the upper left 3x3 of U/exp(alpha), and the
/// inertia follows the deformation. Neutral at zero. com_shift is t alone.
struct RigidBody {
  static EffectInfo info() {
    EffectInfo info{
        "rigid_body",
        "Link's mass properties",
        Where::joint,
        Stage::link,
        "P -> U P U^T, P the link's pseudo-inertia, U = exp(alpha) [[exp(d1), s12, s13, t1], [0, exp(d2), s23, t2], "
        "[0, 0, exp(d3), t3], [0, 0, 0, 1]]",
        "gravity and inertia pattern of one link",
        "masses, com_shift, armature",
        "C. Rucker and P. M. Wensing, Smooth parameterization of rigid-body inertia, IEEE RA-L 7 (2022)",
        {size("alpha", "half the logarithm of mass over the URDF's"), size("d1", "logarithm of the stretch along x"),
         size("d2", "logarithm of the stretch along y"), size("d3", "logarithm of the stretch along z"),
         size("s12", "shear of x by y"), size("s23", "shear of y by z"), size("s13", "shear of x by z"),
         shift("t1", "shift along x"), shift("t2", "shift along y"), shift("t3", "shift along z")}};
    info.in_efforts = true;
    info.as_one = true;
    return info;
  }
  static void inertials(const double* p, const Robot&, int joint, std::vector<Inertial>& bodies) {
    if (std::all_of(p, p + kCount, [](double x) { return x == 0.0; })) return;
    Inertial& body = bodies[joint];
    const Eigen::Matrix4d U = deformation(p);
    body = from_pseudo_inertia(U * pseudo_inertia(body) * U.transpose());
  }

 private:
  enum { kAlpha, kD1, kD2, kD3, kS12, kS23, kS13, kT1, kT2, kT3, kCount };
  static ParameterInfo size(const char* name, const char* meaning) {
    constexpr double kMost = 5.0;  // 150-fold: no arm is off by more
    return {name, "1", 0.0, -kMost, kMost, meaning, Scale::ratio, {0.05}};
  }
  static ParameterInfo shift(const char* name, const char* meaning) {
    return {name, "m", 0.0, -10.0, 10.0, meaning, Scale::length, {0.1}};
  }
  static Eigen::Matrix4d deformation(const double* p) {
    Eigen::Matrix4d U;
    U << std::exp(p[kD1]), p[kS12], p[kS13], p[kT1],  //
        0.0, std::exp(p[kD2]), p[kS23], p[kT2],       //
        0.0, 0.0, std::exp(p[kD3]), p[kT3],           //
        0.0, 0.0, 0.0, 1.0;
    return std::exp(p[kAlpha]) * U;
  }
};

}  // namespace lacuna
