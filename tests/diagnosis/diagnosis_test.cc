// Small diagnoses from end to end: what is concealed is found, what is not there is not.
#include "diagnosis/diagnosis.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "diagnosis/anew.h"
#include "diagnosis/baseline.h"
#include "diagnosis/checkpoint.h"
#include "diagnosis/evidence.h"
#include "diagnosis/exchange.h"
#include "diagnosis/prune.h"
#include "diagnosis/rounds.h"
#include "diagnosis/unexplained.h"
#include "diagnosis/without.h"
#include "tests/diagnosis/interrupted.h"
#include "tests/diagnosis/noise.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

const PendulumTruth kStart{2.2, 1.1, 5.0, 1.0};
const std::vector<std::string> kDrive{"gain", "damping", "stiffness"};
constexpr double kNoise = 1e-3;    // rad
constexpr double kDeadband = 0.5;  // V, of a command of 3 V
constexpr double kSlightAsymmetry = 0.02;

DiagnoseOptions small() {
  DiagnoseOptions options;
  options.identify.optimizer = Optimizer::lsq;
  options.identify.simulator.threads = 2;
  options.other_engines = false;
  return options;
}

Scenario concealed_deadband() {
  // Made by another engine than the one that diagnoses, where there is one.
  return pendulum_problem(kStart, kDrive, kNoise, {effect("valve_deadband", "swing", {{"d", kDeadband}})}, 10.0,
                          available_engines().size() > 2 ? available_engines()[2] : engine_of_data());
}

/// A ripple of the transducer, which no effect of the catalogue makes.
void add_ripple(Scenario& scenario, double height) {
  for (RecordingSpec& recording : scenario.recordings) {
    auto rippled = std::make_shared<Recording>(*recording.data);
    auto& q = rippled->columns[rippled->find("q_swing")];
    for (std::size_t k = 50; k < q.size(); ++k) q[k] += height * std::sin(0.26 * static_cast<double>(k));
    recording.data = rippled;
  }
}

TEST(Misfits, NameTheSecondsThatHoldMoreThanNoiseAndNoOthers) {
  const Experiment experiment = make_experiment(concealed_deadband());
  std::vector<ResidualBlock> blocks;
  Eigen::Index rows = 0;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s) {
    const Eigen::Index n = experiment.segments[s].count;
    blocks.push_back({static_cast<int>(s), 0, rows, n});
    rows += n;
  }
  const std::vector<double> noise{1.0};
  const std::vector<int> joints{0};
  int false_alarms = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    false_alarms += !misfits(white(rows, 100 + seed), blocks, noise, joints, experiment).empty();
  EXPECT_LE(false_alarms, 2);  // one in a thousand each: three or more in 200 come once in 900 times
  Eigen::VectorXd r = white(rows, 1);
  const Segment& second = experiment.segments[1];
  const double from = second.time(0) + 3.0;
  for (std::size_t k = 0; k < second.count; ++k) {
    if (second.time(k) >= from && second.time(k) < from + 1.5) r(blocks[1].first + static_cast<Eigen::Index>(k)) += 5.0;
  }
  const std::vector<Misfit> found = misfits(r, blocks, noise, joints, experiment);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].recording, second.file);
  EXPECT_EQ(found[0].joint, "swing");
  EXPECT_NEAR(found[0].begin, from, 0.02);
  EXPECT_NEAR(found[0].end, from + 2.0, 0.02);
  EXPECT_GT(found[0].ratio, 3.0);
  EXPECT_LT(found[0].p_value, 1e-3);
}

