#include "reports/wording.h"

#include <gtest/gtest.h>

#include "tests/reports/sample.h"

namespace lacuna {
namespace {

Estimate estimate(double value, double low, double high, const std::string& unit = "N m") {
  return {"p", unit, value, low, high, true, false, false};
}

TEST(Number, ShortAndReadable) {
  EXPECT_EQ(number(24.7), "24.7");
  EXPECT_EQ(number(0.000015), "1.5e-5");
  EXPECT_EQ(number(123456.7), "123457");
  EXPECT_EQ(number(8123.4, 3), "8123");
  EXPECT_EQ(number(0.0), "0");
  EXPECT_EQ(number(sample::kNan), "\u2013");
}

TEST(Number, SteadyKeepsItsZeros) {
  EXPECT_EQ(steady(4.0), "4.00");
  EXPECT_EQ(steady(0.00031), "0.000310");
  EXPECT_EQ(steady(400.0), "400");
  EXPECT_EQ(steady(999.9), "1000");
  EXPECT_EQ(steady(0.0), "0.00");
}

TEST(WithInterval, ShowsTheDigitsThatTheIntervalSupports) {
  EXPECT_EQ(with_interval(estimate(24.7123, 23.9, 25.5)), "24.7 N m (23.9 to 25.5)");
  EXPECT_EQ(with_interval(estimate(182.9381, 182.93, 182.95)), "182.938 N m (182.930 to 182.950)");
  EXPECT_EQ(with_interval(estimate(1.5e-9, 1e-9, 2e-9, "m")), "1.5e-9 m (1e-9 to 2e-9)");
  EXPECT_EQ(with_interval(estimate(3.0, 3.0, 3.0, "")), "3 (3 to 3)");
}

TEST(WithInterval, OpenEndsAreSaidInWords) {
  EXPECT_EQ(interval(estimate(1.0, 0.5, sample::kInf)), "above 0.5");
  EXPECT_EQ(interval(estimate(1.0, -sample::kInf, sample::kInf)), "not determined");
  Estimate open = estimate(100.0, -1313.0, 1513.0);
  open.spans_range = true;
  EXPECT_EQ(with_interval(open), "not determined");
  Estimate stiffest = estimate(665981.49, 664021.5, 667941.4, "N/m");
  stiffest.at_bound = true;
  EXPECT_EQ(with_interval(stiffest), "665981 N/m (at the end of the range searched)");
}

TEST(WithError, RoundsToTheError) {
  EXPECT_EQ(with_error(1234.5678, 88.0), "1235 \u00b1 88");
  EXPECT_EQ(with_error(0.51234, 0.04), "0.51 \u00b1 0.04");
  EXPECT_EQ(with_error(3.0, 0.0), "3");
}

TEST(Probability, NeverClaimsCertainty) {
  EXPECT_EQ(probability(1.0), "above 0.99");
  EXPECT_EQ(probability(0.98), "0.98");
  EXPECT_EQ(probability(0.0), "below 0.01");
  EXPECT_EQ(chance_words(0.0126), "0.013");
  EXPECT_EQ(chance_words(0.0), "below 1e-12");
}

TEST(Percent, NearlyAllIsNotAll) {
  EXPECT_EQ(percent(0.93), "93 %");
  EXPECT_EQ(percent(0.997), "99.7 %");
  EXPECT_EQ(percent(1.0), "100 %");
}

TEST(VerdictSentence, NamesEffectPlaceValueAndImprovement) {
  EXPECT_EQ(verdict_sentence(Scenario{}, sample::diagnosis()),
            "Coulomb friction at joint_2 was left out (probability above 0.99; 0.98 "
            "that it is this and not Stribeck friction): Fc = 24.7 N m (23.9 to 25.5); with it the test "
            "residual falls from 4.00 to 1.01 times the noise.");
}

TEST(VerdictSentence, SeveralFindingsShareOneSentence) {
  Diagnosis d = sample::diagnosis();
  d.findings.push_back(sample::finding());
  d.findings[1].effect = "payload";
  d.findings[1].place = "arm";
  const std::string words = verdict_sentence(Scenario{}, d);
  EXPECT_EQ(
      words.rfind("Coulomb friction at joint_2 and Payload of the arm were left out; with them the test residual", 0),
      0u)
      << words;
}

TEST(VerdictSentence, WhatExplainsLessThanIsLeftIsSaidApart) {
  Diagnosis d = sample::diagnosis();
  d.findings.push_back(sample::finding());
  d.findings[1].effect = "base_compliance", d.findings[1].place = "arm";
  d.findings[1].members = {"base_compliance"}, d.findings[1].rivals.clear();
  d.findings[1].probability = 0.76, d.findings[1].explained = 0.31;
  std::swap(d.findings[0], d.findings[1]);
  EXPECT_EQ(
      verdict_sentence(Scenario{}, d),
      "Coulomb friction at joint_2 was left out; less sure is Base compliance of the arm (0.76), which explains "
      "less than what stays unexplained; with all of them the test residual falls from 2.92 to 1.02 times the noise.");
}

TEST(VerdictSentence, ConsistentSaysSo) {
  Diagnosis d = sample::diagnosis();
  d.verdict = Verdict::consistent;
  d.findings.clear();
  EXPECT_EQ(verdict_sentence(Scenario{}, d).rfind("Nothing is missing: ", 0), 0u);
}

TEST(VerdictSentence, UnknownPhysicsSaysWhere) {
  Diagnosis d = sample::diagnosis();
  d.verdict = Verdict::unknown_physics;
  d.findings.clear();
  d.unexplained = {true, {"joint_3"}, {"large positions"}, {}, 0.34, 0.0, {}};
  EXPECT_EQ(
      verdict_sentence(Scenario{}, d),
      "Something is missing that the catalogue does not explain, at joint_3 (large positions): 34 % of the held-out "
      "residual energy is more than noise.");
  d.findings = sample::diagnosis().findings;
  EXPECT_NE(
      verdict_sentence(Scenario{}, d).find("34 % of the held-out residual energy remains above the noise; beside"),
      std::string::npos)
      << verdict_sentence(Scenario{}, d);
}

TEST(VerdictSentence, SaysWhichNumbersAreNotTheSameInEveryRecording) {
  Diagnosis d = sample::diagnosis();
  const std::string before = verdict_sentence(Scenario{}, d);
  d.unexplained.numbers = {sample::number_by_recording(), sample::number_by_recording()};
  d.unexplained.numbers.back().number = "gain", d.unexplained.numbers.back().unit = "N m/V";
  EXPECT_EQ(verdict_sentence(Scenario{}, d),
            before +
                " Not the same in every recording: command added at joint_3 (0.1 ± 0.25 V; 40 % of what is left there "
                "goes with it) and gain at joint_3 (0.1 ± 0.25 N m/V; 40 % of what is left there goes with it).");
}

TEST(VerdictSentence, SaysWhatWasLearnedInPlaceOfANameAndWhatThatBrings) {
  const LearnedLaw ripple = sample::learned_law();
  // Of both joints: 1.03 and 4.00 times the noise before, 1.03 and 1.01 after, as root mean squares.
  EXPECT_EQ(verdict_sentence(Scenario{}, sample::learned_diagnosis({ripple})),
            "Something is missing that the catalogue does not explain, at joint_2: 90 % of the held-out residual "
            "energy is more than noise. Learned from the recordings: " +
                ripple.description + ". With it the test residual falls from 2.92 to 1.02 times the noise.");
  EXPECT_EQ(ripple.description.rfind("joint_2 lacks a torque that depends on its position: 0.2 N m to either side of "
                                     "its middle, repeats every 0.5 rad",
                                     0),
            0u)
      << ripple.description;
}

TEST(VerdictSentence, SaysOfALawWithoutAPeriodWhichWayItGoes) {
  const std::string words = verdict_sentence(Scenario{}, sample::learned_diagnosis({sample::learned_law(false)}));
  EXPECT_NE(words.find("Learned from the recordings: joint_2 lacks a torque that depends on its speed: 0.8 N m to "
                       "either side of its middle, turns with the sign, rises or falls throughout; like quadratic "
                       "damping (100 % of the curve). With it the test residual falls"),
            std::string::npos)
      << words;
  EXPECT_EQ(words.find("repeats"), std::string::npos);
}

TEST(VerdictSentence, SaysEveryLearnedLawAndTheirGainOnce) {
  const LearnedLaw ripple = sample::learned_law(), drag = sample::learned_law(false);
  const std::string words = verdict_sentence(Scenario{}, sample::learned_diagnosis({ripple, drag}));
  EXPECT_NE(words.find(". Learned from the recordings: " + ripple.description +
                       ". Learned from the recordings: " + drag.description + ". With them the test residual falls"),
            std::string::npos)
      << words;
  EXPECT_EQ(verdict_sentence(Scenario{}, sample::diagnosis()).find("Learned"), std::string::npos);
}

TEST(EventWords, SayWhatHappenedWhereAndWhen) {
  using Kind = EventSpec::Kind;
  EXPECT_EQ(event_words(sample::learned_event()), "a push of 12 N m in train_1.csv from 6.1 to 6.6 s");
  EXPECT_EQ(event_words(sample::learned_event(Kind::reading)),
            "a slip of the transducer of 0.02 rad in train_1.csv from 6.1 to 6.6 s");
  LearnedEvent command = sample::learned_event(Kind::command);
  EXPECT_EQ(event_words(command), "a lost command in train_1.csv from 6.1 to 6.6 s") << "nothing has no size";
  command.value = -35.0, command.resembles = "a repeated command";
  EXPECT_EQ(event_words(command), "a repeated command of -35 % in train_1.csv from 6.1 to 6.6 s");
}

TEST(EventWords, RoundToWhatIsRead) {
  LearnedEvent push = sample::learned_event();
  push.value = -1.23456, push.from = 6.12345, push.to = 106.789;
  EXPECT_EQ(event_words(push), "a push of -1.23 N m in train_1.csv from 6.123 to 106.789 s");
}

TEST(EventWords, GroupEventsByKindAndJointInTheirOrder) {
  LearnedEvent elsewhere = sample::learned_event();
  elsewhere.place = "joint_1";
  const LearnedEvent push = sample::learned_event(), slip = sample::learned_event(EventSpec::Kind::reading);
  EXPECT_TRUE(alike({}).empty());
  const auto groups = alike({slip, push, elsewhere, push, slip, push});
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0].size(), 2u);
  EXPECT_EQ(groups[0].front().kind, EventSpec::Kind::reading);
  EXPECT_EQ(groups[1].size(), 3u);
  EXPECT_EQ(groups[1].front().place, "joint_2");
  ASSERT_EQ(groups[2].size(), 1u);
  EXPECT_EQ(groups[2].front().place, "joint_1");
}

