#include "diagnosis/chain.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "diagnosis/baseline.h"
#include "diagnosis/evidence.h"
#include "diagnosis/locate.h"
#include "diagnosis/regions.h"
#include "ga/random.h"
#include "physics/chamber_balance.h"
#include "physics/filter.h"

namespace lacuna {
namespace {

constexpr std::uint32_t kChainDraws = 72;  // of random draws
constexpr double kSettles = 0.5;           // s, within which oil comes to rest behind a valve that has closed
constexpr double kCommanded = 0.01;        // of a joint's largest command: what opens its valve
constexpr double kLeastRatio = 1.5;        // of what is expected: what is worth saying
constexpr std::size_t kFewest = 10;        // samples that judge a part
constexpr std::size_t kPartCount = kParts.size();

std::size_t at(ChainPart part) { return static_cast<std::size_t>(part); }

/// Samples of one joint, part by part.
struct JointSamples {
  std::array<std::vector<double>, kPartCount> mismatch, signal;
};

double rms_of(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double each : x) sum += each * each;
  return x.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(x.size()));
}
void take_off_mean(std::vector<double>& x) {
  double sum = 0.0;
  for (const double each : x) sum += each;
  for (double& each : x) each -= sum / static_cast<double>(std::max<std::size_t>(1, x.size()));
}

/// Which of the parts in front of the pressures a joint's commands let be judged at an instant.
class Commands {
 public:
  explicit Commands(const Experiment& experiment) : largest_(experiment.joint_names.size(), 0.0) {
    for (const Segment& s : experiment.segments)
      for (std::size_t j = 0; j < largest_.size(); ++j)
        for (const double u : s.commands->value[j]) largest_[j] = std::max(largest_[j], std::fabs(u));
  }
  ChainPart part_at(const Segment& segment, std::size_t joint, std::size_t sample) const {
    if (!lately(segment, joint, sample)) return ChainPart::flow_to_pressure;
    for (std::size_t j = 0; j < largest_.size(); ++j)
      if (j != joint && lately(segment, j, sample)) return ChainPart::supply;
    return ChainPart::command_to_flow;
  }

 private:
  bool lately(const Segment& segment, std::size_t joint, std::size_t sample) const {
    const std::vector<double>& time = segment.commands->time;
    const std::size_t now = segment.first + sample;
    for (std::size_t k = now + 1; k-- > 0 && time[k] >= time[now] - kSettles;)
      if (std::fabs(segment.commands->value[joint][k]) > kCommanded * largest_[joint]) return true;
    return false;
  }
  std::vector<double> largest_;
};

std::vector<int> not_fitted(const Experiment& experiment) {
  std::vector<int> out;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s)
    if (experiment.segments[s].role != Role::train) out.push_back(static_cast<int>(s));
  return out;
}

bool has_column(const Scenario& scenario, ChannelKind kind, const std::string& joint) {
  const auto of = scenario.channels.of.find(kind);
  return of != scenario.channels.of.end() && of->second.contains(joint);
}
bool has_pressures(const Scenario& scenario, const std::string& joint) {
  return has_column(scenario, ChannelKind::pressure_a, joint) && has_column(scenario, ChannelKind::pressure_b, joint);
}

/// Scenario of the motions alone: as a whole, without events; of what is measured positions and pressures.
Scenario bare(const Scenario& scenario) {
  Scenario out = scenario;
  for (const ChannelKind kind : {ChannelKind::velocity, ChannelKind::effort, ChannelKind::motor_position})
    out.channels.of.erase(kind);
  for (const Joint& joint : scenario.robot->joints())  // one pressure alone tells nothing
    if (!has_pressures(scenario, joint.name))
      for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b})
        if (has_column(scenario, kind, joint.name)) out.channels.of.at(kind).erase(joint.name);
  out.events.clear();
  out.prediction = FreeRun{};
  out.pressure_driven = false;
  return out;
}

/// Whether kLocateCutoff lies far enough below what the samples can show.
bool can_filter(double rate) { return kLocateCutoff < 0.25 * rate; }

/// A motion with the chambers' pressures beside it.
struct Course {
  RawMotion motion;
  PressureTrack pressures;  ///< on the times of inverse dynamics
};

