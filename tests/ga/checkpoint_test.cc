#include "ga/checkpoint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "tests/ga/test_problems.h"

namespace lacuna {
namespace {

using test::infinity;

RunIdentity some_identity() { return {"tester", {{"seed", "1"}, {"rate", exact_text(0.05)}}, {{0}, {1}, {"x"}}, "p"}; }

Checkpoint some_checkpoint() {
  return {.best = {0.1, -0.0, 5e-324},
          .best_cost = 1.0 / 3.0,
          .evaluations = 123456789012,
          .history = {{.1, .2, .3, .4, 70, 1.5}, {.1, infinity, infinity, 0.0, 130, 2.5}},
          .population = {{0, 65535}, {1, 2}},
          .costs = {std::numeric_limits<double>::max(), infinity}};
}

std::string contents(const std::filesystem::path& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

std::string refusal(const std::filesystem::path& file, const RunIdentity& identity) {
  try {
    load_checkpoint(file, identity);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Checkpoint, ReadsBackToTheSameBits) {
  const test::TemporaryFolder folder;
  const auto file = folder / "run.json";
  const auto saved = some_checkpoint();
  save_checkpoint(file, some_identity(), saved);
  const auto loaded = load_checkpoint(file, some_identity());
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->best, saved.best);
  EXPECT_TRUE(std::signbit(loaded->best[1]));
  EXPECT_EQ(loaded->best_cost, saved.best_cost);
  EXPECT_EQ(loaded->evaluations, saved.evaluations);
  EXPECT_EQ(loaded->population, saved.population);
  EXPECT_EQ(loaded->costs, saved.costs);
  ASSERT_EQ(loaded->history.size(), 2u);
  EXPECT_EQ(loaded->history[1].median, infinity);
  EXPECT_EQ(loaded->history[1].evaluations, 130);
  EXPECT_EQ(loaded->history[1].seconds, 2.5);
}

TEST(Checkpoint, OfAFileThatIsNotThereIsNothing) {
  const test::TemporaryFolder folder;
  EXPECT_FALSE(load_checkpoint(folder / "none.json", some_identity()));
  EXPECT_NO_THROW(remove_checkpoint(folder / "none.json"));
}

TEST(Checkpoint, LeavesNoOtherFileBehindAndIsRemovable) {
  const test::TemporaryFolder folder;
  const auto file = folder / "run.json";
  save_checkpoint(file, some_identity(), some_checkpoint());
  save_checkpoint(file, some_identity(), some_checkpoint());
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(file.parent_path())) ++files;
  EXPECT_EQ(files, 1);
  remove_checkpoint(file);
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(Checkpoint, CutAtAnyPlaceIsRefusedAsDamaged) {
  const test::TemporaryFolder folder;
  const auto file = folder / "run.json";
  save_checkpoint(file, some_identity(), some_checkpoint());
  const std::string whole = contents(file);
  for (std::size_t length = 0; length + 2 < whole.size(); length += 7) {
    write(file, whole.substr(0, length));
    ASSERT_NE(refusal(file, some_identity()), "") << length;
  }
}

TEST(Checkpoint, WithAnyChangedCharacterIsRefusedOrUnchangedInMeaning) {
  const test::TemporaryFolder folder;
  const auto file = folder / "run.json";
  save_checkpoint(file, some_identity(), some_checkpoint());
  const std::string whole = contents(file);
  for (std::size_t i = 0; i + 1 < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = changed[i] == '7' ? '8' : '7';
    write(file, changed);
    ASSERT_NE(refusal(file, some_identity()), "") << "character " << i;
  }
}

TEST(Checkpoint, OfAnotherRunIsRefusedNamingWhatDiffers) {
  const test::TemporaryFolder folder;
  const auto file = folder / "run.json";
  save_checkpoint(file, some_identity(), some_checkpoint());
  EXPECT_EQ(refusal(file, some_identity()), "");
  auto other = some_identity();
  other.options[0].second = "2";
  EXPECT_NE(refusal(file, other).find("seed"), std::string::npos);
  other = some_identity();
  other.box.upper[0] = std::nextafter(1.0, 2.0);
  EXPECT_NE(refusal(file, other).find("upper bounds"), std::string::npos);
  other = some_identity();
  other.problem = "q";
  EXPECT_NE(refusal(file, other).find("problem"), std::string::npos);
  other = some_identity();
  other.optimizer = "somebody";
  EXPECT_NE(refusal(file, other).find("optimizer"), std::string::npos);
}

TEST(Checkpoint, ThatIsAnythingElseIsRefused) {
  const test::TemporaryFolder folder;
  const auto file = folder / "run.json";
  for (const std::string text : {"", "null", "[]", "7", "{}", "time,joint_1\n0,1\n", "{\"format\": 3}", "\xff\xfe\x00",
                                 R"({"format": "lacuna-optimizer-checkpoint/1", "checksum": "", "content": {}})"}) {
    write(file, text);
    EXPECT_NE(refusal(file, some_identity()), "") << text;
  }
  write(file, std::string(100000, '['));
  EXPECT_NE(refusal(file, some_identity()), "");
  EXPECT_NE(refusal(file.parent_path(), some_identity()), "") << "a folder";
}

TEST(Checkpoint, ThatCannotBeWrittenSaysWhere) {
  const test::TemporaryFolder folder;
  try {
    write(folder / "file", "no folder");
    save_checkpoint(folder / "file/run.json", some_identity(), some_checkpoint());
    FAIL();
  } catch (const WriteError& error) {
    EXPECT_NE(std::string(error.what()).find("file/run.json"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("Not a directory"), std::string::npos);
  }
}

}  // namespace
}  // namespace lacuna