TEST(EventWords, TellThreeOfAGroupAndCountTheOthers) {
  std::vector<LearnedEvent> events;
  for (const char* file : {"a.csv", "b.csv", "c.csv", "d.csv", "e.csv"})
    events.push_back(sample::learned_event_in(file, Role::train));
  const auto push = [](const std::string& file) { return "a push of 12 N m in " + file + " from 6.1 to 6.6 s"; };
  EXPECT_EQ(description_of({events[0]}), "joint_2: " + push("a.csv"));
  EXPECT_EQ(description_of({events[0], events[1], events[2]}),
            "joint_2: " + push("a.csv") + ", " + push("b.csv") + " and " + push("c.csv"));
  EXPECT_EQ(description_of(events),
            "joint_2: " + push("a.csv") + ", " + push("b.csv") + ", " + push("c.csv") + " and 2 more");
}

TEST(VerdictSentence, SaysWhatHappenedAndWhatThatTakesAway) {
  const LearnedEvent push = sample::learned_event(), slip = sample::learned_event(EventSpec::Kind::reading);
  const std::string words = verdict_sentence(Scenario{}, sample::eventful_diagnosis({push, slip}));
  EXPECT_NE(words.find(" Events at " + description_of({push}) + ". Events at " + description_of({slip}) + ". "),
            std::string::npos)
      << words;
  // No test figure, in which nothing of it stands. 2.92 and 1.02: of both joints, as above.
  EXPECT_NE(words.find(" the validate residual falls from 2.92 to 1.02 times the noise."), std::string::npos) << words;
  EXPECT_EQ(words.find("test"), std::string::npos) << words;
  EXPECT_EQ(verdict_sentence(Scenario{}, sample::diagnosis()).find("Events"), std::string::npos);
}

