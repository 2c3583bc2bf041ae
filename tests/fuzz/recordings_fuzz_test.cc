// Mutated databases of bags and MATLAB 7.3 files, changed where their structure stands: loading them succeeds or throws
// InputError.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/fuzz/mutants.h"

namespace lacuna {
namespace {

using test::kFileMutants;
using test::Loader;
using test::loader;
using test::Mutator;
using test::survives;

TEST(FuzzRecordings, BagDatabases) {
  const Loader& one = loader("db3");
  const std::vector<std::string> valid = one.seeds();
  Mutator mutate(one.tokens, 12);
  for (int i = 0; i < kFileMutants; ++i) {
    // Most of a database's structure stands at the beginning of its pages.
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    const std::size_t page = 4096 * (static_cast<std::size_t>(i / 2) % (origin.size() / 4096));
    const std::string mutant =
        i % 3 == 0 ? mutate(origin)
                   : origin.substr(0, page) + mutate(origin.substr(page, 64)) + origin.substr(page + 64);
    if (!survives(one, mutant)) break;
  }
}

/// Version 7.3: read by a process of its own, which may end as it likes.
TEST(FuzzRecordings, Hdf5MatFiles) {
  const Loader& one = loader("mat73");
  const std::vector<std::string> valid = one.seeds();
  Mutator mutate(one.tokens, 15);
  for (int i = 0; i < kFileMutants / 3; ++i) {
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    // Behind MATLAB's 512 bytes; half of the mutants keep the length, on which HDF5's addresses rest.
    std::string mutant = mutate(origin.substr(512));
    if (i % 4 < 2) mutant.resize(origin.size() - 512, '\0');
    if (!survives(one, origin.substr(0, 512) + mutant)) break;
  }
}

}  // namespace
}  // namespace lacuna
