// `mpirun -n 2 lacuna ...`: the same bits, one output, and an end to the whole job when a rank dies or is interrupted.
#include "physics/ranks.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

const std::vector<std::string> kTwoRanks{"mpirun", "-n", "2"};

class Job : public testing::Test {
 protected:
  void SetUp() override {
    const RanksInfo info = ranks_info();
    if (info.version.empty()) GTEST_SKIP() << info.reason;
    if (std::system("command -v mpirun >/dev/null") != 0) GTEST_SKIP() << "no mpirun in PATH (openmpi-bin)";
    // Open MPI as it must be told in a container: run by root, more ranks than CPUs, no reading of a neighbour's
    // memory.
    for (const char* setting :
         {"OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "OMPI_MCA_rmaps_base_oversubscribe"})
      ::setenv(setting, "1", 1);
    ::setenv("OMPI_MCA_btl", "self,vader", 1);
    ::setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 1);
    ::setenv("OMPI_MCA_hwloc_base_binding_policy", "none", 1);
    // In a sanitized build: what MPI keeps until the end is not ours; runs without it look for leaks.
    ::setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
  }

  Outcome run(const std::vector<std::string>& arguments) const { return Program(arguments, {}, kTwoRanks).wait(); }

  std::vector<std::string> identify(const fs::path& out, int generations = 10) const {
    return {"identify",
            arm_.scenario(),
            "-o",
            out.string(),
            "--population",
            "20",
            "--generations",
            std::to_string(generations),
            "--no-pictures",
            "--threads",
            "1"};
  }

  Arm arm_;
};

/// Of the launcher's two children the one that is rank 1; 0 if there is none (any more).
pid_t second_rank(pid_t launcher) {
  const std::string id = std::to_string(launcher);
  std::ifstream children("/proc/" + id + "/task/" + id + "/children");
  for (pid_t child = 0; children >> child;) {
    std::ifstream in("/proc/" + std::to_string(child) + "/environ", std::ios::binary);
    const std::string environment(std::istreambuf_iterator<char>(in), {});
    if (environment.find("OMPI_COMM_WORLD_RANK=1") != std::string::npos) return child;
  }
  return 0;
}

/// Does `harm` to the launcher's process once there is a checkpoint. Empty if the job was done before.
std::optional<Outcome> harmed_run(const std::vector<std::string>& arguments, const fs::path& checkpoint,
                                  const std::function<void(const Program&)>& harm) {
  Program program(arguments, {}, kTwoRanks);
  while (program.running() && !fs::exists(checkpoint)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (!program.running()) return std::nullopt;
  harm(program);
  const Outcome outcome = program.wait();
  return outcome.code == 0 ? std::nullopt : std::optional(outcome);
}

TEST_F(Job, IdentifiesToTheSameBitsAndSpeaksOnce) {
  const fs::path alone = arm_.folder() / "alone", shared = arm_.folder() / "shared";
  ASSERT_EQ(lacuna(identify(alone)).code, 0);
  std::vector<std::string> line = identify(shared);
  line.emplace_back("--json");
  const auto printed = json_of(run(line));  // one document, not two
  EXPECT_EQ(numbers_of(alone / "fit.json"), numbers_of(shared / "fit.json"));
  EXPECT_EQ(json_file(alone / "fit.json").at("context").at("ranks"), 1);
  EXPECT_EQ(json_file(shared / "fit.json").at("context").at("ranks"), 2);
  EXPECT_EQ(printed, json_file(shared / "fit.json"));
  EXPECT_FALSE(fs::exists(shared / "checkpoint.json"));
}

TEST_F(Job, DiagnosesToTheSameBits) {
  const Arm arm({"elbow.gain=25", "elbow.damping=1.4", "elbow.coulomb_friction.Fc=4"});
  const auto line = [&](const std::string& out) {
    return std::vector<std::string>{"diagnose",
                                    arm.scenario(),
                                    "-o",
                                    (arm.folder() / out).string(),
                                    "--no-engines",
                                    "--no-pictures",
                                    "--population",
                                    "20",
                                    "--generations",
                                    "5",
                                    "--threads",
                                    "1"};
  };
  ASSERT_EQ(lacuna(line("alone")).code, 0);
  const Outcome shared = run(line("shared"));
  ASSERT_EQ(shared.code, 0) << shared.err;
  EXPECT_EQ(numbers_of(arm.folder() / "alone/diagnosis.json"), numbers_of(arm.folder() / "shared/diagnosis.json"));
}

TEST_F(Job, GivesTheSameVerdictsOnAFolderOfCasesAndDoesNotRepeatThem) {
  const auto line = [&](const fs::path& out) {
    return std::vector<std::string>{"blind",
                                    arm_.folder().string(),
                                    "-o",
                                    out.string(),
                                    "--no-engines",
                                    "--no-pictures",
                                    "--population",
                                    "20",
                                    "--generations",
                                    "5",
                                    "--threads",
                                    "1"};
  };
  const auto verdicts = [](const fs::path& out) {
    auto cases = json_file(out / "blind.json").at("cases");
    for (auto& one : cases) one.erase("seconds");
    return cases;
  };
  const TemporaryFolder results;
  const fs::path alone = results.path() / "alone", shared = results.path() / "shared";
  ASSERT_EQ(lacuna(line(alone)).code, 0);
  ASSERT_EQ(run(line(shared)).code, 0);
  EXPECT_EQ(verdicts(alone), verdicts(shared));
  const fs::path name = arm_.folder().filename() / "diagnosis.json", verdict = shared / name;
  EXPECT_EQ(numbers_of(alone / name), numbers_of(verdict));
  const auto written = fs::last_write_time(verdict);
  ASSERT_EQ(run(line(shared)).code, 0);
  EXPECT_EQ(fs::last_write_time(verdict), written);
  EXPECT_EQ(verdicts(alone), verdicts(shared));
}

TEST_F(Job, StudiesToTheSameBits) {
  const auto line = [&](const std::string& name, const std::string& parts) {
    return std::vector<std::string>{"study",
                                    arm_.scenario(),
                                    "-o",
                                    (arm_.folder() / name).string(),
                                    "--parts",
                                    parts,
                                    "--population",
                                    "14",
                                    "--generations",
                                    "2",
                                    "--seeds",
                                    "2",
                                    "--threads",
                                    "1"};
  };
  const auto records = [&](const std::string& name) {
    return without_clock(json_file(arm_.folder() / name / "study.json").at("scenarios"));
  };
  ASSERT_EQ(lacuna(line("alone", "rivals")).code, 0);
  const Outcome shared = run(line("shared", "rivals"));
  ASSERT_EQ(shared.code, 0) << shared.err;
  EXPECT_EQ(records("alone"), records("shared"));
}

/// A rank that is killed ends the job; whatever number of ranks takes it up again comes to the same result.
TEST_F(Job, AKilledRankEndsItAndARerunResumes) {
  constexpr int kGenerations = 80;
  const fs::path whole = arm_.folder() / "whole", parts = arm_.folder() / "parts";
  ASSERT_EQ(lacuna(identify(whole, kGenerations)).code, 0);
  std::optional<Outcome> ended;
  for (int attempt = 0; attempt < 10 && !ended; ++attempt) {
    fs::remove_all(parts);
    ended = harmed_run(identify(parts, kGenerations), parts / "checkpoint.json", [](const Program& program) {
      const pid_t rank = second_rank(program.id());
      if (rank > 0) ::kill(rank, SIGKILL);  // 0 would mean this test as well
    });
  }
  ASSERT_TRUE(ended) << "always done before the signal";
  EXPECT_EQ(ended->out, "");
  EXPECT_THAT(ended->err, HasSubstr("lacuna: interrupted; the same command resumes from"));
  EXPECT_THAT(ended->err, HasSubstr("signal 9"));  // mpirun's own words on who died
  EXPECT_FALSE(fs::exists(parts / "fit.json"));
  const Outcome resumed = run(identify(parts, kGenerations));
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(numbers_of(parts / "fit.json"), numbers_of(whole / "fit.json"));
}

TEST_F(Job, AnInterruptionEndsItAndOneProcessResumes) {
  constexpr int kGenerations = 1200;  // mpirun takes a second or two to pass a signal on
  const fs::path whole = arm_.folder() / "whole", parts = arm_.folder() / "parts";
  ASSERT_EQ(lacuna(identify(whole, kGenerations)).code, 0);
  std::optional<Outcome> ended;
  for (int attempt = 0; attempt < 10 && !ended; ++attempt) {
    fs::remove_all(parts);
    ended = harmed_run(identify(parts, kGenerations), parts / "checkpoint.json",
                       [](const Program& program) { program.interrupt(); });
    if (fs::exists(parts / "fit.json")) ended.reset();  // done all the same; mpirun calls that a failure
  }
  ASSERT_TRUE(ended) << "always done before the signal";
  EXPECT_THAT(ended->err, HasSubstr("lacuna: interrupted; the same command resumes from"));
  ASSERT_EQ(lacuna(identify(parts, kGenerations)).code, 0);
  EXPECT_EQ(numbers_of(parts / "fit.json"), numbers_of(whole / "fit.json"));
}

TEST_F(Job, RefusesBadInputOnce) {
  const Outcome outcome = run({"identify", (arm_.folder() / "missing.yaml").string()});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.out, "");
  const std::string message = "lacuna: " + (arm_.folder() / "missing.yaml").string();
  const std::size_t first = outcome.err.find(message);
  EXPECT_NE(first, std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find(message, first + 1), std::string::npos) << outcome.err;
}

TEST_F(Job, OtherCommandsRunOnceAndNamesWhatRanksRunOn) {
  const Outcome outcome = run({"engines"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string sign = "ranks: " + ranks_info().version;
  const std::size_t first = outcome.out.find(sign);
  EXPECT_NE(first, std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find(sign, first + 1), std::string::npos) << outcome.out;
}

}  // namespace
}  // namespace lacuna::test
