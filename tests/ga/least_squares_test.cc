#include "ga/least_squares.h"

#include <gtest/gtest.h>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

const PendulumTruth kFar{2.0, 1.5, 6.0, 1.0};
const std::vector<std::string> kDrive{"gain", "damping", "stiffness"};

TEST(Problem, JacobianIsThatOfCentralDifferences) {
  Setting s(pendulum_problem(kFar, {"gain", "damping", "stiffness", "mass"}, 1e-3));
  const std::vector<double> point = s.space.start();
  const Eigen::MatrixXd J = s.problem.jacobian(point, s.problem.residual(point, s.train), s.train);
  for (std::size_t a = 0; a < point.size(); ++a) {
    std::vector<double> up = point, down = point;
    const double h = 1e-4 * point[a];
    up[a] += h, down[a] -= h;
    const Eigen::VectorXd slope = (s.problem.residual(up, s.train) - s.problem.residual(down, s.train)) / (2.0 * h);
    // Forward differences over 1e-6 of the value: curvature and rounding each leave about 1e-6 of the slope.
    EXPECT_LT((J.col(a) - slope).norm(), 1e-5 * slope.norm()) << "axis " << a;
  }
}

TEST(Problem, JacobianStaysInsideTheBoxAtAnUpperBound) {
  Setting s(pendulum_problem(kFar, kDrive, 1e-3));
  std::vector<double> point = s.space.start();
  const Eigen::MatrixXd inside = s.problem.jacobian(point, s.problem.residual(point, s.train), s.train);
  point[0] = s.space.axes()[0].upper;
  const Eigen::MatrixXd at_bound = s.problem.jacobian(point, s.problem.residual(point, s.train), s.train);
  EXPECT_TRUE(at_bound.allFinite());
  EXPECT_GT(at_bound.col(0).norm(), 0.0);
  EXPECT_EQ(at_bound.cols(), inside.cols());
}

TEST(Problem, StacksResidualsInItsLayoutAndLeavesMissingSamplesOut) {
  Scenario scenario = pendulum_problem(kFar, kDrive, 1e-3);
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  auto& q = data->columns[data->find("q_swing")];
  q[10] = q[11] = q[200] = kMissing;
  scenario.recordings[0].data = data;
  Setting s(scenario);
  const auto blocks = s.problem.layout(s.train);
  ASSERT_EQ(blocks.size(), 1u);
  EXPECT_EQ(blocks[0].count, data->rows() - 3);
  const Eigen::VectorXd r = s.problem.residual(s.space.start(), s.train);
  EXPECT_EQ(r.size(), blocks[0].count);
  EXPECT_TRUE(r.allFinite());
  const auto predicted = predict_one(s.model, s.experiment, on("featherstone", 0.005));
  EXPECT_DOUBLE_EQ(r(9), (predicted[0][0][9] - q[9]) / s.problem.weights()[0]);
  EXPECT_DOUBLE_EQ(r(10), (predicted[0][0][12] - q[12]) / s.problem.weights()[0]);
}

TEST(Problem, CostIsTheNormOfTheWhitenedResidual) {
  Setting s(pendulum_problem(kFar, kDrive, 1e-3));
  const std::vector<std::vector<double>> points{s.space.start(), {3.0, 0.8, 4.0}};
  std::vector<double> costs(2);
  s.problem.costs(points, costs, s.train, Fitness::norm_2);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(costs[i], s.problem.residual(points[i], s.train).norm(), 1e-9 * costs[i]);
  EXPECT_LT(costs[1], costs[0]);
}

TEST(LeastSquares, RecoversAKnownOptimumFromAFarStart) {
  Setting s(pendulum_problem(kFar, kDrive, 0.0));
  const LeastSquaresResult fit = solve_least_squares(s.problem, s.space.start(), s.train);
  const std::vector<double> truth{3.0, 0.8, 4.0};
  // Data at 1 ms steps, fit at 5 ms: the integration error is far below this.
  for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(fit.point[a], truth[a], 1e-4 * truth[a]) << a;
}

