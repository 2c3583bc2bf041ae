// A part of long recordings that is enough to search in.
#include "diagnosis/thinned.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

/// Train recordings of 40 s and 4 s, one each to validate and to test, in windows of 2 s.
Experiment windows() {
  Scenario truth = pendulum_scenario({}), scenario = pendulum_scenario({});
  scenario.prediction = Windows{2.0};
  const Start rest{{0.0}, {0.0}, false};
  const auto add = [&](const std::string& file, double seconds, Role role) {
    add_recording(scenario, simulated_recording(truth, rested_drive(seconds, 1.3), rest, "featherstone", file, 1e-3, 3),
                  role);
  };
  add("long.csv", 40.0, Role::train);
  add("short.csv", 4.0, Role::train);
  add("validate.csv", 20.0, Role::validate);
  add("test.csv", 20.0, Role::test);
  scenario.noise[ChannelKind::position]["swing"] = 1e-3;
  return make_experiment(scenario);
}

TEST(Thinned, KeepsTheSameShareOfEveryRecordingAndAllThatIsTested) {
  const Experiment all = windows();
  const std::size_t values = all.sample_count(Role::train);
  const Experiment some = thinned(all, values / 4);
  std::map<std::string, std::size_t> had, has;
  for (const Segment& s : all.segments) ++had[s.file];
  for (const Segment& s : some.segments) ++has[s.file];
  EXPECT_EQ(has["test.csv"], had["test.csv"]);
  EXPECT_EQ(has["short.csv"], 1u) << "none is left out whole";
  for (const char* file : {"long.csv", "validate.csv"})
    EXPECT_NEAR(static_cast<double>(has[file]), 0.25 * static_cast<double>(had[file]), 0.51) << file;
  EXPECT_LT(some.sample_count(Role::train), values / 3);
  // Spread evenly: no gap is twice as long as another.
  std::vector<double> begins;
  for (const Segment& s : some.segments)
    if (s.file == "long.csv") begins.push_back(s.time(0));
  ASSERT_GT(begins.size(), 3u);
  for (std::size_t k = 1; k < begins.size(); ++k) EXPECT_NEAR(begins[k] - begins[k - 1], 40.0 / 5.0, 2.01);
}

TEST(Thinned, SeesStartsAndEndsOfShortRecordingsAsOftenAsTheirMiddles) {
  Scenario truth = pendulum_scenario({}), scenario = pendulum_scenario({});
  scenario.prediction = Windows{2.0};
  constexpr int kFiles = 20;
  for (int k = 0; k < kFiles; ++k)
    add_recording(scenario,
                  simulated_recording(truth, rested_drive(8.0, 1.3), {{0.0}, {0.0}, false}, "featherstone",
                                      "run_" + std::to_string(k) + ".csv", 1e-3, 3),
                  Role::train);
  const Experiment all = make_experiment(scenario);
  const Experiment some = thinned(all, all.sample_count(Role::train) / 4);
  ASSERT_EQ(some.segments.size(), static_cast<std::size_t>(kFiles)) << "one window of each";
  std::map<int, int> seen;  // [second at which it begins]
  for (const Segment& s : some.segments) ++seen[static_cast<int>(std::lround(s.time(0)))];
  EXPECT_EQ(seen.size(), all.segments.size() / kFiles);
  for (const auto& [begin, count] : seen) EXPECT_GE(count, 3) << begin;
}

TEST(Thinned, LeavesWhatIsShortAsItIs) {
  const Experiment all = windows();
  EXPECT_EQ(thinned(all).segments.size(), all.segments.size());
}

}  // namespace
}  // namespace lacuna