/// Joints with chambers: all parts from pressures and motion, nothing simulated but what the filter leaves.
class Chambers {
 public:
  Chambers(const Scenario& scenario, const SimulatorOptions& options) : options_(options) {
    Scenario whole = bare(scenario);
    free_run_ = make_experiment(whole);
    if (!can_invert(free_run_) || !complete()) return;
    whole.prediction = InverseDynamics{kLocateCutoff};
    given_ = make_experiment(whole);
    whole.pressure_driven = true;
    pressed_ = make_experiment(whole);
    segments_ = not_fitted(given_);
    commands_.emplace(given_);
  }
  bool any() const { return !segments_.empty(); }

  std::vector<JointSamples> mismatch(const CurrentModel& model) const {
    const std::vector<std::optional<Course>> own = simulated(model);
    std::vector<JointSamples> out(joints());
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const std::vector<ChamberBalance> seen = balances(model, i, measured(i));
      std::vector<ChamberBalance> left;
      if (own[i]) left = balances(model, i, *own[i]);
      for (std::size_t j = 0; j < out.size(); ++j)
        if (!seen[j].effort.empty()) add(i, j, seen[j], left.empty() ? nullptr : &left[j], out[j]);
    }
    for (JointSamples& each : out) take_off_mean(each.signal[at(ChainPart::pressure_to_motion)]);
    return out;
  }
  /// What the noise of positions and pressures makes of it.
  std::vector<JointSamples> noise(const CurrentModel& model, std::uint64_t seed) const {
    std::vector<JointSamples> out(joints());
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const std::vector<ChamberBalance> quiet = balances(model, i, measured(i));
      const std::vector<ChamberBalance> noisy = balances(model, i, noisy_course(i, seed));
      for (std::size_t j = 0; j < out.size(); ++j)
        if (!quiet[j].effort.empty()) add(i, j, noisy[j], &quiet[j], out[j]);
    }
    return out;
  }

 private:
  std::size_t joints() const { return free_run_.joint_names.size(); }
  const Segment& given(std::size_t i) const { return given_.segments[static_cast<std::size_t>(segments_[i])]; }

  /// Whether every pressure is there at every instant.
  bool complete() const {
    for (std::size_t c = 0; c < free_run_.channels.size(); ++c) {
      const ChannelKind kind = free_run_.channels[c].kind;
      if (kind != ChannelKind::pressure_a && kind != ChannelKind::pressure_b) continue;
      for (const Segment& s : free_run_.segments)
        if (!std::ranges::all_of(s.measured[c], [](double x) { return std::isfinite(x); })) return false;
    }
    return true;
  }

  Course measured(std::size_t i) const {
    return {*given(i).raw, *pressed_.segments[static_cast<std::size_t>(segments_[i])].pressures};
  }
  /// By the model, where it can be.
  std::vector<std::optional<Course>> simulated(const CurrentModel& model) const {
    std::vector<std::optional<Course>> out(segments_.size());
    const std::vector<std::vector<double>> one{model.space.expand(model.fit.point)};
    make_simulator(model.model, free_run_, options_)->run(one, segments_, [&](int, int s, const auto& predicted) {
      const auto i = static_cast<std::size_t>(std::ranges::find(segments_, s) - segments_.begin());
      Course course = measured(i);
      for (std::size_t c = 0; c < predicted.size(); ++c) {
        const Channel& channel = free_run_.channels[c];
        const auto j = static_cast<std::size_t>(channel.joint);
        if (!std::ranges::all_of(predicted[c], [](double x) { return std::isfinite(x); })) return;
        if (channel.kind == ChannelKind::position) {
          course.motion.position[j] = predicted[c];
        } else {
          PressureTrack one_signal(1);
          one_signal[0][0] = predicted[c];
          course.pressures[j][channel.kind == ChannelKind::pressure_b] = resampled(
              one_signal, free_run_.segments[static_cast<std::size_t>(s)].commands->time, given(i).motion->time)[0][0];
        }
      }
      out[i] = std::move(course);
    });
    return out;
  }
  Course noisy_course(std::size_t i, std::uint64_t seed) const {
    Course out = measured(i);
    const std::vector<double> levels = noise_levels(free_run_);
    for (std::size_t c = 0; c < levels.size(); ++c) {
      const Channel& channel = free_run_.channels[c];
      const auto j = static_cast<std::size_t>(channel.joint);
      if (!(levels[c] > 0.0)) continue;
      RandomStream random(seed, static_cast<std::uint32_t>(segments_[i]), static_cast<std::uint32_t>(c), kChainDraws);
      std::vector<double>& signal = channel.kind == ChannelKind::position
                                        ? out.motion.position[j]
                                        : out.pressures[j][channel.kind == ChannelKind::pressure_b];
      for (double& each : signal) each += levels[c] * random.normal();
    }
    return out;
  }

  std::vector<ChamberBalance> balances(const CurrentModel& model, std::size_t i, Course course) const {
    Segment segment = given(i);
    const ZeroPhaseLowPass filter(kLocateCutoff, segment.motion->rate);
    for (auto& joint : course.pressures)
      for (std::vector<double>& p : joint)
        if (!p.empty()) filter.apply(p);
    segment.pressures = std::make_shared<const PressureTrack>(std::move(course.pressures));
    set_motion(segment, std::move(course.motion), kLocateCutoff);
    std::vector<ChamberBalance> out =
        chamber_balances(model.model, options_.engine, model.space.expand(model.fit.point), segment);
    for (ChamberBalance& each : out)
      for (std::vector<double>* signal :
           {&each.flow[0], &each.flow[1], &each.compression[0], &each.compression[1], &each.effort, &each.excess})
        if (!signal->empty()) filter.apply(*signal);
    return out;
  }

  /// Joint j's samples of a segment, less `left` where there is one.
  void add(std::size_t i, std::size_t j, const ChamberBalance& seen, const ChamberBalance* left,
           JointSamples& out) const {
    const Segment& segment = given(i);
    const auto less = [&](const std::vector<double>& x, const std::vector<double> ChamberBalance::*of, std::size_t k) {
      return left != nullptr ? x[k] - (left->*of)[k] : x[k];
    };
    for (const std::size_t k : segment.compared) {
      std::array<double, 2> flow;
      for (const std::size_t which : {0u, 1u})
        flow[which] = seen.flow[which][k] - (left != nullptr ? left->flow[which][k] : 0.0);
      out.mismatch[at(ChainPart::pressure_to_motion)].push_back(less(seen.excess, &ChamberBalance::excess, k));
      out.signal[at(ChainPart::pressure_to_motion)].push_back(seen.effort[k]);
      const ChainPart part = commands_->part_at(segment, j, k);
      if (part != ChainPart::flow_to_pressure) {
        out.mismatch[at(part)].push_back(0.5 * (flow[0] + flow[1]));
        out.signal[at(part)].push_back(segment.motion->v[j][k]);
        continue;
      }
      for (const std::size_t which : {0u, 1u}) {
        out.mismatch[at(part)].push_back(flow[which]);
        out.signal[at(part)].push_back(seen.compression[which][k]);
      }
    }
  }

  SimulatorOptions options_;
  Experiment free_run_, given_, pressed_;
  std::vector<int> segments_;
  std::optional<Commands> commands_;  // of `given_`, once that is there
};