TEST(Diagnosis, FindsAConcealedDeadbandWithItsSizeAndRemovesIt) {
  const Diagnosis d = diagnose(concealed_deadband(), small());
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  ASSERT_FALSE(d.findings.empty());
  const Finding& f = d.findings[0];
  EXPECT_EQ(f.effect, "valve_deadband");
  EXPECT_EQ(f.place, "swing");
  ASSERT_EQ(f.parameters.size(), 1u);
  EXPECT_NEAR(f.parameters[0].value, kDeadband, 0.02 * kDeadband);
  EXPECT_LT(f.p_value, 1e-6);
  EXPECT_GT(f.heldout_gain, 0.0);
  auto rms = [](const FitResult& fit) { return fit.rms.back().second.front().second; };
  ASSERT_EQ(d.after.rms.back().first, Role::test);
  EXPECT_LT(rms(d.after), 1.2 * kNoise);
  EXPECT_GT(rms(d.before), 3.0 * rms(d.after));
}

TEST(Diagnosis, ALagBesideAnInertiaIsNoSpring) {
  const Diagnosis d = diagnose(
      pendulum_problem(kStart, kDrive, kNoise,
                       {effect("armature", "swing", {{"J", 0.1}}), effect("actuator_lag", "swing", {{"T", 0.005}})},
                       10.0, engine_of_data()),
      small());
  // Alone a spring with inertia and damper behind it explains more than either.
  ASSERT_FALSE(d.rounds.empty());
  EXPECT_EQ(d.rounds[0].front().effect, "joint_compliance");
  ASSERT_EQ(d.findings.size(), 2u);
  EXPECT_EQ(d.findings[0].effect, "actuator_lag");
  EXPECT_NEAR(d.findings[0].parameters.front().value, 0.005, 0.0005);
  // On one pendulum an inertia, another gravity and a spring that hardens are one class.
  EXPECT_EQ(std::count(d.findings[1].members.begin(), d.findings[1].members.end(), "armature"), 1);
}

TEST(Diagnosis, JudgesEveryFindingBesideTheOthers) {
  const Diagnosis d = diagnose(pendulum_problem(kStart, kDrive, kNoise,
                                                {effect("valve_deadband", "swing", {{"d", kDeadband}}),
                                                 effect("valve_asymmetry", "swing", {{"a", 0.2}})},
                                                10.0, engine_of_data()),
                               small());
  ASSERT_EQ(d.findings.size(), 2u);
  for (const Finding& f : d.findings) {
    // Each is all that is missing without it: in the round that found it, the first left much to the second.
    EXPECT_GT(f.heldout_share, 0.97) << f.effect;
    EXPECT_GT(f.probability, 0.9) << f.effect;
  }
}

TEST(Diagnosis, StaysSilentWhereNothingIsMissing) {
  const Diagnosis d = diagnose(pendulum_problem(kStart, kDrive, kNoise, {}, 10.0), small());
  EXPECT_EQ(d.verdict, Verdict::consistent) << (d.findings.empty() ? "" : d.findings[0].effect);
  EXPECT_TRUE(d.findings.empty());
  EXPECT_FALSE(d.unexplained.present);
}

TEST(Diagnosis, SaysHowMuchStaysUnexplained) {
  Scenario scenario = concealed_deadband();
  add_ripple(scenario, 4.0 * kNoise);
  const Diagnosis d = diagnose(scenario, small());
  ASSERT_FALSE(d.findings.empty());
  EXPECT_EQ(d.findings[0].effect, "valve_deadband");
  ASSERT_TRUE(d.unexplained.present);
  EXPECT_GT(d.unexplained.probability, 0.0);
  EXPECT_LT(d.unexplained.probability, 0.5) << "the deadband is most of what was missing";
  // One finding is all that was removed. Its share is found at the step and by the few iterations of a comparison.
  EXPECT_NEAR(d.findings[0].explained, 1.0 - d.unexplained.probability, 0.02);
  EXPECT_EQ(diagnose(concealed_deadband(), small()).unexplained.probability, 0.0);
}

TEST(Diagnosis, GivesTheSameNumbersOnOneAndTwoThreads) {
  DiagnoseOptions one = small(), two = small();
  one.identify.simulator.threads = 1;
  const Scenario scenario = concealed_deadband();
  const Diagnosis a = diagnose(scenario, one), b = diagnose(scenario, two);
  EXPECT_TRUE(same_bits(a.after.values, b.after.values));
  ASSERT_EQ(a.findings.size(), b.findings.size());
  for (std::size_t i = 0; i < a.findings.size(); ++i) EXPECT_EQ(a.findings[i].p_value, b.findings[i].p_value);
}