TEST(LeastSquares, StepDoesNotDependOnTheUnitsOfItsCoordinates) {
  Eigen::MatrixXd J(5, 3);
  J << 1.0, 0.3, 0.2, 0.4, 2.0, -0.1, -0.7, 0.5, 1.5, 0.2, 0.9, 0.8, 1.1, -0.6, 0.4;
  const Eigen::VectorXd r = Eigen::VectorXd::LinSpaced(5, 1.0, 3.0);
  const Eigen::VectorXd units(
      Eigen::Vector3d(1e10, 1.0, 1e-8));  // a spring's 1/k beside a mass beside a large stiffness
  const Eigen::MatrixXd K = J * units.asDiagonal();
  const Eigen::VectorXd exact = J.colPivHouseholderQr().solve(-r);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(3);
  const Eigen::VectorXd plain = damped_step(J.transpose() * J, J.transpose() * r, 0.0, none);
  const Eigen::VectorXd scaled = damped_step(K.transpose() * K, K.transpose() * r, 1e-13, none);
  EXPECT_LT((plain - exact).norm(), 1e-12 * exact.norm());
  EXPECT_LT((units.cwiseProduct(scaled) - exact).norm(), 1e-10 * exact.norm());
}

TEST(LeastSquares, StepLeavesACoordinateWithoutEffectAlone) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(2, 2);
  normal(0, 0) = 4.0;
  const Eigen::VectorXd step = damped_step(normal, Eigen::Vector2d(-8.0, 0.0), 0.0, Eigen::Vector2d::Zero());
  EXPECT_EQ(step(0), 2.0);
  EXPECT_EQ(step(1), 0.0);
}

TEST(LeastSquares, StepLeavesACoordinateWhoseColumnIsRoundingWhereItStands) {
  std::vector<Axis> axes(2);
  for (Axis& axis : axes) axis.lower = -0.1, axis.upper = 0.1;
  Eigen::MatrixXd J(3, 2);
  J << 100.0, 1e-9, 200.0, -2e-9, -300.0, 1e-9;
  const Eigen::VectorXd r = Eigen::Vector3d(1.0, 5.0, -2.0);
  const Eigen::MatrixXd normal = J.transpose() * J;
  const Eigen::VectorXd gradient = J.transpose() * r;
  const Eigen::VectorXd free = damped_step(normal, gradient, 0.0, Eigen::Vector2d::Zero());
  const Eigen::VectorXd kept = damped_step(normal, gradient, 0.0, least_curvatures(axes));
  EXPECT_GT(std::fabs(free(1)), 1e8);
  EXPECT_LT(std::fabs(kept(1)), 1e-6);
  EXPECT_NEAR(kept(0), -J.col(0).dot(r) / J.col(0).squaredNorm(), 1e-6);
}

TEST(LeastSquares, ErrorsAreThoseThatItsCovarianceStates) {
  Setting s(pendulum_problem(kFar, kDrive, 2e-3));
  const LeastSquaresResult fit = solve_least_squares(s.problem, s.space.start(), s.train);
  const double n = static_cast<double>(fit.residual.size());
  EXPECT_NEAR(fit.sum_of_squares, n - 3.0, 5.0 * std::sqrt(2.0 * n)) << "weights are the noise";
  const Identifiability known = identifiability(s.space, fit.point, fit.jacobian, 1.0, 1.0);
  const std::vector<double> truth{3.0, 0.8, 4.0};
  EXPECT_EQ(known.rank, 3);
  for (Eigen::Index a = 0; a < 3; ++a) {
    const double error = std::sqrt(known.covariance(a, a));
    EXPECT_LT(std::fabs(fit.point[a] - truth[a]), 4.0 * error) << a;
    EXPECT_LT(error, 0.05 * truth[a]) << a;
  }
}

