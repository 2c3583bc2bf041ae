// The structure that two diagnoses of one machine have in common: what either set of recordings needs, both have.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "diff/side.h"

namespace lacuna {

/// One set with its diagnosis.
struct DiagnosedSet {
  const Scenario& scenario;
  const Diagnosis& diagnosis;
};

/// An effect of the common structure.
struct CommonEffect {
  EffectSpec spec;  ///< `parameters`: those that are held fixed; `recordings` are each side's own, below
  struct There {
    std::vector<std::string> recordings;   ///< files in which it acts; empty: all
    std::map<std::string, double> values;  ///< as diagnosed
    double probability = 0.0;
  };
  std::optional<There> a, b;             ///< where a diagnosis holds it
  std::vector<std::string> look_alikes;  ///< not told from it by a diagnosis
};

/// The union of both diagnoses' effects, A's first. Of two at one place of which the data cannot tell one from the
/// other, or one is a special case of the other, each found in one set only, the more probable one stands for both.
/// Laws without a name are left out, and said in `notes`: they belong to what the model does not explain.
std::vector<CommonEffect> common_effects(const Diagnosis& a, const Diagnosis& b, std::vector<std::string>& notes);

struct Structure {
  Side a, b;  ///< each fitted to its own train recordings
  std::vector<Changeable> changeables;
};

/// Both sides over the common structure, with the same axes and priors. An effect that acts in named recordings of one
/// set alone acts in none of the other's, where it is pinned at neutral. Throws WorkError where a set cannot be fitted,
/// Interrupted.
Structure common_structure(const DiagnosedSet& a, const DiagnosedSet& b, const SimulatorOptions& simulator,
                           const RunControl& control, std::vector<std::string>& notes);

/// One more effect in one set only, at neutral and pinned there in the other: `in_b` says which. Returns the index of
/// the new changeable.
std::size_t add_in_one(Structure& structure, const EffectSpec& spec, bool in_b);

}  // namespace lacuna
