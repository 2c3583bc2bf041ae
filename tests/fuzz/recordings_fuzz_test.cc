// Mutated MATLAB 7.3 files: whatever one holds, loading it succeeds or throws InputError.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scenarios/recording.h"
#include "tests/fuzz/mutants.h"
#include "tests/scenarios/hdf5_mat_writer.h"

namespace lacuna {
namespace {

using test::Fuzz;
using test::kFileMutants;
using test::Mutator;
using test::read;
using test::survives;
using test::write;

/// Version 7.3: read by a process of its own, which may end as it likes.
TEST_F(Fuzz, Hdf5MatFiles) {
  const std::vector<std::string> tokens{std::string(8, '\0'),         std::string(8, '\xff'), "TREE", "SNOD", "HEAP",
                                        std::string("\x01\0\0\0", 4), "MATLAB_class",         "t",    "OHDR"};
  std::vector<std::string> valid;
  for (const bool packed : {false, true}) {
    {
      test::Hdf5MatWriter writer(folder_ / "run.mat");
      writer.vector<double>("t", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, 0.1, 0.2}, packed);
      if (packed) writer.vector<float>("q_1", MAT_C_SINGLE, MAT_T_SINGLE, {1, 2, 3}, packed);
      if (!packed) writer.structure("log", {{"q_1", {1, 2, 3}}, {"u_1", {4, 5, 6}}});
    }
    valid.push_back(read(folder_ / "run.mat"));
  }
  Mutator mutate(tokens, 15);
  for (int i = 0; i < kFileMutants / 3; ++i) {
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    // Behind MATLAB's 512 bytes; half of the mutants keep the length, on which HDF5's addresses rest.
    std::string mutant = mutate(origin.substr(512));
    if (i % 4 < 2) mutant.resize(origin.size() - 512, '\0');
    write(folder_ / "run.mat", origin.substr(0, 512) + mutant);
    if (!survives([&] { load_recording(folder_ / "run.mat", "run.mat"); }, "mutant " + std::to_string(i))) break;
  }
}

}  // namespace
}  // namespace lacuna