TEST(VerdictSentence, ClaimsNothingOfWhatHappenedInTestRecordingsAlone) {
  const LearnedEvent push = sample::learned_event_in("test_1.csv", Role::test);
  const std::string words = verdict_sentence(Scenario{}, sample::eventful_diagnosis({push}));
  EXPECT_NE(words.find(" Events at " + description_of({push}) + "."), std::string::npos) << words;
  EXPECT_EQ(words.find("falls"), std::string::npos) << words;
  EXPECT_NE(words.find("What happened in the test recordings stays in their figures."), std::string::npos) << words;
}

TEST(VerdictSentence, WithoutNoiseSpeaksInUnits) {
  Diagnosis d = sample::diagnosis();
  d.noise.clear();
  const std::string words = verdict_sentence(Scenario{}, d);
  EXPECT_NE(words.find("from 0.00120 to 0.000303 rad rms"), std::string::npos) << words;
}

TEST(VerdictSentence, OfNothingIsStillASentence) {
  for (const Verdict verdict : {Verdict::consistent, Verdict::missing_physics, Verdict::unknown_physics}) {
    Diagnosis d;
    d.verdict = verdict;
    EXPECT_TRUE(verdict_sentence(Scenario{}, d).ends_with("."));
  }
}

}  // namespace
}  // namespace lacuna
