// Laws of two variables, of another joint, of a period, on a command and on a reading: what their knots promise.
#include "physics/effects/learned_curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "physics/effects/learned_command.h"
#include "physics/effects/learned_effort.h"
#include "physics/effects/learned_reading.h"
#include "scenarios/error.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kExact = 1e-13;  // of values about 1

struct KnotsOf {
  LearnedCurve::Variable over = LearnedCurve::kPosition;
  int of = 0;
  double from = 0.0, to = 1.0;
  int count = 0;
  double place(int k) const { return from + (to - from) * k / (count - 1); }
};

/// A law's numbers as the plant has them.
std::vector<double> numbers_of(const KnotsOf& first, const KnotsOf& second,
                               const std::function<double(double, double)>& f, double period = 0.0) {
  std::vector<double> out;
  for (const KnotsOf& v : {first, second})
    out.insert(out.end(), {static_cast<double>(v.over), 1.0 * v.of, v.from, v.to, 1.0 * v.count});
  out.push_back(period);
  for (int a = 0; a < first.count; ++a)
    for (int b = 0; b < std::max(second.count, 1); ++b)
      out.push_back(f(first.place(a), second.count > 0 ? second.place(b) : 0.0));
  return out;
}

double value(const std::vector<double>& numbers, const JointView<double>& s) {
  return LearnedCurve::at(numbers.data(), s);
}
JointView<double> moving(double q, double v, double u = 0.0) {
  JointView<double> s;
  s.q = q, s.v = v, s.u = u;
  return s;
}

TEST(LearnedCurve, OfTwoVariablesIsExactForAProductOfLinesAndGoesOnLevel) {
  const auto law = [](double q, double v) { return (0.3 - q) * (1.0 + 2.0 * v); };
  const auto numbers =
      numbers_of({LearnedCurve::kPosition, 0, -1.0, 1.0, 9}, {LearnedCurve::kSpeed, 0, -2.0, 2.0, 5}, law);
  for (const double q : {-1.0, -0.37, 0.0, 0.81})
    for (const double v : {-2.0, -0.4, 1.3}) EXPECT_NEAR(value(numbers, moving(q, v)), law(q, v), kExact);
  EXPECT_NEAR(value(numbers, moving(5.0, -7.0)), law(1.0, -2.0), kExact);
}

TEST(LearnedCurve, WithTwoKnotsOfTheSpeedHasACurveForEitherWay) {
  const auto law = [](double q, double v) { return v > 0.0 ? std::sin(3.0 * q) : -q; };
  const KnotsOf position{LearnedCurve::kPosition, 0, -1.0, 1.0, 17};
  const auto numbers = numbers_of(position, {LearnedCurve::kSpeed, 0, -0.05, 0.05, 2}, law);
  for (int k = 0; k < position.count; ++k) {
    const double q = position.place(k);
    EXPECT_NEAR(value(numbers, moving(q, 1.0)), law(q, 1.0), kExact);
    EXPECT_NEAR(value(numbers, moving(q, -1.0)), law(q, -1.0), kExact);
    EXPECT_NEAR(value(numbers, moving(q, 0.0)), 0.5 * (law(q, 1.0) + law(q, -1.0)), kExact) << "between both at rest";
  }
}

TEST(LearnedCurve, OfAPeriodRepeatsItselfWithoutASeam) {
  constexpr double kPeriod = 0.3;
  constexpr int kCount = 24;
  const auto law = [](double q, double) { return std::sin(2.0 * std::numbers::pi / kPeriod * q); };
  const auto numbers =
      numbers_of({LearnedCurve::kPosition, 0, 0.1, 0.1 + kPeriod * (kCount - 1) / kCount, kCount}, {}, law, kPeriod);
  for (double q = -2.0; q < 2.0; q += 0.0137) {
    EXPECT_NEAR(value(numbers, moving(q, 0.0)), value(numbers, moving(q + 7.0 * kPeriod, 0.0)), 1e-9);
    EXPECT_NEAR(value(numbers, moving(q, 0.0)), law(q, 0.0), 2e-3) << "third order: (2 pi / 24)^3 / 9";
  }
  const double seam = 0.1 + 3.0 * kPeriod;
  EXPECT_NEAR(value(numbers, moving(seam - 1e-9, 0.0)), value(numbers, moving(seam + 1e-9, 0.0)), 1e-6);
}

TEST(LearnedCurve, MayDependOnAnotherJointTheCommandOrTime) {
  const std::vector<double> positions{0.2, -0.4}, speeds{1.5, -0.7};
  JointView<double> s = moving(0.2, 1.5, 0.6);
  s.positions = positions.data(), s.speeds = speeds.data(), s.joints = 2, s.t = 0.9;
  const auto over = [&](LearnedCurve::Variable variable, int of) {
    return value(numbers_of({variable, of, -2.0, 2.0, 5}, {}, [](double x, double) { return x; }), s);
  };
  EXPECT_NEAR(over(LearnedCurve::kPosition, 2), -0.4, kExact);
  EXPECT_NEAR(over(LearnedCurve::kSpeed, 2), -0.7, kExact);
  EXPECT_NEAR(over(LearnedCurve::kSpeed, 0), 1.5, kExact);
  EXPECT_NEAR(over(LearnedCurve::kCommand, 0), 0.6, kExact);
  EXPECT_NEAR(over(LearnedCurve::kTime, 0), 0.9, kExact);
}

