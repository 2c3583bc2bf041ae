#include "reports/json.h"

#include <cmath>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "reports/wording.h"
#include "tests/reports/sample.h"

namespace lacuna {
namespace {

using Json = nlohmann::json;

void expect_keys(const Json& object, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) EXPECT_TRUE(object.contains(key)) << key << " is missing in " << object.dump();
}

TEST(DiagnosisJson, HoldsEveryKeyOfTheContract) {
  const Json out = Json::parse(to_json(sample::diagnosis(), sample::context()));
  expect_keys(out, {"format", "scenario", "engine", "seed", "version", "verdict", "findings", "unexplained", "fit",
                    "parameters", "seconds", "context", "candidates", "engines", "identifiability", "step", "notes"});
  EXPECT_EQ(out["format"], "lacuna-diagnosis/1");
  EXPECT_EQ(out["verdict"], "missing_physics");
  EXPECT_EQ(out["version"], "0.1.0");
  expect_keys(out["unexplained"], {"present", "where", "regions", "times", "share", "probability"});
  expect_keys(out["fit"], {"noise", "before", "after"});
  for (const char* when : {"before", "after"}) expect_keys(out["fit"][when], {"train", "validate", "test"});
  EXPECT_DOUBLE_EQ(out["fit"]["before"]["test"]["joint_2"], 1.2e-3);
  EXPECT_DOUBLE_EQ(out["fit"]["noise"]["joint_2"], 3e-4);
  expect_keys(out["parameters"]["joint_2.gain"], {"value", "ci95", "unit", "identifiable", "at_bound"});
}

TEST(DiagnosisJson, FindingHoldsEveryKeyOfTheContract) {
  const Json out = Json::parse(to_json(sample::diagnosis(), sample::context()));
  ASSERT_EQ(out["findings"].size(), 1u);
  const Json& finding = out["findings"][0];
  expect_keys(finding,
              {"effect", "where", "probability", "rivals", "class", "parameters", "evidence", "separating_experiment"});
  expect_keys(finding["rivals"][0], {"effect", "where", "probability"});
  expect_keys(finding["evidence"],
              {"times", "regions", "p_value", "heldout_gain", "heldout_share", "explained_share", "stability"});
  EXPECT_EQ(finding["where"], "joint_2");
  EXPECT_EQ(finding["class"], Json({"coulomb_friction", "stribeck_friction"}));
  EXPECT_EQ(finding["parameters"]["Fc"]["ci95"], Json::array({23.9, 25.5}));
  EXPECT_TRUE(finding["separating_experiment"].is_null());
}

TEST(DiagnosisJson, NamesTheExperimentThatWouldSeparateAClass) {
  Diagnosis d = sample::diagnosis();
  d.findings[0].separation = Separation{{{0.0, 20.0}, {{0.0, 1.0}}}, "stribeck_friction", 12.5, 0.5};
  const Json out = Json::parse(to_json(d, sample::context()))["findings"][0]["separating_experiment"];
  EXPECT_EQ(out, Json({{"file", "separating_1.csv"},
                       {"seconds", 20.0},
                       {"rival", "stribeck_friction"},
                       {"expected_evidence", 12.5},
                       {"expected_evidence_of_a_repeat", 0.5}}));
}

TEST(DiagnosisJson, NamesTheRecordingOfEveryInterval) {
  const Json evidence = Json::parse(to_json(sample::diagnosis(), sample::context()))["findings"][0]["evidence"];
  EXPECT_EQ(evidence["times"], Json::array({{2.1, 2.4}, {5.0, 5.5}}));
  EXPECT_EQ(evidence["recording"], Json::array({"train_1.csv", "train_2.csv"}));
}

void expect_learned_at_joint_2(const Json& learned) {
  expect_keys(learned, {"where", "stage", "over", "unit", "over_unit", "curve", "events", "period", "description",
                        "tells_more", "resembles", "probability", "evidence", "heldout"});
  EXPECT_EQ(learned["where"], "joint_2");
  EXPECT_EQ(learned["stage"], "link");
}

TEST(DiagnosisJson, LearnedLawHoldsEveryKeyOfTheContract) {
  const LearnedLaw law = sample::learned_law();
  const Json out = Json::parse(to_json(sample::learned_diagnosis({law}), sample::context()));
  ASSERT_EQ(out["learned"].size(), 1u);
  const Json& learned = out["learned"][0];
  expect_learned_at_joint_2(learned);
  EXPECT_EQ(learned["over"], Json::array({"q"}));
  EXPECT_EQ(learned["unit"], "N m");
  EXPECT_EQ(learned["over_unit"], "rad");
  EXPECT_EQ(learned["period"], 0.5);
  EXPECT_EQ(learned["description"], law.description);
  EXPECT_EQ(learned["resembles"], Json({{"law", "gear ripple"}, {"share", law.share}}));
  EXPECT_EQ(learned["probability"], 0.97);
  EXPECT_EQ(learned["evidence"], 850.0);
  EXPECT_EQ(learned["heldout"], Json({{"gain", 1234.5}, {"share", 0.94}}));
  ASSERT_EQ(learned["curve"].size(), law.curve.size());
  const LearnedLaw::Point& p = law.curve[3];
  EXPECT_EQ(learned["curve"][3],
            Json({{"at", p.at}, {"value", p.value}, {"lower95", p.lower95}, {"upper95", p.upper95}}));
}

TEST(DiagnosisJson, HoldsSpeedAgainstCommandOfEveryValve) {
  const Json out = Json::parse(to_json(sample::diagnosis(), sample::context()));
  const Json& valve = out.at("speed_against_command").at("joint_2");
  for (const char* of : {"recorded", "simulated"}) {
    const Json& one = valve.at(of);
    expect_keys(one, {"delay", "lag", "command", "speed", "seconds", "stops", "rms"});
    EXPECT_EQ(one.at("speed"), Json({-0.2, 0.0, 0.0, 0.0, 0.3}));
    EXPECT_EQ(one.at("seconds").size(), one.at("command").size());
    EXPECT_EQ(one.at("stops"), Json({nullptr, 0.7}));
    EXPECT_EQ(one.at("rms").at("test"), 0.01);
  }
}

TEST(DiagnosisJson, SaysOfEveryJointWhatIsLeft) {
  Diagnosis d = sample::diagnosis();
  d.unexplained.per_joint = {{"joint_2", 4.0, 0.6}, {"joint_3", std::nan(""), 0.0}};
  const Json joints = Json::parse(to_json(d, sample::context()))["unexplained"]["per_joint"];
  EXPECT_EQ(joints, Json({{"joint_2", {{"rms_over_noise", 4.0}, {"probability", 0.6}}},
                          {"joint_3", {{"rms_over_noise", nullptr}, {"probability", 0.0}}}}));
}

TEST(DiagnosisJson, SaysWhichNumberEveryRecordingHas) {
  Diagnosis d = sample::diagnosis();
  EXPECT_EQ(Json::parse(to_json(d, sample::context()))["unexplained"]["numbers_by_recording"], Json::array());
  d.unexplained.numbers = {sample::number_by_recording()};
  EXPECT_EQ(Json::parse(to_json(d, sample::context()))["unexplained"]["numbers_by_recording"],
            Json::parse(R"([{"where": "joint_3", "number": "valve_offset.b", "unit": "V", "value": 0.1,
                             "standard_deviation": 0.25, "evidence": 31.0, "share": 0.4,
                             "recordings": {"train_1.csv": -0.2, "validate_1.csv": 0.3}}])"));
}