/// The fit of a pendulum from afar, and that from its end with the Jacobian handed back.
struct Fits {
  explicit Fits(const std::string& engine) : s(pendulum_problem(kFar, kDrive, 2e-3), 0.005, engine) {
    LeastSquaresOptions options;
    options.polish = false;
    first = solve_least_squares(s.problem, s.space.start(), s.train, options);
    options.jacobian = &first.jacobian;
    again = solve_least_squares(s.problem, first.point, s.train, options);
  }
  Setting s;
  LeastSquaresResult first, again;
};

std::string engine_without_lanes() {
  for (const std::string& engine : available_engines()) {
    if (Setting(pendulum_problem(kFar, kDrive, 1e-3), 0.005, engine).problem.simulator().lanes() == 1) return engine;
  }
  return "";
}

TEST(LeastSquares, TakesFewJacobiansAndAKnownOneSparesTheFirst) {
  const std::string engine = engine_without_lanes();
  if (engine.empty()) GTEST_SKIP() << "every engine built computes several models at once";
  Fits fits(engine);
  EXPECT_TRUE(fits.first.converged);
  EXPECT_LT(fits.first.evaluations, fits.first.iterations * 4) << "fewer than a Jacobian of 3 columns and a trial each";
  // The Jacobian handed back belongs to the end, not to an update on the way.
  const Eigen::MatrixXd there = fits.s.problem.jacobian(fits.first.point, fits.first.residual, fits.s.train);
  EXPECT_LT((fits.first.jacobian - there).norm(), 1e-9 * there.norm());
  EXPECT_LE(fits.again.evaluations, 3 + 9) << "one new Jacobian and one iteration's trials at most";
}

TEST(LeastSquares, AsksCoarserDampingsOnlyWhereAStepBreaksItsPromiseToTheSameEnd) {
  const std::string single = engine_without_lanes();
  if (single.empty()) GTEST_SKIP() << "every engine built computes several models at once";
  Fits lanes("featherstone"), one(single);
  ASSERT_GT(lanes.s.problem.simulator().lanes(), 1);
  EXPECT_TRUE(lanes.first.converged);
  EXPECT_LT(lanes.first.evaluations, lanes.first.iterations * (3 + 2)) << "seldom all eight";
  const Identifiability known = identifiability(one.s.space, one.first.point, one.first.jacobian, 1.0, 1.0);
  for (Eigen::Index a = 0; a < 3; ++a) {
    const std::size_t k = a;
    EXPECT_NEAR(lanes.first.point[k], one.first.point[k], 0.1 * std::sqrt(known.covariance(a, a))) << "axis " << k;
  }
}

/// The space with a prior on every axis, about `centers`, a standard deviation of `width` of them.
SearchSpace with_priors(const SearchSpace& space, const std::vector<double>& centers, double width) {
  std::vector<Axis> axes = space.axes();
  for (std::size_t a = 0; a < axes.size(); ++a) axes[a].center = centers[a], axes[a].prior = width * centers[a];
  SearchSpace out = space;
  out.replace(axes);
  return out;
}

TEST(LeastSquares, MinimisesTheSumOfDataAndPriors) {
  for (const bool polish : {false, true}) {
    Setting s(pendulum_problem(kFar, kDrive, 2e-3));
    // Off the truth (3, .8, 4), and as sharp as the data: both parts count.
    const SearchSpace space = with_priors(s.space, {3.03, 0.81, 3.96}, 3e-3);
    Problem problem(s.model, s.experiment, space, on("featherstone", 0.005), first_weights(s.model, s.experiment));
    LeastSquaresOptions options;
    options.polish = polish;
    const LeastSquaresResult fit = solve_least_squares(problem, space.start(), s.train, options);
    const Eigen::VectorXd prior = prior_information(space.axes());
    Eigen::VectorXd slope = fit.jacobian.transpose() * fit.residual;
    for (std::size_t a = 0; a < space.size(); ++a) slope(a) += prior(a) * (fit.point[a] - space.axes()[a].center);
    Eigen::MatrixXd normal = fit.jacobian.transpose() * fit.jacobian;
    normal.diagonal() += prior;
    const Eigen::VectorXd left = normal.ldlt().solve(slope);
    for (Eigen::Index a = 0; a < left.size(); ++a)
      EXPECT_LT(std::fabs(left(a)), 0.2 * std::sqrt(normal.inverse()(a, a))) << "off the bottom along axis " << a;
    EXPECT_DOUBLE_EQ(fit.sum_of_squares, fit.residual.squaredNorm());
    EXPECT_DOUBLE_EQ(fit.prior_cost, prior_cost(space.axes(), fit.point));
    EXPECT_GT(fit.prior_cost, 1.0);
    const Identifiability known = identifiability(space, fit.point, fit.jacobian, 1.0, 1.0);
    EXPECT_LT((known.covariance - normal.inverse()).norm(), 1e-6 * known.covariance.norm());
  }
}

