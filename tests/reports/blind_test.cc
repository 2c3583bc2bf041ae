#include "reports/blind.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/reports/own_scripts.h"
#include "tests/reports/sample.h"
#include "tests/trial/cases.h"

namespace lacuna {
namespace {

using test::claim;
using test::kFriction;
using test::one_case;

TEST(BlindRecord, HasTheNamesThatOthersLookFor) {
  const std::vector<BlindCase> cases{one_case({}, "consistent"),
                                     one_case({kFriction}, "missing_physics", {claim("coulomb_friction", "joint_2")})};
  const auto record = nlohmann::json::parse(to_json(cases, sample::context()));
  EXPECT_EQ(record.at("format"), "lacuna-blind/1");
  EXPECT_TRUE(record.at("context").contains("commit"));
  for (const char* name : {"null_false_alarms", "location_top1", "effect_top1", "class_top1", "abstained_correctly",
                           "set_f1", "heldout_gain_share", "calibration", "seconds"})
    EXPECT_TRUE(record.at("totals").contains(name)) << name;
  EXPECT_EQ(record.at("totals").at("null_false_alarms"), 0);
  EXPECT_EQ(record.at("totals").at("class_top1"), 1.0);
  EXPECT_EQ(record.at("cases")[1].at("label").at("effects")[0].at("location"), "joint_2");
  EXPECT_EQ(record.at("cases")[1].at("correct"), true);
}

TEST(BlindPage, InputCannotBecomeMarkup) {
  const std::string evil = "<script>alert('x')</script>";
  BlindCase hostile = one_case({{evil, evil, 1.0}}, evil, {claim(evil, evil)});
  hostile.name = evil;
  BlindCase failed;
  failed.name = "\xff";
  failed.error = evil;
  const std::string page = blind_page({hostile, failed}, evil, sample::context());
  EXPECT_EQ(without_own_scripts(page).find("<script"), std::string::npos);
  EXPECT_EQ(page.find('\xff'), std::string::npos);
  for (const char* title : {"Totals", "Confusion", "Calibration", "Baselines", "Cases", "Context"})
    EXPECT_NE(page.find("<h2>" + std::string(title) + "</h2>"), std::string::npos) << title;
  EXPECT_NE(blind_page({}, "", Context{}).find("</html>"), std::string::npos);
  EXPECT_NO_THROW(nlohmann::json::parse(to_json(std::vector<BlindCase>{hostile, failed}, sample::context())));
}

}  // namespace
}  // namespace lacuna
