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

}  // namespace
}  // namespace lacuna
