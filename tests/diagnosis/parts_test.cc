// A machine taken apart where its joints cannot move each other, and put together again.
#include "diagnosis/parts.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "diagnosis/baseline.h"
#include "diagnosis/checkpoint.h"
#include "diagnosis/set_search.h"
#include "tests/diagnosis/interrupted.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kPartReading = 1e-4;  // m or rad, noise of a reading

Scenario identified(std::vector<EffectSpec> concealed) {
  Scenario out = two_machines(std::move(concealed), {Role::train, Role::validate, Role::test}, kPartReading);
  for (const char* name : {"gain", "damping", "stiffness"}) out.identify.push_back({name, true, 0.2, 5.0, "test"});
  for (const char* joint : {"slide", "swing"}) out.noise[ChannelKind::position][joint] = kPartReading;
  return out;
}

std::vector<Scenario> parts_at_start(const Scenario& scenario) {
  const Experiment experiment = make_experiment(scenario);
  const PlantModel model(scenario);
  CurrentModel plain{model, SearchSpace(model, scenario), {}, {}};
  plain.weights.assign(experiment.channels.size(), kPartReading);
  const FitContext context{experiment, on("featherstone", 0.005)};
  evaluate_at(plain, plain.space.start(), context);
  return parts_of(scenario, plain, context);
}

TEST(Parts, AreBranchesOfATreeWhoseBaseStandsStill) {
  Scenario scenario = identified({});
  const std::vector<Scenario> parts = parts_at_start(scenario);
  ASSERT_EQ(parts.size(), 2u);
  for (const Scenario& part : parts) {
    EXPECT_EQ(part.robot->dof(), 1);
    EXPECT_EQ(part.robot->joints().front().name, part.name);
    EXPECT_EQ(part.actuators.size(), 1u);
    EXPECT_EQ(part.identify.size(), 3u);
    EXPECT_EQ(make_experiment(part).channels.size(), 1u);
  }
  Scenario held = scenario;
  held.total_mass = 3.0;
  EXPECT_TRUE(parts_at_start(held).empty()) << "a known total mass ties them together";
  Scenario sprung = scenario;
  sprung.effects = {effect("base_tilt", "arm", {{"roll", 0.0}, {"pitch", 0.0}})};
  EXPECT_TRUE(parts_at_start(sprung).empty()) << "an effect of the whole arm ties them together";
  Scenario blind = scenario;
  blind.channels.of[ChannelKind::position].erase("slide");
  EXPECT_TRUE(parts_at_start(blind).empty()) << "one measured branch is all there is";
  EXPECT_TRUE(parts_at_start(pendulum_problem({}, {"gain"}, kPartReading)).empty());
}

TEST(Parts, GoByTheirNamesInEveryFullName) {
  Scenario scenario = identified({});
  scenario.identify = {{"slide.gain", true, 0.2, 5.0, "test"}, {"rod.mass", true, 0.5, 2.0, "test"}};
  const std::vector<Scenario> parts = parts_at_start(scenario);
  ASSERT_EQ(parts.size(), 2u);
  for (const Scenario& part : parts) {
    ASSERT_EQ(part.identify.size(), 1u) << part.name;
    EXPECT_EQ(part.identify.front().name, part.name == "slide" ? "slide.gain" : "rod.mass");
  }
}

TEST(Parts, HoldNoEffectOfTheWholeArm) {
  const Scenario scenario = identified({});
  const Scenario part = parts_at_start(scenario).front();
  Experiment experiment = make_experiment(part);
  const PlantModel model(part);
  const CurrentModel current{model, SearchSpace(model, part), {1.0}, {}};
  const EffectInfo& payload = effect_table()[find_effect("payload")];
  EXPECT_FALSE(places_of(payload, current, experiment).empty());
  experiment.parts = 2;
  EXPECT_TRUE(places_of(payload, current, experiment).empty());
}

