#include "physics/experiment.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <map>

#include "physics/actuators/table.h"
#include "physics/catalogue.h"
#include "physics/events.h"
#include "physics/noise.h"
#include "physics/quantity.h"
#include "physics/units.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr int kInversePasses = 1;  ///< of the filter, through which what inverse dynamics compares goes

constexpr std::size_t kFewestSamples = 10;
/// Of polynomials that explain their samples so many are taken for others, since noise alone leaves that much.
constexpr double kRefusedByChance = 0.01;

const std::vector<double>& column_of(const Recording& data, const std::string& name) {
  return data.columns[data.find(name)];
}

std::vector<double> converted(const Recording& data, const ColumnSpec& spec, std::size_t from, std::size_t to) {
  const std::vector<double>& raw = column_of(data, spec.column);
  std::vector<double> out;
  out.reserve(to - from);
  for (std::size_t i = from; i < to; ++i) out.push_back(spec.scale * raw[i] + spec.offset);
  return out;
}

std::string unit_of(const Scenario& scenario, ChannelKind kind, const Joint& joint) {
  const Quantity& quantity = quantity_of(kind);
  const char* unit = joint.prismatic() ? quantity.linear_unit : quantity.unit;
  return *unit == '\0' ? command_unit(scenario, joint.name) : unit;
}

bool inverse(const Scenario& scenario) { return std::holds_alternative<InverseDynamics>(scenario.prediction); }

const ColumnSpec* column_spec(const Scenario& scenario, ChannelKind kind, const Joint& joint) {
  const auto of_kind = scenario.channels.of.find(kind);
  if (of_kind == scenario.channels.of.end()) return nullptr;
  const auto spec = of_kind->second.find(joint.name);
  return spec == of_kind->second.end() ? nullptr : &spec->second;
}

/// First sample of a recording's time range, and the one after its last.
std::pair<std::size_t, std::size_t> rows_of(const Scenario& scenario, const RecordingSpec& spec) {
  const std::vector<double>& time = column_of(*spec.data, scenario.channels.time);
  const auto first = std::lower_bound(time.begin(), time.end(), spec.from.value_or(-HUGE_VAL));
  const auto last = std::upper_bound(first, time.end(), spec.to.value_or(HUGE_VAL));
  const std::size_t from = first - time.begin();
  const std::size_t to = last - time.begin();
  if (to - from < kFewestSamples) {
    throw InputError(spec.where, fmt::format("{} samples of {} in the time range", to - from, quoted(spec.file)),
                     fmt::format("at least {}", kFewestSamples));
  }
  return {from, to};
}

/// A recording cut to its time range.
struct Cut {
  std::shared_ptr<const CommandTrack> track;
  std::map<ChannelKind, std::vector<std::vector<double>>> signals;  ///< [joint]; empty: not measured
  double session = 0.0;                                             ///< s, of the track's start
  std::shared_ptr<const PressureTrack> pressures = {};              ///< where they drive joints

  const std::vector<double>& signal(ChannelKind kind, int joint) const { return signals.at(kind)[joint]; }
};

Cut cut(const Scenario& scenario, const RecordingSpec& spec, double session_offset) {
  const Recording& data = *spec.data;
  const auto [from, to] = rows_of(scenario, spec);
  Cut out{command_track(scenario, spec), {}, session_offset + column_of(data, scenario.channels.time)[from]};
  for (const Quantity& quantity : quantity_table()) {
    if (quantity.predicted_by == PredictedBy::given) continue;
    std::vector<std::vector<double>>& joints = out.signals[quantity.kind];
    for (const Joint& joint : scenario.robot->joints()) {
      const ColumnSpec* column = column_spec(scenario, quantity.kind, joint);
      joints.push_back(column == nullptr ? std::vector<double>{} : converted(data, *column, from, to));
    }
  }
  return out;
}

