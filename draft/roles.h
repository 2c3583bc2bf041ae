// Which recordings to fit, to judge by and to report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenarios/scenario.h"

namespace lacuna {

struct RoleGuess {
  std::size_t recording = 0;  ///< index
  Role role = Role::train;
  std::optional<double> from, to;  ///< s, on the recording's clock
};

/// What there is of one recording.
struct RecordingSpan {
  std::string file;
  std::vector<double> time;   ///< s
  std::vector<double> speed;  ///< [sample], of all joints together in shares of their rms: low where everything rests
};

struct RoleGuesses {
  std::vector<RoleGuess> roles;
  std::string reason;
};

/// By name where names say train, validate or test and at least the first two occur. Else one recording is split in
/// time (half, a quarter, a quarter, cut at rest where there is one near by), of two the second is halved, and more are
/// dealt out in turn, so that what changes over a session is in every role.
RoleGuesses guess_roles(const std::vector<RecordingSpan>& recordings);

}  // namespace lacuna
