// kill -9 at any moment: the same command resumes, and leaves the files of a run that nobody disturbed. A few moments
// here; scripts/kill_test tries many.
#include <chrono>
#include <random>
#include <regex>
#include <thread>

#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kKills = 4;

/// A report without what the clock says: its date and its durations.
std::string without_clock_text(const std::string& page) {
  static const std::regex clock(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ|[\d.]+ (ms|s|min|h)( of computing)?</(dd|td)>)");
  return std::regex_replace(page, clock, "");
}

/// Everything below the folder, by name.
std::map<std::string, std::string> results_of(const fs::path& folder) {
  std::map<std::string, std::string> out;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::string text = text_of(entry.path());
    if (entry.path().extension() == ".json") text = without_clock(nlohmann::json::parse(text)).dump();
    if (entry.path().extension() == ".html") text = without_clock_text(text);
    out[fs::relative(entry.path(), folder).string()] = std::move(text);
  }
  return out;
}

struct Command {
  const char* name;
  std::vector<std::string> arguments;  ///< ARM stands for the scenario, CASES for a folder of two cases
};

class Killed : public testing::TestWithParam<Command> {
 protected:
  std::vector<std::string> line() {
    std::vector<std::string> out = GetParam().arguments;
    for (std::string& word : out) {
      if (word == "ARM") word = arm_.scenario();
      if (word == "CASES") word = cases().string();
    }
    out.insert(out.end(), {"-o", "out"});
    return out;
  }

  fs::path folder(const std::string& name) const {
    fs::remove_all(arm_.folder() / name);
    fs::create_directories(arm_.folder() / name);
    return arm_.folder() / name;
  }

 private:
  fs::path cases() const {
    const fs::path out = arm_.folder() / "cases";
    for (const char* name : {"a", "b"}) {
      fs::create_directories(out / name);
      for (const char* file : {"scenario.yaml", "arm.urdf", "train.csv", "validate.csv", "test.csv"})
        fs::copy_file(arm_.folder() / file, out / name / file, fs::copy_options::overwrite_existing);
    }
    return out;
  }

  Arm arm_;
};

/// Whether the run was still going on at the moment.
bool killed_after(const std::vector<std::string>& arguments, const fs::path& folder, Clock::duration moment) {
  Program program(arguments, folder);
  std::this_thread::sleep_for(moment);
  const bool running = program.running();
  program.kill();
  program.wait();
  return running;
}

TEST_P(Killed, ItResumesToTheSameFiles) {
  const std::vector<std::string> arguments = line();
  const fs::path whole = folder("whole");
  const auto began = Clock::now();
  const Outcome undisturbed = lacuna(arguments, whole);
  ASSERT_EQ(undisturbed.code, 0) << undisturbed.err;
  const std::chrono::duration<double> seconds = Clock::now() - began;
  const auto expected = results_of(whole);
  std::mt19937 draw(7);
  int killed = 0;
  for (int k = 0; k < kKills; ++k) {
    const fs::path parts = folder("parts");
    const double share = (k + static_cast<double>(draw()) / static_cast<double>(std::mt19937::max())) / kKills;
    const auto moment = std::chrono::duration_cast<Clock::duration>(share * seconds);
    killed += killed_after(arguments, parts, moment) ? 1 : 0;
    const Outcome resumed = lacuna(arguments, parts);
    ASSERT_EQ(resumed.code, 0) << resumed.err;
    const auto left = results_of(parts);
    EXPECT_EQ(left.size(), expected.size());
    for (const auto& [name, text] : left) EXPECT_TRUE(expected.count(name) && expected.at(name) == text) << name;
  }
  EXPECT_GT(killed, 0) << "always done before the kill";
}

INSTANTIATE_TEST_SUITE_P(
    Commands, Killed,
    testing::Values(
        Command{"identify", {"identify", "ARM", "--no-pictures", "--population", "20", "--generations", "60"}},
        Command{"diagnose",
                {"diagnose", "ARM", "--no-engines", "--no-pictures", "--population", "20", "--generations", "5"}},
        Command{"study",
                {"study", "ARM", "--parts", "grid", "--seeds", "2", "--population", "14", "--generations", "10"}},
        Command{"blind", {"blind", "CASES", "--quick"}}),
    [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace lacuna::test
