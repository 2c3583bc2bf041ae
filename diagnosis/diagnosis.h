// The diagnosis of one scenario: what its plain model leaves out, where, how much, and how far the fit improves.
//
// The steps stand one file each, in order: baseline.h (identify the plain model), locate.h (where it fails),
// missing_physics.h (the search for what is missing, by branches that cannot move each other: parts.h), in rounds of
// one effect each (rounds.h): screen.h (every effect at every place, re-identified with it), decide.h (what is better
// than chance on recordings that were not fitted), where.h (when and in which states that shows), prune.h (whether all
// are needed), anew.h (what is said of those that are); set_search.h (sets of effects where a rest remains; in efforts
// effort_search.h alone); separate.h (the motion that would tell a class apart), verify.h (test recordings, other
// engines).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/chain.h"
#include "diagnosis/idim.h"
#include "diagnosis/locate.h"
#include "diagnosis/valve_comparison.h"
#include "diagnosis/when.h"
#include "ga/identify.h"
#include "scenarios/scenario.h"

namespace lacuna {

enum class Verdict { consistent, missing_physics, unknown_physics };
const char* to_string(Verdict verdict);

struct Rival {
  std::string effect, place;
  double probability = 0.0;
  std::map<std::string, double> fixed = {};  ///< own parameters held at these values
  std::vector<double> own = {};              ///< its other parameters where it fitted best, search coordinates
  std::vector<std::string> recordings = {};  ///< files in which it acts; empty: all
};

/// The motion that would tell a finding from the rest of its class.
struct Separation {
  CommandTrack commands;  ///< [joint], in each command's unit; from rest at the recordings' start
  std::string rival;      ///< the member that is hardest to tell apart by it
  double evidence = 0.0;  ///< log-likelihood to be expected against that one
  double recorded = 0.0;  ///< the same of one more recording like those there are
};

/// One effect found.
struct Finding {
  std::string effect, place;
  double probability = 0.0;             ///< of this effect at this place, among all that were tried, chance, and
                                        ///< what the catalogue does not hold (Unexplained::probability)
  double outside = 0.0;                 ///< probability of what takes no part in the contest of rivals: that it came
                                        ///< about by chance, or stands for two effects (or they for one)
  std::vector<Rival> rivals;            ///< most probable first
  std::vector<std::string> members;     ///< the class: effects that the data do not separate from it, itself first
  std::vector<Estimate> parameters;     ///< names without the place ("Fc")
  std::vector<std::string> recordings;  ///< files in which it acts; empty: all
  std::map<std::string, double> fixed;  ///< own parameters held at these values
  struct Interval {
    std::string recording;
    double begin = 0.0, end = 0.0;  ///< s
  };
  std::vector<Interval> times;       ///< where the residual that it removes is largest
  std::vector<std::string> regions;  ///< in words
  double p_value = 1.0;              ///< of train and held-out gain together, corrected for everything that was tried
  double heldout_gain = 0.0;         ///< log-likelihood gained on the validate recordings
  double heldout_error = 0.0;        ///< its standard error
  double heldout_share = 0.0;        ///< share of the validate residual energy removed
  double explained = 1.0;            ///< its share in what would be missing at its place without it (unexplained.h)
  double stability = 0.0;            ///< share of block resamples in which it beats the best rival elsewhere
  std::optional<Separation> separation;  ///< where the class has several members
};

struct Diagnosis;
/// Whether the diagnosed model is another one than the plain one.
bool changes_the_model(const Diagnosis& diagnosis);

/// That one of the finding's class stands at its place, whichever.
double class_probability(const Finding& finding);

/// Whether a finding explains more of what would be missing at its place without it than stays unexplained there.
inline bool explains_most(const Finding& finding) { return finding.explained > 0.5; }

/// A number of the diagnosed model that is another one in each recording (between_recordings.h).
struct NumberByRecording {
  std::string joint;
  std::string number;      ///< "valve_deadband.d", "gain": the parameter without its joint
  std::string unit;        ///< of it
  double value = 0.0;      ///< the one that the model has for all
  double deviation = 0.0;  ///< standard deviation between recordings
  double evidence = 0.0;   ///< log evidence over one for all, beside those that stand before it
  double share = 0.0;      ///< of the residual energy there, train and validate recordings, that goes with it
  std::vector<std::pair<std::string, double>> recordings;  ///< file, its number beyond what all share
};

struct Unexplained {
  bool present = false;
  std::vector<std::string> where;  ///< joints
  std::vector<std::string> regions;
  std::vector<Misfit> times;  ///< when, in the recordings that were not fitted; most energy first
  double share = 0.0;         ///< of the validate residual energy above the noise, after the findings
  /// That something outside the catalogue, or a combination of effects not tried, is missing: the rest, in units of the
  /// noise, as a share of what was missing at all joints together; 0 where no rest is significant or the noise is
  /// unknown. Findings leave room for it joint by joint.
  double probability = 0.0;
  /// The same of one joint, on its own.
  struct AtJoint {
    std::string joint;
    double over_noise = 0.0;   ///< rms of what is left over the noise's; NaN where the noise is unknown
    double probability = 0.0;  ///< the rest's share of what was missing there; 0 where it is no more than noise
  };
  std::vector<AtJoint> per_joint;               ///< every joint that is compared
  std::vector<NumberByRecording> numbers = {};  ///< what of it are numbers that are not the same in each recording
};

/// What no effect of the catalogue stands for, as a function of one variable or two (learned.h).
struct LearnedLaw {
  std::string place;          ///< joint
  Stage stage = Stage::link;  ///< of an effort; `command` and `reading`: what is added to these
  struct Variable {
    std::string name;             ///< "q", "v", "u" or "JOINT.q" (scenarios/learned_entry.h)
    double from = 0.0, to = 0.0;  ///< what was seen of it; beyond it the law goes on level
    std::string unit;
    std::size_t knots = 0;  ///< a second variable of two knots only says which way the joint moves
  };
  std::vector<Variable> over;  ///< one or two
  std::string unit;            ///< of the law
  struct Point {
    double at = 0.0, value = 0.0, lower95 = 0.0, upper95 = 0.0;
    double beside = 0.0;  ///< second variable
  };
  std::vector<Point> curve;                      ///< at the knots, the second variable's next to each other
  std::vector<std::pair<double, double>> cloud;  ///< missing effort over the first variable, as measured (locate.h)
  std::string resembles;                         ///< the nearest textbook law
  double share = 0.0;                            ///< of the curve's variance that it explains
  double period = 0.0;  ///< where it repeats itself over its first variable, in its unit; 0: it does not
  double height = 0.0;  ///< half of the way from its lowest to its highest point
  std::string description;
  std::string tells_more;      ///< which recording would; "": it is known well enough
  double probability = 0.0;    ///< that it is this joint and these variables, of those that were offered
  double evidence = 0.0;       ///< log evidence over the model without it, fitted in full
  double heldout_gain = 0.0;   ///< log-likelihood on the validate recordings
  double heldout_share = 0.0;  ///< of their residual energy that it takes away
};

/// What happened once in one recording and is no part of the machine (events.h).
struct LearnedEvent {
  EventSpec::Kind kind = EventSpec::Kind::effort;
  std::string place, recording;
  Role role = Role::train;      ///< of the recording; one of a test recording is said and goes into no figure
  double from = 0.0, to = 0.0;  ///< s, on the recording's own clock
  double value = 0.0;           ///< the largest of it, in `unit`
  std::string unit;
  std::string resembles;          ///< "a push", "a lost command", "a repeated command", "a slip of the transducer"
  double evidence = 0.0;          ///< log evidence over the same without it, corrected for all edges tried
  std::vector<EventSpec> pieces;  ///< rectangles that it is made of
};

/// Everything that was tried in one round, for the report.
struct Candidate {
  std::string effect, place;
  double train_gain = 0.0;  ///< log-likelihood
  double heldout_gain = 0.0, heldout_error = 0.0, heldout_share = 0.0;
  double p_value = 1.0;
  int parameters = 0;
  std::string note;  ///< why it was not kept
};

/// The found model's residual on another engine.
struct EngineGain {
  std::string engine;
  bool available = false;
  std::string reason;
  JointRms before, after;  ///< on the test recordings
  double kept = 0.0;       ///< share of the identifying engine's energy reduction that remains
};

/// What is left of one joint's residual on the recordings that were not fitted, as colour: by lag from 1, in samples.
struct Whiteness {
  std::string joint;
  Role role = Role::test;  ///< of those recordings
  double samples = 0.0;
  std::vector<double> before, after;     ///< autocorrelations
  double p_before = 1.0, p_after = 1.0;  ///< of so much colour in white noise
};

/// Signals of one test recording for the before/after plots; one per joint.
struct Trace {
  std::string recording, joint, unit;
  std::vector<double> time, measured, before, after;
};

/// One recording to be played: what was measured, what both models predict, and the effort that either lacks.
struct Replay {
  std::string recording;
  Role role = Role::test;
  std::vector<Trace> traces;  ///< one per joint
  struct Effort {
    std::string joint, unit;
    double noise = 0.0;                 ///< rms that the positions' noise makes of it; in `unit`
    std::vector<double> time;           ///< s
    std::vector<double> before, after;  ///< that the plain and the diagnosed model lack; either may be empty
  };
  std::vector<Effort> missing;  ///< empty where it cannot be said (locate.h)
};

struct Diagnosis {
  std::string scenario, engine;
  std::uint64_t seed = 1;
  Verdict verdict = Verdict::consistent;
  std::vector<Finding> findings;
  std::vector<EffectSpec> added;  ///< effects of the diagnosed model that the scenario's has not, in its order
  Unexplained unexplained;        ///< by the findings; the laws learned from it do not count
  std::vector<LearnedLaw> learned;
  std::vector<LearnedEvent> events;               ///< in the order of the recordings and of time
  std::vector<MissingEffort> missing;             ///< where the plain model fails; empty where that cannot be said
  JointRms noise;                                 ///< an entry a channel; NaN where it is unknown
  FitResult before, after;                        ///< `after` equals `before` where nothing was found
  std::vector<std::string> worse;                 ///< joints whose test rms the findings raised
  std::vector<std::string> worse_besides_starts;  ///< those of them that the errors of the starts do not excuse
  /// The found model fitted once more to every recording, test included, after all else was settled: for comparison
  /// with references that used the whole record. No other figure here depends on it.
  std::vector<Estimate> all_recordings;
  std::vector<std::vector<Candidate>> rounds;
  std::optional<Idim> idim;  ///< the yardstick, where efforts are compared
  /// The yardstick of joints whose valves give a flow, and what the final model has in its place.
  std::vector<ValveComparison> valves;
  std::vector<JointChain> chain;  ///< joints whose pressures are measured
  std::vector<EngineGain> engines;
  std::vector<Whiteness> whiteness;
  std::vector<Trace> traces;                    ///< of the first test recording
  std::vector<std::vector<Trace>> predictions;  ///< of every test recording, joint by joint
  std::vector<Replay> replays;  ///< the first test recording, then those in which the findings act (replay.h)
  std::vector<std::string> notes;
  double seconds = 0.0;
};

struct DiagnoseOptions {
  IdentifyOptions identify;
  bool other_engines = true;
};

/// Runs all steps. Throws Interrupted (resumable when options.identify.control.checkpoint is set) and WorkError.
Diagnosis diagnose(const Scenario& scenario, const DiagnoseOptions& options);

/// The scenario with the findings and the identified values put in; runs as it is.
Scenario diagnosed_scenario(const Scenario& scenario, const Diagnosis& diagnosis);

/// The scenario with identified values put in (masses stay with the robot: `link_masses`), searched within the bounds
/// that it had.
Scenario with_values(const Scenario& scenario, const PlantModel& model, std::span<const double> values);

}  // namespace lacuna
