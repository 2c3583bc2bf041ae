// Numbers and verdicts in words, for people.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Significant digits, without trailing zeros: "24.7", "1.5e-5"; a dash for what is not finite.
std::string number(double value, int digits = 4);
/// The same with trailing zeros, for numbers that stand below each other: "4.00", "0.000310".
std::string steady(double value, int digits = 3);
/// With its unit: "24.7 N m".
std::string quantity(double value, const std::string& unit, int digits = 4);
/// As many digits as the 95 % interval supports: "24.7 N m (23.9 to 25.5)"; open ends are said in words, and so
/// is a value at the end of what was searched, which has no interval.
std::string with_interval(const Estimate& estimate);
/// "Fc = 24.7 N m (23.9 to 25.5)", "Fc: not determined".
std::string named_value(const Estimate& estimate);
/// "23.9 to 25.5", "above 23.9", "not determined" (so is the number itself where its interval spans all that was
/// searched).
std::string interval(const Estimate& estimate);
/// The value alone, with the interval's digits: "24.7".
std::string value_of(const Estimate& estimate);
/// As many digits as the standard error supports: "1234 ± 88".
std::string with_error(double value, double error);
/// "0.98", "above 0.99", "below 0.01".
std::string probability(double value);
/// A p-value: "0.013", "2.5e-7", "below 1e-12" (no model of the noise is good enough to say by how much).
std::string chance_words(double p_value);
/// "93 %", a dash for what is not finite.
std::string percent(double share);
/// "12.3 s", "4 min 10 s".
std::string duration(double seconds);
/// "a", "a and b", "a, b and c".
std::string list_of(const std::vector<std::string>& items);

/// "Coulomb friction" for coulomb_friction; an unknown name stays as it is.
std::string effect_title(const std::string& effect);
/// Where an effect acts: "joint_2", or "the arm".
std::string place_words(const std::string& effect, const std::string& place);

/// Unit of a residual's joint entry ("joint_2", "joint_2.velocity") in this scenario; "" where it does
/// not say.
std::string residual_unit(const Scenario& scenario, const Diagnosis* diagnosis, const std::string& entry);

/// rms table of a role; empty where it is absent.
const JointRms& rms_in(const FitResult& fit, Role role);

/// The role that a claim about improvement rests on: test, else validate, else train.
Role judged_role(const FitResult& fit);

/// How much is left: "34 % of the held-out residual energy remains above the noise", or where nothing was found, and so
/// nothing removed, "... is more than noise".
std::string rest_words(const Diagnosis& diagnosis);
/// What each recording's own offset of a valve is, without a full stop.
std::string number_by_recording_words(const NumberByRecording& number);

/// "a push of 12 N m in train_1.csv from 6.1 to 6.6 s".
std::string event_words(const LearnedEvent& event);
/// Events of one kind at one joint, group by group.
std::vector<std::vector<LearnedEvent>> alike(const std::vector<LearnedEvent>& events);
/// Of such a group: "joint_2: a push of 12 N m in train_1.csv from 6.1 to 6.6 s, ... and 3 more".
std::string description_of(const std::vector<LearnedEvent>& events);

/// What was found, in one plain sentence; a second one names the joints that got worse.
std::string verdict_sentence(const Scenario& scenario, const Diagnosis& diagnosis);

}  // namespace lacuna
