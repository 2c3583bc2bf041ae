// What a learned curve is said to look like: curves of textbook laws, and curves of none.
#include "diagnosis/resemblance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace lacuna {
namespace {

/// The law at `knots` even places, known to a hundredth of `height`.
LearnedLaw described_law(const std::function<double(double)>& law, const std::string& over, double from, double to,
                         std::size_t knots = 33, double period = 0.0) {
  LearnedLaw out;
  out.place = "swing", out.unit = "N m";
  out.over = {{over, from, to, over == "v" ? "rad/s" : "rad", knots}};
  out.period = period;
  double height = 0.0;
  for (std::size_t k = 0; k < knots; ++k) {
    const double at = from + (to - from) * static_cast<double>(k) / static_cast<double>(knots - 1);
    out.curve.push_back({at, law(at), 0.0, 0.0});
    height = std::max(height, std::fabs(law(at)));
  }
  for (LearnedLaw::Point& p : out.curve) p.lower95 = p.value - 0.01 * height, p.upper95 = p.value + 0.01 * height;
  describe_curve(out);
  return out;
}

bool says(const LearnedLaw& law, const std::string& words) { return law.description.find(words) != std::string::npos; }

/// sin of so many periods over two radians, 0.2 N m high, in eight knots a period.
LearnedLaw ripple_of(int periods) {
  const double period = 2.0 / periods;
  return described_law([=](double q) { return 0.2 * std::sin(2.0 * std::numbers::pi / period * q); }, "q", -1.0, 1.0,
                       static_cast<std::size_t>(8 * periods + 1), period);
}

struct TextbookCase {
  const char* name;
  const char* over;
  double reach;  ///< the curve goes from -reach to reach
  std::function<double(double)> law;
  const char* resembles;
};

const std::vector<TextbookCase>& textbook_cases() {
  static const std::vector<TextbookCase> all{
      {"Spring", "q", 1.0, [](double q) { return -2.0 * q; }, "a spring"},
      {"HardeningSpring", "q", 1.0, [](double q) { return -q - 2.0 * q * q * q; }, "a hardening spring"},
      {"Lever", "q", 2.0, [](double q) { return 4.9 * std::sin(q) + 1.0 * std::cos(q); }, "a weight on a lever"},
      {"Stop", "q", 1.0, [](double q) { return -4.0 * std::max(q - 0.3, 0.0); }, "a stop or a spring with slack"},
      {"Viscous", "v", 3.0, [](double v) { return -0.8 * v; }, "viscous friction"},
      {"Quadratic", "v", 3.0, [](double v) { return -0.8 * v * std::fabs(v); }, "quadratic damping"},
      {"Sign", "v", 3.0, [](double v) { return v > 0.0   ? -0.7
                                               : v < 0.0 ? 0.7
                                                         : 0.0; }, "Coulomb friction"},
      {"Tanh", "v", 3.0, [](double v) { return -0.7 * std::tanh(v / 0.2); }, "Coulomb friction"},
      {"CoulombAndViscous", "v", 1.0, [](double v) { return -std::tanh(v / 0.05) - 1.5 * v; },
       "Coulomb and viscous friction"},
      {"Stribeck", "v", 1.0, [](double v) { return -std::tanh(v / 0.02) * (1.0 + std::exp(-(v / 0.3) * (v / 0.3))); },
       "Stribeck friction"},
  };
  return all;
}

class Resemblance : public testing::TestWithParam<std::size_t> {};

TEST_P(Resemblance, OfATextbookLawIsThatLaw) {
  const TextbookCase& c = textbook_cases()[GetParam()];
  const LearnedLaw law = described_law(c.law, c.over, -c.reach, c.reach);
  EXPECT_EQ(law.resembles, c.resembles);
  EXPECT_GT(law.share, 0.95);
  EXPECT_LE(law.share, 1.0);
  EXPECT_TRUE(says(law, std::string("; like ") + c.resembles)) << law.description;
  // Every one of them has its extremes at its ends, but for friction that falls with speed.
  if (law.resembles != "Stribeck friction" && law.resembles != "a weight on a lever") {
    EXPECT_DOUBLE_EQ(law.height, 0.5 * std::fabs(c.law(c.reach) - c.law(-c.reach)));
    EXPECT_TRUE(says(law, "rises or falls throughout")) << law.description;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Resemblance, testing::Range(std::size_t{0}, textbook_cases().size()),
                         [](const auto& p) { return std::string(textbook_cases()[p.param].name); });

TEST(ResemblanceOfARipple, SaysItsPeriodAndItsHeight) {
  const LearnedLaw law = ripple_of(4);
  EXPECT_EQ(law.resembles, "gear ripple");
  EXPECT_GT(law.share, 0.95);
  EXPECT_EQ(law.period, 0.5);
  EXPECT_NEAR(law.height, 0.2, 1e-12);  // its crests stand on knots
  EXPECT_TRUE(says(law, "swing lacks a torque that depends on its position: 0.2 N m to either side of its middle"))
      << law.description;
  EXPECT_TRUE(says(law, "repeats every 0.5 rad")) << law.description;
}

TEST(ResemblanceOfARipple, HoldsForAsManyPeriodsAsAreLearned) {
  for (const int periods : {8, 16}) {
    const LearnedLaw law = ripple_of(periods);
    EXPECT_EQ(law.resembles, "gear ripple") << periods;
    EXPECT_GT(law.share, 0.95) << periods;
  }
}

TEST(ResemblanceOfARipple, SaysAPeriodInTheUnitOfWhatTheLawDependsOn) {
  const LearnedLaw law =
      described_law([](double v) { return std::sin(4.0 * std::numbers::pi * v); }, "v", -1.0, 1.0, 33, 0.5);
  EXPECT_TRUE(says(law, "depends on its speed")) << law.description;
  EXPECT_TRUE(says(law, "repeats every 0.5 rad/s")) << law.description;
}

TEST(ResemblanceOfNothing, NamesNoTextbookLaw) {
  // What drives either way alike is no friction.
  const LearnedLaw even = described_law([](double v) { return std::fabs(v); }, "v", -1.0, 1.0);
  EXPECT_LT(even.share, 0.01);
  EXPECT_TRUE(says(even, "no textbook law")) << even.description;
  EXPECT_TRUE(says(even, "the same in either direction, rises and falls")) << even.description;
  EXPECT_DOUBLE_EQ(even.height, 0.5);
}

TEST(ResemblanceOfNothing, HoldsForAConstant) {
  for (const double value : {0.5, 0.3, -0.7, 1e-3}) {
    const LearnedLaw level = described_law([=](double) { return value; }, "q", -1.0, 1.0);
    EXPECT_EQ(level.height, 0.0) << value;
    EXPECT_EQ(level.share, 0.0) << value << ": there is no variance of which a law could explain a share";
    EXPECT_TRUE(says(level, "no textbook law")) << level.description;
  }
}

TEST(ResemblanceOfNothing, IsLeftEmptyForACurveOfTooFewPoints) {
  const LearnedLaw few = described_law([](double q) { return q; }, "q", -1.0, 1.0, 3);
  EXPECT_TRUE(few.resembles.empty());
  EXPECT_EQ(few.share, 0.0);
}

TEST(ResemblanceWords, TellDirectionsOnlyWhereBothWereSeen) {
  const auto odd = [](double v) { return -0.8 * v * std::fabs(v); };
  EXPECT_TRUE(says(described_law(odd, "v", -2.0, 2.0), "turns with the sign"));
  EXPECT_FALSE(says(described_law(odd, "v", 0.5, 2.0), "turns with the sign"));
  EXPECT_FALSE(says(described_law(odd, "v", -0.2, 2.0), "turns with the sign"));
}

TEST(ResemblanceWords, CallWhatRisesButForItsBandsRising) {
  // Up and down from knot to knot, on a line that rises by .0625 a knot: it falls by .0075, its bands are .02 wide; and
  // by .14.
  const auto wiggled = [](double by) {
    return described_law([=](double q) { return q + by * std::cos(16.0 * std::numbers::pi * q); }, "q", -1.0, 1.0);
  };
  EXPECT_TRUE(says(wiggled(0.035), "rises or falls throughout")) << wiggled(0.035).description;
  EXPECT_TRUE(says(wiggled(0.1), "rises and falls")) << wiggled(0.1).description;
}

TEST(ResemblanceWords, SpeakOfForcesOnASlide) {
  LearnedLaw law = described_law([](double q) { return q; }, "q", -1.0, 1.0);
  law.unit = "N", law.over.front().unit = "m";
  describe_curve(law);
  EXPECT_TRUE(says(law, "swing lacks a force that depends on its position: 1 N to either side")) << law.description;
}

TEST(ResemblanceWeights, LetPointsThatAreNotKnownSayLittle) {
  // A spring, but for one knot that nothing was seen of.
  LearnedLaw law = described_law([](double q) { return -2.0 * q; }, "q", -1.0, 1.0);
  const double known = law.share;
  LearnedLaw::Point& astray = law.curve[5];
  astray.value += 3.0;
  describe_curve(law);
  EXPECT_LT(law.share, known - 0.05);
  astray.lower95 = -HUGE_VAL, astray.upper95 = HUGE_VAL;
  describe_curve(law);
  EXPECT_EQ(law.resembles, "a spring");
  EXPECT_GT(law.share, 0.99);
}

/// A law of two variables on `rows` by `columns` knots.
LearnedLaw described_map(const std::function<double(double, double)>& law, LearnedLaw::Variable second,
                         std::size_t rows = 16) {
  LearnedLaw out;
  out.place = "swing", out.unit = "N m";
  out.over = {{"q", -1.0, 1.0, "rad", rows}, std::move(second)};
  for (std::size_t k = 0; k < rows * out.over[1].knots; ++k) {
    const auto at = [&](const LearnedLaw::Variable& v, std::size_t knot) {
      return v.from + (v.to - v.from) * static_cast<double>(knot) / static_cast<double>(v.knots - 1);
    };
    const double x = at(out.over[0], k / out.over[1].knots), y = at(out.over[1], k % out.over[1].knots);
    out.curve.push_back({x, law(x, y), law(x, y) - 0.01, law(x, y) + 0.01, y});
  }
  describe_curve(out);
  return out;
}

TEST(ResemblanceOfALoop, IsFrictionThatDependsOnThePosition) {
  const LearnedLaw::Variable way{"v", -0.05, 0.05, "rad/s", 2};
  const auto spot = [](double q, double v) { return v > 0.0 ? -std::exp(-q * q / 0.04) : std::exp(-q * q / 0.04); };
  const LearnedLaw friction = described_map(spot, way);
  EXPECT_EQ(friction.resembles, "friction that depends on the position");
  EXPECT_GT(friction.share, 0.99);
  EXPECT_TRUE(says(friction, "depends on its position and on which way it moves")) << friction.description;
  EXPECT_TRUE(says(friction, "a loop, so dry friction or a memory; like")) << friction.description;
  const LearnedLaw spring = described_map([](double q, double) { return q * q * q; }, way);
  EXPECT_LT(spring.share, 0.01) << "what does not turn with the way is no friction";
}

TEST(ResemblanceOfAMap, IsASumOrAProduct) {
  const LearnedLaw::Variable other{"elbow.q", -1.0, 1.0, "rad", 8};
  const LearnedLaw sum = described_map([](double x, double y) { return std::sin(2.0 * x) + y * y; }, other, 8);
  EXPECT_EQ(sum.resembles, "two laws side by side, one of either");
  EXPECT_NEAR(sum.share, 1.0, 1e-9);
  EXPECT_TRUE(says(sum, "depends on its position and on the position of elbow")) << sum.description;
  const LearnedLaw product = described_map([](double x, double y) { return std::sin(2.0 * x) * (y - 0.2); }, other, 8);
  EXPECT_EQ(product.resembles, "the product of a law of either");
  EXPECT_NEAR(product.share, 1.0, 1e-9);
}

TEST(ResemblanceOfACommand, IsANotchOrADeadZone) {
  const auto described = [](const std::function<double(double)>& law, Stage stage) {
    LearnedLaw out = described_law(law, "q", -1.0, 1.0);
    out.stage = stage, out.over.front().name = stage == Stage::command ? "u" : "q";
    describe_curve(out);
    return out;
  };
  const LearnedLaw notch =
      described([](double u) { return -0.2 * std::exp(-std::pow((u - 0.5) / 0.2, 2)) + 0.1 * u; }, Stage::command);
  EXPECT_EQ(notch.resembles, "a notch");
  EXPECT_TRUE(says(notch, "the command of swing arrives changed by what depends on its command")) << notch.description;
  const LearnedLaw dead = described([](double u) { return -std::clamp(u, -0.1, 0.1); }, Stage::command);
  EXPECT_EQ(dead.resembles, "a dead zone");
  const LearnedLaw ring = described([](double q) { return 0.01 * std::sin(q); }, Stage::reading);
  EXPECT_TRUE(says(ring, "the position of swing is read wrong")) << ring.description;
}

TEST(ResemblanceWords, SayWhichRecordingWouldTellMore) {
  LearnedLaw law = described_law([](double q) { return q; }, "q", -1.0, 1.0);
  EXPECT_TRUE(law.tells_more.empty());
  law.curve.back().upper95 += 2.0;
  describe_curve(law);
  EXPECT_NE(law.tells_more.find("Least is known of it where its position is 1 rad"), std::string::npos)
      << law.tells_more;
}

}  // namespace
}  // namespace lacuna