/// Puts measured pressures in the place of commands at the joints whose actuators have chambers.
void drive_by_pressures(const Scenario& scenario, const RecordingSpec& spec, Cut& piece) {
  auto pressures = std::make_shared<PressureTrack>(scenario.robot->joints().size());
  auto track = std::make_shared<CommandTrack>(*piece.track);
  for (std::size_t j = 0; j < pressures->size(); ++j) {
    const Joint& joint = scenario.robot->joints()[j];
    if (!has_chambers(scenario, joint.name)) continue;
    for (const std::size_t which : {0u, 1u}) {
      const ChannelKind kind = which == 0 ? ChannelKind::pressure_a : ChannelKind::pressure_b;
      const std::vector<double>& values = piece.signal(kind, static_cast<int>(j));
      for (std::size_t k = 0; k < values.size(); ++k)
        if (!std::isfinite(values[k]))
          throw InputError(spec.where,
                           fmt::format("no {} of {} at {} s of {}", to_string(kind), quoted(joint.name),
                                       track->begin + track->time[k], quoted(spec.file)),
                           "a pressure at every instant, where pressures drive the joint");
      (*pressures)[j][which] = values;
    }
    std::fill(track->value[j].begin(), track->value[j].end(), 0.0);
  }
  piece.track = track, piece.pressures = pressures;
}

void set_stated_noise(const Scenario& scenario, Channel& channel) {
  const auto stated = scenario.noise.find(channel.kind);
  if (stated == scenario.noise.end()) return;
  const auto of = stated->second.find(scenario.robot->joints()[channel.joint].name);
  if (of != stated->second.end()) channel.noise = of->second, channel.noise_stated = true;
}

/// What can be compared at joint j: by simulation whatever is measured and can be predicted, by inverse dynamics the
/// effort, or what is told the joint in its place, and the actuator's side.
std::vector<ChannelKind> compared_kinds(const Scenario& scenario, const Joint& joint) {
  std::vector<ChannelKind> out;
  for (const Quantity& quantity : quantity_table()) {
    const bool measured = column_spec(scenario, quantity.kind, joint) != nullptr;
    const bool starts_there = inverse(scenario) && quantity.predicted_by == PredictedBy::motion;
    const bool within = quantity.predicted_by == PredictedBy::chambers;
    const bool predicted = within
                               ? !inverse(scenario) && !scenario.pressure_driven && has_chambers(scenario, joint.name)
                               : quantity.predicted_by != PredictedBy::given;
    if (measured && predicted && !starts_there) out.push_back(quantity.kind);
  }
  if (!inverse(scenario) || column_spec(scenario, ChannelKind::effort, joint) != nullptr) return out;
  const bool commanded = column_spec(scenario, ChannelKind::command, joint) != nullptr;
  const bool passive = std::none_of(scenario.actuators.begin(), scenario.actuators.end(),
                                    [&](const ActuatorSpec& a) { return a.joint == joint.name; });
  if (commanded || passive) out.push_back(ChannelKind::command);
  return out;
}

std::vector<Channel> make_channels(const Scenario& scenario) {
  std::vector<Channel> channels;
  for (const Quantity& quantity : quantity_table()) {
    for (int j = 0; j < scenario.robot->dof(); ++j) {
      const Joint& joint = scenario.robot->joints()[j];
      const std::vector<ChannelKind> kinds = compared_kinds(scenario, joint);
      if (std::find(kinds.begin(), kinds.end(), quantity.kind) == kinds.end()) continue;
      channels.push_back({quantity.kind, j, unit_of(scenario, quantity.kind, joint), std::nan(""), false});
      set_stated_noise(scenario, channels.back());
    }
  }
  return channels;
}

/// The median over recordings of what the signal's differences show; NaN where no recording shows it.
double estimated_noise(const std::vector<Cut>& cuts, ChannelKind kind, int joint) {
  std::vector<double> estimates;
  for (const Cut& piece : cuts) {
    const double rms = noise_of(piece.track->time, piece.signal(kind, joint));
    if (std::isfinite(rms)) estimates.push_back(rms);
  }
  if (estimates.empty()) return std::nan("");
  std::sort(estimates.begin(), estimates.end());
  return estimates[estimates.size() / 2];
}

/// rms of a transducer's noise, stated or estimated; NaN: unknown, or no transducer.
double transducer_noise(const Scenario& scenario, const std::vector<Cut>& cuts, ChannelKind kind, int joint) {
  if (cuts.front().signal(kind, joint).empty()) return std::nan("");
  Channel channel{kind, joint, "", std::nan(""), false};
  set_stated_noise(scenario, channel);
  return channel.noise_stated ? channel.noise : estimated_noise(cuts, kind, joint);
}

void estimate_noise(std::vector<Channel>& channels, const std::vector<Cut>& cuts) {
  for (Channel& channel : channels) {
    if (!channel.noise_stated && channel.kind != ChannelKind::command)
      channel.noise = estimated_noise(cuts, channel.kind, channel.joint);
  }
}