/// Joints whose actuators give a flow: measured speeds against simulated ones, in the predictions as they are.
class Speeds {
 public:
  Speeds(const Experiment& experiment, const SimulatorOptions& options)
      : experiment_(experiment), options_(options), segments_(not_fitted(experiment)), commands_(experiment) {}

  std::vector<JointSamples> mismatch(const CurrentModel& model) const {
    std::vector<std::vector<JointSamples>> parts(experiment_.segments.size());  // one a thread may write
    const std::vector<std::vector<double>> one{model.space.expand(model.fit.point)};
    make_simulator(model.model, experiment_, options_)->run(one, segments_, [&](int, int s, const auto& predicted) {
      const Segment& segment = experiment_.segments[static_cast<std::size_t>(s)];
      std::vector<JointSamples>& part = parts[static_cast<std::size_t>(s)];
      part.resize(experiment_.joint_names.size());
      for (std::size_t c = 0; c < predicted.size(); ++c)
        if (experiment_.channels[c].kind == ChannelKind::position)
          add(segment, c, predicted[c], part[static_cast<std::size_t>(experiment_.channels[c].joint)]);
    });
    std::vector<JointSamples> out(experiment_.joint_names.size());
    for (const auto& part : parts)
      for (std::size_t j = 0; j < part.size(); ++j)
        for (std::size_t l = 0; l < kPartCount; ++l) {
          out[j].mismatch[l].insert(out[j].mismatch[l].end(), part[j].mismatch[l].begin(), part[j].mismatch[l].end());
          out[j].signal[l].insert(out[j].signal[l].end(), part[j].signal[l].begin(), part[j].signal[l].end());
        }
    return out;
  }
  /// rad/s (m/s): what the noise of joint j's position makes of its speed.
  double noise(std::size_t joint) const {
    const std::vector<double> levels = noise_levels(experiment_);
    const int c = position_channels(experiment_)[joint];
    const double rate = 1.0 / experiment_.sample_period;
    if (!can_filter(rate)) return 0.0;
    return levels[static_cast<std::size_t>(c)] * rate * filter_gain(ZeroPhaseLowPass(kLocateCutoff, rate), 1).slope;
  }

