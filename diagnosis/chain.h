// Where the chain from command to motion fails, at joints whose chambers' pressures are measured.
//
//   command -> valve -> flow -> chambers -> pressure -> piston, links -> motion
//                        ^ supply, shared with other joints
//
// A measured pressure cuts the chain, and each part is judged by what was measured on either side of it, so that a
// wrong valve says nothing against the links and a wrong mass nothing against the valve:
//
//   command to flow     flow that the valve's equation gives at this command and these pressures, against what the
//                       chambers took for the piston's motion and the oil's compression; while no other joint is
//                       commanded
//   supply              the same while others are commanded, too: it fails where that is more than the valve leaves by
//                       itself, in proportion to the speed
//   flow to pressure    the same while the joint's valve has been closed for a while: what is left are leaks and
//                       compression
//   pressure to motion  the piston's force against the effort that the motion needs (inverse dynamics)
//
// Flows are told as the joint's speed. Where the actuator gives a flow and no areas (`flow_source`) the first two
// compare the simulated speed with the measured one, the third cannot be judged, and the areas of the last are fitted
// to the train recordings. All is low-passed at kLocateCutoff; what filter and held commands leave of a motion without
// any mismatch is taken off by doing the same to the model's own simulation.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "physics/simulator.h"

namespace lacuna {

struct CurrentModel;
struct FitContext;

enum class ChainPart { command_to_flow, supply, flow_to_pressure, pressure_to_motion };
inline constexpr std::array<ChainPart, 4> kParts{ChainPart::command_to_flow, ChainPart::supply,
                                                 ChainPart::flow_to_pressure, ChainPart::pressure_to_motion};
const char* to_string(ChainPart part);  ///< "command_to_flow", ...

/// One part of one joint, on the recordings that were not fitted.
struct PartFit {
  ChainPart part = ChainPart::command_to_flow;
  std::string why_not;  ///< it cannot be judged; empty: it is
  std::string unit;     ///< of the figures: rad/s (m/s), N m (N)
  double samples = 0.0;
  double signal = 0.0;  ///< rms of what the part gave as measured: speed; oil's compression; effort about its mean
  double noise = 0.0;   ///< rms that the transducers' noise makes of the mismatch
  double before = 0.0, after = 0.0;  ///< rms of the mismatch, of the plain and of the diagnosed model
  /// rms of it where the part is right: the noise; of a supply what the valve leaves by itself, where that is more.
  double expected_before = 0.0, expected_after = 0.0;
  double p_before = 1.0, p_after = 1.0;  ///< of so much more from chance alone, corrected for all that is judged
  bool fails() const;                    ///< the plain model's, beyond chance (kLocateError) and half as much again
  bool still_fails() const;              ///< the diagnosed one's
};

struct JointChain {
  std::string joint;
  bool areas_given = false;
  std::array<PartFit, 4> parts;  ///< as kParts
};

/// Joints whose both pressures are measured and whose position is, in simulated predictions; none where inverse
/// dynamics cannot be had (locate.h).
std::vector<JointChain> joint_chains(const CurrentModel& before, const CurrentModel& after, const Scenario& scenario,
                                     const FitContext& context, std::uint64_t seed);

}  // namespace lacuna