/// Whether inverse dynamics can be asked for at all: of every joint the position, of one what moves it.
void refuse_unusable(const Scenario& scenario) {
  if (!inverse(scenario)) return;
  for (const Joint& joint : scenario.robot->joints()) {
    if (column_spec(scenario, ChannelKind::position, joint) == nullptr) {
      throw InputError(scenario.file.string() + ": channels.position", "none of the joint " + quoted(joint.name),
                       "the position of every joint, from which inverse dynamics starts");
    }
  }
}

/// Index of the channel of `kind` at `joint`, or -1.
int find_channel(const std::vector<Channel>& channels, ChannelKind kind, int joint) {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind == kind && channels[c].joint == joint) return static_cast<int>(c);
  }
  return -1;
}

/// Chambers' pressures at a sample, from which a simulation starts: those of the joints whose pressures are compared.
/// The sample alone: oil may ring faster than neighbouring samples could be averaged.
std::vector<std::array<double, 2>> start_pressures(const Cut& piece, const std::vector<Channel>& channels,
                                                   std::size_t joints, std::size_t first) {
  std::vector<std::array<double, 2>> out(joints, {std::nan(""), std::nan("")});
  for (const Channel& channel : channels) {
    if (quantity_of(channel.kind).predicted_by != PredictedBy::chambers) continue;
    const std::vector<double>& column = piece.signal(channel.kind, channel.joint);
    out[channel.joint][channel.kind == ChannelKind::pressure_b ? 1 : 0] = column[first];
  }
  return out;
}

Segment make_segment(const Scenario& scenario, int index, const Cut& piece, const std::vector<Channel>& channels,
                     std::size_t first, std::size_t count) {
  const RecordingSpec& spec = scenario.recordings[index];
  Segment segment{index, spec.role, spec.file, piece.track, first, count, {}, {}, {}, {}, {}, piece.session};
  for (const Channel& channel : channels) {
    const std::vector<double>& column = piece.signal(channel.kind, channel.joint);
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(first);
    segment.measured.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(count));
  }
  for (int j = 0; j < scenario.robot->dof(); ++j) {
    const int c = find_channel(channels, ChannelKind::position, j);
    LocalState start;
    if (c >= 0) {
      const std::vector<double>& column = piece.signal(ChannelKind::position, j);
      start = local_state(piece.track->time, column, first, 0, column.size(), channels[c].noise);
    }
    const int rate = find_channel(channels, ChannelKind::velocity, j);
    if (rate >= 0) {
      const double v = piece.signal(ChannelKind::velocity, j)[first];
      if (std::isfinite(v)) {
        start.slope = v;
        const double noise = channels[static_cast<std::size_t>(rate)].noise;
        start.slope_error = std::isfinite(noise) ? noise : 0.0;
      }
    }
    segment.q0.push_back(start.value);
    segment.v0.push_back(start.slope);
    segment.q0_error.push_back(start.value_error);
    segment.v0_error.push_back(start.slope_error);
  }
  segment.pressures0 = start_pressures(piece, channels, segment.q0.size(), first);
  segment.pressures = piece.pressures;
  return segment;
}

double median_spacing(const std::vector<double>& time) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < time.size(); ++i) gaps.push_back(time[i] - time[i - 1]);
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
  return gaps[gaps.size() / 2];
}

/// The transducers' signals of one recording, for inverse dynamics.
RawMotion raw_motion(const Scenario& scenario, const std::vector<Cut>& cuts, const Cut& piece) {
  RawMotion out;
  out.time = piece.track->time;
  for (int j = 0; j < scenario.robot->dof(); ++j) {
    out.position.push_back(piece.signal(ChannelKind::position, j));
    out.velocity.push_back(piece.signal(ChannelKind::velocity, j));
    out.position_noise.push_back(transducer_noise(scenario, cuts, ChannelKind::position, j));
    out.velocity_noise.push_back(transducer_noise(scenario, cuts, ChannelKind::velocity, j));
  }
  return out;
}