 private:
  void add(const Segment& segment, std::size_t channel, const std::vector<double>& predicted, JointSamples& out) const {
    const std::vector<double>& seen = segment.measured[channel];
    if (segment.count < kFewest) return;
    const double rate = static_cast<double>(segment.count - 1) / (segment.time(segment.count - 1) - segment.time(0));
    if (!can_filter(rate)) return;
    const Thinning thinning(kLocateCutoff, rate);
    std::vector<double> error(seen), position(seen);
    for (std::size_t k = 0; k < seen.size(); ++k) error[k] -= predicted[k];
    if (seen.size() <= 2 * thinning.edge + 2 || !std::ranges::all_of(error, [](double x) { return std::isfinite(x); }))
      return;
    const ZeroPhaseLowPass filter(kLocateCutoff, rate);
    filter.apply(error), filter.apply(position);
    for (std::size_t k = thinning.edge; k + thinning.edge < seen.size(); k += thinning.stride) {
      const ChainPart part =
          commands_.part_at(segment, static_cast<std::size_t>(experiment_.channels[channel].joint), k);
      out.mismatch[at(part)].push_back(0.5 * rate * (error[k + 1] - error[k - 1]));
      out.signal[at(part)].push_back(0.5 * rate * (position[k + 1] - position[k - 1]));
    }
  }

  const Experiment& experiment_;
  SimulatorOptions options_;
  std::vector<int> segments_;
  Commands commands_;
};

/// Joints whose areas nobody gives: the effort that the motion needs, against both pressures, each times an area.
class FittedAreas {
 public:
  /// `joints`: of the robot, whose pressures stand in the place of measured efforts, one after the other.
  FittedAreas(const Scenario& scenario, const SimulatorOptions& options, const std::vector<std::string>& joints)
      : options_(options) {
    Scenario whole = bare(scenario);
    if (joints.empty() || !can_invert(make_experiment(whole))) return;
    whole.prediction = InverseDynamics{kLocateCutoff};
    for (const std::size_t which : {0u, 1u}) {
      const auto& columns = scenario.channels.of.at(which == 0 ? ChannelKind::pressure_a : ChannelKind::pressure_b);
      for (const std::string& joint : joints) whole.channels.of[ChannelKind::effort][joint] = columns.at(joint);
      experiments_.push_back(make_experiment(whole));
    }
  }
  bool any() const { return !experiments_.empty(); }

