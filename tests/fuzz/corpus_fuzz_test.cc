// What the guided fuzzer (scripts/fuzz) found worth keeping, and every input that once broke a loader: loading it
// succeeds or throws InputError, in every build.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/fuzz/loaders.h"

namespace lacuna::test {
namespace {

namespace fs = std::filesystem;
const fs::path kCorpus = fs::path(LACUNA_SOURCE_DIR) / "tests/fuzz/corpus";

class Corpus : public testing::TestWithParam<std::string> {};

TEST_P(Corpus, IsTakenOrRefusedInOneLine) {
  const Loader& one = loader(GetParam());
  for (const std::string& seed : one.seeds()) EXPECT_EQ(fault_of(one, seed), "") << "a seed";
  if (!fs::exists(kCorpus / one.name)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(kCorpus / one.name))
    EXPECT_EQ(fault_of(one, read(entry.path())), "") << entry.path();
}

/// A seed that is refused would be a poor beginning.
TEST_P(Corpus, SeedsAreTaken) {
  const Loader& one = loader(GetParam());
  for (const std::string& seed : one.seeds()) EXPECT_NO_THROW(loads(one, seed)) << seed.substr(0, 200);
}

INSTANTIATE_TEST_SUITE_P(Loaders, Corpus, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const Loader& one : loaders()) names.push_back(one.name);
                           return names;
                         }()),
                         [](const auto& one) { return one.param; });

/// Every folder is some loader's.
TEST(CorpusFolders, HaveALoaderEach) {
  ASSERT_TRUE(fs::exists(kCorpus)) << "nothing would be replayed";
  for (const fs::directory_entry& entry : fs::directory_iterator(kCorpus))
    EXPECT_NO_THROW(loader(entry.path().filename().string())) << entry.path();
}

}  // namespace
}  // namespace lacuna::test
