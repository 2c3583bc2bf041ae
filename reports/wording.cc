#include "reports/wording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "physics/catalogue.h"
#include "physics/units.h"

namespace lacuna {
namespace {

constexpr char kDash[] = "\u2013";
constexpr char kNotDetermined[] = "not determined";
constexpr double kLeastChance = 1e-12;  ///< below it no model of the noise says by how much

/// Decimals that a half-width supports: one digit of it, two where it starts with 1 or 2.
int decimals_for(double half_width) {
  const int decade = static_cast<int>(std::floor(std::log10(half_width)));
  const bool small_lead = half_width / std::pow(10.0, decade) < 3.0;
  return std::max(0, -decade + (small_lead ? 1 : 0));
}

/// Numbers of one estimate, all written alike.
class Digits {
 public:
  explicit Digits(const Estimate& estimate) {
    const double half = 0.5 * (estimate.upper95 - estimate.lower95), size = std::fabs(estimate.value);
    const bool usable = std::isfinite(half) && half > 1e-12 * size && half > 0.0;
    decimals_ = usable ? decimals_for(half) : -1;
    // Long rows of digits that mean nothing, or of zeros, are harder to read than an exponent.
    if (decimals_ > 6 || size >= 1e7 || half >= 1e6 || (decimals_ == 0 && half > 10 * std::max(size, 1e3)))
      decimals_ = -1;
  }
  std::string operator()(double value) const {
    return decimals_ < 0 || !std::isfinite(value) ? number(value, 4) : fmt::format("{:.{}f}", value, decimals_);
  }

