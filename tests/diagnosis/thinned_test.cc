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

TEST(Thinned, KeepsAboutAsMuchAsAskedOfEveryRecordingAndAllThatIsTested) {
  const Experiment all = windows();
  const std::size_t values = all.sample_count(Role::train);
  const Experiment some = thinned(all, values / 2);
  std::map<std::string, std::size_t> had, has;
  for (const Segment& s : all.segments) ++had[s.file];
  for (const Segment& s : some.segments) ++has[s.file];
  EXPECT_EQ(has["test.csv"], had["test.csv"]);
  EXPECT_GE(has["short.csv"], 1u) << "none is left out whole";
  EXPECT_NEAR(static_cast<double>(some.sample_count(Role::train)), 0.5 * static_cast<double>(values),
              0.15 * static_cast<double>(values));
  EXPECT_NEAR(static_cast<double>(has["validate.csv"]), 0.5 * static_cast<double>(had["validate.csv"]), 2.0);
}

/// A recording of 80 s in windows of 2 s: a second of rest in the first window, a step of the command in the second,
/// held until it is taken back in the one before the last.
Experiment one_step(int recordings) {
  Scenario truth = pendulum_scenario({}), scenario = pendulum_scenario({});
  scenario.prediction = Windows{2.0};
  Drive drive = constant_drive(1, 80.0, 0.02, 0.0);
  for (std::size_t k = 0; k < drive.time.size(); ++k) drive.u[0][k] = drive.time[k] > 3.0 && drive.time[k] < 77.0;
  for (int k = 0; k < recordings; ++k)
    add_recording(scenario,
                  simulated_recording(truth, drive, {{0.0}, {0.0}, false}, "featherstone",
                                      "run_" + std::to_string(k) + ".csv", 1e-3, 3),
                  Role::train);
  return make_experiment(scenario);
}

TEST(Thinned, KeepsWhatComesOnceAndThinsWhatGoesOn) {
  const Experiment all = one_step(3);
  const Experiment some = thinned(all, all.sample_count(Role::train) / 8);
  EXPECT_LE(some.segments.size(), all.segments.size() / 6);
  std::map<std::string, std::map<char, int>> kept;  // [recording][o: opens, c: closes, h: holds, r: rests]
  for (const Segment& s : some.segments) {
    const double first = s.commands->value[0][s.first], last = s.commands->value[0][s.first + s.count - 1];
    ++kept[s.file][first < last ? 'o' : first > last ? 'c' : first > 0.0 ? 'h' : 'r'];
  }
  int rests = 0;
  for (auto& [file, kinds] : kept) {
    EXPECT_EQ(kinds['o'] + kinds['c'], 2) << file;
    EXPECT_GE(kinds['h'], 1) << file;
    EXPECT_LE(kinds['h'], 6) << file << " of 36";
    rests += kinds['r'];
  }
  EXPECT_GE(rests, 1);
  EXPECT_LE(rests, 4) << "of 6 in all, one kind";
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
  // Sines: nearly every window is a kind of its own. A quarter of 80, and one of each recording that has none among it.
  ASSERT_GE(some.segments.size(), static_cast<std::size_t>(kFiles));
  ASSERT_LE(some.segments.size(), static_cast<std::size_t>(kFiles) * 5 / 4);
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
