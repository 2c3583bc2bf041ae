// A full disk, a folder that cannot be written, a closed standard output: one clear line, exit code 3, what was there
// before whole, and nothing half-written beside it.
#include <sys/wait.h>

#include <cstdlib>

#include "render/snapshot.h"
#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

struct Writer {
  const char* name;
  std::vector<std::string> arguments;  ///< below its folder the words ARM/... stand for the arm's files
  bool pictures = false;               ///< it draws
};

const std::vector<std::string> kSmall{"--population", "20", "--generations", "5"};

std::vector<std::string> with(std::vector<std::string> line, const std::vector<std::string>& more) {
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

const Writer kWriters[] = {
    {"simulate", {"simulate", "ARM/scenario.yaml"}},
    {"identify", with({"identify", "ARM/scenario.yaml", "--no-pictures"}, kSmall)},
    {"diagnose", with({"diagnose", "ARM/scenario.yaml", "--no-engines", "--no-pictures"}, kSmall)},
    {"study",
     {"study", "ARM/scenario.yaml", "--parts", "grid", "--seeds", "1", "--population", "14", "--generations", "2"}},
    {"compare", {"compare", "ARM/scenario.yaml", "--no-identify", "--no-pictures", "--engine", "featherstone"}},
    {"render", {"render", "ARM/scenario.yaml", "--engine", "featherstone"}, true},
    {"conceal", {"conceal", "ARM/scenario.yaml", "--engine", "featherstone"}},
    {"excite", {"excite", "ARM/scenario.yaml", "--population", "8", "--generations", "2", "--seconds", "4"}},
    {"init", {"init", "ARM/arm.urdf", "ARM/train.csv", "ARM/validate.csv", "ARM/test.csv", "--force"}},
    {"export", {"export", "ARM/scenario.yaml", "--format", "urdf"}},
    {"blind", {"blind", "ARM/cases", "--quick"}},
};

/// Runs `script` in a shell with the command's words as its arguments.
std::vector<std::string> shell(const std::string& script) { return {"sh", "-c", script, "sh"}; }

class Disk : public testing::TestWithParam<Writer> {
 protected:
  void SetUp() override {
    if (std::string reason; GetParam().pictures && !render_available(&reason)) GTEST_SKIP() << reason;
    const fs::path one = arm_.folder() / "cases/one";
    fs::create_directories(one);
    for (const char* file : {"scenario.yaml", "arm.urdf", "train.csv", "validate.csv", "test.csv"})
      fs::copy_file(arm_.folder() / file, one / file);
  }

  std::vector<std::string> line(const fs::path& out) const {
    std::vector<std::string> words = GetParam().arguments;
    for (std::string& word : words)
      if (word.starts_with("ARM/")) word = (arm_.folder() / word.substr(4)).string();
    words.insert(words.end(), {"-o", out.string()});
    return words;
  }

  Outcome run(const fs::path& out, const std::vector<std::string>& launcher = {}) const {
    return Program(line(out), {}, launcher).wait();
  }

  Arm arm_;
};

/// The last line names what could not be written and why; the lines before it are notes.
void expect_not_written(const Outcome& outcome, const std::string& reason) {
  EXPECT_EQ(outcome.code, kNotDone) << outcome.err;
  const std::string text = outcome.err.substr(0, outcome.err.find_last_not_of('\n') + 1);
  const std::string last = text.substr(text.rfind('\n') + 1);
  EXPECT_THAT(last, testing::StartsWith("lacuna: cannot ")) << outcome.err;
  EXPECT_THAT(last, HasSubstr(reason));
}

std::map<std::string, std::string> files_below(const fs::path& folder) {
  std::map<std::string, std::string> out;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) out[fs::relative(entry.path(), folder).string()] = text_of(entry.path());
  return out;
}

/// Files may have one block and no more, which ends the writing of every larger one as a full disk does. (conceal has
/// to be given a new folder: it never writes over a case.)
TEST_P(Disk, FullLeavesWhatWasThereAndNothingElse) {
  const fs::path out = arm_.folder() / "out";
  const bool again = std::string(GetParam().name) != "conceal";
  if (again) {
    ASSERT_EQ(run(out).code, 0);
  }
  fs::create_directories(out);
  fs::remove(out / "one/input.txt");  // of blind: so that the case is diagnosed again
  const auto before = files_below(out);
  const Outcome full = run(out, shell("ulimit -f 1; exec \"$@\""));
  if (full.code == 0) {
    for (const auto& [name, text] : files_below(out)) EXPECT_LE(text.size(), 1024u) << name << " was written";
    return;
  }
  expect_not_written(full, "File too large");
  const auto after = files_below(out);
  for (const auto& [name, text] : before) {
    ASSERT_TRUE(after.count(name)) << name;
    EXPECT_TRUE(text.size() <= 1024 || after.at(name) == text) << name;
  }
  for (const auto& [name, text] : after) EXPECT_THAT(name, testing::Not(testing::HasSubstr(".part"))) << name;
  // With room again the same command does it, from what was kept.
  EXPECT_EQ(run(out).code, 0);
}

TEST_P(Disk, AFolderBelowAFileIsRefusedBeforeTheWork) {
  arm_.files().write("file", "no folder");
  const Outcome outcome = run(arm_.folder() / "file/out");
  expect_not_written(outcome, "Not a directory");
  EXPECT_EQ(text_of(arm_.folder() / "file"), "no folder");
}

/// In a mount namespace of its own, so that nothing is left of it.
std::string mounted(const std::string& options) {
  const std::string fill = options == "ro" ? "" : " && head -c 4096 /dev/zero >\"${0%/*}/other\"";
  return "mount -t tmpfs -o " + options + " lacuna \"${0%/*}\"" + fill + " && exec \"$@\"";
}

TEST_P(Disk, AFullOrReadOnlyFileSystemSaysSo) {
  if (std::system("unshare -rm true >/dev/null 2>&1") != 0) GTEST_SKIP() << "no mount namespaces for this user here";
  const fs::path out = arm_.folder() / "disk/out";
  fs::create_directories(out.parent_path());
  const auto on = [&](const std::string& options) {
    const std::string script = mounted(options);
    return run(out, {"unshare", "-rm", "sh", "-c", script, out.string()});
  };
  expect_not_written(on("size=4k"), "No space left on device");
  expect_not_written(on("ro"), "Read-only file system");
}

INSTANTIATE_TEST_SUITE_P(Commands, Disk, testing::ValuesIn(kWriters), [](const auto& one) { return one.param.name; });

TEST(StandardOutput, FullIsSaid) {
  const Arm arm;
  for (const std::vector<std::string>& line :
       {std::vector<std::string>{"simulate", arm.scenario()}, {"engines"}, {"effects"}, {"--help"}, {"--version"}}) {
    const Outcome outcome = Program(line, {}, shell("exec \"$@\" >/dev/full")).wait();
    expect_refused(outcome, kNotDone, "cannot write to standard output: No space left on device");
  }
}

}  // namespace
}  // namespace lacuna::test
