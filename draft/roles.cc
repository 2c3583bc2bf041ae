#include "draft/roles.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "draft/names.h"

namespace lacuna {
namespace {

constexpr std::size_t kFewestToSplit = 80;  ///< samples, so that each part has enough to be simulated

std::optional<Role> named_role(const std::string& file) {
  const std::vector<std::string> words = words_of(file.substr(file.find_last_of('/') + 1));
  for (const std::string& word : words) {
    if (word == "train" || word == "training" || word == "fit") return Role::train;
    if (word == "validate" || word == "validation" || word == "valid" || word == "val") return Role::validate;
    if (word == "test" || word == "testing") return Role::test;
  }
  return std::nullopt;
}

std::optional<RoleGuesses> by_names(const std::vector<RecordingSpan>& recordings) {
  RoleGuesses out{{}, "by the files' names"};
  std::array<int, 3> count{};
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const auto role = named_role(recordings[i].file);
    if (!role) return std::nullopt;
    ++count[static_cast<std::size_t>(*role)];
    out.roles.push_back({i, *role, std::nullopt, std::nullopt});
  }
  if (count[0] == 0 || count[1] == 0) return std::nullopt;
  return out;
}

/// The quietest sample's time within a twentieth of the recording about `share` of it.
double cut_near(const RecordingSpan& recording, double share) {
  constexpr double kReach = 0.05;
  const double n = static_cast<double>(recording.time.size() - 1);
  const auto at = [&](double s) { return static_cast<std::size_t>(std::lround(std::clamp(s, 0.0, 1.0) * n)); };
  std::size_t best = at(share);
  for (std::size_t i = at(share - kReach); i <= at(share + kReach); ++i)
    if (i < recording.speed.size() && recording.speed[i] < recording.speed[best]) best = i;
  return recording.time[best];
}

/// A time with as many digits as people read, where the samples lie further apart than that.
double rounded(const RecordingSpan& recording, double time) {
  constexpr double kReadable = 1e-3;  // s
  const double span = recording.time.back() - recording.time.front();
  return span > 100.0 * kReadable ? std::round(time / kReadable) * kReadable : time;
}

}  // namespace

RoleGuesses guess_roles(const std::vector<RecordingSpan>& recordings) {
  if (const auto named = by_names(recordings)) return *named;
  RoleGuesses out;
  if (recordings.size() <= 2 && recordings.back().time.size() < kFewestToSplit) {
    for (std::size_t i = 0; i < recordings.size(); ++i)
      out.roles.push_back({i, i == 0 ? Role::train : Role::validate, std::nullopt, std::nullopt});
    out.reason = "too short to split; a diagnosis needs a validate recording";
  } else if (recordings.size() == 1) {
    const double first = rounded(recordings[0], cut_near(recordings[0], 0.5));
    const double second = rounded(recordings[0], cut_near(recordings[0], 0.75));
    out.roles = {{0, Role::train, std::nullopt, first},
                 {0, Role::validate, first, second},
                 {0, Role::test, second, std::nullopt}};
    out.reason = "one recording, split in time where it is quiet: half, a quarter, a quarter";
  } else if (recordings.size() == 2) {
    const double middle = rounded(recordings[1], cut_near(recordings[1], 0.5));
    out.roles = {{0, Role::train, std::nullopt, std::nullopt},
                 {1, Role::validate, std::nullopt, middle},
                 {1, Role::test, middle, std::nullopt}};
    out.reason = "two recordings: one to fit, the other halved in time";
  } else {
    static constexpr std::array kTurns{Role::train, Role::train, Role::validate, Role::train, Role::test};
    static constexpr std::array kFew{Role::train, Role::validate, Role::test};
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      const bool few = recordings.size() == 3;
      // Four: the last is the test, so that no role is empty.
      const Role role = few ? kFew[i] : recordings.size() == 4 && i == 3 ? Role::test : kTurns[i % kTurns.size()];
      out.roles.push_back({i, role, std::nullopt, std::nullopt});
    }
    out.reason = "dealt out in turn; every role should hold every kind of motion: change it where it does not";
  }
  return out;
}

}  // namespace lacuna