TEST(LearnedCommand, IsAddedToTheCommandThatArrives) {
  const auto numbers =
      numbers_of({LearnedCurve::kCommand, 0, -1.0, 1.0, 9}, {}, [](double u, double) { return -0.25 * u; });
  EXPECT_NEAR(LearnedCommand::command(numbers.data(), moving(0.0, 0.0, 0.8)), 0.6, kExact);
  EXPECT_NEAR(LearnedCommand::command(numbers.data(), moving(0.0, 0.0, -3.0)), -2.75, kExact) << "level beyond -1";
}

TEST(LearnedReading, IsUndoneByItsInverse) {
  const auto numbers = numbers_of({LearnedCurve::kPosition, 0, -1.0, 1.0, 33}, {},
                                  [](double q, double) { return 0.02 * std::sin(9.0 * q); });
  const std::vector<double> time{0.0, 0.1, 0.2};
  const std::vector<double> positions{-0.9, 0.13, 1.7};
  std::vector<double> readings = positions;
  LearnedReading::sense(numbers.data(), time, readings.data(), 1);
  for (std::size_t k = 0; k < positions.size(); ++k) {
    EXPECT_GT(std::fabs(readings[k] - positions[k]), 1e-3) << "nothing was read wrong";
    EXPECT_NEAR(LearnedReading::unsense(numbers.data(), readings[k]), positions[k], 1e-12);
  }
}

/// A line of slope `slope` over the joint's command or position, as an effect.
EffectSpec line(const char* name, LearnedCurve::Variable over, double reach, double slope) {
  std::map<std::string, double> parameters{{"over", over}, {"from", -reach}, {"to", reach}, {"knots", 8.0}};
  for (int k = 0; k < 8; ++k) parameters["value_" + std::to_string(k + 1)] = slope * reach * (2.0 * k / 7.0 - 1.0);
  return effect(name, "slide", parameters);
}

TEST(LearnedCurve, OnCommandAndReadingMovesThePlantAsTheNamedLawThatItFollows) {
  constexpr double kRoundingOfARun = 1e-11;  // m
  const Start start{{0.1}, {0.0}};
  const auto actuated = [](double gain) {
    return std::vector<ActuatorSpec>{
        actuator("slide", "torque_source", {{"gain", gain}, {"damping", 1.0}, {"stiffness", 20.0}})};
  };
  const auto moved = [&](double gain, const std::vector<EffectSpec>& effects) {
    const Scenario scenario = driven_scenario(block_robot(), actuated(gain), sine_drive(1, 3.0, 0.01, 4.0), start);
    return predict_one(PlantModel(scenario).with_effects(effects), started_experiment(scenario, start),
                       on("featherstone", 0.002))
        .front();
  };
  const auto plain = moved(3.0, {});
  const auto weaker = moved(2.4, {});  // u - 0.2 u under a gain of 3
  EXPECT_LT(worst_difference(moved(3.0, {line("learned_command", LearnedCurve::kCommand, 10.0, -0.2)})[0], weaker[0]),
            kRoundingOfARun);
  EXPECT_GT(worst_difference(plain[0], weaker[0]), 1e-2) << "nothing was tested";
  const auto scaled = moved(3.0, {effect("sensor_scale", "slide", {{"s", 0.05}})});
  EXPECT_LT(worst_difference(moved(3.0, {line("learned_reading", LearnedCurve::kPosition, 10.0, 0.05)})[0], scaled[0]),
            kRoundingOfARun);
  EXPECT_GT(worst_difference(plain[0], scaled[0]), 1e-3) << "nothing was tested";
}

struct Refused {
  const char* name;
  const char* effect;
  std::map<std::string, double> changed;
  const char* says;
};
class RefusedLaw : public testing::TestWithParam<Refused> {};

TEST_P(RefusedLaw, SaysWhatWasExpected) {
  std::map<std::string, double> parameters{{"over", 0.0}, {"from", -1.0}, {"to", 1.0}, {"knots", 5.0}};
  for (const auto& [key, given] : GetParam().changed) parameters[key] = given;
  const double values = parameters["knots"] * std::max(parameters["knots_2"], 1.0);
  for (int k = 1; k <= std::min(values, 1.0 * kMostValues); ++k) parameters["value_" + std::to_string(k)] = 0.0;
  Scenario scenario = bare_scenario(
      block_robot(), {actuator("slide", "torque_source", {{"gain", 3.0}, {"damping", 1.0}, {"stiffness", 20.0}})});
  scenario.effects = {effect(GetParam().effect, "slide", parameters)};
  try {
    const PlantModel model(scenario);
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(GetParam().says));
  }
}

INSTANTIATE_TEST_SUITE_P(
    LearnedCurve, RefusedLaw,
    testing::Values(Refused{"ReadingOverASpeed", "learned_reading", {{"over", 1.0}}, "the joint's own position"},
                    Refused{"ReadingOverAnotherJoint", "learned_reading", {{"of", 1.0}}, "the joint's own position"},
                    Refused{"OfAJointBeyondTheLast", "learned_effort", {{"of", 2.0}}, "the number of a joint"},
                    Refused{"AnothersCommand", "learned_effort", {{"over", 2.0}, {"of", 1.0}}, "the number of a joint"},
                    Refused{"HalfAVariable", "learned_effort", {{"over", 0.5}}, "a whole number"},
                    Refused{"TooManyValues",
                            "learned_effort",
                            {{"knots", 64.0}, {"knots_2", 8.0}, {"from_2", 0.0}, {"to_2", 1.0}},
                            "at most 256"},
                    Refused{"AnotherPeriodThanItsKnots", "learned_effort", {{"period", 2.0}}, "that of the knots"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace lacuna