TEST(LeastSquares, TakesACombinationThatTheDataHardlyDetermineToItsBottom) {
  // The common factor of gain, damping, stiffness and mass is known to half a percent by four priors of a percent, all
  // else a thousand times better; the fit begins one of its standard deviations off.
  Setting s(pendulum_problem({}, {"gain", "damping", "stiffness", "mass"}, 1e-5));
  const SearchSpace space = with_priors(s.space, s.space.start(), 0.01);
  Problem problem(s.model, s.experiment, space, on("featherstone", 0.005), first_weights(s.model, s.experiment));
  std::vector<double> start = space.start();
  for (double& x : start) x *= 1.005;
  const Eigen::MatrixXd there = problem.jacobian(start, problem.residual(start, s.train), s.train);
  LeastSquaresOptions options;
  options.polish = false;
  options.jacobian = &there;
  options.nearby = true;
  const LeastSquaresResult fit = solve_least_squares(problem, start, s.train, options);
  for (std::size_t a = 0; a < 4; ++a)
    EXPECT_NEAR(fit.point[a] / space.axes()[a].center, 1.0, 0.2 * 0.005) << "axis " << a;
}

TEST(LeastSquares, LeavesAnUndeterminedDirectionAtTheCentreOfItsPrior) {
  // Gain, damping, stiffness and mass up to one common factor, from a start off the centre along it.
  Setting s(pendulum_problem({2.5, 1.0, 3.0, 1.0}, {"gain", "damping", "stiffness", "mass"}, 1e-3));
  const SearchSpace space = with_priors(s.space, s.space.start(), 0.7);
  Problem problem(s.model, s.experiment, space, on("featherstone", 0.005), first_weights(s.model, s.experiment));
  std::vector<double> start = space.start();
  for (double& x : start) x *= 4.0;
  const LeastSquaresResult fit = solve_least_squares(problem, start, s.train);
  // In relative changes the data leave (3, .8, 4, 1) times a factor; the priors' best of them, in closed form.
  const std::vector<double> truth{3.0, 0.8, 4.0, 1.0};
  double along = 0.0, square = 0.0;
  for (std::size_t a = 0; a < 4; ++a) {
    const double share = truth[a] / space.axes()[a].center;
    along += share, square += share * share;
  }
  for (std::size_t a = 0; a < 4; ++a) EXPECT_NEAR(fit.point[a], truth[a] * along / square, 0.03 * truth[a]) << a;
  const Identifiability known = identifiability(space, fit.point, fit.jacobian, 1.0, 1.0);
  EXPECT_EQ(known.rank, 3) << "a prior determines nothing";
  for (std::size_t a = 0; a < 4; ++a) {
    const Eigen::Index i = a;
    EXPECT_GT(known.relative_error[a], 1.0) << a;
    EXPECT_LT(std::sqrt(known.covariance(i, i)), space.axes()[a].prior) << "wider than its prior: axis " << a;
  }
}

TEST(LeastSquares, RefusesAPointOfAnotherSpace) {
  Setting s(pendulum_problem(kFar, kDrive, 1e-3));
  EXPECT_THROW(solve_least_squares(s.problem, {1.0, 2.0}, s.train), std::invalid_argument);
}

