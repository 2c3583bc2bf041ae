// Which of the preferred changes are claimed: those that predict recordings which neither set was fitted to.
#pragma once

#include <string>
#include <vector>

#include "diff/joint_fit.h"
#include "diff/structure.h"

namespace lacuna {

/// A point for both sets, and what it is about.
struct Hypothesised {
  ChangedSet changed;
  JointFit fit;
};

/// What one point has over another on both sets' validate recordings, in the sides' weights: a sample that says nothing
/// new counts for nothing. Zeros where there are none.
struct HeldoutGainOf {
  double gain = 0.0, error = 0.0, share = 0.0;
  bool known = false;
  bool speaks_for() const { return gain > 2.0 * error && gain > 0.0; }
};
HeldoutGainOf heldout_over(const Structure& structure, const JointFit& one, const JointFit& other);

/// A change of the best set, and what became of it.
struct Claim {
  std::size_t group = 0;
  HeldoutGainOf heldout;  ///< over the set without it, everything else fitted again
  std::string refused;    ///< why it is not claimed, in words; empty: it is
};

/// Takes out, one at a time and the worst first, what held-out recordings do not confirm, and what its class makes less
/// probable than not; `best` becomes what is left, fitted. Without validate recordings in either set evidence decides
/// alone. `class_probability`: [group].
std::vector<Claim> claims_of(const Structure& structure, const ChangeGroups& groups,
                             const std::vector<double>& class_probability, Hypothesised& best,
                             const std::atomic<bool>* stop);

}  // namespace lacuna