/// Commands in force at even times.
std::shared_ptr<const CommandTrack> held_at(const CommandTrack& track, const std::vector<double>& at) {
  auto out = std::make_shared<CommandTrack>();
  out->time = at, out->begin = track.begin;
  for (const std::vector<double>& value : track.value) {
    std::vector<double> held(at.size());
    std::size_t i = 0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      while (i + 1 < value.size() && track.time[i + 1] <= at[k]) ++i;
      held[k] = value[i];
    }
    out->value.push_back(std::move(held));
  }
  return out;
}

/// A whole recording for inverse dynamics: everything on one even clock, what is compared filtered as the prediction
/// is, and thinned.
Segment make_inverse_segment(const Scenario& scenario, int index, const std::vector<Cut>& cuts,
                             const std::vector<Channel>& channels) {
  const RecordingSpec& spec = scenario.recordings[index];
  const Cut& piece = cuts[index];
  const double cutoff = std::get<InverseDynamics>(scenario.prediction).cutoff_hz;
  const std::size_t n = scenario.robot->dof();
  Segment out{index, spec.role, spec.file, piece.track, 0, piece.track->time.size(), {}, {}, {}, {}, {}, piece.session};
  out.q0.assign(n, 0.0), out.v0 = out.q0_error = out.v0_error = out.q0;
  const double rate = static_cast<double>(out.count - 1) / (piece.track->time.back() - piece.track->time.front());
  if (!(cutoff < 0.5 * rate)) {
    throw InputError(spec.where, fmt::format("{:.4g} samples a second of {}", rate, quoted(spec.file)),
                     fmt::format("more than twice the cutoff of {} Hz", cutoff));
  }
  set_motion(out, raw_motion(scenario, cuts, piece), cutoff);
  const std::vector<double>& even = out.motion->time;
  out.pressures = piece.pressures;
  if (!is_even(piece.track->time)) {
    out.commands = held_at(*piece.track, even);
    if (piece.pressures)
      out.pressures = std::make_shared<const PressureTrack>(resampled(*piece.pressures, piece.track->time, even));
  }
  const ZeroPhaseLowPass filter(cutoff, rate);
  const Thinning thinning(cutoff, rate);
  for (std::size_t k = thinning.edge; k + thinning.edge < out.count; k += thinning.stride) out.compared.push_back(k);
  if (out.compared.size() < kFewestSamples) {
    throw InputError(spec.where, fmt::format("{} s of {}", piece.track->time.back(), quoted(spec.file)),
                     fmt::format("at least {} half cycles of the cutoff", kFewestSamples));
  }
  for (const Channel& channel : channels) {
    const std::size_t j = channel.joint;
    std::vector<double> signal = channel.kind == ChannelKind::command
                                     ? out.commands->value[j]
                                     : resampled(is_even(piece.track->time) ? even : piece.track->time,
                                                 piece.signal(channel.kind, channel.joint), even);
    for (int pass = 0; pass < kInversePasses; ++pass) filter.apply(signal);
    std::vector<double> thinned;
    for (const std::size_t k : out.compared) thinned.push_back(signal[k]);
    out.measured.push_back(std::move(thinned));
  }
  return out;
}

void add_segments(const Scenario& scenario, int index, const std::vector<Cut>& cuts, Experiment& out) {
  const Cut& piece = cuts[index];
  const std::vector<double>& time = piece.track->time;
  if (inverse(scenario)) {
    out.segments.push_back(make_inverse_segment(scenario, index, cuts, out.channels));
    return;
  }
  const auto* windows = std::get_if<Windows>(&scenario.prediction);
  if (windows == nullptr) {
    out.segments.push_back(make_segment(scenario, index, piece, out.channels, 0, time.size()));
    return;
  }
  const RecordingSpec& spec = scenario.recordings[index];
  if (time.back() < windows->horizon) {
    throw InputError(spec.where, fmt::format("{} s of {}", time.back(), quoted(spec.file)),
                     fmt::format("at least one horizon of {} s", windows->horizon));
  }
  for (std::size_t first = 0; first < time.size();) {
    const double end = time[first] + windows->horizon;
    const std::size_t stop =
        static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), end * (1.0 + 1e-12)) - time.begin());
    if (time[stop - 1] - time[first] < 0.9 * windows->horizon && stop == time.size()) break;  // a stump
    if (stop - first >= 3)
      out.segments.push_back(make_segment(scenario, index, piece, out.channels, first, stop - first));
    first = std::max(stop - 1, first + 1);
  }
}