TEST(LeastSquares, StaysInItsBoundsAndIdentifySaysWhichParameterIsStuck) {
  Scenario scenario = pendulum_problem(kFar, {"gain", "damping"}, 1e-3);
  scenario.identify.push_back({"stiffness", false, 5.0, 9.0, "test"});  // the truth is 4
  Setting s(scenario);
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  const FitResult fit = identify(s.model, s.experiment, s.space, options);
  ASSERT_EQ(fit.estimates.size(), 3u);
  EXPECT_EQ(fit.estimates[2].name, "swing.stiffness");
  EXPECT_TRUE(fit.estimates[2].at_bound);
  EXPECT_NEAR(fit.estimates[2].value, 5.0, 1e-3);
  EXPECT_FALSE(fit.estimates[0].at_bound);
  EXPECT_FALSE(fit.estimates[1].at_bound);
}

TEST(EffectiveSamples, AreAllSamplesOfWhiteNoise) {
  const Eigen::Index n = 4000;
  Eigen::VectorXd r(n);
  Noise random(3);
  for (Eigen::Index k = 0; k < n; ++k) r(k) = random();
  const std::vector<ResidualBlock> blocks{{0, 0, 0, n}};
  EXPECT_NEAR(effective_samples(r, blocks), static_cast<double>(n), 0.15 * static_cast<double>(n));
  EXPECT_LE(effective_samples(r, blocks), static_cast<double>(n));
}

TEST(EffectiveSamples, OfFirstOrderNoiseFollowTheory) {
  for (const double phi : {0.5, 0.8, 0.9}) {
    const Eigen::Index n = 40000;
    Eigen::VectorXd r(n);
    Noise random(4);
    double x = 0.0;
    for (Eigen::Index k = -1000; k < n; ++k) {
      x = phi * x + random();
      if (k >= 0) r(k) = x;
    }
    const double theory = static_cast<double>(n) * (1.0 - phi) / (1.0 + phi);
    const std::vector<ResidualBlock> whole{{0, 0, 0, n}}, halves{{0, 0, 0, n / 2}, {1, 0, n / 2, n / 2}};
    EXPECT_NEAR(effective_samples(r, whole), theory, 0.15 * theory) << phi;
    EXPECT_NEAR(effective_samples(r, halves), theory, 0.15 * theory) << phi;
  }
}

TEST(Identifiability, FindsAndNamesTheScaleThatAnglesLeaveOpen) {
  // Gain, damping, stiffness and mass up to one common factor.
  Setting s(pendulum_problem({2.5, 1.0, 3.0, 1.0}, {"gain", "damping", "stiffness", "mass"}, 1e-3));
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  const FitResult fit = identify(s.model, s.experiment, s.space, options);
  EXPECT_EQ(fit.identifiability.rank, 3);
  EXPECT_GT(fit.identifiability.condition, 1e4);
  ASSERT_EQ(fit.identifiability.undetermined.size(), 1u);
  for (const double weight : fit.identifiability.undetermined[0].weights) {
    EXPECT_NEAR(std::fabs(weight), 0.5, 0.01) << "all four by the same factor";
  }
  ASSERT_EQ(fit.undetermined.size(), 1u);
  for (const char* name : {"swing.gain", "swing.damping", "swing.stiffness", "rod.mass"}) {
    EXPECT_NE(fit.undetermined[0].find(name), std::string::npos) << fit.undetermined[0];
  }
  for (const Estimate& e : fit.estimates) {
    EXPECT_FALSE(e.identifiable) << e.name;
    EXPECT_TRUE(e.spans_range) << e.name;
    const bool may_be_negative = e.name == "swing.gain";  // hoses may be swapped
    EXPECT_TRUE(may_be_negative || e.lower95 >= 0.0) << e.name << ": " << e.lower95;
  }
}

