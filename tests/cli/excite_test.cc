#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> excite(const Arm& arm, const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> line{"excite", arm.scenario(),  "-o", out.string(), "--population",
                                "8",      "--generations", "5",  "--seconds",  "4"};
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST(Excite, WritesCommandsThatTheProgramItselfSimulates) {
  const Arm arm;
  const fs::path out = arm.folder() / "next";
  const auto record = json_of(lacuna(excite(arm, out, {"--json", "--command", "0.5"})));
  EXPECT_EQ(record.at("format"), "lacuna-excitation/1");
  EXPECT_GT(record.at("best").at("log_det"), record.at("step").at("log_det"));
  std::ostringstream csv;
  csv << std::ifstream(out / "excitation.csv").rdbuf();
  const auto columns = columns_of(csv.str());
  ASSERT_EQ(columns.size(), 2u);
  for (const double u : columns.at("u")) EXPECT_LE(std::fabs(u), 0.5 + 1e-12);
  EXPECT_TRUE(fs::exists(out / "report.html"));
  const Outcome simulated = lacuna({"simulate", arm.scenario(), "--recording", (out / "excitation.csv").string()});
  EXPECT_EQ(simulated.code, 0) << simulated.err;
  EXPECT_GT(simulated.out.size(), 1000u);
}

TEST(Excite, RefusesUnknownShapesAndImpossibleLimits) {
  const Arm arm;
  expect_refused(lacuna(excite(arm, arm.folder() / "a", {"--shape", "square"})), 2, "square");
  expect_refused(lacuna(excite(arm, arm.folder() / "b", {"--speed", "1e-9"})), 3, "limits");
}

}  // namespace
}  // namespace lacuna::test
