// What chain.h judges the parts of a joint's chain by: samples of their mismatch, and how they are sorted.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "diagnosis/chain.h"

namespace lacuna {

/// Samples of one joint, part by part (kParts).
struct JointSamples {
  std::array<std::vector<double>, kParts.size()> mismatch, signal;

  /// `from` behind what is there.
  void append(const JointSamples& from);
};

/// One joint as the recordings that were not fitted show it.
struct JointLook {
  JointSamples before, after;                 ///< of the plain and of the diagnosed model
  std::array<double, kParts.size()> noise{};  ///< rms that the transducers' noise makes of it; 0: unknown
  std::array<std::string, kParts.size()> why_not;
};

inline constexpr const char* kCannotInvert =
    "the effort that the motion needs is not known: a joint's position or pressure is not measured throughout";
inline constexpr std::size_t kFewestInPart = 10;  ///< samples that judge a part

inline std::size_t index_of(ChainPart part) { return static_cast<std::size_t>(part); }
double rms_of(const std::vector<double>& x);
void take_off_mean(std::vector<double>& x);

/// Which of the parts in front of the pressures a joint's commands let be judged at an instant.
class CommandedParts {
 public:
  explicit CommandedParts(const Experiment& experiment);
  ChainPart at(const Segment& segment, std::size_t joint, std::size_t sample) const;

 private:
  bool lately(const Segment& segment, std::size_t joint, std::size_t sample) const;
  std::vector<double> largest_;  ///< command of each joint
};

/// Of a joint that hardly ever moves alone all that its open valve lets through judges the valve, in all of `samples`
/// (the first decides), and the supply is not judged. The reason; empty where it moves alone often enough.
std::string take_together_where_needed(const std::vector<JointSamples*>& samples);

/// Segments of validate and test recordings.
std::vector<int> not_fitted(const Experiment& experiment);
bool has_pressures(const Scenario& scenario, const std::string& joint);
/// The scenario of the motions alone: whole recordings, without events; of what is measured positions, and pressures
/// where both of a joint are.
Scenario motions_of(const Scenario& scenario);
/// The motion with white noise of its positions' level.
RawMotion with_noise(RawMotion motion, std::uint64_t seed, int segment);
/// Whether kLocateCutoff lies far enough below what the samples can show.
bool can_filter(double rate);

/// Joints with chambers, by joint of the robot: all parts from pressures and motion (physics/chamber_balance.h).
/// Nothing is simulated but what the filter leaves of the models' own motions. Empty where a position or a pressure is
/// not measured throughout.
std::vector<JointLook> chamber_looks(const CurrentModel& before, const CurrentModel& after, const Scenario& scenario,
                                     const SimulatorOptions& options, std::uint64_t seed);

/// `joints` whose actuators give a flow and have no areas, by joint of the robot: measured speeds against simulated
/// ones, in the experiment's predictions; the effort that the motion needs against both pressures, each times an area
/// that is fitted to the train recordings.
std::vector<JointLook> flow_looks(const CurrentModel& before, const CurrentModel& after, const Scenario& scenario,
                                  const FitContext& context, std::uint64_t seed, const std::vector<int>& joints);

}  // namespace lacuna