TEST(Identifiability, OfAKnownMassIsFull) {
  Setting s(pendulum_problem({2.5, 1.0, 3.0, 1.0}, kDrive, 1e-3));
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  const FitResult fit = identify(s.model, s.experiment, s.space, options);
  EXPECT_EQ(fit.identifiability.rank, 3);
  EXPECT_TRUE(fit.undetermined.empty());
  for (const Estimate& e : fit.estimates) {
    EXPECT_TRUE(e.identifiable) << e.name;
    EXPECT_FALSE(e.spans_range) << e.name;
    EXPECT_LT(e.lower95, e.value);
    EXPECT_GT(e.upper95, e.value);
  }
}

/// Worst error of a column of the Jacobian beside differences at the problem's own step, over the column.
double worst_column(Setting& s) {
  const std::vector<double> point = s.space.start();
  const Eigen::VectorXd at = s.problem.residual(point, s.train);
  const Eigen::MatrixXd J = s.problem.jacobian(point, at, s.train);
  double worst = 0.0;
  for (std::size_t a = 0; a < point.size(); ++a) {
    std::vector<double> moved = point;
    moved[a] += 1e-6 * (s.space.axes()[a].coordinate == Coordinate::logarithm ? 1.0 : point[a]);
    const Eigen::VectorXd slope = (s.problem.residual(moved, s.train) - at) / (moved[a] - point[a]);
    EXPECT_GT(slope.norm(), 0.0) << "axis " << a;
    worst = std::max(worst, (J.col(a) - slope).norm() / slope.norm());
  }
  return worst;
}

TEST(Problem, JacobianOfJointsThatCannotMoveEachOtherIsThatOfEachAlone) {
  Scenario scenario = two_machines({effect("coulomb_friction", "swing", {{"Fc", 1.0}})});
  for (const char* joint : {"slide", "swing"})
    for (const char* name : {".gain", ".damping", ".stiffness"})
      scenario.identify.push_back({joint + std::string(name), true, 0.2, 5.0, "test"});
  Setting s(scenario);
  ASSERT_EQ(s.space.size(), 6u);
  EXPECT_LT(worst_column(s), 1e-9);
}

/// Everything of both machines free, by a factor of 5 either way.
Scenario all_of_two_machines(double swing_damping) {
  Scenario scenario = two_machines();
  scenario.actuators.back().parameters["damping"] = swing_damping;
  for (const char* joint : {"slide", "swing"})
    for (const char* name : {".gain", ".damping", ".stiffness"})
      scenario.identify.push_back({joint + std::string(name), true, 0.2, 5.0, "test"});
  for (const char* link : {"block", "rod"})
    scenario.identify.push_back({link + std::string(".mass"), true, 0.2, 5.0, "test"});
  return scenario;
}

TEST(Problem, SensitivitiesAreTakenAtALongerStepThanTheResidualWhereTheyStayTheSame) {
  Setting s(all_of_two_machines(0.5), 0.02 / 32);
  const double worst = worst_column(s);
  EXPECT_LT(worst, 0.02);
  EXPECT_GT(worst, 1e-9) << "simulated at the residual's own step";
}

TEST(Problem, SensitivitiesStayAtTheResidualsStepWhereALongerOneDiverges) {
  // The rod's inertia is .27 kg m^2: at 10 ms its damper is beyond what Kutta's method stands (2.8 / step).
  Setting s(all_of_two_machines(100.0), 0.005);
  EXPECT_LT(worst_column(s), 1e-9);
}

