#include "scenarios/clocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenarios/resample.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::column;
using test::input_error;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kSumRounding = 1e-12;  // of times near 1 s that were moved by a sum

Track track(const std::string& name, const std::vector<double>& time, const std::vector<double>& values,
            bool command = false) {
  Track out;
  out.source = name, out.clock = name + "/time", out.time = time, out.command = command;
  out.names = {name}, out.columns = {values};
  return out;
}

ColumnUse use(std::set<std::string> commands, std::set<std::string> measured) {
  ColumnUse out;
  out.commands = std::move(commands), out.measured = std::move(measured);
  return out;
}

Recording joined(const std::vector<Track>& tracks, const ColumnUse& use_of) {
  return join_tracks(tracks, 0, "time", use_of, "run", {});
}

TEST(Clocks, HoldCommandsAndDrawLinesBetweenMeasurements) {
  const std::vector<Track> tracks{track("q", {0, 1, 2, 3}, {5, 6, 7, 8}), track("u", {0, 1.5}, {10, 20}),
                                  track("p", {-0.5, 0.5, 1.5, 2.5, 3.5}, {0, 1, 2, 3, 4})};
  const Recording data = joined(tracks, use({"u"}, {"q", "p"}));
  EXPECT_THAT(column(data, "time"), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(column(data, "q"), ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(column(data, "u"), ElementsAre(10, 10, 20, 20));
  EXPECT_THAT(column(data, "p"), ElementsAre(0.5, 1.5, 2.5, 3.5));
  EXPECT_TRUE(data.joined);
  EXPECT_THAT(data.notes, Contains(HasSubstr("u: brought onto the clock of q, held")));
  EXPECT_THAT(data.notes, Contains(HasSubstr("p: brought onto the clock of q, by straight lines")));
}

TEST(Clocks, WhatIsAskedForDecidesBeforeTheTypeOfAMessage) {
  const std::vector<Track> tracks{track("q", {0, 1, 2}, {0, 0, 0}), track("x", {0, 2}, {0, 4}, true)};
  EXPECT_THAT(column(joined(tracks, {}), "x"), ElementsAre(0, 0, 4));
  EXPECT_THAT(column(joined(tracks, use({}, {"q", "x"})), "x"), ElementsAre(0, 2, 4));
  EXPECT_THAT(column(joined(tracks, use({"x"}, {"q"})), "x"), ElementsAre(0, 0, 4));
}

TEST(Clocks, UseOnlyTheCommonSpanAndSaySo) {
  const std::vector<Track> tracks{track("q", {0, 1, 2, 3, 4, 5}, {0, 1, 2, 3, 4, 5}), track("u", {1.5}, {7}),
                                  track("p", {0, 2, 4}, {0, 2, 4}), track("unused", {3, 3.1}, {0, 1})};
  const Recording data = joined(tracks, use({"u"}, {"q", "p"}));
  EXPECT_THAT(column(data, "time"), ElementsAre(2, 3, 4));
  EXPECT_THAT(column(data, "u"), ElementsAre(7, 7, 7));
  EXPECT_THAT(data.notes, Contains(HasSubstr("2 to 4 s of 0 to 5 s")));
  // What nobody uses neither limits nor fills anything.
  EXPECT_TRUE(std::isnan(column(data, "unused")[0]));
  EXPECT_EQ(column(data, "unused")[1], 0.0);
}

TEST(Clocks, WhereNothingIsAskedForEveryRowStays) {
  const Recording data = joined({track("q", {0, 1, 2}, {0, 1, 2}), track("u", {1}, {7}, true)}, {});
  EXPECT_EQ(data.rows(), 3u);
  EXPECT_TRUE(std::isnan(column(data, "u")[0]));
  EXPECT_EQ(column(data, "u")[2], 7.0);
  EXPECT_EQ(data.missing, 1u);
}

TEST(Clocks, DrawNoLineOverAGapOrToAMissingValue) {
  const std::vector<Track> tracks{track("q", {0.5, 1.5, 2.5, 5.5, 13.5}, {0, 0, 0, 0, 0}),
                                  track("p", {0, 1, 2, 3, 12, 13, 14}, {0, 1, kNone, 3, 12, 13, 14})};
  const std::vector<double> p = column(joined(tracks, use({}, {"q", "p"})), "p");
  EXPECT_EQ(p[0], 0.5);
  EXPECT_TRUE(std::isnan(p[1])) << "next to a missing value";
  EXPECT_TRUE(std::isnan(p[2])) << "next to a missing value";
  EXPECT_TRUE(std::isnan(p[3])) << "nine intervals without a sample";
  EXPECT_EQ(p[4], 13.5);
}

TEST(Clocks, TakeTimesThatDifferByRoundingForTheSame) {
  // 0.3 and 0.1 + 0.2 differ in their last bit.
  const Recording data =
      joined({track("q", {0.1, 0.3}, {0, 0}), track("u", {0.1, 0.1 + 0.2}, {1, 2})}, use({"u"}, {"q"}));
  EXPECT_THAT(column(data, "u"), ElementsAre(1, 2));
}

TEST(Clocks, PreferTheOneThatIsNamedThenStatesOfJoints) {
  std::vector<Track> tracks{track("fast", {0, 1, 2, 3}, {0, 0, 0, 0}), track("states", {0, 1}, {0, 0})};
  EXPECT_EQ(reference_track(tracks, ""), 0u);
  tracks[1].state = true;
  EXPECT_EQ(reference_track(tracks, ""), 1u);
  EXPECT_EQ(reference_track(tracks, "fast/time"), 0u);
}

TEST(Clocks, OfOneEpochFindEachOtherAndOthersNeedAnOffset) {
  Track first = track("a", {0, 1}, {0, 0}), second = track("b", {0, 1}, {0, 0});
  first.epoch_ns = 1'700'000'000'900'000'000, second.epoch_ns = 1'700'000'002'100'000'000;
  Track moved = second;
  shift_clock(moved, first, std::nullopt, "b");
  EXPECT_NEAR(moved.time[0], 1.2, kSumRounding);
  moved = second;
  shift_clock(moved, first, -0.2, "b");
  EXPECT_NEAR(moved.time[0], 1.0, kSumRounding);
  Track plain = track("c.csv", {100, 101}, {0, 0});
  const std::string refusal = input_error([&] { shift_clock(plain, first, std::nullopt, "c.csv"); });
  EXPECT_THAT(refusal, HasSubstr("clock_offset"));
  EXPECT_THAT(refusal, HasSubstr("-100 would let both begin together"));
  shift_clock(plain, first, -99.5, "c.csv");
  EXPECT_EQ(plain.time[0], 0.5);
}

TEST(Clocks, RefuseSpansThatDoNotMeetAndNamesThatComeTwice) {
  const Track q = track("q", {0, 1, 2}, {0, 0, 0});
  EXPECT_THAT(input_error([&] {
                joined({q, track("p", {5, 6}, {0, 0})}, use({}, {"q", "p"}));
              }),
              HasSubstr("p from 5 to 6 s and q from 0 to 2 s"));
  EXPECT_THAT(input_error([&] { joined({q, track("u", {5, 6}, {0, 0})}, use({"u"}, {"q"})); }), HasSubstr("overlap"));
  EXPECT_THAT(input_error([&] { joined({q, track("u", {-1000}, {0})}, use({"u"}, {"q"})); }), HasSubstr("overlap"));
  EXPECT_NO_THROW(joined({q, track("u", {-10}, {0})}, use({"u"}, {"q"}))) << "a command given once before";
  EXPECT_THAT(input_error([&] {
                joined({q, track("p", {1.9, 3}, {0, 0})}, use({}, {"q", "p"}));
              }),
              HasSubstr("1 sample of q"));
  EXPECT_THAT(input_error([&] { joined({q, q}, {}); }), HasSubstr("\"q\" twice"));
  RecordingLimits few;
  few.columns = 2;
  EXPECT_THAT(input_error([&] {
                join_tracks({q, track("p", {0, 2}, {0, 0})}, 0, "time", {}, "run", few);
              }),
              HasSubstr("more than 2 columns"));
}

TEST(Clocks, ACommandThatEndsEarlyIsHeldAndSaid) {
  const Recording data = joined({track("q", {0, 5, 10}, {0, 0, 0}), track("u", {0, 1}, {1, 2})}, use({"u"}, {"q"}));
  EXPECT_THAT(column(data, "u"), ElementsAre(1, 2, 2));
  EXPECT_THAT(data.notes, Contains(HasSubstr("its last command comes 9 s before the end")));
}

}  // namespace
}  // namespace lacuna
