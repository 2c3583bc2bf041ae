#include "trial/records.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reports/json.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "tests/reports/sample.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

TEST(BlindLabels, AreReadAndCheckedInForm) {
  const BlindLabel label = read_label(
      R"({"case": "d03", "effects": [{"effect": "coulomb_friction", "location": "joint_2", "strength": 25}],
          "left_rms_over_noise": 7.2, "truth": {"gain": [1]}})",
      "label.json");
  ASSERT_EQ(label.effects.size(), 1u);
  EXPECT_EQ(label.effects[0].place, "joint_2");
  EXPECT_EQ(label.left_rms_over_noise, 7.2);
  EXPECT_TRUE(std::isnan(read_label(R"({"effects": []})", "label.json").left_rms_over_noise));
  for (const char* bad : {"", "[", "3", "{}", R"({"effects": 3})", R"({"effects": [3]})", R"({"effects": [{}]})",
                          R"({"effects": [{"effect": 1, "location": "a"}]})"})
    EXPECT_NE(test::input_error([&] { read_label(bad, "dir/label.json"); }).find("dir/label.json"), std::string::npos)
        << bad;
}

TEST(BlindLabels, SayWhatElseTheMachineHad) {
  const BlindLabel label = read_label(
      R"({"effects": [{"effect": "background", "location": "arm", "strength": 0.7}],
          "conditions": {"uneven": 0.3, "alone": "joint_2"}})",
      "label.json");
  EXPECT_TRUE(label.effects.empty()) << "a background is nothing that can be named";
  EXPECT_EQ(label.conditions.at("background"), 0.7);
  EXPECT_EQ(label.conditions.at("uneven"), 0.3);
  EXPECT_TRUE(label.has("alone"));
  EXPECT_TRUE(label.inexact());
  EXPECT_FALSE(read_label(R"({"effects": [], "conditions": {"alone": "joint_2"}})", "label.json").inexact());
  EXPECT_THROW(read_label(R"({"effects": [], "conditions": [1]})", "label.json"), InputError);
}

TEST(BlindLabels, SayTheLawOutsideTheCatalogue) {
  const BlindLabel label = read_label(
      R"({"effects": [{"effect": "tight_spot", "location": "a", "strength": 2, "stage": "link", "over": ["q", "v"],
                       "curve": [{"at": [0.5, -1], "value": 3}]},
                      {"effect": "repeated_samples", "location": "a", "strength": 0.2, "stage": "reading", "over": ["t"],
                       "events": [{"recording": "r.csv", "from": 1.5, "to": 1.7, "value": null}]},
                      {"effect": "position_ripple", "location": "b", "strength": 1}]})",
      "label.json");
  ASSERT_TRUE(label.effects[0].law && label.effects[1].law);
  EXPECT_EQ(label.effects[0].law->curve[0].at, (std::vector<double>{0.5, -1.0}));
  EXPECT_EQ(label.effects[1].law->events[0].to, 1.7);
  EXPECT_FALSE(label.effects[2].law) << "a label of an earlier version";
}

/// Entries of a label or under `learned` that are refused, each with the key at fault.
const std::vector<std::pair<std::string, std::string>> kBadLaws{
    {R"("stage": 3, "over": ["q"])", "stage"},
    {R"("stage": "link")", "over"},
    {R"("stage": "link", "over": [])", "over"},
    {R"("stage": "link", "over": [1])", "over"},
    {R"("stage": "link", "over": ["q", "v", "u"])", "over"},
    {R"("stage": "link", "over": ["q"], "curve": {})", "curve"},
    {R"("stage": "link", "over": ["q"], "curve": [3])", "value"},
    {R"("stage": "link", "over": ["q"], "curve": [{"at": 1}])", "value"},
    {R"("stage": "link", "over": ["q"], "curve": [{"value": 1}])", "at"},
    {R"("stage": "link", "over": ["q"], "curve": [{"at": [1, 2], "value": 1}])", "at"},
    {R"("stage": "link", "over": ["q"], "curve": [{"at": "x", "value": 1}])", "at"},
    {R"("stage": "link", "over": ["t"], "events": 1)", "events"},
    {R"("stage": "link", "over": ["t"], "events": [[]])", "recording"},
    {R"("stage": "link", "over": ["t"], "events": [{"recording": "r", "from": 1}])", "to"}};

TEST(BlindLabels, RefuseALawThatIsNone) {
  for (const auto& [law, key] : kBadLaws) {
    const std::string effect = R"({"effects": [{"effect": "e", "location": "a", )" + law + "}]}",
                      entry = R"({"format": "lacuna-diagnosis/1", "verdict": "unknown_physics", "findings": [],
                                  "learned": [{"where": "a", )" +
                              law + "}]}";
    for (const std::string& error : {test::input_error([&] { read_label(effect, "dir/some.json"); }),
                                     test::input_error([&] { read_verdict(entry, "dir/some.json"); })}) {
      EXPECT_NE(error.find("dir/some.json"), std::string::npos) << law;
      EXPECT_NE(error.find("under " + key), std::string::npos) << law << ": " << error;
    }
  }
}

TEST(BlindVerdicts, AreReadFromADiagnosis) {
  const Diagnosis diagnosis = sample::diagnosis();
  const BlindVerdict verdict = read_verdict(to_json(diagnosis, sample::context()), "diagnosis.json");
  EXPECT_EQ(verdict.verdict, to_string(diagnosis.verdict));
  ASSERT_EQ(verdict.claims.size(), diagnosis.findings.size());
  EXPECT_EQ(verdict.claims[0].members, diagnosis.findings[0].members);
  EXPECT_EQ(verdict.claims[0].probability, diagnosis.findings[0].probability);
  EXPECT_EQ(verdict.noise, diagnosis.noise);
  EXPECT_EQ(verdict.before, rms_in(diagnosis.before, Role::test));
  EXPECT_EQ(verdict.first_round.size(), diagnosis.rounds.at(0).size());
  ASSERT_EQ(diagnosis.learned.empty(), verdict.learned.empty());
  if (!verdict.learned.empty()) {
    EXPECT_EQ(verdict.learned[0].place, diagnosis.learned[0].place);
    EXPECT_EQ(verdict.learned[0].law.curve.size(), diagnosis.learned[0].curve.size());
  }
  for (const char* bad : {"", "{}", R"({"format": "lacuna-fit/1"})", R"({"format": "lacuna-diagnosis/1"})"})
    EXPECT_NE(test::input_error([&] { read_verdict(bad, "x.json"); }), "") << bad;
}

}  // namespace
}  // namespace lacuna