TEST(Parts, PutTogetherPredictWhatEachDid) {
  const Scenario scenario = identified({});
  const Experiment whole_experiment = make_experiment(scenario);
  const PlantModel model(scenario);
  const FitContext context{whole_experiment, on("featherstone", 0.005)};
  CurrentModel whole{model, SearchSpace(model, scenario), {kPartReading, kPartReading}, {}};
  whole.fit.point = whole.space.start();
  std::vector<Experiment> experiments;
  std::vector<CurrentModel> models;
  std::vector<Eigen::VectorXd> residuals;
  for (const Scenario& part : parts_at_start(scenario)) {
    experiments.push_back(make_experiment(part));
    CurrentModel one = part_of(whole, whole_experiment, part, experiments.back());
    EXPECT_EQ(one.weights, std::vector<double>{kPartReading});
    for (double& x : one.fit.point) x *= 1.1;
    const EffectSpec friction{"stribeck_friction", part.name, {{"Fs", 1.5}}, {"run_1.csv"}, "test"};
    one = extended(one, experiments.back(), friction, one.fit.point, {0.5, 0.05, 0.0});
    one.weights = {part.name == "slide" ? 2.0 * kPartReading : kPartReading};
    const std::vector<int> all{0, 1, 2};
    residuals.push_back(problem_of(one, context.on(experiments.back())).residual(one.fit.point, all));
    models.push_back(std::move(one));
  }
  const CurrentModel together = put_together(whole, models, experiments, context);
  EXPECT_EQ(together.weights, (std::vector<double>{2.0 * kPartReading, kPartReading}));
  ASSERT_EQ(together.model.effects().size(), 2u);
  EXPECT_EQ(together.model.effects()[1].recordings, std::vector<std::string>{"run_1.csv"});
  EXPECT_EQ(together.space.size(), 6u + 6u) << "what was held stays held";
  EXPECT_EQ(together.fit.jacobian.cols(), 12);
  Problem problem = problem_of(together, context);
  const std::vector<int> all{0, 1, 2};
  const Eigen::VectorXd r = problem.residual(together.fit.point, all);
  std::vector<Eigen::Index> row(2, 0);
  for (const ResidualBlock& block : problem.layout(all)) {
    const std::size_t j = whole_experiment.channels[block.channel].joint;
    const auto own = residuals[j].segment(row[j], block.count);
    EXPECT_LT((r.segment(block.first, block.count) - own).norm(), 1e-6 * own.norm()) << block.segment << " " << j;
    row[j] += block.count;
  }
}

/// Three eighths of the time the shoulder alone is commanded, three eighths the elbow alone, at last both.
Drive in_turn(Drive drive) {
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    const double passed = drive.time[k] / drive.time.back();
    if (passed < 0.75) drive.u[passed < 0.375 ? 1 : 0][k] = 0.0;
  }
  return drive;
}

/// Two rods, one on the other, each moved by a cylinder whose oil is so stiff; the recordings have `concealed`.
/// `turns`: in_turn(), and predicted over half seconds.
Scenario rods_on_cylinders(double stiffness, std::vector<EffectSpec> concealed, bool turns = false) {
  const auto drive = [&](const char* joint) {
    return actuator(joint, "flow_source", {{"gain", 0.5}, {"stiffness", stiffness}, {"damping", 0.01 * stiffness}});
  };
  const auto at_rest = [&](int k) {
    const Drive commands = rested_drive(turns ? 24.0 : 8.0, 7.3 * k, 2);
    return turns ? in_turn(commands) : commands;
  };
  const Start rest{{0.0, 0.0}, {0.0, 0.0}, false};
  Scenario out = driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                                 {drive("shoulder"), drive("elbow")}, at_rest(0), rest);
  Scenario truth = out;
  out.recordings.clear();
  truth.effects = std::move(concealed);
  int k = 0;
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    const auto seed = static_cast<std::uint64_t>(k) + 5;
    add_recording(out,
                  simulated_recording(truth, at_rest(k), rest, available_engines().front(),
                                      "run_" + std::to_string(k) + ".csv", kPartReading, seed),
                  role);
    ++k;
  }
  if (turns) out.prediction = Windows{0.5};
  out.identify = {{"gain", true, 0.2, 5.0, "test"}, {"mass", true, 0.2, 5.0, "test"}};
  for (const char* joint : {"shoulder", "elbow"}) out.noise[ChannelKind::position][joint] = kPartReading;
  return out;
}
constexpr double kStiffOil = 2e3, kSoftOil = 40.0;  // N m/rad, under rods of 5 N m