/// s, by file: what must be added to its clock to get the session's time. Files are in the order of their first
/// mention; clocks that go on from one file to the next are taken as they are.
std::map<std::string, double> session_offsets(const Scenario& scenario) {
  std::vector<std::pair<std::string, const std::vector<double>*>> clocks;
  for (const RecordingSpec& spec : scenario.recordings) {
    const auto same = std::find_if(clocks.begin(), clocks.end(), [&](const auto& c) { return c.first == spec.file; });
    if (same == clocks.end()) clocks.emplace_back(spec.file, &column_of(*spec.data, scenario.channels.time));
  }
  bool goes_on = true;
  for (std::size_t k = 1; k < clocks.size(); ++k)
    goes_on = goes_on && clocks[k].second->front() >= clocks[k - 1].second->back();
  std::map<std::string, double> out;
  double end = 0.0;  // of the files so far, in the session's time
  for (const auto& [file, time] : clocks) {
    out[file] = (goes_on ? -clocks.front().second->front() : end - time->front());
    end += time->back() - time->front();
  }
  return out;
}

/// What transducers' noise is left with after the filters of inverse dynamics.
void filter_noise(const Scenario& scenario, Experiment& out) {
  const auto* inverse = std::get_if<InverseDynamics>(&scenario.prediction);
  if (inverse == nullptr) return;
  const double gain =
      filter_gain(ZeroPhaseLowPass(inverse->cutoff_hz, out.segments.front().motion->rate), kInversePasses).value;
  for (Channel& channel : out.channels) channel.noise *= gain;
}

/// N m (N): the measured effort of joint j, or what the pressures that drive it give where it stands.
std::vector<double> efforts_of(const Scenario& scenario, const Cut& piece, int j) {
  const std::vector<double>& position = piece.signal(ChannelKind::position, j);
  if (!piece.pressures || (*piece.pressures)[j].front().empty() || position.empty())
    return piece.signal(ChannelKind::effort, j);
  const ActuatorSpec& spec =
      *std::ranges::find(scenario.actuators, scenario.robot->joints()[j].name, &ActuatorSpec::joint);
  const std::size_t type = find_actuator(spec.model);
  std::vector<double> parameters, out;
  for (const ParameterInfo& p : actuator_table()[type].parameters) {
    const auto given = spec.parameters.find(p.name);
    parameters.push_back(given == spec.parameters.end() ? p.neutral : given->second);
  }
  for (std::size_t k = 0; k < position.size(); ++k) {
    const std::array<double, 2> chambers{(*piece.pressures)[j][0][k] / kPressureUnit,
                                         (*piece.pressures)[j][1][k] / kPressureUnit};
    JointView<double> view;
    view.q = position[k], view.z = chambers.data();
    out.push_back(Actuators::hooks<double>()[type].effort(parameters.data(), view));
  }
  return out;
}

/// rms about zero (commands, efforts) or about the mean (positions) over the train recordings.
void measure_sizes(const Scenario& scenario, const std::vector<Cut>& cuts, Experiment& out) {
  for (int j = 0; j < scenario.robot->dof(); ++j) {
    double u2 = 0, q2 = 0, v2 = 0, e2 = 0, q_sum = 0, low = HUGE_VAL, high = -HUGE_VAL;
    std::size_t n_u = 0, n_q = 0, n_v = 0, n_e = 0;
    for (std::size_t r = 0; r < cuts.size(); ++r) {
      if (scenario.recordings[r].role != Role::train) continue;
      for (const double u : cuts[r].track->value[j]) u2 += u * u, ++n_u;
      for (const double e : efforts_of(scenario, cuts[r], j))
        if (std::isfinite(e)) e2 += e * e, ++n_e;
      const std::vector<double>& q = cuts[r].signal(ChannelKind::position, j);
      const std::vector<double>& t = cuts[r].track->time;
      const std::size_t stride = std::max<std::size_t>(1, q.size() / 500);  // speed over strides: above the noise
      for (std::size_t i = 0; i < q.size(); ++i) {
        if (!std::isfinite(q[i])) continue;
        q2 += q[i] * q[i], q_sum += q[i], ++n_q;
        low = std::min(low, q[i]), high = std::max(high, q[i]);
        if (i < stride || i % stride != 0 || !std::isfinite(q[i - stride])) continue;
        const double v = (q[i] - q[i - stride]) / (t[i] - t[i - stride]);
        v2 += v * v, ++n_v;
      }
    }
    const double mean = n_q > 0 ? q_sum / static_cast<double>(n_q) : 0.0;
    out.position_middle.push_back(n_q > 0 ? 0.5 * (low + high) : 0.0);
    out.position_reach.push_back(n_q > 0 ? 0.5 * (high - low) : 0.0);
    out.effort_rms.push_back(n_e > 0 ? std::sqrt(e2 / static_cast<double>(n_e)) : 0.0);
    out.command_rms.push_back(n_u > 0 ? std::sqrt(u2 / static_cast<double>(n_u)) : 0.0);
    out.position_rms.push_back(n_q > 0 ? std::sqrt(std::max(0.0, q2 / static_cast<double>(n_q) - mean * mean)) : 0.0);
    out.speed_rms.push_back(n_v > 0 ? std::sqrt(v2 / static_cast<double>(n_v)) : 0.0);
  }
}

}  // namespace

