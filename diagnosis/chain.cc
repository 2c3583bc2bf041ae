#include "diagnosis/chain.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/chain_samples.h"
#include "diagnosis/evidence.h"
#include "diagnosis/locate.h"
#include "diagnosis/regions.h"
#include "ga/fit_context.h"

namespace lacuna {
namespace {

constexpr double kLeastRatio = 1.5;  // of what is expected: what is worth saying

void put(PartFit& part, const JointLook& look) {
  const std::size_t k = index_of(part.part);
  const std::vector<double>&before = look.before.mismatch[k], &after = look.after.mismatch[k];
  part.why_not = look.why_not[k];
  part.samples = static_cast<double>(before.size());
  if (before.size() < kFewestInPart || after.size() != before.size()) return;
  part.signal = rms_of(look.before.signal[k]), part.noise = look.noise[k];
  part.before = rms_of(before), part.after = rms_of(after);
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
  const PartFit& alone = chain.parts[index_of(ChainPart::command_to_flow)];
  PartFit& supply = chain.parts[index_of(ChainPart::supply)];
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
      const double reference = chain.parts[index_of(ChainPart::command_to_flow)].samples;
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

JointChain begun(const Scenario& scenario, const Joint& joint) {
  JointChain out{joint.name, has_chambers(scenario, joint.name), {}};
  for (const ChainPart part : kParts) {
    const bool effort = part == ChainPart::pressure_to_motion;
    out.parts[index_of(part)].part = part;
    out.parts[index_of(part)].unit = effort ? (joint.prismatic() ? "N" : "N m") : (joint.prismatic() ? "m/s" : "rad/s");
  }
  return out;
}

/// What is missing to a judgement of parts that were not.
void say_why_not(JointChain& chain) {
  for (PartFit& part : chain.parts)
    if (part.why_not.empty() && !(part.noise > 0.0))
      part.why_not = part.samples < static_cast<double>(kFewestInPart) ? too_few(part.part) : "its noise is not known";
}

bool beyond(double p, double rms, double expected) { return p < kLocateError && rms > kLeastRatio * expected; }

}  // namespace

const char* to_string(ChainPart part) {
  static constexpr const char* kNames[] = {"command_to_flow", "supply", "flow_to_pressure", "pressure_to_motion"};
  return kNames[index_of(part)];
}

bool PartFit::fails() const { return why_not.empty() && beyond(p_before, before, expected_before); }
bool PartFit::still_fails() const { return why_not.empty() && beyond(p_after, after, expected_after); }

std::vector<JointChain> joint_chains(const CurrentModel& before, const CurrentModel& after, const Scenario& scenario,
                                     const FitContext& context, std::uint64_t seed) {
  std::vector<JointChain> out;
  if (std::holds_alternative<InverseDynamics>(scenario.prediction) || scenario.pressure_driven) return out;
  const std::vector<int> positions = position_channels(context.experiment);
  std::vector<int> indices, without_areas;
  for (std::size_t j = 0; j < positions.size(); ++j) {
    const Joint& joint = scenario.robot->joints()[j];
    if (positions[j] < 0 || !has_pressures(scenario, joint.name)) continue;
    out.push_back(begun(scenario, joint));
    indices.push_back(static_cast<int>(j));
    if (!out.back().areas_given) without_areas.push_back(indices.back());
  }
  if (out.empty() || not_fitted(context.experiment).empty()) return {};
  std::vector<JointLook> chambers, flows;
  if (without_areas.size() < out.size()) chambers = chamber_looks(before, after, scenario, context.simulator, seed);
  if (!without_areas.empty()) flows = flow_looks(before, after, scenario, context, seed, without_areas);
  for (std::size_t k = 0; k < out.size(); ++k) {
    const std::vector<JointLook>& looks = out[k].areas_given ? chambers : flows;
    for (PartFit& part : out[k].parts) {
      if (looks.empty())
        part.why_not = kCannotInvert;
      else
        put(part, looks[indices[k]]);
    }
    say_why_not(out[k]);
  }
  judge(out);
  return out;
}

}  // namespace lacuna
