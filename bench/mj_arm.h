// The benchmarks' arm as a user of MuJoCo has it: the URDF loaded by MuJoCo itself.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>

namespace lacuna::bench {

inline constexpr int kJoints = 6;

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// Ends the program (3) where MuJoCo does not load it.
inline std::unique_ptr<mjModel, Deleter> arm_model() {
  std::array<char, 500> error{};
  std::unique_ptr<mjModel, Deleter> model(mj_loadXML(LACUNA_SOURCE_DIR "/scenarios/hydrolek/seed_table1.urdf", nullptr,
                                                     error.data(), static_cast<int>(error.size())));
  if (model && model->nv == kJoints) return model;
  std::fprintf(stderr, "no arm of %d joints: %s\n", kJoints, error.data());
  std::exit(3);
}

}  // namespace lacuna::bench
