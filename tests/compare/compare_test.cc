// The comparison as a whole.
#include "compare/compare.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "backends/engine.h"

namespace lacuna {
namespace {

TEST(Compare, DrawsAnEngineWhoseOwnStepsDivergeByTheCommonMethod) {
  // Oil springs are faster than the steps by which engines are held against each other.
  Scenario scenario = load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/hydrolek/hydraulic/scenario.yaml");
  std::erase_if(scenario.recordings, [](const RecordingSpec& spec) { return spec.role != Role::test; });
  CompareOptions options;
  options.engines = {"featherstone"};
  options.duration = 0.3;
  options.identify = false;
  std::vector<EngineRun> runs;
  const ScenarioComparison out = compare_engines(scenario, options, &runs);
  const auto own = std::find_if(out.engines.front().methods.begin(), out.engines.front().methods.end(),
                                [](const MethodResult& method) { return method.native; });
  ASSERT_NE(own, out.engines.front().methods.end());
  ASSERT_FALSE(std::isfinite(own->trajectory_error)) << "its own steps carry it: nothing is tested";
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs.back().method, kCommonMethod);
  for (const std::vector<double>& q : runs.back().run.q)
    for (const double x : q) ASSERT_TRUE(std::isfinite(x));
}

}  // namespace
}  // namespace lacuna