TEST(Problem, JacobianOfAMeasuredMotionIsThatOfEachNumberAlone) {
  // Two links that carry each other: their drives and frictions share simulations, their masses do not.
  Scenario scenario =
      bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                    {actuator("shoulder", "torque_source", {{"gain", 3.0}, {"damping", 0.8}, {"stiffness", 4.0}}),
                     actuator("elbow", "torque_source", {{"gain", 2.0}, {"damping", 0.5}, {"stiffness", 2.0}})},
                    false);
  add_recording(scenario, simulated_recording(scenario, rested_drive(4.0, 0.0, 2), {{0.0, 0.0}, {0.0, 0.0}, false},
                                              engine_of_data(), "run.csv", 1e-4, 3));
  scenario.prediction = InverseDynamics{5.0};
  for (const char* joint : {"shoulder", "elbow"}) {
    scenario.effects.push_back(effect("coulomb_friction", joint, {{"Fc", 0.2}}));
    scenario.effects.push_back(effect("hysteresis_friction", joint, {{"Fc", 0.1}, {"sigma0", 20.0}}));
    for (const char* name : {".gain", ".damping", ".stiffness", ".coulomb_friction.Fc", ".hysteresis_friction.Fc"})
      scenario.identify.push_back({joint + std::string(name), true, 0.2, 5.0, "test"});
  }
  for (const char* name : {"upper.mass", "lower.mass"}) scenario.identify.push_back({name, true, 0.2, 5.0, "test"});
  Setting s(scenario);
  ASSERT_EQ(s.space.size(), 12u);
  EXPECT_EQ(worst_column(s), 0.0) << "not the same bits";
}

TEST(Identify, WhatOneJointLeavesWidensNoIntervalOfAnother) {
  Scenario both = two_machines({effect("coulomb_friction", "swing", {{"Fc", 1.0}})}), alone = both;
  for (const char* name : {"slide.gain", "slide.damping", "slide.stiffness"}) {
    for (Scenario* scenario : {&both, &alone}) scenario->identify.push_back({name, true, 0.2, 5.0, "test"});
  }
  for (const char* name : {"swing.gain", "swing.damping", "swing.stiffness"})
    both.identify.push_back({name, true, 0.2, 5.0, "test"});
  alone.channels.of[ChannelKind::position].erase("swing");
  const auto widths = [](const Scenario& scenario) {
    const PlantModel model(scenario);
    const Experiment experiment = make_experiment(scenario);
    IdentifyOptions options;
    options.optimizer = Optimizer::lsq;
    const FitResult fit = identify(model, experiment, SearchSpace(model, scenario), options);
    std::vector<double> out;
    for (const Estimate& e : fit.estimates) out.push_back(e.upper95 - e.lower95);
    return out;
  };
  const std::vector<double> beside = widths(both), own = widths(alone);
  ASSERT_EQ(own.size(), 3u);
  for (std::size_t k = 0; k < own.size(); ++k) EXPECT_NEAR(beside[k], own[k], 0.1 * own[k]) << k;
}

TEST(Identify, StepsAsShortAsTheValuesFoundNeed) {
  // Guessed with a third of its damping the pendulum is not stiff; as it is, 10 ms is beyond what Kutta's method
  // stands.
  constexpr double kDamping = 400.0, kNoise = 1e-3;  // N m s/rad, rad
  const Scenario truth = pendulum_scenario({1200.0, kDamping, 1600.0});
  Scenario scenario = pendulum_scenario({1200.0, kDamping / 3.0, 1600.0});
  for (const Role role : {Role::train, Role::validate}) {
    add_recording(scenario,
                  simulated_recording(truth, rested_drive(6.0, 3.1 * static_cast<double>(role)), {{0.0}, {0.0}, false},
                                      engine_of_data(), std::string(to_string(role)) + ".csv", kNoise, 5),
                  role);
  }
  scenario.identify.push_back({"damping", true, 0.2, 5.0, "test: identify.damping"});
  scenario.noise[ChannelKind::position]["swing"] = kNoise;
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  const double guessed = choose_step(model, experiment, options.simulator, model.values()).step;
  const FitResult fit = identify(model, experiment, SearchSpace(model, scenario), options);
  EXPECT_LT(fit.step.step, guessed);
  EXPECT_LE(fit.step.step, choose_step(model, experiment, options.simulator, fit.values).step);
  EXPECT_NEAR(fit.estimates.front().value, kDamping, 0.02 * kDamping);
  for (const auto& [role, rms] : fit.rms) {
    if (role == Role::test) continue;
    EXPECT_LT(rms.front().second, 1.1 * kNoise);
  }
}

}  // namespace
}  // namespace lacuna