TEST(Parts, AreJointsOfAChainThatItsDrivesMoveWhateverTheLoad) {
  const auto worn = [] {
    return std::vector<EffectSpec>{effect("valve_deadband", "shoulder", {{"d", 0.5}}),
                                   effect("valve_deadband", "elbow", {{"d", 0.5}})};
  };
  const std::vector<Scenario> parts = parts_at_start(rods_on_cylinders(kStiffOil, worn()));
  ASSERT_EQ(parts.size(), 2u);
  for (const Scenario& part : parts) {
    EXPECT_EQ(part.robot->dof(), 1);
    EXPECT_EQ(part.robot->joints().front().name, part.name);
    ASSERT_EQ(part.identify.size(), 1u) << "what a joint is loaded with is not its own";
    EXPECT_EQ(part.identify.front().name, part.name + ".gain");
  }
  EXPECT_TRUE(parts_at_start(rods_on_cylinders(kSoftOil, worn())).empty()) << "one rod's weight moves the other";
  EXPECT_TRUE(parts_at_start(rods_on_cylinders(kStiffOil, {})).empty()) << "nothing is missing: noise is all there is";
}

DiagnoseOptions quick_parts() {
  DiagnoseOptions out;
  out.identify.optimizer = Optimizer::lsq;
  out.identify.simulator.engine = "featherstone";
  out.other_engines = false;
  return out;
}

/// At each place the one effect.
void expect_named(const Diagnosis& out, const std::map<std::string, std::string>& effects) {
  EXPECT_EQ(out.verdict, Verdict::missing_physics);
  std::set<std::string> places;
  for (const Finding& f : out.findings) {
    ASSERT_TRUE(effects.count(f.place)) << f.effect << " at " << f.place;
    EXPECT_TRUE(std::count(f.members.begin(), f.members.end(), effects.at(f.place))) << f.effect << " at " << f.place;
    EXPECT_TRUE(places.insert(f.place).second) << "twice at " << f.place;
  }
  EXPECT_EQ(places.size(), effects.size());
}
/// At each place the one effect, and nothing but the noise left.
void expect_found(const Diagnosis& out, const std::map<std::string, std::string>& effects) {
  expect_named(out, effects);
  for (const auto& [joint, rms] : out.after.rms.back().second) EXPECT_LT(rms, 1.1 * kPartReading) << joint;
}

TEST(Parts, EachHasItsOwnFinding) {
  const Diagnosis out = diagnose(
      identified({effect("coulomb_friction", "swing", {{"Fc", 1.0}}), effect("valve_deadband", "slide", {{"d", 0.4}})}),
      quick_parts());
  expect_found(out, {{"swing", "coulomb_friction"}, {"slide", "valve_deadband"}});
  EXPECT_TRUE(out.worse.empty());
}

TEST(Parts, OfAChainHaveFindingsOfTheirOwn) {
  const Diagnosis out = diagnose(rods_on_cylinders(kStiffOil, {effect("valve_deadband", "shoulder", {{"d", 0.6}}),
                                                               effect("actuator_saturation", "elbow", {{"cap", 1.2}})}),
                                 quick_parts());
  expect_found(out, {{"shoulder", "valve_deadband"}, {"elbow", "actuator_saturation"}});
}

TEST(Parts, SharedByAPumpAreEachInOrder) {
  const std::map<std::string, double> pump{{"n", 8.0}, {"full_shoulder", 3.5}, {"full_elbow", 4.0}};
  const Diagnosis out = diagnose(
      rods_on_cylinders(kStiffOil,
                        {effect("valve_deadband", "shoulder", {{"d", 0.5}}),
                         effect("valve_deadband", "elbow", {{"d", 0.4}}), effect("shared_supply", "arm", pump)},
                        true),
      quick_parts());
  // How far the oil is bent where a window starts is not measured: some of the noise's many times stays.
  expect_named(out, {{"shoulder", "valve_deadband"}, {"elbow", "valve_deadband"}, {"arm", "shared_supply"}});
}