TEST(Diagnosis, ResumesAfterAnInterruptionToTheSameNumbers) {
  const auto folder = std::filesystem::temp_directory_path() / ("lacuna_diagnosis_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const Scenario scenario = concealed_deadband();
  const Diagnosis whole = diagnose(scenario, small());
  StopFlag stop{false};
  // The plain model is done then.
  DiagnoseOptions options = stopping_at(small(), folder / "diagnosis.json", "every effect", stop);
  EXPECT_THROW(diagnose(scenario, options), Interrupted);
  EXPECT_TRUE(std::filesystem::exists(options.identify.control.checkpoint));
  stop = false;
  bool searched_again = false;
  options.identify.control.progress = [&](const Progress& p) {
    searched_again = searched_again || p.stage.find("least squares") != std::string::npos;
  };
  const Diagnosis resumed = diagnose(scenario, options);
  EXPECT_FALSE(searched_again) << "the plain model was identified anew";
  EXPECT_TRUE(same_bits(whole.before.values, resumed.before.values));
  EXPECT_TRUE(same_bits(whole.after.values, resumed.after.values));
  ASSERT_EQ(whole.findings.size(), resumed.findings.size());
  for (std::size_t i = 0; i < whole.findings.size(); ++i) {
    const Finding &a = whole.findings[i], &b = resumed.findings[i];
    EXPECT_EQ(a.effect, b.effect);
    EXPECT_EQ(a.probability, b.probability);
    EXPECT_EQ(a.p_value, b.p_value);
    EXPECT_EQ(a.heldout_gain, b.heldout_gain);
    EXPECT_EQ(a.stability, b.stability);
  }
  // Another problem's checkpoint is refused, and an end removes it.
  options.identify.control.problem = "something else";
  EXPECT_THROW(diagnose(scenario, options), InputError);
  DiagnosisCheckpoint::remove(options.identify.control.checkpoint);
  EXPECT_FALSE(std::filesystem::exists(options.identify.control.checkpoint));
  std::filesystem::remove_all(folder);
}

/// A model with effects as if they had been found, identified on the train recordings.
CurrentModel found(const CurrentModel& plain, const Experiment& experiment, const std::vector<Finding>& findings,
                   const std::vector<std::vector<double>>& own) {
  CurrentModel out = plain;
  for (std::size_t k = 0; k < findings.size(); ++k) {
    const EffectSpec spec{findings[k].effect, findings[k].place, findings[k].fixed, {}, "test"};
    out = extended(out, experiment, spec, out.fit.point, own[k]);
  }
  refine(out, {experiment, on("featherstone", 0.005)}, 25);
  return out;
}

/// A model with two findings on the pendulum, from a plain refit.
struct Pruned {
  Pruned(const Scenario& scenario, const std::string& first, const std::vector<double>& strengths)
      : Pruned(scenario, {on_swing(first), on_swing("valve_deadband")}, {{strengths[0]}, {strengths[1]}}) {}
  Pruned(const Scenario& scenario, std::vector<Finding> two, const std::vector<std::vector<double>>& own)
      : model(scenario), experiment(make_experiment(scenario)), space(model, scenario), findings(std::move(two)) {
    FitResult fit;
    plain = identify_plain(model, experiment, space, small().identify, fit);
    both = found(*plain, experiment, findings, own);
  }
  static Finding on_swing(const std::string& effect) {
    Finding out;
    out.effect = effect, out.place = "swing";
    return out;
  }
  FitContext context() const { return {experiment, on("featherstone", 0.005)}; }
  std::vector<std::string> again() { return prune(*plain, *both, findings, context()); }
  void judge() { judge_anew(*plain, *both, findings, context(), 10, 1); }

  PlantModel model;
  Experiment experiment;
  SearchSpace space;
  std::optional<CurrentModel> plain, both;
  std::vector<Finding> findings;
};

TEST(Prune, TakesOutWhatTheOtherFindingsMakeNeedlessAndNothingElse) {
  Pruned two(concealed_deadband(), "quadratic_damping", {0.01, kDeadband});
  EXPECT_EQ(two.again(), std::vector<std::string>{"quadratic_damping at swing"});
  ASSERT_EQ(two.findings.size(), 1u);
  EXPECT_EQ(two.findings[0].effect, "valve_deadband");
  ASSERT_EQ(two.both->model.effects().size(), 1u);
  EXPECT_NEAR(two.both->space.expand(two.both->fit.point).back(), kDeadband, 0.02 * kDeadband);
  EXPECT_TRUE(two.again().empty()) << "the last one stays";
}

TEST(JudgeAnew, SaysOfEachWhatItIsWorthBesideTheOthersAndAmongRivalsThatAreNoFindings) {
  Pruned two(concealed_deadband(), "quadratic_damping", {0.01, kDeadband});
  Finding &damping = two.findings[0], &deadband = two.findings[1];
  // As if each had been found alone: the damping for the whole, in one class with the deadband.
  damping.probability = 0.99, damping.p_value = 1e-9, damping.heldout_gain = 500.0, damping.heldout_share = 0.6;
  damping.members = {"quadratic_damping", "valve_deadband"};
  damping.rivals = {{"valve_deadband", "swing", 0.01, {}, {kDeadband}, {}}};
  deadband.probability = 0.1, deadband.p_value = 0.5, deadband.heldout_gain = 0.0;
  deadband.rivals = {{"coulomb_friction", "swing", 0.9, {{"v0", 0.0}}, {0.1}, {}}};
  two.judge();
  EXPECT_EQ(damping.p_value, 1.0);
  EXPECT_LT(std::fabs(damping.heldout_gain), 10.0);
  EXPECT_EQ(damping.members, std::vector<std::string>{"quadratic_damping"});
  EXPECT_TRUE(damping.rivals.empty()) << "the deadband is a finding of its own";
  EXPECT_GT(deadband.probability, 0.99);
  EXPECT_LT(deadband.p_value, 1e-6);
  EXPECT_GT(deadband.heldout_gain, 100.0);
  EXPECT_GT(deadband.heldout_share, 0.9);
}

TEST(JudgeRest, WhatExplainsNoMoreThanIsLeftIsNotAsSureAsWhatExplainsMost) {
  // The deadband is most of what is missing at the joint; the asymmetry is no more than the ripple that nothing
  // explains.
  Scenario scenario = pendulum_problem(kStart, kDrive, kNoise,
                                       {effect("valve_deadband", "swing", {{"d", kDeadband}}),
                                        effect("valve_asymmetry", "swing", {{"a", kSlightAsymmetry}})},
                                       10.0, engine_of_data());
  add_ripple(scenario, 4.0 * kNoise);
  Pruned two(scenario, "valve_asymmetry", {kSlightAsymmetry, kDeadband});
  Diagnosis d;
  d.findings = two.findings;
  for (Finding& finding : d.findings) finding.probability = 1.0, finding.members = {finding.effect};
  judge_rest(d, *two.plain, *two.both, two.context());
  ASSERT_TRUE(d.unexplained.present);
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  const Finding &asymmetry = d.findings[0], &deadband = d.findings[1];
  EXPECT_GT(deadband.explained, 0.95);
  EXPECT_GT(deadband.probability, 0.99);
  EXPECT_LT(asymmetry.explained, 0.7);
  EXPECT_LT(asymmetry.probability, 0.95);
  EXPECT_GT(asymmetry.probability, 0.5) << "two of three of the least share are there";
  // With the asymmetry alone most of it stays unknown.
  Diagnosis alone;
  Without rest = without(1, *two.plain, *two.both, two.findings, two.experiment);
  ASSERT_TRUE(refit(rest.model, two.context()));
  alone.findings = rest.findings;
  alone.findings[0].probability = 1.0, alone.findings[0].members = {"valve_asymmetry"};
  judge_rest(alone, *two.plain, rest.model, two.context());
  EXPECT_LT(alone.findings[0].explained, 0.5);
  EXPECT_EQ(alone.verdict, Verdict::unknown_physics);
}

TEST(Prune, WhatOneFindingContainsOfAnotherItTakesOver) {
  constexpr double kSpring = 60.0, kSide = 0.05;  // N m/rad, kg m^2
  Finding spring = Pruned::on_swing("joint_compliance");
  spring.fixed = {{"J", 0.0}, {"c", 0.0}};
  Pruned two(
      pendulum_problem(kStart, kDrive, kNoise, {effect("joint_compliance", "swing", {{"k", kSpring}, {"J", kSide}})},
                       10.0, engine_of_data()),
      {Pruned::on_swing("armature"), spring}, {{kSide}, {1.0 / kSpring}});
  EXPECT_EQ(two.again(), std::vector<std::string>{"armature at swing"});
  ASSERT_EQ(two.findings.size(), 1u);
  EXPECT_EQ(two.findings[0].fixed, (std::map<std::string, double>{{"c", 0.0}})) << "the inertia is free now";
  const std::vector<double> values = two.both->space.expand(two.both->fit.point);
  EXPECT_NEAR(values[values.size() - 3], kSpring, 0.05 * kSpring);
  EXPECT_NEAR(values[values.size() - 2], kSide, 0.05 * kSide);
}

TEST(Rounds, FindAnewWhatALaterFindingContains) {
  constexpr double kSpring = 60.0, kSide = 0.05, kLag = 0.02;  // N m/rad, kg m^2, s
  const Scenario scenario = pendulum_problem(kStart, kDrive, kNoise,
                                             {effect("joint_compliance", "swing", {{"k", kSpring}, {"J", kSide}}),
                                              effect("actuator_lag", "swing", {{"T", kLag}})},
                                             10.0, engine_of_data());
  Finding spring = Pruned::on_swing("joint_compliance");
  spring.fixed = {{"c", 0.0}};
  // As if the inertia had been found before its spring, and then a spring without one.
  Pruned wrong(scenario, {Pruned::on_swing("armature"), spring}, {{kSide}, {1.0 / kSpring, std::log(1e-3)}});
  Diagnosis d;
  d.findings = wrong.findings;
  DiagnosisCheckpoint none("", "", false);
  const Report silent = [](const std::string&, double) {};
  Rounds rounds(scenario, {wrong.experiment, on("featherstone", 0.005, 2)}, none, *wrong.plain, d, silent);
  rounds.current = *wrong.both;
  rounds.reconsider();
  ASSERT_EQ(d.findings.size(), 2u);
  EXPECT_EQ(d.findings[0].effect, "joint_compliance");
  EXPECT_EQ(d.findings[1].effect, "actuator_lag");
  const std::vector<double> values = rounds.current.space.expand(rounds.current.fit.point);
  EXPECT_NEAR(values.back(), kLag, 0.1 * kLag);
}

TEST(Diagnosis, SaysWhereOnlyTheTestRecordingMissesSomething) {
  const Scenario silent = pendulum_problem(kStart, kDrive, kNoise, {}, 10.0, engine_of_data());
  Scenario scenario = silent;
  const Scenario stuck = pendulum_problem(kStart, kDrive, kNoise, {effect("coulomb_friction", "swing", {{"Fc", 0.2}})},
                                          10.0, engine_of_data());
  for (std::size_t k = 0; k < scenario.recordings.size(); ++k) {
    if (scenario.recordings[k].role == Role::test) scenario.recordings[k] = stuck.recordings[k];
  }
  const auto says = [](const Diagnosis& d) {
    return std::count_if(d.notes.begin(), d.notes.end(), [](const std::string& note) {
      return note.find("swing: the test recordings leave") != std::string::npos;
    });
  };
  const Diagnosis d = diagnose(scenario, small());
  EXPECT_EQ(d.verdict, Verdict::consistent) << "test recordings choose nothing";
  EXPECT_EQ(says(d), 1);
  EXPECT_EQ(says(diagnose(silent, small())), 0);
}

TEST(Diagnosis, AStartInMidMotionIsNoPhysics) {
  // Four recordings each: their estimated starts are off by what noise allows, which the parameters must not take up.
  int alarms = 0;
  double squares = 0.0;
  constexpr int kCases = 6;
  for (int k = 0; k < kCases; ++k) {
    const Scenario truth = pendulum_scenario({});
    Scenario scenario = pendulum_scenario(kStart);
    std::uint64_t seed = 100 * static_cast<std::uint64_t>(k);
    for (const Role role : {Role::train, Role::train, Role::validate, Role::test}) {
      const Drive drive = sine_drive(1, 6.0, 0.02, 3.0, static_cast<double>(++seed));
      add_recording(scenario,
                    simulated_recording(truth, drive, {{0.1}, {0.8}, false}, engine_of_data(),
                                        std::to_string(seed) + ".csv", kNoise, seed),
                    role);
    }
    for (const std::string& name : kDrive) scenario.identify.push_back({name, true, 0.2, 5.0, "test: " + name});
    scenario.noise[ChannelKind::position]["swing"] = kNoise;
    const Diagnosis d = diagnose(scenario, small());
    alarms += d.verdict != Verdict::consistent;
    const PendulumTruth right;
    for (const auto& [name, value] : {std::pair{"swing.gain", right.gain}, {"swing.damping", right.damping}}) {
      const auto found = std::find_if(d.after.estimates.begin(), d.after.estimates.end(),
                                      [&](const Estimate& e) { return e.name == name; });
      ASSERT_NE(found, d.after.estimates.end());
      squares += std::pow((found->value - value) / ((found->upper95 - found->lower95) / (2.0 * 1.96)), 2);
    }
  }
  EXPECT_EQ(alarms, 0);
  // Mean square of 12 standardised errors: chi-square, 1 in 1,000 above 32.9.
  EXPECT_LT(squares, 32.9);
}

TEST(Prune, KeepsTwoThatAreBothThere) {
  Pruned two(pendulum_problem(kStart, kDrive, kNoise,
                              {effect("valve_deadband", "swing", {{"d", kDeadband}}),
                               effect("valve_asymmetry", "swing", {{"a", 0.2}})},
                              10.0, engine_of_data()),
             "valve_asymmetry", {0.2, kDeadband});
  EXPECT_TRUE(two.again().empty());
  EXPECT_EQ(two.findings.size(), 2u);
}

TEST(Exchange, PutsTheRivalInThatExplainsMoreBesideTheOthersAndKeepsWhatIsRight) {
  const std::vector<EffectSpec> concealed{effect("valve_deadband", "swing", {{"d", kDeadband}}),
                                          effect("valve_asymmetry", "swing", {{"a", 0.2}})};
  const Scenario scenario = pendulum_problem(kStart, kDrive, kNoise, concealed, 10.0, engine_of_data());
  Pruned wrong(scenario, "damping_asymmetry", {0.2, kDeadband});
  wrong.findings[0].rivals = {{"valve_asymmetry", "swing", 0.1, {}, {0.1}, {}},
                              {"input_delay", "swing", 0.0, {}, {0.01}, {}}};
  wrong.findings[1].rivals = {{"coulomb_friction", "swing", 0.0, {{"v0", 0.0}}, {0.1}, {}}};
  const auto look = [](Pruned& p) { return exchange(*p.plain, *p.both, p.findings, p.context()); };
  ASSERT_EQ(look(wrong).size(), 1u);
  wrong.judge();
  EXPECT_EQ(wrong.findings[0].effect, "valve_asymmetry");
  EXPECT_EQ(wrong.findings[1].effect, "valve_deadband");
  EXPECT_GT(wrong.findings[0].probability, 0.99);
  EXPECT_GT(wrong.findings[0].heldout_gain, 0.0);
  EXPECT_LT(wrong.findings[0].p_value, 1e-3);
  ASSERT_FALSE(wrong.findings[0].rivals.empty());
  EXPECT_EQ(wrong.findings[0].rivals[0].effect, "damping_asymmetry") << "what gave way stays a rival";
  const std::vector<double> values = wrong.both->space.expand(wrong.both->fit.point);
  EXPECT_NEAR(values[values.size() - 2], 0.2, 0.02) << "the asymmetry";
  EXPECT_TRUE(look(wrong).empty()) << "now all is right";
}

TEST(Diagnosis, NamesEveryJointUnderNoiseEvenWhereItIsUnknown) {
  Scenario scenario = concealed_deadband();
  scenario.prediction = InverseDynamics{4.0};
  const Diagnosis d = diagnose(scenario, small());
  ASSERT_EQ(d.noise.size(), 1u);
  EXPECT_EQ(d.noise[0].first, "swing");
}

TEST(DiagnosedScenario, SearchesTheSameSpaceAgain) {
  Scenario scenario = concealed_deadband();
  // Names as a user mixes them: a kind, a full name that refines it, absolute bounds.
  scenario.identify = {{"gain", true, 0.2, 5.0, "test"},
                       {"damping", true, 0.5, 2.0, "test"},
                       {"swing.damping", true, 0.2, 5.0, "test"},
                       {"mass", true, 0.9, 1.1, "test"},
                       {"stiffness", false, 1.0, 25.0, "test"}};
  const PlantModel plain(scenario);
  const SearchSpace space(plain, scenario);
  Diagnosis d;
  d.findings = {Finding{}};
  d.findings[0].effect = "valve_deadband", d.findings[0].place = "swing";
  d.after.values = plain.values();
  for (double& value : d.after.values) value *= 1.05;
  d.after.values.push_back(kDeadband);
  const Scenario found = diagnosed_scenario(scenario, d);
  const PlantModel model(found);
  const SearchSpace again(model, found);
  ASSERT_EQ(again.size(), space.size());
  for (std::size_t a = 0; a < space.size(); ++a) {
    const Axis &was = space.axes()[a], &is = again.axes()[a];
    EXPECT_EQ(model.parameters()[is.parameter].name, plain.parameters()[was.parameter].name);
    EXPECT_DOUBLE_EQ(is.lower, was.lower);
    EXPECT_DOUBLE_EQ(is.upper, was.upper);
  }
  // At a wall, too, the diagnosed scenario loads.
  d.after.values[plain.find("swing.gain")] = std::exp(std::log(5.0 * kStart.gain)) * (1 + 1e-15);
  EXPECT_NO_THROW(SearchSpace(PlantModel(diagnosed_scenario(scenario, d)), diagnosed_scenario(scenario, d)));
}

TEST(DiagnosedScenario, RunsAsItIsAndPredictsWhatTheDiagnosisDid) {
  const Scenario scenario = concealed_deadband();
  const Diagnosis d = diagnose(scenario, small());
  const Scenario found = diagnosed_scenario(scenario, d);
  ASSERT_EQ(found.effects.size(), d.findings.size());
  const PlantModel model(found);
  EXPECT_TRUE(same_bits(model.values(), d.after.values));
  const Experiment experiment = make_experiment(found);
  Problem problem(model, experiment, SearchSpace(model, scenario), on("featherstone", d.after.step.step),
                  first_weights(model, experiment));
  const JointRms rms = residual_rms(problem, model.values(), Role::test);
  EXPECT_NEAR(rms[0].second, d.after.rms.back().second[0].second, 1e-9);
}

}  // namespace
}  // namespace lacuna
