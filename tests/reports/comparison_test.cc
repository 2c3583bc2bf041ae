#include "reports/comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "scenarios/error.h"
#include "tests/reports/own_scripts.h"
#include "compare/runner.h"

namespace lacuna {
namespace {

Timing about(double median) { return {median, 0.99 * median, 1.01 * median, 9}; }

MethodResult method(const std::string& name, bool native, double error, double ns) {
  MethodResult out;
  out.name = name;
  out.native = native;
  for (const double step : {4e-3, 2e-3, 1e-3}) {
    WorkPoint point;
    point.step = step;
    point.error = error * step;
    point.steps_per_second = 1.0 / step;
    point.cpu_per_second = 1e-9 * ns / step;
    point.stable = true;
    out.points.push_back(point);
  }
  out.order = out.order_free = 1.0;
  out.largest_stable_step = 4e-3;
  out.trajectory_error = error;
  out.energy_drift = error;
  out.momentum_drift = error;
  out.time = {0.0, 0.5, 1.0};
  out.error = {0.0, error, 0.5 * error};
  out.ns_per_step = about(ns);
  out.realtime_factor = 1e6 / ns;
  out.repeats = out.restores = true;
  return out;
}

EngineComparison engine(const std::string& name, double ns) {
  EngineComparison out;
  out.engine = name;
  out.available = true;
  out.acceleration_difference = {1e-14, "random state 3 of seed 1"};
  out.acceleration_error = {2e-14, "random state 4 of seed 1"};
  out.pose_difference = {1e-16, "random state 5 of seed 1"};
  out.states = 1024;
  out.forward_ns = about(ns);
  out.set_inertial_ns = about(0.1 * ns);
  out.build_us = about(10.0);
  out.memory_bytes = 1e4;
  out.methods = {method(kCommonMethod, false, 1e-8, 4.0 * ns), method("own", true, 1e-3, 2.0 * ns)};
  return out;
}

Comparison sample_comparison() {
  Comparison out;
  ScenarioComparison scenario;
  scenario.name = "<script>alert('x')</script>";
  scenario.motion = "1 s & more";
  scenario.dof = 2;
  scenario.duration = scenario.window = 1.0;
  scenario.step = 1e-3;
  scenario.referee = {"a method", 1e-15, 1e-16, 1.0, 0.1};
  scenario.engines = {engine("featherstone", 100.0), engine("mujoco", 400.0)};
  EngineComparison refused;
  refused.engine = "ode";
  refused.reason = "ode cannot hold robot \"<b>\"";
  scenario.engines.push_back(refused);
  scenario.identification.not_run = "not asked for";
  scenario.notes = {"a <note>"};
  out.scenarios.push_back(scenario);
  for (const char* name : {"featherstone", "mujoco", "ode"}) {
    EngineInfo info;
    info.name = name;
    info.available = true;
    info.own_models = {{"armature", "none of <its> own"}};
    out.engines.push_back(info);
  }
  return out;
}

nlohmann::json parsed(const Comparison& comparison) {
  return nlohmann::json::parse(to_json(comparison, Baseline{}, Context{}));
}

TEST(ComparisonJson, HasWhatTheFormatAsksOfEveryEngine) {
  const auto json = parsed(sample_comparison());
  ASSERT_EQ(json.at("engines").size(), 3u);
  const auto& mujoco = json.at("engines")[1];
  EXPECT_EQ(mujoco.at("engine"), "mujoco");
  EXPECT_EQ(mujoco.at("max_acceleration_difference"), 1e-14);
  EXPECT_EQ(mujoco.at("trajectory_error"), 1e-8);
  EXPECT_EQ(mujoco.at("energy_drift"), 1e-8);
  EXPECT_EQ(mujoco.at("ns_per_step"), 1600.0);
  EXPECT_EQ(mujoco.at("realtime_factor"), 625.0);
  EXPECT_EQ(mujoco.at("work_precision")[1].at("points").size(), 3u);
  EXPECT_TRUE(json.contains("context"));
}

TEST(ComparisonJson, SaysWhyAnEngineIsMissingAndNeverWritesNan) {
  const std::string text = to_json(sample_comparison(), Baseline{}, Context{});
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("inf\n"), std::string::npos);
  const auto json = nlohmann::json::parse(text);
  const auto& ode = json.at("engines")[2];
  EXPECT_EQ(ode.at("available"), false);
  EXPECT_TRUE(ode.at("trajectory_error").is_null());
  EXPECT_EQ(ode.at("refused")[0].at("reason"), "ode cannot hold robot \"<b>\"");
}

TEST(ComparisonPage, EscapesAndPutsTheVerdictFirst) {
  const Comparison comparison = sample_comparison();
  const std::string page = without_own_scripts(comparison_page(comparison, {}, Context{}, {}));
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("<note>"), std::string::npos);
  EXPECT_EQ(page.find("\"<b>\""), std::string::npos);
  EXPECT_NE(page.find("a &lt;note&gt;"), std::string::npos);
  EXPECT_LT(page.find("Which engine for which need"), page.find("Method and limits"));
  EXPECT_EQ(page.find("http://"), std::string::npos) << "self-contained";
}

