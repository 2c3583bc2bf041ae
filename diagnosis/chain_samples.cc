#include "diagnosis/chain_samples.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/locate.h"
#include "ga/random.h"

namespace lacuna {
namespace {

constexpr std::uint32_t kChainDraws = 72;  // of random draws
constexpr double kSettles = 0.5;           // s, within which oil comes to rest behind a valve that has closed
constexpr double kCommanded = 0.01;        // of a joint's largest command: what opens its valve

bool has_column(const Scenario& scenario, ChannelKind kind, const std::string& joint) {
  const auto of = scenario.channels.of.find(kind);
  return of != scenario.channels.of.end() && of->second.contains(joint);
}

void take_together(JointSamples& samples) {
  for (auto* of : {&samples.mismatch, &samples.signal}) {
    std::vector<double>& alone = (*of)[index_of(ChainPart::command_to_flow)];
    std::vector<double>& together = (*of)[index_of(ChainPart::supply)];
    alone.insert(alone.end(), together.begin(), together.end());
    together.clear();
  }
}

}  // namespace

void JointSamples::append(const JointSamples& from) {
  for (std::size_t part = 0; part < kParts.size(); ++part) {
    mismatch[part].insert(mismatch[part].end(), from.mismatch[part].begin(), from.mismatch[part].end());
    signal[part].insert(signal[part].end(), from.signal[part].begin(), from.signal[part].end());
  }
}

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

CommandedParts::CommandedParts(const Experiment& experiment) : largest_(experiment.joint_names.size(), 0.0) {
  for (const Segment& s : experiment.segments)
    for (std::size_t j = 0; j < largest_.size(); ++j)
      for (const double u : s.commands->value[j]) largest_[j] = std::max(largest_[j], std::fabs(u));
}

ChainPart CommandedParts::at(const Segment& segment, std::size_t joint, std::size_t sample) const {
  if (!lately(segment, joint, sample)) return ChainPart::flow_to_pressure;
  for (std::size_t j = 0; j < largest_.size(); ++j)
    if (j != joint && lately(segment, j, sample)) return ChainPart::supply;
  return ChainPart::command_to_flow;
}

bool CommandedParts::lately(const Segment& segment, std::size_t joint, std::size_t sample) const {
  const std::vector<double>& time = segment.commands->time;
  const std::size_t now = segment.first + sample;
  for (std::size_t k = now + 1; k-- > 0 && time[k] >= time[now] - kSettles;)
    if (std::fabs(segment.commands->value[joint][k]) > kCommanded * largest_[joint]) return true;
  return false;
}

std::string take_together_where_needed(const std::vector<JointSamples*>& samples) {
  if (samples.front()->mismatch[index_of(ChainPart::command_to_flow)].size() >= kFewestInPart) return {};
  for (JointSamples* each : samples) take_together(*each);
  return "the joint is hardly ever commanded alone: what others take is not told from its own valve";
}

std::vector<int> not_fitted(const Experiment& experiment) {
  std::vector<int> out;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s)
    if (experiment.segments[s].role != Role::train) out.push_back(static_cast<int>(s));
  return out;
}

bool has_pressures(const Scenario& scenario, const std::string& joint) {
  return has_column(scenario, ChannelKind::pressure_a, joint) && has_column(scenario, ChannelKind::pressure_b, joint);
}

Scenario motions_of(const Scenario& scenario) {
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

RawMotion with_noise(RawMotion motion, std::uint64_t seed, int segment) {
  for (std::size_t j = 0; j < motion.position.size(); ++j) {
    const double level = j < motion.position_noise.size() ? motion.position_noise[j] : 0.0;
    if (!(level > 0.0)) continue;
    RandomStream random(seed, static_cast<std::uint32_t>(segment), static_cast<std::uint32_t>(j), kChainDraws);
    for (double& q : motion.position[j]) q += level * random.normal();
  }
  return motion;
}

bool can_filter(double rate) { return kLocateCutoff < 0.25 * rate; }

}  // namespace lacuna
