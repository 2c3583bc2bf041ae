// A law given by its values at knots: what cubic convolution promises, in numbers, in packs and in the plant.
#include "physics/effects/learned_effort.h"

#include <gtest/gtest.h>

#include <functional>

#include "physics/lanes.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kRoundings = 1e-13;       // of values about 1: some ten products and sums
constexpr double kRoundingOfARun = 1e-11;  // m, over some thousand steps

/// A curve over the position, or over the speed.
struct KnottedLaw {
  bool over_speed = false;
  double from = 0.0, to = 1.0;
  std::vector<double> values;

  double spacing() const { return (to - from) / static_cast<double>(values.size() - 1); }
  double knot(std::size_t k) const { return from + static_cast<double>(k) * spacing(); }
  /// As the effect takes it.
  std::vector<double> numbers() const {
    std::vector<double> out{over_speed ? 1.0 : 0.0, 0.0, from, to, static_cast<double>(values.size())};
    out.resize(LearnedCurve::kValues, 0.0);  // no second variable, no period
    out.insert(out.end(), values.begin(), values.end());
    return out;
  }
  double operator()(double q, double v = 0.0) const {
    JointView<double> s;
    s.q = q, s.v = v;
    return LearnedEffort::effort(numbers().data(), s);
  }
  EffectSpec at(const std::string& joint) const {
    std::map<std::string, double> parameters{
        {"over", over_speed ? 1.0 : 0.0}, {"from", from}, {"to", to}, {"knots", static_cast<double>(values.size())}};
    for (std::size_t k = 0; k < values.size(); ++k) parameters["value_" + std::to_string(k + 1)] = values[k];
    return effect("learned_effort", joint, parameters);
  }
};

KnottedLaw learned_from(const std::function<double(double)>& law, double from, double to, std::size_t knots,
                        bool over_speed = false) {
  KnottedLaw out{over_speed, from, to, std::vector<double>(knots)};
  for (std::size_t k = 0; k < knots; ++k) out.values[k] = law(out.knot(k));
  return out;
}

/// Values without any pattern, of some 1 N m.
KnottedLaw random_curve(std::uint64_t seed, std::size_t knots = 9) {
  Noise random(seed);
  return learned_from([&](double) { return random(); }, -0.8, 1.2, knots);
}

/// Places from `from` to `to`, both included.
std::vector<double> places_between(double from, double to, int count = 400) {
  std::vector<double> out;
  for (int k = 0; k <= count; ++k) out.push_back(from + (to - from) * k / count);
  return out;
}

TEST(LearnedEffort, HasItsValuesAtItsKnots) {
  const KnottedLaw curve = random_curve(1);
  for (std::size_t k = 0; k < curve.values.size(); ++k)
    EXPECT_NEAR(curve(curve.knot(k)), curve.values[k], kRoundings) << k;
}

TEST(LearnedEffort, OfAStraightLineIsThatLineToBothEnds) {
  const auto line = [](double x) { return 0.7 - 1.3 * x; };
  const KnottedLaw curve = learned_from(line, -0.6, 0.9, 7);
  for (const double x : places_between(curve.from, curve.to)) EXPECT_NEAR(curve(x), line(x), kRoundings) << x;
}

TEST(LearnedEffort, OfAParabolaIsThatParabolaButForTheOutermostSpacings) {
  constexpr double kBend = 2.1;
  const auto parabola = [](double x) { return 0.7 - 1.3 * x + kBend * x * x; };
  const KnottedLaw curve = learned_from(parabola, -0.6, 0.9, 7);
  const double h = curve.spacing();
  for (const double x : places_between(curve.from + h, curve.to - h))
    EXPECT_NEAR(curve(x), parabola(x), kRoundings) << x;
  // The knot beyond an end lies on a line: 2 kBend h^2 off the parabola, with a weight of 2/27 at most, a third in.
  const double most = 4.0 / 27.0 * kBend * h * h;
  for (const double x : places_between(curve.from, curve.from + h))
    EXPECT_LE(std::fabs(curve(x) - parabola(x)), most + kRoundings) << x;
  EXPECT_NEAR(curve(curve.from + h / 3.0) - parabola(curve.from + h / 3.0), most, kRoundings);
  EXPECT_NEAR(curve(curve.to - h / 3.0) - parabola(curve.to - h / 3.0), most, kRoundings);
}

TEST(LearnedEffort, MissesASmoothLawByTheThirdOrderOfTheSpacing) {
  const auto law = [](double x) { return std::sin(3.0 * x); };
  const auto worst = [&](std::size_t knots) {
    const KnottedLaw curve = learned_from(law, -1.0, 1.0, knots);
    double out = 0.0;
    for (const double x : places_between(-1.0 + curve.spacing(), 1.0 - curve.spacing(), 2000))
      out = std::max(out, std::fabs(curve(x) - law(x)));
    return out;
  };
  // 2^3; the next order's share is still seen at these spacings.
  const double ratio = worst(33) / worst(65);
  EXPECT_GT(ratio, 7.5);
  EXPECT_LT(ratio, 8.5);
}

