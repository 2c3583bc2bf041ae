// Two sets of recordings of one machine: what both have in common, what changed, where, and how certain that is.
//
// The steps, one file each: both sets are diagnosed (diagnosis/), their structures united and fitted to either
// (structure.h), what changed is chosen among subsets by evidence (changed_sets.h), the choice is fitted in full
// simulation with the common numbers common (joint_fit.h), and each change must predict recordings that neither set was
// fitted to (claims.h).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"

namespace lacuna {

enum class DiffVerdict {
  same,           ///< nothing changed that these recordings show
  changed,        ///< each change is named
  unknown_change  ///< the sets differ, or one alone leaves a rest, and no change of the model's numbers says how
};
const char* to_string(DiffVerdict verdict);

/// One number of a change. Differences are B minus A, with both errors and what they share.
struct ChangedNumber {
  std::string key;  ///< "Fc", "gain"
  Estimate a, b, difference;
};

/// What changed: a number of the plain model, or an effect with all its numbers.
struct MachineChange {
  std::string name;                      ///< "joint_2.gain", "joint_2.coulomb_friction"
  std::string effect;                    ///< empty: a number of the plain model
  std::string place;                     ///< "joint_2", "arm", "link_3"
  std::vector<ChangedNumber> numbers;    ///< the leading one first
  double probability = 0.0;              ///< of this change
  double class_probability = 0.0;        ///< of it or another of its class
  std::vector<std::string> members;      ///< its class: changes that the recordings do not tell from it, itself first
  std::vector<std::string> look_alikes;  ///< effects that a diagnosis did not tell from this one
  std::vector<std::string> recordings;   ///< files in which alone it acts; empty: all of its set
  double heldout_gain = 0.0;   ///< log-likelihood on both sets' validate recordings over the same without this change
  double heldout_error = 0.0;  ///< its standard error
  double heldout_share = 0.0;  ///< of their residual energy that it takes away
};

/// A change that the evidence prefers and that is not claimed.
struct RefusedChange {
  std::string name;
  double probability = 0.0;
  std::string reason;  ///< in words
};

/// What both sets have in common, fitted to both.
struct SharedNumber {
  Estimate pooled;
  double changed = 0.0;  ///< probability that it differs all the same
};

/// Residual rms of one set under three models: that of set A, that of set B, each fitted to its set alone, and the one
/// with the common numbers common and the changes apart.
struct DiffFit {
  Role role = Role::test;
  JointRms of_a, of_b, joint;
};

/// What one model has over another on recordings that were not fitted, both sets.
struct HeldoutGainOver {
  double gain = 0.0, error = 0.0, share = 0.0;
};

struct DiffSet {
  std::string name;  ///< of its scenario
  Verdict verdict = Verdict::consistent;
  std::vector<std::string> findings;  ///< "joint_2.coulomb_friction"
  Unexplained unexplained;            ///< by its own diagnosis
  JointRms noise;
  std::vector<DiffFit> fit;  ///< by role
};

struct Diff {
  DiffSet a, b;
  std::string engine;
  std::uint64_t seed = 1;
  DiffVerdict verdict = DiffVerdict::same;
  std::vector<MachineChange> changes;  ///< most certain first
  std::vector<RefusedChange> refused;
  std::vector<SharedNumber> shared;
  double no_change = 0.0;  ///< probability that nothing changed
  double evidence = 0.0;   ///< log evidence of the claimed changes over none
  HeldoutGainOver changed_over_same, own_over_joint;
  std::vector<std::string> rest_in_a, rest_in_b;  ///< joints where that set alone leaves more than its noise
  std::vector<std::string> notes;
  double seconds = 0.0;
};

/// Throws InputError, naming the second scenario's file and key, where the two do not describe one machine seen in one
/// way: robot, gravity, known mass, actuators, effects, what is identified, measured quantities with their scales, and
/// prediction must agree. Names, columns, noise and recordings may differ.
void check_comparable(const Scenario& a, const Scenario& b);

/// Compares what both diagnoses left. `options` as for the diagnoses; its control's progress is told from 0 to 1.
/// Throws Interrupted, and WorkError where a set cannot be fitted.
Diff compare_sets(const Scenario& a, const Diagnosis& found_a, const Scenario& b, const Diagnosis& found_b,
                  const IdentifyOptions& options);

}  // namespace lacuna