namespace {

/// One local polynomial: its state at the middle, the error variance of that value, and whether it explains the
/// samples.
struct LocalFit {
  LocalState state;
  double variance = HUGE_VAL;
  bool adequate = false;
  std::vector<std::size_t> used;
  int order = 0;
};
constexpr int kHighestOrder = 2;

/// Sum of squares over the noise variance that so many degrees of freedom exceed by chance.
double most_by_chance(Eigen::Index freedom) {
  const boost::math::chi_squared chi2(static_cast<double>(freedom));
  return boost::math::quantile(boost::math::complement(chi2, kRefusedByChance));
}

LocalFit fit_polynomial(const std::vector<double>& time, const std::vector<double>& signal,
                        const std::vector<std::size_t>& used, std::size_t at, int order, double sigma2) {
  const Eigen::Index n = static_cast<Eigen::Index>(used.size()), terms = order + 1;
  Eigen::MatrixXd basis(n, terms);
  Eigen::VectorXd y(n);
  const double span = std::max(time[used.back()] - time[used.front()], 1e-300);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t k = used[i];
    for (Eigen::Index p = 0; p < terms; ++p) basis(i, p) = std::pow((time[k] - time[at]) / span, p);
    y(i) = signal[k];
  }
  const Eigen::MatrixXd inverse = (basis.transpose() * basis).inverse();
  const Eigen::VectorXd x = inverse * (basis.transpose() * y);
  const double residual = (y - basis * x).squaredNorm() / static_cast<double>(n - terms);
  const double variance = std::max(residual, sigma2);
  LocalFit out{{x(0), order > 0 ? x(1) / span : 0.0, std::sqrt(inverse(0, 0) * variance), 0.0},
               inverse(0, 0) * variance,
               residual * static_cast<double>(n - terms) <= sigma2 * most_by_chance(n - terms),
               used,
               order};
  if (order > 0) out.state.slope_error = std::sqrt(inverse(1, 1) * variance) / span;
  return out;
}

}  // namespace

LocalState local_state(const std::vector<double>& time, const std::vector<double>& signal, std::size_t at,
                       std::size_t begin, std::size_t end, double noise) {
  const double sigma2 = std::isfinite(noise) && noise > 0.0 ? noise * noise : 0.0;
  LocalFit best;
  for (const std::size_t half : {3u, 5u, 8u, 12u, 20u, 32u, 50u, 80u}) {
    const std::size_t from = at - begin > half ? at - half : begin;
    std::vector<std::size_t> used;
    for (std::size_t i = from; i < std::min(end, at + half + 1); ++i) {
      if (std::isfinite(signal[i])) used.push_back(i);
    }
    for (int order = 0; order <= kHighestOrder; ++order) {
      if (static_cast<int>(used.size()) < order + 3) continue;
      const LocalFit fit = fit_polynomial(time, signal, used, at, order, sigma2);
      // Any adequate fit beats any other; among equals the smaller error of the value at `at` wins.
      const bool better = fit.adequate != best.adequate ? fit.adequate : fit.variance < best.variance;
      if (better) best = fit;
    }
  }
  if (best.variance == HUGE_VAL && at < signal.size() && std::isfinite(signal[at])) best.state.value = signal[at];
  if (best.variance == HUGE_VAL || sigma2 == 0.0) {
    best.state.value_error = best.state.slope_error = 0.0;
  } else if (best.used.size() > static_cast<std::size_t>(best.order) + 2) {
    const LocalState higher = fit_polynomial(time, signal, best.used, at, best.order + 1, sigma2).state;
    LocalState& state = best.state;
    state.value_error = std::max(higher.value_error, std::hypot(state.value_error, state.value - higher.value));
    state.slope_error = std::max(higher.slope_error, std::hypot(state.slope_error, state.slope - higher.slope));
  }
  return best.state;
}