 private:
  int decimals_ = -1;
};

/// Numbers of up to six places before the point need no exponent.
bool is_written_out(double value, int digits) {
  return std::fabs(value) >= std::pow(10.0, digits - 1) && std::fabs(value) < 1e6;
}

std::string written_out(double value, int digits) {
  const int places = static_cast<int>(std::floor(std::log10(std::fabs(value)))) + 1;
  return fmt::format("{:.{}f}", value, std::max(0, digits - places));
}

/// "1.5e-05" -> "1.5e-5".
std::string short_exponent(const std::string& any) {
  const std::size_t e = any.find('e');
  return e == std::string::npos ? any : any.substr(0, e) + "e" + std::to_string(std::stoi(any.substr(e + 1)));
}

std::string with_unit(const std::string& value, const std::string& unit) {
  return unit.empty() || unit == "1" ? value : value + " " + unit;  // 1: a ratio
}

/// "Coulomb friction at joint_2".
std::string finding_words(const Finding& finding) {
  return effect_title(finding.effect) + (of_whole_arm(finding.effect) ? " of the arm" : " at " + finding.place);
}

std::string parameter_words(const Finding& finding) {
  std::vector<std::string> parts;
  for (const Estimate& parameter : finding.parameters) parts.push_back(named_value(parameter));
  return list_of(parts);
}

/// "the test residual falls from 4.0 to 1.01 times the noise"; "" where there is no residual.
/// `joint` empty: of all joints.
std::string improvement(const Scenario& scenario, const Diagnosis& diagnosis, const std::string& joint, Role role) {
  const JointRms &before = rms_in(diagnosis.before, role), &after = rms_in(diagnosis.after, role);
  const auto only = [&](const JointRms& rms) { return joint.empty() ? rms : JointRms{{joint, entry_of(rms, joint)}}; };
  double from = over_noise(only(before), only(diagnosis.noise)), to = over_noise(only(after), only(diagnosis.noise));
  std::string tail = " times the noise";
  if (!std::isfinite(from) || !std::isfinite(to)) {
    const std::string shown = joint.empty() && !after.empty() ? after.front().first : joint;
    from = entry_of(before, shown), to = entry_of(after, shown);
    tail = fmt::format(" {} rms", residual_unit(scenario, &diagnosis, shown));
    if (joint.empty() && after.size() > 1) tail += " at " + shown;
  }
  if (!std::isfinite(to)) return {};
  const char* direction = to <= from ? "falls" : "rises";
  if (!std::isfinite(from)) return fmt::format("the {} residual is {}{}", to_string(role), steady(to), tail);
  return fmt::format("the {} residual {} from {} to {}{}", to_string(role), direction, steady(from), steady(to), tail);
}

std::string consistent_sentence(const Scenario& scenario, const Diagnosis& d) {
  const std::size_t tried = d.rounds.empty() ? 0 : d.rounds.front().size();
  const Role role = judged_role(d.after);
  const double ratio = over_noise(rms_in(d.after, role), d.noise);
  std::string out = "Nothing is missing: the identified model explains the recordings";
  if (std::isfinite(ratio)) {
    out += fmt::format(" down to {} times the noise ({} residual)", steady(ratio), to_string(role));
  } else if (!rms_in(d.after, role).empty()) {
    const auto& [joint, value] = rms_in(d.after, role).front();
    out += fmt::format(" ({} residual of {}: {} rms)", to_string(role), joint,
                       quantity(value, residual_unit(scenario, &d, joint), 3));
  }
  if (tried == 1) out += ", and the one effect tried does no better than chance";
  if (tried > 1)
    out += fmt::format(", and none of {} effects tried (each at each place) does better than chance", tried);
  return out + ".";
}

/// Each effect once, with all its places.
std::string by_effect(const std::vector<Finding>& findings) {
  std::vector<std::pair<std::string, std::vector<std::string>>> places;
  for (const Finding& finding : findings) {
    const auto same =
        std::find_if(places.begin(), places.end(), [&](const auto& p) { return p.first == finding.effect; });
    auto& of = same == places.end() ? places.emplace_back(finding.effect, std::vector<std::string>{}) : *same;
    of.second.push_back(place_words(finding.effect, finding.place));
  }
  std::string out;
  for (const auto& [effect, where] : places)
    out += (out.empty() ? "" : "; ") + effect_title(effect) + " at " + list_of(where);
  return out;
}

std::string probability_words(const Finding& finding) {
  std::string out = "probability " + probability(class_probability(finding));
  std::vector<std::string> others;
  for (const std::string& name : finding.members)
    if (name != finding.effect) others.push_back(effect_title(name));
  if (others.empty()) return out;
  return out +
         fmt::format("; {} that it is this and not {}", probability(finding.probability), fmt::join(others, " or "));
}

/// "Coulomb friction at joint_2 was left out"; each effect once, with all its places, where there are many.
std::string left_out_words(const std::vector<Finding>& findings) {
  constexpr std::size_t kMany = 4;
  std::vector<std::string> parts;
  for (const Finding& finding : findings) parts.push_back(finding_words(finding));
  return (parts.size() < kMany ? list_of(parts) : by_effect(findings)) +
         (findings.size() == 1 ? " was left out" : " were left out");
}

/// Those that explain less than what stays unexplained; "" where there are none.
std::string less_sure_words(const std::vector<Finding>& findings) {
  std::vector<std::string> parts;
  for (const Finding& finding : findings)
    parts.push_back(fmt::format("{} ({})", finding_words(finding), probability(class_probability(finding))));
  if (parts.empty()) return {};
  return fmt::format("; less sure {} {}, which explain{} less than what stays unexplained",
                     parts.size() == 1 ? "is" : "are", list_of(parts), parts.size() == 1 ? "s" : "");
}

std::string found_sentence(const Scenario& scenario, const Diagnosis& d) {
  std::vector<Finding> likely, doubted;
  std::ranges::partition_copy(d.findings, std::back_inserter(likely), std::back_inserter(doubted), explains_most);
  const bool one = d.findings.size() == 1;
  std::string out = left_out_words(likely);
  if (one) {
    const Finding& finding = d.findings.front();
    const std::string parameters = parameter_words(finding);
    out += " (" + probability_words(finding) + ")";
    if (!parameters.empty()) out += ": " + parameters;
  }
  out += less_sure_words(doubted);
  const std::string joint = one && std::isfinite(entry_of(rms_in(d.after, judged_role(d.after)), d.findings[0].place))
                                ? d.findings[0].place
                                : "";
  const std::string better = improvement(scenario, d, joint, judged_role(d.after));
  if (!better.empty())
    out += fmt::format("; with {} {}", one ? "it" : doubted.empty() ? "them" : "all of them", better);
  return out + ".";
}

std::string unknown_sentence(const Diagnosis& d) {
  std::string out = "Something is missing that the catalogue does not explain";
  if (!d.unexplained.where.empty()) out += ", at " + list_of(d.unexplained.where);
  if (!d.unexplained.regions.empty()) out += " (" + list_of(d.unexplained.regions) + ")";
  if (d.unexplained.share > 0.0) out += ": " + rest_words(d);
  if (!d.findings.empty()) {
    std::vector<std::string> parts;
    for (const Finding& finding : d.findings)
      parts.push_back(fmt::format("{} ({})", finding_words(finding), probability_words(finding)));
    out += "; beside it " + list_of(parts) + " may have been left out";
  }
  return out + ".";
}

/// Of "valve_deadband.d": "half-width of the dead zone"; "gain" is its own name.
std::string meaning_of(const std::string& number) {
  const std::size_t dot = number.find('.');
  const int effect = dot == std::string::npos ? -1 : find_effect(number.substr(0, dot));
  if (effect < 0) return number;
  const EffectInfo& info = effect_table()[effect];
  for (const ParameterInfo& p : info.parameters)
    if (p.name == number.substr(dot + 1)) return p.meaning;
  return number;
}

/// "0.3 ± 0.036 V": of all recordings, and by how much each differs from it.
std::string scatter_of(const NumberByRecording& n) {
  return fmt::format("{} ± {}", number(n.value, 3), quantity(n.deviation, n.unit, 2));
}

/// What of the rest are numbers that differ between recordings; "" where none were seen.
std::string numbers_sentence(const Diagnosis& d) {
  std::vector<std::string> each;
  for (const NumberByRecording& n : d.unexplained.numbers)
    each.push_back(fmt::format("{} at {} ({}; {} of what is left there goes with it)", meaning_of(n.number), n.joint,
                               scatter_of(n), percent(n.share)));
  if (each.empty()) return {};
  return fmt::format(" Not the same in every recording: {}.", list_of(each));
}

/// What was learned in place of a name; "" where nothing was.
std::string learned_sentence(const Scenario& scenario, const Diagnosis& d) {
  if (d.learned.empty()) return {};
  std::string out;
  for (const LearnedLaw& law : d.learned) out += " Learned from the recordings: " + law.description + ".";
  const std::string better = improvement(scenario, d, "", judged_role(d.after));
  if (!better.empty()) out += fmt::format(" With {} {}.", d.learned.size() == 1 ? "it" : "them", better);
  return out;
}

/// What happened in the recordings; "" where nothing did. Nothing can foretell what happened in a test recording, so
/// that its figures say nothing of events.
std::string event_sentence(const Scenario& scenario, const Diagnosis& d) {
  if (d.events.empty()) return {};
  std::string out;
  bool in_test = false, elsewhere = false;
  for (const std::vector<LearnedEvent>& events : alike(d.events)) out += " Events at " + description_of(events) + ".";
  for (const LearnedEvent& event : d.events) (event.role == Role::test ? in_test : elsewhere) = true;
  const Role role = rms_in(d.after, Role::validate).empty() ? Role::train : Role::validate;
  const std::string better = improvement(scenario, d, "", role);
  if (elsewhere && !better.empty()) out += " With these events in the simulation " + better + ".";
  if (in_test) out += " What happened in the test recordings stays in their figures.";
  return out;
}

/// Joints that the findings did no good on the test recordings.
std::string worse_sentence(const Diagnosis& diagnosis) {
  const std::vector<std::string>& really = diagnosis.worse_besides_starts;
  std::vector<std::string> excused;
  std::ranges::copy_if(diagnosis.worse, std::back_inserter(excused),
                       [&](const std::string& joint) { return std::ranges::find(really, joint) == really.end(); });
  std::string out;
  if (!really.empty()) out += " At " + list_of(really) + " the test residual grew.";
  if (!excused.empty())
    out += " At " + list_of(excused) +
           " the test residual grew, but by no more than the measured start's errors can do to a simulated motion.";
  return out;
}

}  // namespace

std::string number(double value, int digits) {
  if (!std::isfinite(value)) return kDash;
  return is_written_out(value, digits) ? written_out(value, digits)
                                       : short_exponent(fmt::format("{:.{}g}", value, digits));
}

std::string steady(double value, int digits) {
  if (!std::isfinite(value)) return kDash;
  if (is_written_out(value, digits)) return written_out(value, digits);
  return short_exponent(fmt::format("{:#.{}g}", value, digits));
}

std::string quantity(double value, const std::string& unit, int digits) {
  return std::isfinite(value) ? with_unit(number(value, digits), unit) : kDash;
}

std::string value_of(const Estimate& estimate) {
  return estimate.spans_range ? kNotDetermined : Digits(estimate)(estimate.value);
}

std::string interval(const Estimate& estimate) {
  if (estimate.spans_range) return kNotDetermined;
  const Digits digits(estimate);
  const bool low = std::isfinite(estimate.lower95), high = std::isfinite(estimate.upper95);
  if (low && high) return digits(estimate.lower95) + " to " + digits(estimate.upper95);
  if (low) return "above " + number(estimate.lower95);
  if (high) return "below " + number(estimate.upper95);
  return kNotDetermined;
}

std::string with_interval(const Estimate& estimate) {
  if (estimate.spans_range) return kNotDetermined;
  // The best may lie beyond the end: an interval about it says nothing.
  if (estimate.at_bound) return quantity(estimate.value, estimate.unit) + " (at the end of the range searched)";
  return with_unit(value_of(estimate), estimate.unit) + " (" + interval(estimate) + ")";
}

std::string named_value(const Estimate& estimate) {
  return estimate.name + (estimate.spans_range ? ": " : " = ") + with_interval(estimate);
}

std::string probability(double value) {
  if (!std::isfinite(value)) return kDash;
  if (value > 0.995) return "above 0.99";
  if (value < 0.005) return "below 0.01";
  return fmt::format("{:.2f}", value);
}

std::string chance_words(double p_value) {
  if (p_value < kLeastChance) return "below " + number(kLeastChance);
  return number(p_value, 2);
}

std::string percent(double share) {
  if (!std::isfinite(share)) return kDash;
  const double value = 100.0 * share;
  // 99.7 % is not all of it.
  const bool fine = std::fabs(value) < 10.0 || (value > 99.0 && value < 99.95);
  return fmt::format("{:.{}f} %", value, fine ? 1 : 0);
}

std::string with_error(double value, double error) {
  if (!std::isfinite(value) || !std::isfinite(error) || !(error > 0.0)) return number(value);
  if (error >= 1e6 || error < 1e-6) return number(value) + " \u00b1 " + number(error, 2);
  const int decimals = decimals_for(error);
  return fmt::format("{:.{}f} \u00b1 {:.{}f}", value, decimals, error, decimals);
}

std::string duration(double seconds) {
  if (!std::isfinite(seconds)) return kDash;
  if (seconds < 100.0) return quantity(seconds, "s", 3);
  const long whole = std::lround(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string list_of(const std::vector<std::string>& items) {
  std::string out;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) out += i + 1 == items.size() ? " and " : ", ";
    out += items[i];
  }
  return out;
}

std::string effect_title(const std::string& effect) {
  const int index = find_effect(effect);
  return index < 0 ? effect : effect_table()[index].title;
}

std::string place_words(const std::string& effect, const std::string& place) {
  return of_whole_arm(effect) ? "the arm" : place;
}

std::string residual_unit(const Scenario& scenario, const Diagnosis* diagnosis, const std::string& entry) {
  if (diagnosis != nullptr) {
    for (const Trace& trace : diagnosis->traces) {
      if (trace.joint == entry && !trace.unit.empty()) return trace.unit;
    }
  }
  const std::size_t dot = entry.rfind('.');
  const std::string kind = dot == std::string::npos ? "" : entry.substr(dot + 1);
  const bool qualified = kind == "velocity" || kind == "effort" || kind == "motor_position" || kind == "pressure_a" ||
                         kind == "pressure_b";
  const auto efforts = scenario.channels.of.find(ChannelKind::effort);
  const bool measured = efforts != scenario.channels.of.end() && efforts->second.count(entry) > 0;
  if (!qualified && !measured && std::holds_alternative<InverseDynamics>(scenario.prediction))
    return scenario.robot ? command_unit(scenario, entry) : kAnyCommand;
  const std::optional<int> joint =
      scenario.robot ? scenario.robot->find_joint(qualified ? entry.substr(0, dot) : entry) : std::nullopt;
  if (!joint) return {};
  const bool slides = scenario.robot->joints()[*joint].prismatic();
  if (kind == "pressure_a" || kind == "pressure_b") return "Pa";
  if (kind == "velocity") return slides ? "m/s" : "rad/s";
  const bool effort = kind == "effort" || (measured && std::holds_alternative<InverseDynamics>(scenario.prediction));
  if (effort) return slides ? "N" : "N m";
  return slides ? "m" : "rad";
}

const JointRms& rms_in(const FitResult& fit, Role role) {
  static const JointRms kNone;
  for (const auto& [r, rms] : fit.rms) {
    if (r == role) return rms;
  }
  return kNone;
}

Role judged_role(const FitResult& fit) {
  for (const Role role : {Role::test, Role::validate}) {
    if (!rms_in(fit, role).empty()) return role;
  }
  return Role::train;
}

std::string rest_words(const Diagnosis& diagnosis) {
  return percent(diagnosis.unexplained.share) + " of the held-out residual energy " +
         (diagnosis.findings.empty() ? "is more than noise" : "remains above the noise");
}

std::string number_by_recording_words(const NumberByRecording& number) {
  std::vector<std::string> each;
  for (const auto& [file, beyond] : number.recordings) each.push_back(fmt::format("{:+.2g} in {}", beyond, file));
  return fmt::format(
      "{} at {} ({}) is not the same in every recording: {}, beyond what all share: {}; {} of the residual energy "
      "there "
      "goes with it",
      meaning_of(number.number), number.joint, number.number, scatter_of(number), list_of(each), percent(number.share));
}

/// To milliseconds, whatever the clock stands at.
std::string seconds_of(double time) {
  return number(time, 4 + std::max(0, static_cast<int>(std::log10(std::max(1.0, std::fabs(time))))));
}

std::string event_words(const LearnedEvent& event) {
  const bool sized = event.kind != EventSpec::Kind::command || event.value != 0.0;
  const std::string size = sized ? " of " + quantity(event.value, event.unit, 3) : "";
  return fmt::format("{}{} in {} from {} to {} s", event.resembles, size, event.recording, seconds_of(event.from),
                     seconds_of(event.to));
}

std::vector<std::vector<LearnedEvent>> alike(const std::vector<LearnedEvent>& events) {
  std::vector<std::vector<LearnedEvent>> out;
  for (const LearnedEvent& event : events) {
    const auto same = std::ranges::find_if(out, [&](const std::vector<LearnedEvent>& group) {
      return group.front().kind == event.kind && group.front().place == event.place;
    });
    (same == out.end() ? out.emplace_back() : *same).push_back(event);
  }
  return out;
}

std::string description_of(const std::vector<LearnedEvent>& events) {
  constexpr std::size_t kTold = 3;
  std::vector<std::string> parts;
  for (const LearnedEvent& event : events)
    if (parts.size() < kTold) parts.push_back(event_words(event));
  if (events.size() > kTold) parts.push_back(fmt::format("{} more", events.size() - kTold));
  return events.front().place + ": " + list_of(parts);
}

std::string verdict_sentence(const Scenario& scenario, const Diagnosis& diagnosis) {
  std::string out = diagnosis.verdict == Verdict::consistent        ? consistent_sentence(scenario, diagnosis)
                    : diagnosis.verdict == Verdict::unknown_physics ? unknown_sentence(diagnosis)
                                                                    : found_sentence(scenario, diagnosis);
  out += learned_sentence(scenario, diagnosis) + numbers_sentence(diagnosis) + event_sentence(scenario, diagnosis);
  return out + worse_sentence(diagnosis);
}

}  // namespace lacuna
