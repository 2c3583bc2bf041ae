// What was measured, cut into the pieces that are simulated: one segment per recording (free run) or per window.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "physics/measured_motion.h"
#include "physics/noise.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// A measured quantity that predictions are compared with. Kinds, units and stages: physics/quantity.h.
struct Channel {
  ChannelKind kind = ChannelKind::position;
  int joint = 0;
  std::string unit;
  double noise =
      0.0;  ///< rms, channel units, of what is compared (after any filter); NaN: neither stated nor estimated
  bool noise_stated = false;
};

/// Commands of one recording, held between their instants. Shared by its segments.
struct CommandTrack {
  std::vector<double> time;                ///< s, from the recording's first used sample
  std::vector<std::vector<double>> value;  ///< [joint][sample], V; zeros for joints without a command
  double begin = 0.0;                      ///< s, the recording's own clock at time 0
};

struct StartEffects;

/// Measured pressures of one recording that drive its joints: [joint][0: A, 1: B][sample of the track], Pa; empty where
/// a joint is driven otherwise. Between samples they go on straight lines.
using PressureTrack = std::vector<std::array<std::vector<double>, 2>>;
/// The same at other times.
PressureTrack resampled(PressureTrack pressures, const std::vector<double>& time, const std::vector<double>& at);

struct Segment {
  int recording = 0;  ///< index in Scenario::recordings
  Role role = Role::train;
  std::string file;
  std::shared_ptr<const CommandTrack> commands;
  std::size_t first = 0, count = 0;           ///< samples of the track that the segment covers
  std::vector<std::vector<double>> measured;  ///< [channel][compared sample]; NaN where missing
  std::vector<double> q0, v0;                 ///< start of the simulation, from the measured positions
  std::vector<double> q0_error, v0_error;     ///< standard errors of these; 0 where the noise is unknown
  /// s, from the session's start to time 0 of the track: recordings follow one another in the order of the scenario,
  /// each when the one before has ended, unless their own clocks go on from file to file.
  double session = 0.0;
  /// What the errors of the start do to the prediction (ga/start_effects.h); null: the start is taken as exact.
  std::shared_ptr<const StartEffects> start_effects = {};

  /// What happened in it (events.h): efforts on joints besides all else [joint][interval], N m (N), and what position
  /// transducers read too much [joint][sample], rad (m). Null: nothing.
  std::shared_ptr<const std::vector<std::vector<double>>> pushes = {}, slips = {};

  /// [joint] Pa, chambers A and B at the start as measured there; NaN: not. Empty: at no joint.
  std::vector<std::array<double, 2>> pressures0 = {};
  std::shared_ptr<const PressureTrack> pressures = {};  ///< null: every joint is driven by its command

  /// Inverse dynamics only: the motion on even samples, which the track's are, too, and those of its samples that are
  /// compared (low-passed signals are thinned to twice the cutoff).
  std::shared_ptr<const MeasuredMotion> motion = {};
  std::shared_ptr<const RawMotion> raw = {};  ///< what the motion was made from
  std::vector<std::size_t> compared = {};

  /// Whether measured pressures drive joint j; the segments of an experiment are alike in that.
  bool is_pressed(std::size_t j) const { return pressures && !(*pressures)[j].front().empty(); }
  double time(std::size_t sample) const { return commands->time[first + sample]; }
  /// s, of a sample of `measured`.
  double compared_time(std::size_t k) const { return time(compared.empty() ? k : compared[k]); }
};

/// Everything that does not change while parameters are searched.
struct Experiment {
  std::vector<Channel> channels;
  std::vector<Segment> segments;
  Prediction prediction;
  std::vector<std::string> joint_names;
  double sample_period = 0.0;  ///< s, median spacing of the samples

  std::vector<int> with_role(Role role) const;  ///< indices of segments
  std::size_t sample_count(Role role) const;    ///< measured values, all channels
  /// rms of the command and of the measured positions' speed per joint (train recordings): sizes for searches.
  std::vector<double> command_rms, speed_rms, position_rms;
  std::vector<double> effort_rms;                       ///< of the measured effort (train); 0 where not measured
  std::vector<double> position_middle, position_reach;  ///< middle and half of the range travelled (train)
  double span = 0.0;                                    ///< s, length of the session
  /// [joint] Pa rms, chambers A and B, of measured pressures that drive joints; NaN: unknown. Empty: they drive none.
  std::vector<std::array<double, 2>> pressure_noise = {};
  /// Of so many parts that cannot move each other this is one: effects of the whole arm have no place in it.
  int parts = 1;
};

/// Whether the actuator of the joint of that name has two chambers, and thereby two pressures.
bool has_chambers(const Scenario& scenario, const std::string& joint);

/// The commands of one loaded recording over its time range. Throws InputError where that is shorter than ten samples.
std::shared_ptr<const CommandTrack> command_track(const Scenario& scenario, const RecordingSpec& spec);

/// Cuts the scenario's recordings. Compared are the measured positions, speeds and efforts; in inverse dynamics the
/// measured efforts or, of joints without one, the command that stands for it (of passive joints an effort of 0), all
/// filtered as the motion is. Throws InputError where nothing is measured, there is no recording, one is shorter than
/// ten samples or than the horizon, or something is given that this prediction cannot use.
Experiment make_experiment(const Scenario& scenario);

/// Inverse dynamics: the same experiment with other positions and speeds in a segment.
void set_motion(Segment& segment, RawMotion raw, double cutoff_hz);

/// Start of a piece of a signal: value and slope at time[at], by the widest local polynomial (constant, line, parabola)
/// that explains samples [begin, end) around it down to the noise (chi-square). NaN samples are skipped. What a
/// polynomial leaves out is not known to be nothing: the errors are at least those of one a degree higher, and hold the
/// difference from it.
struct LocalState {
  double value = 0.0, slope = 0.0;
  double value_error = 0.0, slope_error = 0.0;  ///< standard errors; 0 where nothing is known
};
LocalState local_state(const std::vector<double>& time, const std::vector<double>& signal, std::size_t at,
                       std::size_t begin, std::size_t end, double noise);

}  // namespace lacuna