  /// Of joint j. What areas fitted to the train recordings leave of the others' efforts.
  JointSamples mismatch(const CurrentModel& model, int joint) const {
    JointSamples out;
    const std::optional<Fit> fit = fitted(model, joint);
    if (!fit) return out;
    const Eigen::VectorXd left = fit->rest.needed - fit->rest.columns * fit->areas;
    out.mismatch[at(ChainPart::pressure_to_motion)].assign(left.begin(), left.end());
    out.signal[at(ChainPart::pressure_to_motion)].assign(fit->rest.needed.begin(), fit->rest.needed.end());
    take_off_mean(out.signal[at(ChainPart::pressure_to_motion)]);
    return out;
  }
  /// N m (N): what the noise of positions and pressures makes of it.
  double noise(const CurrentModel& model, int joint, std::uint64_t seed) const {
    const std::optional<Fit> fit = fitted(model, joint);
    if (!fit) return 0.0;
    Experiment noisy = experiments_[0];
    for (std::size_t s = 0; s < noisy.segments.size(); ++s) {
      RawMotion raw = *noisy.segments[s].raw;
      for (std::size_t j = 0; j < raw.position.size(); ++j) {
        RandomStream random(seed, static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(j), kChainDraws);
        const double level = j < raw.position_noise.size() ? raw.position_noise[j] : 0.0;
        if (level > 0.0)
          for (double& q : raw.position[j]) q += level * random.normal();
      }
      set_motion(noisy.segments[s], std::move(raw), kLocateCutoff);
    }
    const std::size_t c = *channel_of(joint);
    const Eigen::VectorXd moved = table(model, noisy, c, is_rest).needed - fit->rest.needed;
    double squares = moved.squaredNorm() / static_cast<double>(moved.size());
    for (const std::size_t which : {0u, 1u})
      squares +=
          std::pow(fit->areas(static_cast<Eigen::Index>(which)) * kBar * noise_levels(experiments_[which])[c], 2);
    return std::sqrt(squares);
  }

 private:
  struct Table {
    Eigen::MatrixXd columns;  ///< pressures of A and B, bar; 1
    Eigen::VectorXd needed;   ///< N m (N)
  };
  struct Fit {
    Eigen::VectorXd areas;  ///< N m (N) per bar of A and of B; offset
    Table rest;             ///< of the recordings that were not fitted
  };
  static constexpr double kBar = 1e-5;  ///< bar/Pa
  static bool is_train(const Segment& s) { return s.role == Role::train; }
  static bool is_rest(const Segment& s) { return s.role != Role::train; }

  std::optional<Fit> fitted(const CurrentModel& model, int joint) const {
    const std::optional<std::size_t> c = channel_of(joint);
    if (!c) return std::nullopt;
    const Table train = table(model, experiments_[0], *c, is_train);
    Fit out{{}, table(model, experiments_[0], *c, is_rest)};
    if (train.needed.size() < 3 * static_cast<Eigen::Index>(kFewest) || out.rest.needed.size() == 0)
      return std::nullopt;
    out.areas = train.columns.colPivHouseholderQr().solve(train.needed);
    return out;
  }
  std::optional<std::size_t> channel_of(int joint) const {
    const std::vector<Channel>& channels = experiments_.front().channels;
    for (std::size_t c = 0; c < channels.size(); ++c)
      if (channels[c].kind == ChannelKind::effort && channels[c].joint == joint) return c;
    return std::nullopt;
  }
  /// Pressures as measured, efforts as the motions of `a` need them.
  Table table(const CurrentModel& model, const Experiment& a, std::size_t c, bool (*uses)(const Segment&)) const {
    std::vector<int> segments;
    for (std::size_t s = 0; s < a.segments.size(); ++s)
      if (uses(a.segments[s])) segments.push_back(static_cast<int>(s));
    std::map<int, std::vector<double>> needed;
    for (const int s : segments) needed[s] = {};
    const std::vector<std::vector<double>> one{model.space.expand(model.fit.point)};
    make_simulator(model.model, a, options_)->run(one, segments, [&](int, int s, const auto& predicted) {
      needed.at(s) = predicted[c];
    });
    std::vector<std::array<double, 3>> rows;
    for (const auto& [s, efforts] : needed)
      for (std::size_t k = 0; k < efforts.size(); ++k) {
        const auto pressure = [&](std::size_t which) {
          return kBar * experiments_[which].segments[static_cast<std::size_t>(s)].measured[c][k];
        };
        const std::array<double, 3> row{pressure(0), pressure(1), efforts[k]};
        if (std::ranges::all_of(row, [](double x) { return std::isfinite(x); })) rows.push_back(row);
      }
    Table out{Eigen::MatrixXd(static_cast<Eigen::Index>(rows.size()), 3),
              Eigen::VectorXd(static_cast<Eigen::Index>(rows.size()))};
    for (Eigen::Index k = 0; k < out.needed.size(); ++k) {
      const auto& row = rows[static_cast<std::size_t>(k)];
      out.columns.row(k) << row[0], row[1], 1.0;
      out.needed(k) = row[2];
    }
    return out;
  }

  SimulatorOptions options_;
  std::vector<Experiment> experiments_;  ///< with the pressures of A and of B as measured efforts
};