TEST(Parts, ASharedPumpTakesThePlaceOfTheLimitsThatJointsSeemToHave) {
  const std::map<std::string, double> pump{{"n", 8.0}, {"full_shoulder", 3.5}, {"full_elbow", 4.0}};
  const Scenario scenario = rods_on_cylinders(kStiffOil, {effect("shared_supply", "arm", pump)}, true);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  options.simulator = on("featherstone", 0.005);
  options.step = options.simulator.max_step;
  FitResult fit;
  const CurrentModel plain = identify_plain(model, experiment, SearchSpace(model, scenario), options, fit);
  CurrentModel limited = plain;
  std::vector<Finding> found;
  for (const char* joint : {"shoulder", "elbow"}) {
    const EffectSpec limit{"actuator_saturation", joint, {{"n", 8.0}}, {}, "test"};
    limited = extended(limited, experiment, limit, limited.fit.point, {1.0 / 4.0});
    found.emplace_back();
    found.back().effect = limit.effect, found.back().place = joint, found.back().fixed = limit.parameters;
    found.back().members = {limit.effect};
  }
  const FitContext context{experiment, options.simulator};
  refine(limited, context);
  SetSearchOptions search;
  search.skipped = [](const EffectSpec& spec) { return spec.place != "arm"; };
  const auto out = search_sets(plain, limited, found, context, search);
  ASSERT_TRUE(out);
  ASSERT_EQ(out->findings.size(), 1u);
  EXPECT_EQ(out->findings.front().effect, "shared_supply");
  EXPECT_TRUE(out->notes.empty()) << "put in beside the limits, which went afterwards: " << out->notes.front();
  EXPECT_GT(out->findings.front().probability, 0.9);
  for (const char* joint : {"shoulder", "elbow"})
    EXPECT_LT(out->model.model.find_effect_at("actuator_saturation", joint), 0) << joint;
}

TEST(Parts, MayOpenGradually) {
  const Diagnosis out =
      diagnose(rods_on_cylinders(kStiffOil, {effect("valve_deadband", "shoulder", {{"d", 0.6}}),
                                             effect("valve_opening", "elbow", {{"c", 0.7}, {"full", 1.0}})}),
               quick_parts());
  expect_found(out, {{"shoulder", "valve_deadband"}, {"elbow", "valve_opening"}});
}

TEST(Parts, SayNothingOfOneThatIsComplete) {
  const Diagnosis out = diagnose(identified({effect("coulomb_friction", "swing", {{"Fc", 1.0}})}), quick_parts());
  ASSERT_EQ(out.findings.size(), 1u);
  EXPECT_EQ(out.findings.front().place, "swing");
}

TEST(Parts, StayTogetherWhereOneEffectOfTheWholeArmExplainsAll) {
  const Diagnosis out =
      diagnose(identified({effect("base_tilt", "arm", {{"roll", 0.0}, {"pitch", 0.05}})}), quick_parts());
  ASSERT_EQ(out.findings.size(), 1u);
  EXPECT_EQ(out.findings.front().effect, "base_tilt");
  EXPECT_EQ(out.findings.front().place, "arm");
}

TEST(Parts, ResumeAfterAnInterruptionToTheSameNumbers) {
  const auto folder = std::filesystem::temp_directory_path() / ("lacuna_parts_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const Scenario scenario =
      identified({effect("coulomb_friction", "swing", {{"Fc", 1.0}}), effect("valve_deadband", "slide", {{"d", 0.4}})});
  const Diagnosis whole = diagnose(scenario, quick_parts());
  StopFlag stop{false};
  // The slide is done then.
  DiagnoseOptions options = stopping_at(quick_parts(), folder / "diagnosis.json", "swing: every effect", stop);
  EXPECT_THROW(diagnose(scenario, options), Interrupted);
  EXPECT_TRUE(std::filesystem::exists(folder / "diagnosis.part_0.json"));
  stop = false;
  options.identify.control.progress = nullptr;
  const Diagnosis resumed = diagnose(scenario, options);
  EXPECT_TRUE(same_bits(whole.after.values, resumed.after.values));
  ASSERT_EQ(whole.findings.size(), resumed.findings.size());
  for (std::size_t k = 0; k < whole.findings.size(); ++k) {
    EXPECT_EQ(whole.findings[k].effect, resumed.findings[k].effect);
    EXPECT_EQ(whole.findings[k].probability, resumed.findings[k].probability);
  }
  DiagnosisCheckpoint::remove(options.identify.control.checkpoint);
  EXPECT_TRUE(std::filesystem::is_empty(folder)) << "an end removes the parts', too";
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace lacuna
