// The published EMPS recording and the labelled cases, where they lie beside the repository or under $LACUNA_DATA.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "diagnosis/diagnosis.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

std::filesystem::path data_folder() {
  const char* named = std::getenv("LACUNA_DATA");
  return named != nullptr ? std::filesystem::path(named) : std::filesystem::path(LACUNA_SOURCE_DIR) / ".." / "shared";
}

#if defined(__SANITIZE_ADDRESS__) || !defined(NDEBUG)
constexpr bool kSlowBuild = true;
#else
constexpr bool kSlowBuild = false;
#endif

#define NEEDS_DATA(file)                                                                              \
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no data at " << (file) << "; set LACUNA_DATA"; \
  if (kSlowBuild) GTEST_SKIP() << "minutes in this build; runs in release"

DiagnoseOptions options() {
  DiagnoseOptions out;
  out.identify.optimizer = Optimizer::lsq;
  out.identify.simulator.threads = default_threads();
  return out;
}

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> out;
  for (const Finding& f : d.findings) out.push_back(f.effect + " at " + f.place);
  return out;
}
bool has(const Diagnosis& d, const std::string& name) {
  const auto all = names(d);
  return std::find(all.begin(), all.end(), name) != all.end();
}

double test_rms(const FitResult& fit) { return fit.rms.back().second.front().second; }

// The benchmark's reference model (Janot, Gautier and Brunot 2019); its offset is minus our b.
constexpr double kMass = 95.1089, kDamping = 203.5034, kCoulomb = 20.3935, kOffset = 3.1648;

TEST(Emps, DiagnosisFindsTheFrictionWithTheOffset) {
  const auto file = data_folder() / "recordings/emps/scenario.yaml";
  NEEDS_DATA(file);
  const Diagnosis d = diagnose(load_scenario(file), options());
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  EXPECT_TRUE(has(d, "coulomb_friction at slide")) << testing::PrintToString(names(d));
  EXPECT_TRUE(has(d, "torque_offset at slide")) << testing::PrintToString(names(d));  // no valve before a drive's force
}

TEST(Emps, RefitOverTheWholeRecordGivesThePublishedParametersWithinOnePercent) {
  const auto file = data_folder() / "recordings/emps/scenario.yaml";
  NEEDS_DATA(file);
  Scenario scenario = load_scenario(file);
  scenario.recordings.resize(1);
  scenario.recordings[0].from = 0.0;
  scenario.recordings[0].to = 24.84;
  scenario.effects = {effect("coulomb_friction", "slide", {{"Fc", 10.0}, {"v0", 0.0}}),
                      effect("valve_offset", "slide", {{"b", 0.0}})};
  scenario.identify.push_back({"slide.coulomb_friction.Fc", false, 0.0, 100.0, "test"});
  scenario.identify.push_back({"slide.valve_offset.b", false, -20.0, 20.0, "test"});
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  for (const std::string& engine : available_engines()) {
    IdentifyOptions identify_options;
    identify_options.optimizer = Optimizer::lsq;
    identify_options.simulator.engine = engine;
    identify_options.simulator.threads = default_threads();
    const FitResult fit = identify(model, experiment, space, identify_options);
    auto value = [&](const std::string& name) { return fit.values[model.find(name)]; };
    const std::vector<double> masses = model.link_masses(fit.values);
    double mass = 0.0;
    for (const double m : masses) mass += m;
    constexpr double kOnePercent = 0.01;
    EXPECT_NEAR(mass, kMass, kOnePercent * kMass) << engine;
    EXPECT_NEAR(value("slide.damping"), kDamping, kOnePercent * kDamping) << engine;
    EXPECT_NEAR(value("slide.coulomb_friction.Fc"), kCoulomb, kOnePercent * kCoulomb) << engine;
    EXPECT_NEAR(value("slide.valve_offset.b"), kOffset, kOnePercent * kOffset) << engine;
  }
}

TEST(Emps, WindowsNameTheDryFrictionAndTheirTestResidualFallsAtLeastFourfold) {
  const auto file = data_folder() / "recordings/emps/scenario_windows.yaml";
  NEEDS_DATA(file);
  const Diagnosis d = diagnose(load_scenario(file), options());
  // Though a curve over the speed, which is learned beside it, could be any friction.
  EXPECT_TRUE(std::ranges::any_of(d.findings, [](const Finding& f) {
    return std::ranges::count(f.members, "coulomb_friction") > 0;
  })) << testing::PrintToString(names(d));
  EXPECT_GT(test_rms(d.before), 4.0 * test_rms(d.after)) << testing::PrintToString(names(d));
  for (const EngineGain& engine : d.engines) {
    if (engine.available) {
      EXPECT_GT(engine.kept, 0.95) << engine.engine;
    }
  }
}

class DevCase : public testing::TestWithParam<std::string> {};

TEST_P(DevCase, IsDiagnosedAsItsLabelSays) {
  const auto folder = data_folder() / "cases/dev" / GetParam();
  NEEDS_DATA(folder / "scenario.yaml");
  DiagnoseOptions with = options();
  with.other_engines = false;
  const Diagnosis d = diagnose(load_scenario(folder / "scenario.yaml"), with);
  // The label is opened after the answer, and is no input to it.
  const auto label = nlohmann::json::parse(std::ifstream(folder / "label.json"));
  if (label.at("effects").empty()) {
    EXPECT_EQ(d.verdict, Verdict::consistent) << testing::PrintToString(names(d));
    EXPECT_TRUE(d.findings.empty()) << testing::PrintToString(names(d));
    return;
  }
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  for (const auto& planted : label.at("effects")) {
    const std::string name =
        planted.at("effect").get<std::string>() + " at " + planted.at("location").get<std::string>();
    EXPECT_TRUE(has(d, name)) << name << " not among " << testing::PrintToString(names(d));
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, DevCase, testing::Values("d01", "d02", "d03", "d07", "d12", "d21"),
                         [](const auto& p) { return p.param; });

}  // namespace
}  // namespace lacuna