void put(PartFit& part, const JointSamples& before, const JointSamples& after, double noise) {
  const std::size_t l = at(part.part);
  part.samples = static_cast<double>(before.mismatch[l].size());
  if (before.mismatch[l].size() < kFewest || after.mismatch[l].size() != before.mismatch[l].size()) return;
  part.signal = rms_of(before.signal[l]), part.noise = noise;
  part.before = rms_of(before.mismatch[l]), part.after = rms_of(after.mismatch[l]);
}

std::string too_few(ChainPart part) {
  if (part == ChainPart::supply) return "other joints are hardly ever commanded with it";
  if (part == ChainPart::command_to_flow) return "it is hardly ever commanded alone";
  if (part == ChainPart::flow_to_pressure) return "its valve is hardly ever closed";
  return "too few samples";
}

bool is_judged(const PartFit& part) { return part.why_not.empty() && part.noise > 0.0; }

/// What a right part would leave, and how many samples say so.
void expect(JointChain& chain) {
  for (PartFit& part : chain.parts) part.expected_before = part.expected_after = part.noise;
  const PartFit& alone = chain.parts[at(ChainPart::command_to_flow)];
  PartFit& supply = chain.parts[at(ChainPart::supply)];
  if (!is_judged(alone) || !is_judged(supply) || !(alone.signal > 0.0)) return;
  const double faster = supply.signal / alone.signal;
  supply.expected_before = std::max(supply.noise, faster * alone.before);
  supply.expected_after = std::max(supply.noise, faster * alone.after);
}

/// p-values, corrected for all parts of all joints.
void judge(std::vector<JointChain>& chains) {
  double tests = 0.0;
  for (JointChain& chain : chains) {
    expect(chain);
    for (const PartFit& part : chain.parts) tests += is_judged(part);
  }
  for (JointChain& chain : chains) {
    for (PartFit& part : chain.parts) {
      if (!is_judged(part)) continue;
      const double reference = chain.parts[at(ChainPart::command_to_flow)].samples;
      // Of two estimated energies the ratio scatters as that of one with the harmonic number of samples.
      const auto samples = [&](double expected) {
        return expected > part.noise ? part.samples * reference / (part.samples + reference) : part.samples;
      };
      const auto p_of = [&](double rms, double expected) {
        return std::min(1.0, tests * chance_of_energy(std::pow(rms / expected, 2), samples(expected)));
      };
      part.p_before = p_of(part.before, part.expected_before);
      part.p_after = p_of(part.after, part.expected_after);
    }
  }
}

/// Of a joint that hardly ever moves alone all that its open valve lets through judges the valve.
void take_together(JointSamples& samples) {
  for (auto* of : {&samples.mismatch, &samples.signal}) {
    std::vector<double>& alone = (*of)[at(ChainPart::command_to_flow)];
    std::vector<double>& together = (*of)[at(ChainPart::supply)];
    alone.insert(alone.end(), together.begin(), together.end());
    together.clear();
  }
}
/// Does that to all `samples` of a joint where the first of them needs it.
void take_together_where_needed(PartFit& supply, std::initializer_list<JointSamples*> samples) {
  if ((*samples.begin())->mismatch[at(ChainPart::command_to_flow)].size() >= kFewest) return;
  for (JointSamples* each : samples) take_together(*each);
  supply.why_not = "the joint is hardly ever commanded alone: what others take is not told from its own valve";
}

JointChain begun(const Scenario& scenario, const Joint& joint) {
  JointChain out{joint.name, has_chambers(scenario, joint.name), {}};
  for (const ChainPart part : kParts) {
    const bool effort = part == ChainPart::pressure_to_motion;
    out.parts[at(part)].part = part;
    out.parts[at(part)].unit = effort ? (joint.prismatic() ? "N" : "N m") : (joint.prismatic() ? "m/s" : "rad/s");
  }
  return out;
}

/// What is missing to a judgement of parts that were not.
void say_why_not(JointChain& chain) {
  for (PartFit& part : chain.parts)
    if (part.why_not.empty() && !(part.noise > 0.0))
      part.why_not = part.samples < static_cast<double>(kFewest) ? too_few(part.part) : "its noise is not known";
}

constexpr const char* kCannotInvert =
    "the effort that the motion needs is not known: a joint's position or pressure is not measured throughout";

