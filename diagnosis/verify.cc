#include "diagnosis/verify.h"

#include <algorithm>
#include <cmath>

#include "backends/engine.h"
#include "diagnosis/evidence.h"
#include "diagnosis/replay.h"

namespace lacuna {
namespace {

/// rms on the test recordings, and the energy that the findings take off there: what the errors of the starts can do
/// counts for neither model.
struct TestGain {
  EngineGain shown;
  double removed = 0.0;
};
TestGain gain_on(const std::string& engine, const CurrentModel& before, const CurrentModel& after, FitContext context) {
  TestGain gain;
  EngineGain& out = gain.shown;
  out.engine = engine;
  out.available = true;
  context.simulator.engine = engine;
  Problem a = problem_of(before, context);
  Problem b = problem_of(after, context, before.weights);
  out.before = residual_rms(a, before.space.expand(before.fit.point), Role::test);
  out.after = residual_rms(b, after.space.expand(after.fit.point), Role::test);
  const std::vector<int> test = context.experiment.with_role(Role::test);
  gain.removed = a.residual(before.fit.point, test).squaredNorm() - b.residual(after.fit.point, test).squaredNorm();
  return gain;
}

std::vector<Whiteness> whiteness(const CurrentModel& before, const CurrentModel& after, const FitContext& context) {
  const Experiment& experiment = context.experiment;
  const Role role = experiment.with_role(Role::test).empty() ? Role::validate : Role::test;
  const std::vector<int> segments = experiment.with_role(role);
  if (segments.empty()) return {};
  const std::vector<Channel>& channels = experiment.channels;
  Problem a = problem_of(before, context);
  Problem b = problem_of(after, context, before.weights);
  const auto first = autocorrelations(a.residual(before.fit.point, segments), a.layout(segments));
  const auto second = autocorrelations(b.residual(after.fit.point, segments), b.layout(segments));
  std::vector<Whiteness> out;
  for (const Autocorrelation& x : first) {
    const auto y = std::find_if(second.begin(), second.end(), [&](const auto& s) { return s.channel == x.channel; });
    if (y == second.end()) continue;
    const Channel& channel = channels[x.channel];
    out.push_back({experiment.joint_names[channel.joint], role, x.samples, x.by_lag, y->by_lag, x.p_value, y->p_value});
  }
  return out;
}

/// Joints whose test residual grew although the errors of the starts are taken off both.
std::vector<std::string> grown_besides_starts(const CurrentModel& before, const CurrentModel& after,
                                              const FitContext& context) {
  const std::vector<int> test = context.experiment.with_role(Role::test);
  Problem a = problem_of(before, context);
  Problem b = problem_of(after, context, before.weights);
  return joints_that_grew(rms_by_channel(a, a.residual(before.fit.point, test), test),
                          rms_by_channel(b, b.residual(after.fit.point, test), test), context.experiment.joint_names);
}

const JointRms& test_rms(const FitResult& fit) {
  static const JointRms kNone;
  for (const auto& [role, rms] : fit.rms) {
    if (role == Role::test) return rms;
  }
  return kNone;
}

}  // namespace

std::vector<std::string> joints_that_grew(const JointRms& before, const JointRms& after,
                                          const std::vector<std::string>& joints, double margin) {
  std::vector<std::string> out;
  for (const std::string& joint : joints) {
    const auto of_joint = [&](const std::string& entry) { return entry == joint || entry.rfind(joint + ".", 0) == 0; };
    const bool grew = std::any_of(after.begin(), after.end(), [&](const auto& now) {
      const auto was = std::find_if(before.begin(), before.end(), [&](const auto& b) { return b.first == now.first; });
      return of_joint(now.first) && was != before.end() && now.second > (1.0 + margin) * was->second;
    });
    if (grew) out.push_back(joint);
  }
  return out;
}

void verify(Diagnosis& out, const CurrentModel& before, const CurrentModel& after, const FitContext& context,
            bool other_engines) {
  const Experiment& experiment = context.experiment;
  std::vector<int> shown = experiment.with_role(Role::test);
  if (shown.empty()) shown = experiment.with_role(Role::validate);
  out.predictions = traces(before, after, context, shown);
  if (!out.predictions.empty()) out.traces = out.predictions.front();
  out.whiteness = whiteness(before, after, context);
  out.worse = joints_that_grew(test_rms(out.before), test_rms(out.after), experiment.joint_names);
  if (!out.worse.empty())
    for (const std::string& joint : grown_besides_starts(before, after, context))
      if (std::ranges::find(out.worse, joint) != out.worse.end()) out.worse_besides_starts.push_back(joint);
  if (experiment.with_role(Role::test).empty()) return;
  double own = 0.0;
  std::vector<std::string> names{context.simulator.engine};
  for (const Engine* engine : engines()) {
    if (other_engines && engine->info().name != context.simulator.engine) names.push_back(engine->info().name);
  }
  for (const std::string& name : names) {
    const EngineInfo info = find_engine(name).info();
    if (!info.available) {
      EngineGain missing;
      missing.engine = name;
      missing.reason = info.reason;
      out.engines.push_back(missing);
      continue;
    }
    TestGain gain = gain_on(name, before, after, context);
    if (name == context.simulator.engine) own = gain.removed;
    gain.shown.kept = own > 0.0 ? gain.removed / own : std::nan("");
    out.engines.push_back(std::move(gain.shown));
  }
}

}  // namespace lacuna
