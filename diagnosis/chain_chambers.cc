#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/baseline.h"
#include "diagnosis/candidates.h"
#include "diagnosis/chain_samples.h"
#include "diagnosis/locate.h"
#include "ga/random.h"
#include "physics/chamber_balance.h"
#include "physics/filter.h"

namespace lacuna {
namespace {

constexpr std::uint32_t kPressureDraws = 73;  // of random draws

bool all_finite(const std::vector<double>& x) {
  return std::ranges::all_of(x, [](double each) { return std::isfinite(each); });
}
bool is_pressure(const Channel& channel) {
  return channel.kind == ChannelKind::pressure_a || channel.kind == ChannelKind::pressure_b;
}

/// A motion with the chambers' pressures beside it.
struct Course {
  RawMotion motion;
  PressureTrack pressures;  ///< on the times of inverse dynamics

  std::vector<double>& pressure(const Channel& channel) {
    return pressures[channel.joint][channel.kind == ChannelKind::pressure_b];
  }
};

class Chambers {
 public:
  Chambers(const Scenario& scenario, const SimulatorOptions& options) : options_(options) {
    Scenario whole = motions_of(scenario);
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
    for (JointSamples& each : out) take_off_mean(each.signal[index_of(ChainPart::pressure_to_motion)]);
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
  const Segment& given(std::size_t i) const { return given_.segments[segments_[i]]; }

  /// Whether every pressure is there at every instant.
  bool complete() const {
    for (std::size_t c = 0; c < free_run_.channels.size(); ++c) {
      if (!is_pressure(free_run_.channels[c])) continue;
      for (const Segment& s : free_run_.segments)
        if (!all_finite(s.measured[c])) return false;
    }
    return true;
  }

  Course measured(std::size_t i) const { return {*given(i).raw, *pressed_.segments[segments_[i]].pressures}; }
  /// By the model, where it can be.
  std::vector<std::optional<Course>> simulated(const CurrentModel& model) const {
    std::vector<std::optional<Course>> out(segments_.size());
    const std::vector<std::vector<double>> one{model.space.expand(model.fit.point)};
    make_simulator(model.model, free_run_, options_)->run(one, segments_, [&](int, int s, const auto& predicted) {
      const std::size_t i = std::ranges::find(segments_, s) - segments_.begin();
      Course course = measured(i);
      for (std::size_t c = 0; c < predicted.size(); ++c) {
        const Channel& channel = free_run_.channels[c];
        if (!all_finite(predicted[c])) return;
        if (is_pressure(channel)) {
          PressureTrack track(1);
          track[0][0] = predicted[c];
          const std::vector<double>& time = free_run_.segments[s].commands->time;
          course.pressure(channel) = resampled(track, time, given(i).motion->time)[0][0];
        } else {
          course.motion.position[channel.joint] = predicted[c];
        }
      }
      out[i] = std::move(course);
    });
    return out;
  }
  Course noisy_course(std::size_t i, std::uint64_t seed) const {
    Course out = measured(i);
    out.motion = with_noise(std::move(out.motion), seed, segments_[i]);
    const std::vector<double> levels = noise_levels(free_run_);
    for (std::size_t c = 0; c < levels.size(); ++c) {
      if (!is_pressure(free_run_.channels[c]) || !(levels[c] > 0.0)) continue;
      RandomStream random(seed, static_cast<std::uint32_t>(segments_[i]), static_cast<std::uint32_t>(c),
                          kPressureDraws);
      for (double& p : out.pressure(free_run_.channels[c])) p += levels[c] * random.normal();
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
    for (const std::size_t k : segment.compared) {
      std::array<double, 2> flow;
      for (const std::size_t which : {0u, 1u})
        flow[which] = seen.flow[which][k] - (left != nullptr ? left->flow[which][k] : 0.0);
      out.mismatch[index_of(ChainPart::pressure_to_motion)].push_back(seen.excess[k] -
                                                                      (left != nullptr ? left->excess[k] : 0.0));
      out.signal[index_of(ChainPart::pressure_to_motion)].push_back(seen.effort[k]);
      const ChainPart part = commands_->at(segment, j, k);
      if (part != ChainPart::flow_to_pressure) {
        out.mismatch[index_of(part)].push_back(0.5 * (flow[0] + flow[1]));
        out.signal[index_of(part)].push_back(segment.motion->v[j][k]);
        continue;
      }
      for (const std::size_t which : {0u, 1u}) {
        out.mismatch[index_of(part)].push_back(flow[which]);
        out.signal[index_of(part)].push_back(seen.compression[which][k]);
      }
    }
  }

  SimulatorOptions options_;
  Experiment free_run_, given_, pressed_;
  std::vector<int> segments_;
  std::optional<CommandedParts> commands_;  // of `given_`, once that is there
};

}  // namespace

std::vector<JointLook> chamber_looks(const CurrentModel& before, const CurrentModel& after, const Scenario& scenario,
                                     const SimulatorOptions& options, std::uint64_t seed) {
  const Chambers chambers(scenario, options);
  if (!chambers.any()) return {};
  std::vector<JointSamples> plain = chambers.mismatch(before), found = chambers.mismatch(after);
  std::vector<JointSamples> noise = chambers.noise(before, seed);
  std::vector<JointLook> out(plain.size());
  for (std::size_t j = 0; j < out.size(); ++j) {
    out[j].why_not[index_of(ChainPart::supply)] = take_together_where_needed({&plain[j], &found[j], &noise[j]});
    for (std::size_t part = 0; part < kParts.size(); ++part) out[j].noise[part] = rms_of(noise[j].mismatch[part]);
    out[j].before = std::move(plain[j]), out[j].after = std::move(found[j]);
  }
  return out;
}

}  // namespace lacuna