/// Joints with chambers, `indices` in the robot.
void put_chambers(std::vector<JointChain>& chains, const std::vector<int>& indices, const CurrentModel& before,
                  const CurrentModel& after, const Chambers& chambers, std::uint64_t seed) {
  if (!chambers.any()) {
    for (JointChain& chain : chains)
      if (chain.areas_given)
        for (PartFit& part : chain.parts) part.why_not = kCannotInvert;
    return;
  }
  std::vector<JointSamples> plain = chambers.mismatch(before), found = chambers.mismatch(after);
  std::vector<JointSamples> noise = chambers.noise(before, seed);
  for (std::size_t k = 0; k < chains.size(); ++k) {
    if (!chains[k].areas_given) continue;
    const auto j = static_cast<std::size_t>(indices[k]);
    take_together_where_needed(chains[k].parts[at(ChainPart::supply)], {&plain[j], &found[j], &noise[j]});
    for (PartFit& part : chains[k].parts) put(part, plain[j], found[j], rms_of(noise[j].mismatch[at(part.part)]));
  }
}

/// Joints whose actuators have no areas.
void put_flows(std::vector<JointChain>& chains, const std::vector<int>& indices, const CurrentModel& before,
               const CurrentModel& after, const Speeds& speeds, const FittedAreas& areas, std::uint64_t seed) {
  std::vector<JointSamples> plain = speeds.mismatch(before), found = speeds.mismatch(after);
  for (std::size_t k = 0; k < chains.size(); ++k) {
    JointChain& chain = chains[k];
    if (chain.areas_given) continue;
    const auto j = static_cast<std::size_t>(indices[k]);
    take_together_where_needed(chain.parts[at(ChainPart::supply)], {&plain[j], &found[j]});
    for (const ChainPart part : {ChainPart::command_to_flow, ChainPart::supply})
      put(chain.parts[at(part)], plain[j], found[j], speeds.noise(j));
    chain.parts[at(ChainPart::flow_to_pressure)].why_not =
        "the actuator has no chambers: areas and volumes are not given";
    PartFit& last = chain.parts[at(ChainPart::pressure_to_motion)];
    if (!areas.any()) {
      last.why_not = kCannotInvert;
      continue;
    }
    const JointSamples left = areas.mismatch(before, indices[k]);
    put(last, left, areas.mismatch(after, indices[k]), areas.noise(before, indices[k], seed));
  }
}

bool beyond(double p, double rms, double expected) { return p < kLocateError && rms > kLeastRatio * expected; }

}  // namespace

const char* to_string(ChainPart part) {
  static constexpr const char* kNames[] = {"command_to_flow", "supply", "flow_to_pressure", "pressure_to_motion"};
  return kNames[at(part)];
}

bool PartFit::fails() const { return why_not.empty() && beyond(p_before, before, expected_before); }
bool PartFit::still_fails() const { return why_not.empty() && beyond(p_after, after, expected_after); }

std::vector<JointChain> joint_chains(const CurrentModel& before, const CurrentModel& after, const Scenario& scenario,
                                     const Experiment& experiment, const SimulatorOptions& options,
                                     std::uint64_t seed) {
  std::vector<JointChain> out;
  if (std::holds_alternative<InverseDynamics>(scenario.prediction) || scenario.pressure_driven) return out;
  const std::vector<int> positions = position_channels(experiment);
  std::vector<int> indices;
  std::vector<std::string> without_areas;
  for (std::size_t j = 0; j < positions.size(); ++j) {
    const Joint& joint = scenario.robot->joints()[j];
    if (positions[j] < 0 || !has_pressures(scenario, joint.name)) continue;
    out.push_back(begun(scenario, joint));
    indices.push_back(static_cast<int>(j));
    if (!out.back().areas_given) without_areas.push_back(joint.name);
  }
  if (out.empty() || not_fitted(experiment).empty()) return {};
  if (without_areas.size() < out.size()) put_chambers(out, indices, before, after, Chambers(scenario, options), seed);
  if (!without_areas.empty())
    put_flows(out, indices, before, after, Speeds(experiment, options), FittedAreas(scenario, options, without_areas),
              seed);
  std::ranges::for_each(out, say_why_not);
  judge(out);
  return out;
}

}  // namespace lacuna