std::vector<int> Experiment::with_role(Role role) const {
  std::vector<int> out;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (segments[i].role == role) out.push_back(static_cast<int>(i));
  }
  return out;
}

std::size_t Experiment::sample_count(Role role) const {
  std::size_t n = 0;
  for (const int i : with_role(role)) {
    for (const auto& column : segments[i].measured) {
      n += static_cast<std::size_t>(
          std::count_if(column.begin(), column.end(), [](double x) { return std::isfinite(x); }));
    }
  }
  return n;
}

std::shared_ptr<const CommandTrack> command_track(const Scenario& scenario, const RecordingSpec& spec) {
  const Recording& data = *spec.data;
  const std::vector<double>& time = column_of(data, scenario.channels.time);
  const auto [from, to] = rows_of(scenario, spec);
  auto track = std::make_shared<CommandTrack>();
  track->begin = time[from];
  for (std::size_t i = from; i < to; ++i) track->time.push_back(time[i] - time[from]);
  const auto commands = scenario.channels.of.find(ChannelKind::command);
  for (const Joint& joint : scenario.robot->joints()) {
    const bool driven = commands != scenario.channels.of.end() && commands->second.count(joint.name) > 0;
    track->value.push_back(driven ? converted(data, commands->second.at(joint.name), from, to)
                                  : std::vector<double>(to - from, 0.0));
  }
  return track;
}

void set_motion(Segment& segment, RawMotion raw, double cutoff_hz) {
  segment.motion = std::make_shared<const MeasuredMotion>(measured_motion(raw, cutoff_hz));
  segment.raw = std::make_shared<const RawMotion>(std::move(raw));
}

bool has_chambers(const Scenario& scenario, const std::string& joint) {
  return std::ranges::any_of(scenario.actuators, [&](const ActuatorSpec& a) {
    const int type = find_actuator(a.model);
    return a.joint == joint && type >= 0 && actuator_table()[type].chambers;
  });
}

PressureTrack resampled(PressureTrack pressures, const std::vector<double>& time, const std::vector<double>& at) {
  for (auto& joint : pressures)
    for (std::vector<double>& pressure : joint)
      if (!pressure.empty()) pressure = resampled(time, pressure, at);
  return pressures;
}

Experiment make_experiment(const Scenario& scenario) {
  refuse_unusable(scenario);
  Experiment out;
  out.prediction = scenario.prediction;
  out.channels = make_channels(scenario);
  for (const Joint& joint : scenario.robot->joints()) out.joint_names.push_back(joint.name);
  if (out.channels.empty()) {
    throw InputError(scenario.file.string() + ": channels", "no measured channel", "a position of at least one joint");
  }
  std::vector<Cut> cuts;
  const std::map<std::string, double> session = session_offsets(scenario);
  for (const RecordingSpec& spec : scenario.recordings) {
    cuts.push_back(cut(scenario, spec, session.at(spec.file)));
    if (scenario.pressure_driven) drive_by_pressures(scenario, spec, cuts.back());
  }
  if (cuts.empty()) throw InputError(scenario.file.string() + ": recordings", "none", "at least one");
  const std::vector<double>& clock = cuts.front().track->time;
  out.sample_period = scenario.sample_period.value_or(inverse(scenario) ? even_times(clock)[1] : median_spacing(clock));
  estimate_noise(out.channels, cuts);
  if (scenario.pressure_driven)
    for (int j = 0; j < scenario.robot->dof(); ++j)
      out.pressure_noise.push_back({transducer_noise(scenario, cuts, ChannelKind::pressure_a, j),
                                    transducer_noise(scenario, cuts, ChannelKind::pressure_b, j)});
  for (std::size_t r = 0; r < cuts.size(); ++r) add_segments(scenario, static_cast<int>(r), cuts, out);
  filter_noise(scenario, out);
  measure_sizes(scenario, cuts, out);
  for (const Cut& piece : cuts) out.span = std::max(out.span, piece.session + piece.track->time.back());
  add_events(scenario, out);
  return out;
}

}  // namespace lacuna