TEST(DiagnosisJson, LearnedLawsStandInTheirOrderAndMayHaveNoPeriodNorEveryBand) {
  LearnedLaw drag = sample::learned_law(false);
  drag.curve.front().upper95 = sample::kInf;
  const Json out = Json::parse(to_json(sample::learned_diagnosis({sample::learned_law(), drag}), sample::context()));
  ASSERT_EQ(out["learned"].size(), 2u);
  EXPECT_EQ(out["learned"][0]["resembles"]["law"], "gear ripple");
  const Json& learned = out["learned"][1];
  EXPECT_EQ(learned["over"], Json::array({"v"}));
  EXPECT_EQ(learned["over_unit"], "rad/s");
  EXPECT_TRUE(learned["period"].is_null());
  EXPECT_TRUE(learned["curve"][0]["upper95"].is_null());
}

TEST(DiagnosisJson, EventsHoldEveryKeyOfTheContract) {
  LearnedEvent weak = sample::learned_event_in("validate_1.csv", Role::validate);
  weak.evidence = 12.0;
  LearnedEvent strong = sample::learned_event();
  strong.evidence = 14.0;
  const std::vector<LearnedEvent> events{weak, strong};
  const Json out = Json::parse(to_json(sample::eventful_diagnosis(events), sample::context()));
  ASSERT_EQ(out["learned"].size(), 1u);
  const Json& learned = out["learned"][0];
  expect_learned_at_joint_2(learned);
  EXPECT_EQ(learned["over"], Json::array({"t"}));
  EXPECT_EQ(learned["over_unit"], "s");
  EXPECT_EQ(learned["unit"], "N m");
  EXPECT_EQ(learned["curve"], Json::array());
  for (const char* none : {"period", "heldout"}) EXPECT_TRUE(learned[none].is_null()) << none;
  EXPECT_EQ(learned["description"], description_of(events));
  EXPECT_EQ(learned["resembles"], Json({{"law", "a push"}, {"share", nullptr}}));
  EXPECT_EQ(learned["evidence"], 14.0) << "of the strongest";
  EXPECT_DOUBLE_EQ(learned["probability"], 1.0 / (1.0 + std::exp(-14.0)));
  ASSERT_EQ(learned["events"].size(), 2u);
  EXPECT_EQ(learned["events"][0], Json({{"recording", "validate_1.csv"},
                                        {"role", "validate"},
                                        {"from", 6.1},
                                        {"to", 6.6},
                                        {"value", 12.0},
                                        {"unit", "N m"},
                                        {"resembles", "a push"},
                                        {"evidence", 12.0}}));
  EXPECT_EQ(learned["events"][1]["recording"], "train_1.csv");
}

