#include "trial/imperfections.h"

#include <algorithm>
#include <numbers>

#include "ga/random.h"
#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr double kSlowest = 20.0, kFastest = 2.0;  // s, periods of a slow push
constexpr int kSines = 3;

/// Uses of random draws, other than the true machine's.
enum ImperfectionDraws : std::uint32_t { kRipple = 51, kPush = 52, kMisplaced = 53 };

/// The recording with these columns as they are in its first row.
std::shared_ptr<const Recording> held(const Recording& data, const std::vector<std::string>& columns) {
  auto out = std::make_shared<Recording>(data);
  for (const std::string& name : columns) {
    std::vector<double>& column = out->columns[data.find(name)];
    std::fill(column.begin(), column.end(), column.front());
  }
  return out;
}

/// The columns that command any joint but this one.
std::vector<std::string> other_commands(const Scenario& scenario, const std::string& joint) {
  std::vector<std::string> out, known;
  for (const auto& [name, column] : scenario.channels.of.at(ChannelKind::command)) {
    known.push_back(name);
    if (name != joint) out.push_back(column.column);
  }
  if (out.size() == known.size()) throw InputError("--alone", quoted(joint), "a commanded joint: " + one_of(known));
  return out;
}

}  // namespace

Scenario shortened(const Scenario& scenario, const Imperfections& imperfections) {
  Scenario out = scenario;
  std::vector<std::string> still;
  if (!imperfections.alone.empty()) still = other_commands(scenario, imperfections.alone);
  for (RecordingSpec& spec : out.recordings) {
    if (!still.empty()) spec.data = held(*spec.data, still);
    if (!std::isfinite(imperfections.seconds)) continue;
    const auto& time = spec.data->columns[spec.data->find(scenario.channels.time)];
    const double end = spec.from.value_or(time.front()) + imperfections.seconds;
    if (end < time.back()) spec.to = std::min(spec.to.value_or(HUGE_VAL), end);
  }
  return out;
}

UnevenLaw drawn_unevenness(double share, int joint, Stage stage, const Travel& travel, RandomStream stream) {
  UnevenLaw out;
  out.over_command = stage <= Stage::flow;
  const Travel::Range& range = (out.over_command ? travel.command : travel.position)[joint];
  if (!(range.width() > 0.0)) return out;
  out.share = share;
  out.centre = range.at(stream.uniform());
  out.width = range.width() / stream.uniform(0.5, 1.5);
  return out;
}

std::vector<EffectSpec> misplaced_centres(double most, const PlantModel& plain, std::span<const HiddenEffect> hidden,
                                          std::uint64_t seed) {
  std::vector<EffectSpec> out;
  for (int j = 0; j < plain.dof(); ++j) {
    const std::string& joint = plain.robot().joints()[j].name;
    const bool taken =
        plain.find_effect_at("com_shift", joint) >= 0 || std::ranges::any_of(hidden, [&](const HiddenEffect& effect) {
          return effect.effect == "com_shift" && effect.place == joint;
        });
    if (taken) continue;
    RandomStream stream(seed, 0, static_cast<std::uint32_t>(j), kMisplaced);
    EffectSpec shift{"com_shift", joint, {}, {}, "--misplaced"};
    for (const char* axis : {"dx", "dy", "dz"}) shift.parameters[axis] = stream.uniform(-most, most);
    out.push_back(std::move(shift));
  }
  return out;
}

Background::Background(std::span<const double> sizes, const Travel& travel, std::uint64_t seed) : seed_(seed) {
  for (std::size_t j = 0; j < sizes.size(); ++j) {
    RandomStream stream(seed, 0, static_cast<std::uint32_t>(j), kRipple);
    OutsidePhysics ripple{OutsidePhysics::Kind::position_ripple, static_cast<int>(j), std::sqrt(2.0) * sizes[j]};
    const Travel::Range& range = travel.position[j];
    const double width = range.width() * std::exp(stream.uniform(std::log(1.0 / 12.0), std::log(1.0 / 3.0)));
    if (width > 0.0) ripple.form.width = width;
    ripple.form.centre = -stream.uniform() * ripple.form.width;
    ripples_.push_back(std::move(ripple));
    pushes_.push_back(sizes[j]);
  }
}

void Background::scale(std::size_t joint, double factor) {
  ripples_[joint].strength *= factor;
  pushes_[joint] *= factor;
}

Background Background::only(std::size_t joint) const {
  Background out = *this;
  for (std::size_t j = 0; j < joints(); ++j)
    if (j != joint) out.scale(j, 0.0);
  return out;
}

Background Background::times(double factor) const {
  Background out = *this;
  for (std::size_t j = 0; j < joints(); ++j) out.scale(j, factor);
  return out;
}

double Background::push(std::size_t joint, int recording, double t) const {
  RandomStream stream(seed_, static_cast<std::uint32_t>(recording), static_cast<std::uint32_t>(joint), kPush);
  double out = 0.0;
  for (int k = 0; k < kSines; ++k) {
    const double period = std::exp(stream.uniform(std::log(kFastest), std::log(kSlowest)));
    out += std::sin(2.0 * std::numbers::pi * (t / period + stream.uniform()));
  }
  return out * std::sqrt(2.0 / kSines);
}

void Background::act(Segment& segment, std::vector<OutsidePhysics>& outside) const {
  outside.insert(outside.end(), ripples_.begin(), ripples_.end());
  std::vector<std::vector<double>> sum =
      segment.pushes ? *segment.pushes
                     : std::vector<std::vector<double>>(joints(), std::vector<double>(segment.count - 1, 0.0));
  for (std::size_t j = 0; j < joints(); ++j) {
    for (std::size_t k = 0; k < sum[j].size(); ++k)
      sum[j][k] += pushes_[j] * push(j, segment.recording, 0.5 * (segment.time(k) + segment.time(k + 1)));
  }
  segment.pushes = std::make_shared<const std::vector<std::vector<double>>>(std::move(sum));
}

}  // namespace lacuna