// Every number of the verdict's table stands in the JSON, from which the page's reader can trace it.
TEST(ComparisonPage, ShowsTheFiguresOfTheJson) {
  const auto json = parsed(sample_comparison());
  for (const auto& verdict : json.at("verdict")) {
    EXPECT_FALSE(verdict.at("best").empty());
    EXPECT_FALSE(verdict.at("measure").get<std::string>().empty());
    EXPECT_EQ(verdict.at("figures").size(), 3u);
  }
  EXPECT_EQ(json.at("verdict")[0].at("best"), nlohmann::json{"featherstone"});
  EXPECT_EQ(json.at("verdict")[0].at("figures").at("mujoco"), 400.0);
}

TEST(Recommendations, NameAllThatAreAsGood) {
  Comparison comparison = sample_comparison();
  comparison.scenarios[0].engines[1].forward_ns = about(105.0);  // within ten per cent of 100
  const auto all = recommendations(comparison);
  EXPECT_EQ(all.front().best, (std::vector<std::string>{"featherstone", "mujoco"}));
  comparison.scenarios[0].engines[1].forward_ns = about(115.0);
  EXPECT_EQ(recommendations(comparison).front().best, (std::vector<std::string>{"featherstone"}));
}

TEST(Baseline, OfTheSameFiguresHasNoChange) {
  const Comparison comparison = sample_comparison();
  const Baseline same = changes_since(to_json(comparison, {}, Context{}), "old.json", comparison);
  EXPECT_GT(same.compared, 10u);
  EXPECT_TRUE(same.changes.empty());
}

TEST(Baseline, MarksWhatExceedsTheNoiseAndNothingElse) {
  const Comparison old = sample_comparison();
  Comparison now = sample_comparison();
  EngineComparison& mujoco = now.scenarios[0].engines[1];
  mujoco.forward_ns = about(404.0);                    // one per cent: noise
  mujoco.methods[1].ns_per_step = about(2.0 * 800.0);  // twice
  mujoco.methods[0].trajectory_error = 0.5e-8;         // halved
  mujoco.acceleration_error.value = 9e-14;             // rounding
  const Baseline found = changes_since(to_json(old, {}, Context{}), "old.json", now);
  ASSERT_EQ(found.changes.size(), 2u);
  EXPECT_EQ(found.changes[0].quantity, "common rk4: trajectory_error");
  EXPECT_TRUE(found.changes[0].better);
  EXPECT_EQ(found.changes[1].quantity, "own own: ns_per_step");
  EXPECT_FALSE(found.changes[1].better);
  EXPECT_NE(to_json(now, found, Context{}).find("\"beyond_factor\""), std::string::npos);
}

// All timings half again as long: the machine was busy, no engine changed.
TEST(Baseline, ASlowerMachineIsNoChange) {
  Comparison now = sample_comparison();
  for (EngineComparison& one : now.scenarios[0].engines) {
    if (!one.available) continue;
    for (Timing* timing : {&one.forward_ns, &one.set_inertial_ns, &one.build_us}) *timing = about(1.5 * timing->median);
    for (MethodResult& m : one.methods) m.ns_per_step = about(1.5 * m.ns_per_step.median);
  }
  EXPECT_TRUE(changes_since(to_json(sample_comparison(), {}, Context{}), "old.json", now).changes.empty());
}

TEST(Baseline, ThatIsNoneIsRefused) {
  for (const char* text : {"", "{", "[]", "{}", "{\"format\": \"lacuna-fit/1\"}", "{\"format\": \"lacuna-compare/1\"}",
                           "{\"format\": \"lacuna-compare/1\", \"scenarios\": [3]}"})
    EXPECT_THROW(changes_since(text, "old.json", sample_comparison()), InputError) << text;
}

}  // namespace
}  // namespace lacuna