TEST(LearnedEffort, StaysLevelBeyondItsEnds) {
  const KnottedLaw curve = random_curve(2);
  for (const double beyond : {1e-9, 0.3, 1e6}) {
    EXPECT_EQ(curve(curve.from - beyond), curve(curve.from)) << beyond;
    EXPECT_EQ(curve(curve.to + beyond), curve(curve.to)) << beyond;
  }
  EXPECT_NEAR(curve(curve.from), curve.values.front(), kRoundings);
  EXPECT_NEAR(curve(curve.to), curve.values.back(), kRoundings);
}

TEST(LearnedEffort, GoesThroughEveryInnerKnotWithOneSlope) {
  // Keys' kernel passes a knot at the slope between its neighbours, from either side. A difference over kWay is off by
  // half of the curvature, at most some 20 values over a squared spacing, times that way.
  constexpr double kWay = 1e-7;
  const KnottedLaw curve = random_curve(3);
  const double h = curve.spacing(), close = 20.0 / (h * h) * kWay + kRoundings / kWay;
  for (std::size_t k = 1; k + 1 < curve.values.size(); ++k) {
    const double x = curve.knot(k), slope = (curve.values[k + 1] - curve.values[k - 1]) / (2.0 * h);
    EXPECT_NEAR((curve(x) - curve(x - kWay)) / kWay, slope, close) << "before knot " << k;
    EXPECT_NEAR((curve(x + kWay) - curve(x)) / kWay, slope, close) << "behind knot " << k;
  }
}

TEST(LearnedEffort, IsNothingWithoutKnotsAndWithValuesOfZero) {
  for (const std::size_t knots : {0, 1, 4, 128}) {
    const KnottedLaw curve{false, -1.0, 1.0, std::vector<double>(knots, 0.0)};
    for (const double x : {-2.0, -1.0, 0.123, 1.0, 2.0}) EXPECT_EQ(curve(x), 0.0) << knots << " knots at " << x;
  }
}

TEST(LearnedEffort, DependsOnWhatItIsOverAndOnNothingElse) {
  const KnottedLaw curve = random_curve(4);
  for (const double x : places_between(-1.0, 1.4, 17)) {
    EXPECT_EQ(curve(x, 0.7), curve(x, -5.0));
    KnottedLaw over_speed = curve;
    over_speed.over_speed = true;
    EXPECT_EQ(over_speed(3.0, x), curve(x));
  }
}

TEST(LearnedEffort, IsInEveryLaneWhatItIsInDouble) {
  using Pack = xsimd::batch<double, xsimd::sse2>;
  const std::vector<KnottedLaw> curves{random_curve(5), random_curve(6)};
  ASSERT_EQ(kLanes<Pack>, 2);
  for (const bool over_speed : {false, true}) {
    std::vector<Pack> numbers(curves[0].numbers().size());
    for (std::size_t l = 0; l < curves.size(); ++l) {
      KnottedLaw curve = curves[l];
      curve.over_speed = over_speed;
      for (std::size_t i = 0; i < numbers.size(); ++i) set_lane(numbers[i], static_cast<int>(l), curve.numbers()[i]);
    }
    for (const double x : places_between(-1.0, 1.4, 97)) {
      // Lanes in different places, so that each picks other knots.
      const double there[] = {x, 0.4 - x};
      JointView<Pack> s;
      for (int l = 0; l < 2; ++l) set_lane(over_speed ? s.v : s.q, l, there[l]);
      const Pack found = LearnedEffort::effort(static_cast<const Pack*>(numbers.data()), s);
      for (int l = 0; l < 2; ++l) EXPECT_NEAR(lane(found, l), curves[l](there[l]), kRoundings) << "lane " << l;
    }
  }
}

// --- in the plant ---------------------------------------------------------------------------------------------------

/// The block on its slide, pushed by three sines.
struct LearnedBlock {
  const Start start{{0.1}, {0.0}};
  const Scenario scenario = driven_scenario(
      block_robot(), {actuator("slide", "torque_source", {{"gain", 3.0}, {"damping", 1.0}, {"stiffness", 20.0}})},
      sine_drive(1, 3.0, 0.01, 4.0), start);
  std::vector<std::vector<double>> moved(const std::vector<EffectSpec>& effects) const {
    return predict_one(PlantModel(scenario).with_effects(effects), started_experiment(scenario, start),
                       on("featherstone", 0.002))
        .front();
  }
};

