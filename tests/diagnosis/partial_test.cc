// In which recordings an effect acts, read off what the model leaves there with it and without.
#include "diagnosis/partial.h"

#include <gtest/gtest.h>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kLoad = 0.5;  // kg

/// A pendulum that carries a load in "loaded.csv" only; all recordings but the first are `seconds` long.
struct Carrying {
  Carrying(const Prediction& prediction, double seconds) : scenario(pendulum_scenario({})) {
    Scenario truth = scenario;
    truth.effects = {effect("payload", "arm", {{"m", kLoad}}, {"loaded.csv"})};
    for (const auto& [file, role] :
         {std::pair{"first.csv", Role::train}, {"loaded.csv", Role::validate}, {"bare.csv", Role::validate}}) {
      const Drive drive = sine_drive(1, role == Role::train ? 4.0 : seconds, 0.02, 3.0, 1.7);
      add_recording(
          scenario,
          simulated_recording(truth, drive, {{0.9}, {0.0}, false}, available_engines().front(), file, 1e-5, 3), role);
    }
    scenario.noise[ChannelKind::position]["swing"] = 1e-5;
    scenario.prediction = prediction;
  }
  std::vector<std::string> on_in() const {
    const PlantModel model(scenario);
    const Experiment experiment = make_experiment(scenario);
    const CurrentModel plain{model, SearchSpace(model, scenario), {1.0}, {}};
    const CurrentModel with =
        extended(plain, experiment, {"payload", "arm", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}, {}, "test"}, {}, {kLoad});
    return recordings_with_effect(with, {experiment, on("featherstone", 0.005)}, {Role::validate});
  }
  Scenario scenario;
};

TEST(RecordingsWithEffect, AreThoseThatAMotionShows) {
  EXPECT_EQ(Carrying(FreeRun{}, 4.0).on_in(), std::vector<std::string>{"loaded.csv"});
}

TEST(RecordingsWithEffect, AreThoseThatEffortsShow) {
  EXPECT_EQ(Carrying(InverseDynamics{8.0}, 4.0).on_in(), std::vector<std::string>{"loaded.csv"});
}

TEST(RecordingsWithEffect, OfEffortsMayBeShort) {
  EXPECT_EQ(Carrying(InverseDynamics{8.0}, 1.0).on_in(), std::vector<std::string>{"loaded.csv"});
}

}  // namespace
}  // namespace lacuna
