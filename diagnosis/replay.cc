#include "diagnosis/replay.h"

#include <algorithm>

#include "diagnosis/evidence.h"
#include "diagnosis/locate.h"

namespace lacuna {
namespace {

/// Of the validate recordings, those in which something is said to act, most often named first.
std::vector<std::string> telling_recordings(const Diagnosis& found, std::size_t most) {
  std::vector<std::string> out;
  const auto add = [&](const std::string& file) {
    if (!file.empty() && std::find(out.begin(), out.end(), file) == out.end()) out.push_back(file);
  };
  for (const Finding& finding : found.findings)
    for (const Finding::Interval& interval : finding.times) add(interval.recording);
  for (const Misfit& misfit : found.unexplained.times) add(misfit.recording);
  if (out.size() > most) out.resize(most);
  return out;
}

double noise_of(const Diagnosis& found, const std::string& joint, std::string& unit) {
  for (const MissingEffort& m : found.missing) {
    if (m.joint != joint) continue;
    unit = m.unit;
    return m.noise;
  }
  return 0.0;
}

/// Both models' courses put beside each other.
void put_efforts(std::vector<Replay>& out, const Diagnosis& found, const std::vector<EffortCourse>& before,
                 const std::vector<EffortCourse>& after) {
  for (const EffortCourse& course : before) {
    const auto replay =
        std::find_if(out.begin(), out.end(), [&](const Replay& r) { return r.recording == course.recording; });
    if (replay == out.end()) continue;
    Replay::Effort effort{course.joint, "", 0.0, course.time, course.effort, {}};
    effort.noise = noise_of(found, course.joint, effort.unit);
    if (!(effort.noise > 0.0)) continue;
    for (const EffortCourse& other : after)
      if (other.recording == course.recording && other.joint == course.joint && other.time == course.time)
        effort.after = other.effort;
    replay->missing.push_back(std::move(effort));
  }
}

}  // namespace

std::vector<std::vector<Trace>> traces(const CurrentModel& before, const CurrentModel& after, const FitContext& context,
                                       const std::vector<int>& segments) {
  const Experiment& experiment = context.experiment;
  using Predicted = std::vector<std::vector<std::vector<double>>>;
  auto predict = [&](const CurrentModel& current) {
    Predicted all(experiment.segments.size());
    const std::vector<std::vector<double>> one{current.space.expand(current.fit.point)};
    make_simulator(current.model, experiment, context.simulator)
        ->run(one, segments, [&](int, int s, const auto& predicted) { all[s] = predicted; });
    return all;
  };
  const Predicted a = predict(before), b = predict(after);
  std::vector<std::vector<Trace>> out;
  std::vector<std::string> files;
  for (const int s : segments) {
    const Segment& segment = experiment.segments[s];
    const auto known = std::find(files.begin(), files.end(), segment.file);
    const std::size_t at = known - files.begin();
    if (known == files.end()) files.push_back(segment.file), out.emplace_back();
    std::size_t drawn = 0;
    for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
      if (!is_leading(experiment, c)) continue;
      const Channel& channel = experiment.channels[c];
      if (drawn == out[at].size())
        out[at].push_back({segment.file, experiment.joint_names[channel.joint], channel.unit, {}, {}, {}, {}});
      Trace& t = out[at][drawn++];
      for (std::size_t k = 0; k < segment.measured[c].size(); ++k) {
        t.time.push_back(segment.compared_time(k));
        t.measured.push_back(segment.measured[c][k]);
        t.before.push_back(a[s][c][k]);
        t.after.push_back(b[s][c][k]);
      }
    }
  }
  return out;
}

std::vector<Replay> replays(const Diagnosis& found, const CurrentModel& before, const CurrentModel& after,
                            const FitContext& context, const Scenario& scenario) {
  const Experiment& experiment = context.experiment;
  std::vector<Replay> out;
  if (found.traces.empty()) return out;
  const Role first = experiment.with_role(Role::test).empty() ? Role::validate : Role::test;
  out.push_back({found.traces.front().recording, first, found.traces, {}});
  for (const std::string& file : telling_recordings(found, kMostReplays)) {
    std::vector<int> segments = experiment.with_role(Role::validate);
    std::erase_if(segments, [&](int s) { return experiment.segments[s].file != file; });
    if (segments.empty() || file == out.front().recording || out.size() == kMostReplays) continue;
    out.push_back({file, Role::validate, traces(before, after, context, segments).front(), {}});
  }
  if (found.missing.empty()) return out;
  std::vector<std::string> files;
  for (const Replay& replay : out) files.push_back(replay.recording);
  const std::vector<EffortCourse> plain = effort_courses(before, scenario, context.simulator, files);
  put_efforts(out, found, plain,
              changes_the_model(found) ? effort_courses(after, scenario, context.simulator, files)
                                       : std::vector<EffortCourse>{});
  return out;
}

}  // namespace lacuna