TEST(DiagnosisJson, EventsStandBehindTheLawsOneEntryForEachKindAndJoint) {
  using Kind = EventSpec::Kind;
  LearnedEvent elsewhere = sample::learned_event();
  elsewhere.place = "joint_1";
  Diagnosis d = sample::learned_diagnosis({sample::learned_law()});
  d.events = {sample::learned_event(Kind::command), sample::learned_event(), sample::learned_event(Kind::reading),
              elsewhere, sample::learned_event_in("test_1.csv", Role::test)};
  const Json learned = Json::parse(to_json(d, sample::context()))["learned"];
  ASSERT_EQ(learned.size(), 5u);
  EXPECT_EQ(learned[0]["events"], Json::array()) << "a law";
  const std::vector<std::string> stages{"command", "link", "reading", "link"};
  const std::vector<std::string> joints{"joint_2", "joint_2", "joint_2", "joint_1"};
  for (std::size_t k = 0; k < stages.size(); ++k) {
    EXPECT_EQ(learned[k + 1]["stage"], stages[k]) << k;
    EXPECT_EQ(learned[k + 1]["where"], joints[k]) << k;
  }
  ASSERT_EQ(learned[2]["events"].size(), 2u);
  EXPECT_EQ(learned[2]["events"][1]["role"], "test");
  EXPECT_EQ(learned[1]["events"][0]["unit"], "%");
}

TEST(DiagnosisJson, NumbersThatAreNotFiniteBecomeNull) {
  Diagnosis d = sample::diagnosis();
  d.after.rms[2].second[1].second = sample::kNan;
  const Json out = Json::parse(to_json(d, sample::context()));
  EXPECT_TRUE(out["fit"]["after"]["test"]["joint_2"].is_null());
  EXPECT_TRUE(out["parameters"]["link_6.mass"]["ci95"][1].is_null());
  EXPECT_TRUE(out["identifiability"]["condition"].is_null());
  EXPECT_TRUE(out["candidates"][0][1]["heldout_gain"].is_null());
}

TEST(DiagnosisJson, ListsJointsThatGotWorseAndNamesThoseOfUnknownNoise) {
  Diagnosis d = sample::diagnosis();
  d.worse = {"joint_1", "joint_2"}, d.worse_besides_starts = {"joint_2"};
  d.noise = {{"joint_1", sample::kNan}, {"joint_2", 3e-4}};
  const Json out = Json::parse(to_json(d, sample::context()));
  EXPECT_EQ(out["worse"], Json({"joint_1", "joint_2"}));
  EXPECT_EQ(out["worse_besides_starts"], Json({"joint_2"}));
  ASSERT_TRUE(out["fit"]["noise"].contains("joint_1"));
  EXPECT_TRUE(out["fit"]["noise"]["joint_1"].is_null());
}

TEST(DiagnosisJson, CountsMissingEffortInTheCommandsUnit) {
  const Json out = Json::parse(to_json(sample::diagnosis(), sample::context()));
  EXPECT_EQ(out["missing_effort"][0]["unit"], "%");
}

TEST(DiagnosisJson, EmptyDiagnosisHasEmptyListsAndMaps) {
  const Json out = Json::parse(to_json(Diagnosis{}, Context{}));
  EXPECT_EQ(out["findings"], Json::array());
  EXPECT_EQ(out["learned"], Json::array());
  EXPECT_EQ(out["parameters"], Json::object());
  EXPECT_EQ(out["fit"]["noise"], Json::object());
  EXPECT_EQ(out["verdict"], "consistent");
}

TEST(DiagnosisJson, AnyBytesAreWritten) {
  EXPECT_NO_THROW({
    const Json out = Json::parse(to_json(sample::hostile_diagnosis(), sample::context()));
    EXPECT_EQ(out["notes"].size(), 1u);
  });
}

TEST(DiagnosisJson, SameInputSameText) {
  EXPECT_EQ(to_json(sample::diagnosis(), sample::context()), to_json(sample::diagnosis(), sample::context()));
}

TEST(FitJson, CarriesContextAndOneRecordPerEngine) {
  std::vector<FitResult> fits{sample::fit(1e-3), sample::fit(1e-3)};
  fits[1].engine = "mujoco";
  const Json out = Json::parse(to_json(fits, "seed", sample::context()));
  expect_keys(out["context"], {"date", "host", "cpu", "compiler", "flags", "engine_versions", "commit", "seed",
                               "threads", "command_line"});
  ASSERT_EQ(out["engines"].size(), 2u);
  EXPECT_EQ(out["engines"][1]["engine"], "mujoco");
  expect_keys(out["engines"][0], {"parameters", "rms", "identifiability", "step", "optimizer", "seconds"});
  EXPECT_TRUE(out["engines"][0]["history"]["median"][0].is_null());
}

}  // namespace
}  // namespace lacuna