TEST(LearnedEffort, MovesThePlantAsTheNamedLawThatItFollows) {
  const LearnedBlock block;
  const auto plain = block.moved({});
  const auto drag = learned_from([](double v) { return -1.5 * v; }, -20.0, 20.0, 16, true);
  const auto viscous = block.moved({effect("viscous_friction", "slide", {{"D", 1.5}})});
  EXPECT_LT(worst_difference(block.moved({drag.at("slide")})[0], viscous[0]), kRoundingOfARun);
  EXPECT_GT(worst_difference(plain[0], viscous[0]), 1e-2) << "nothing was tested";
  const auto push = learned_from([](double) { return 0.8; }, -0.1, 0.1, 4);
  const auto offset = block.moved({effect("torque_offset", "slide", {{"tau0", 0.8}})});
  EXPECT_LT(worst_difference(block.moved({push.at("slide")})[0], offset[0]), kRoundingOfARun);
}

TEST(LearnedEffort, OfZerosLeavesThePlantAsItWasToTheLastBit) {
  const LearnedBlock block;
  const auto plain = block.moved({});
  EXPECT_TRUE(same_bits(block.moved({KnottedLaw{false, -1.0, 1.0, {}}.at("slide")}), plain));
  EXPECT_TRUE(same_bits(block.moved({KnottedLaw{true, -1.0, 1.0, std::vector<double>(12, 0.0)}.at("slide")}), plain));
}

TEST(LearnedEffort, ActsInTheRecordingsThatAreNamedAndInNoneBesideThem) {
  const LearnedBlock block;
  Scenario scenario = block.scenario;  // with a second recording on the same clock: both are simulated in one pack
  const Drive later = sine_drive(1, 3.0, 0.01, 4.0, 5.0);
  add_recording(scenario, recording_of(*scenario.robot, later, block.start, "second.csv"));
  const Experiment experiment = started_experiment(scenario, block.start);
  const auto moved = [&](const std::vector<EffectSpec>& effects) {
    return predict_one(PlantModel(scenario).with_effects(effects), experiment, on("featherstone", 0.002));
  };
  EffectSpec law = random_curve(8).at("slide");
  const auto plain = moved({}), everywhere = moved({law});
  for (const std::size_t named : {0, 1}) {
    law.recordings = {experiment.segments[named].file};
    const auto partly = moved({law});
    EXPECT_LT(worst_difference(partly[named][0], everywhere[named][0]), kRoundingOfARun) << law.recordings[0];
    EXPECT_LT(worst_difference(partly[1 - named][0], plain[1 - named][0]), kRoundingOfARun) << law.recordings[0];
    EXPECT_GT(worst_difference(plain[named][0], everywhere[named][0]), 1e-2) << "nothing was tested";
  }
}

TEST(LearnedEffort, HasOneParameterAKnotInTheJointsUnit) {
  const LearnedBlock block;
  const PlantModel model = PlantModel(block.scenario).with_effects({random_curve(7).at("slide")});
  const Parameter& last = model.parameters().back();
  EXPECT_EQ(last.name, "slide.learned_effort.value_9");
  EXPECT_EQ(last.unit, "N");
  EXPECT_EQ(last.value, random_curve(7).values.back());
  EffectSpec more = random_curve(7).at("slide");
  more.parameters["value_10"] = 1.0;
  EXPECT_NE(input_error([&] { PlantModel(block.scenario).with_effects({more}); }).find("\"value_10\""),
            std::string::npos);
}

TEST(LearnedEffort, GivesTheSameMotionOnEveryEngine) {
  constexpr double kOfTheMotion = 1e-8;
  constexpr double kOde = 1e-3;  // of it: accelerations good to 1e-5 of theirs, added up over 2 s
  const Start start{{0.3, -0.4}, {0.2, -0.1}};
  std::vector<ActuatorSpec> drives;
  for (const char* joint : {"shoulder", "elbow"})
    drives.push_back(actuator(joint, "torque_source", {{"gain", 3.0}, {"damping", 0.7}, {"stiffness", 2.0}}));
  const Scenario scenario = driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), drives,
                                            sine_drive(2, 2.0, 0.01, 2.0), start);
  const Experiment experiment = started_experiment(scenario, start);
  const PlantModel plain(scenario);
  const PlantModel model = plain.with_effects(
      {learned_from([](double q) { return std::sin(6.0 * q); }, -1.5, 1.5, 32).at("shoulder"),
       learned_from([](double v) { return -0.3 * std::tanh(4.0 * v); }, -3.0, 3.0, 32, true).at("elbow")});
  const auto reference = predict_one(model, experiment, on("featherstone", 0.002)).front();
  const auto without = predict_one(plain, experiment, on("featherstone", 0.002)).front();
  for (const std::string& engine : available_engines()) {
    const auto other = predict_one(model, experiment, on(engine, 0.002)).front();
    for (std::size_t c = 0; c < reference.size(); ++c) {
      const double size = worst_difference(reference[c], std::vector<double>(reference[c].size(), 0.0));
      EXPECT_LT(worst_difference(other[c], reference[c]), (engine == "ode" ? kOde : kOfTheMotion) * size)
          << engine << " channel " << c;
      EXPECT_GT(worst_difference(without[c], reference[c]), 1e-2 * size) << "nothing was tested";
    }
  }
}

}  // namespace
}  // namespace lacuna
