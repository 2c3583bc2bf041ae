// Where in the chain from command to reading something acts.
//
// A joint is driven through a chain: a command opens a valve (or sets a drive), the valve lets oil (or current) flow,
// that gives an effort, which passes a transmission to the link, whose motion is read. A signal measured within the
// chain cuts it: what acts before that point explains the signal, what acts behind it explains what follows from it.
// An effort that was measured already contains deadbands, delays and sagging pressure, so that none of them can stand
// between it and the motion; friction, gaps, masses and readings can.
#pragma once

namespace lacuna {

enum class Stage {
  command,       ///< the signal on its way to the valve or drive
  valve,         ///< valve or drive: what it makes of the signal
  flow,          ///< supply, flow and pressure
  effort,        ///< effort made from pressure or current, in joint terms: what an effort transducer reads
  transmission,  ///< gears, play and springs between that effort and the link
  link,          ///< the link's own motion: masses, friction, springs and stops at the joint, the base
  reading        ///< what transducers make of motion and effort
};

inline const char* to_string(Stage stage) {
  switch (stage) {
    case Stage::command: return "command";
    case Stage::valve: return "valve";
    case Stage::flow: return "flow";
    case Stage::effort: return "effort";
    case Stage::transmission: return "transmission";
    case Stage::link: return "link";
    case Stage::reading: return "reading";
  }
  return "";
}

}  // namespace lacuna
