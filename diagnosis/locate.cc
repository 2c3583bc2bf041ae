#include "diagnosis/locate.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <functional>

#include "diagnosis/baseline.h"
#include "diagnosis/evidence.h"
#include "diagnosis/regions.h"
#include "diagnosis/when.h"
#include "ga/random.h"
#include "physics/filter.h"
#include "scenarios/learned_entry.h"

namespace lacuna {
namespace {

constexpr std::uint32_t kLocateDraws = 71;  // of random draws
constexpr double kLeastRatio = 1.5;

double upper_tail(double z) {
  return boost::math::cdf(boost::math::complement(boost::math::normal(), std::min(z, 35.0)));
}

/// Correlation from sample to sample of first-order noise whose sixth differences show `seen` times its rms: slow noise
/// shows less of itself in them. White noise shows all.
double noise_correlation(double seen) {
  if (!(seen < 1.0)) return 0.0;
  constexpr double kBinomial[] = {924, -792, 495, -220,
                                  66,  -12,  1};  // of the twelfth power, from the middle: lags 0 to 6
  const auto shown = [&](double correlation) {
    double sum = 1.0, power = 1.0;
    for (int lag = 1; lag <= 6; ++lag) sum += 2.0 * kBinomial[lag] / kBinomial[0] * (power *= correlation);
    return std::sqrt(std::max(sum, 0.0));
  };
  double low = 0.0, high = 0.999;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (low + high);
    (shown(middle) > seen ? low : high) = middle;
  }
  return low;
}

/// Missing efforts of all segments, as residuals with unit weights: in units of the commands.
class Efforts {
 public:
  /// `uses`: the segments; those of test recordings decide nothing.
  Efforts(
      const CurrentModel& model, const Scenario& scenario, const SimulatorOptions& options,
      const std::function<bool(const Segment&)>& uses = [](const Segment& s) { return s.role != Role::test; })
      : model_(model), options_(options), values_(model.space.expand(model.fit.point)) {
    // Of positions alone: what else is measured says the same with another noise.
    Scenario whole = scenario;
    for (const ChannelKind kind : {ChannelKind::velocity, ChannelKind::effort, ChannelKind::motor_position})
      whole.channels.of.erase(kind);
    if (!whole.pressure_driven)
      for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b}) whole.channels.of.erase(kind);
    whole.events.clear();  // what happened is missing, too
    whole.prediction = FreeRun{};
    free_run_ = make_experiment(whole);
    if (!can_invert(free_run_)) return;
    whole.prediction = InverseDynamics{kLocateCutoff};
    experiment_ = make_experiment(whole);
    for (std::size_t s = 0; s < experiment_.segments.size(); ++s)
      if (uses(experiment_.segments[s])) segments_.push_back(static_cast<int>(s));
  }

  bool any() const { return !segments_.empty(); }
  const Experiment& experiment() const { return experiment_; }
  const Experiment& free_run() const { return free_run_; }
  /// Whether it is known of every measured position how noisy it is.
  bool noise_known() const {
    const std::vector<double> levels = noise_levels(free_run_);
    for (std::size_t c = 0; c < free_run_.channels.size(); ++c)
      if (free_run_.channels[c].kind == ChannelKind::position && !(levels[c] > 0.0)) return false;
    return true;
  }
  const std::vector<int>& segments() const { return segments_; }
  std::vector<ResidualBlock> layout() const { return problem(experiment_).layout(segments_); }

  /// Of the measured motion, less that of the model's own.
  Eigen::VectorXd measured() const {
    const Eigen::VectorXd out = of(experiment_), own = of(simulated());
    return own.allFinite() ? Eigen::VectorXd(out - own) : out;
  }
  /// What the noise of the positions makes of it.
  Eigen::VectorXd noise(std::uint64_t seed) const {
    Experiment noisy = experiment_;
    std::vector<RawMotion> raw;
    for (const Segment& segment : experiment_.segments) raw.push_back(*segment.raw);
    const std::vector<double> levels = noise_levels(free_run_);
    for (std::size_t c = 0; c < levels.size(); ++c) {
      if (!(levels[c] > 0.0) || free_run_.channels[c].kind != ChannelKind::position) continue;
      const double kept = noise_correlation(noise_seen(free_run_, c) / levels[c]);
      for (std::size_t s = 0; s < raw.size(); ++s) {
        RandomStream random(seed, static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(c), kLocateDraws);
        double x = random.normal();
        for (double& measured : raw[s].position[joint_of(c)]) {
          measured += levels[c] * x;
          x = kept * x + std::sqrt(1.0 - kept * kept) * random.normal();
        }
      }
    }
    for (std::size_t s = 0; s < raw.size(); ++s) set_motion(noisy.segments[s], std::move(raw[s]), kLocateCutoff);
    return of(noisy) - of(experiment_);
  }

 private:
  std::size_t joint_of(std::size_t channel) const {
    return static_cast<std::size_t>(free_run_.channels[channel].joint);
  }
  Problem problem(const Experiment& experiment) const {
    return {model_.model, experiment, model_.space, options_, std::vector<double>(experiment_.channels.size(), 1.0)};
  }
  Eigen::VectorXd of(const Experiment& experiment) const {
    return problem(experiment).residuals_of(std::vector<std::vector<double>>{values_}, segments_).front();
  }
  Experiment simulated() const {
    Experiment out = experiment_;
    const std::vector<std::vector<double>> one{values_};
    make_simulator(model_.model, free_run_, options_)->run(one, segments_, [&](int, int s, const auto& predicted) {
      Segment& segment = out.segments[s];
      RawMotion raw = *segment.raw;
      for (std::size_t c = 0; c < predicted.size(); ++c)
        if (free_run_.channels[c].kind == ChannelKind::position) raw.position[joint_of(c)] = predicted[c];
      set_motion(segment, std::move(raw), kLocateCutoff);
    });
    return out;
  }

  const CurrentModel& model_;
  SimulatorOptions options_;
  std::vector<double> values_;
  Experiment free_run_, experiment_;
  std::vector<int> segments_;
};

using Quantity = std::function<double(const JointStates&, std::size_t)>;

const std::vector<std::pair<std::string, Quantity>>& quantities() {
  static const auto sign = [](double x) { return static_cast<double>((x > 0.0) - (x < 0.0)); };
  static const std::vector<std::pair<std::string, Quantity>> all = {
      {"the direction of motion", [](const JointStates& s, std::size_t k) { return sign(s.v[k]); }},
      {"the speed", [](const JointStates& s, std::size_t k) { return s.v[k]; }},
      {"the speed squared, signed", [](const JointStates& s, std::size_t k) { return std::fabs(s.v[k]) * s.v[k]; }},
      {"the acceleration", [](const JointStates& s, std::size_t k) { return s.a[k]; }},
      {"the command", [](const JointStates& s, std::size_t k) { return s.u[k]; }},
      {"the sign of the command", [](const JointStates& s, std::size_t k) { return sign(s.u[k]); }},
      {"the position", [](const JointStates& s, std::size_t k) { return s.q[k]; }}};
  return all;
}

/// Correlation of zero-mean copies.
double correlation(const std::vector<double>& x, const std::vector<double>& y) {
  const auto map = [](const std::vector<double>& z) { return Eigen::Map<const Eigen::VectorXd>(z.data(), z.size()); };
  const Eigen::VectorXd a = map(x).array() - map(x).mean(), b = map(y).array() - map(y).mean();
  const double size = a.norm() * b.norm();
  return size > 0.0 ? a.dot(b) / size : 0.0;
}

/// Tests of one joint's missing effort `d` at `states`; each sample counts as `worth` independent ones.
void test_regions(MissingEffort& out, const std::vector<double>& d, const JointStates& states, double worth,
                  const Experiment& experiment, std::size_t joint, double joints) {
  const std::vector<Region> regions = regions_of(experiment, joint, states);
  const double tests = joints * static_cast<double>(regions.size());
  for (const Region& region : regions) {
    double in = 0.0, elsewhere = 0.0, n_in = 0.0, n_elsewhere = 0.0;
    for (std::size_t k = 0; k < d.size(); ++k) {
      const bool here = region.holds(states, k);
      (here ? in : elsewhere) += d[k] * d[k];
      (here ? n_in : n_elsewhere) += 1.0;
    }
    if (n_in * worth < 10.0 || n_elsewhere * worth < 10.0 || !(elsewhere > 0.0)) continue;
    const double ratio = (in / n_in) / (elsewhere / n_elsewhere);
    const double error = std::sqrt(2.0 / (n_in * worth) + 2.0 / (n_elsewhere * worth));
    const double p = std::min(1.0, tests * upper_tail(std::log(ratio) / error));
    if (ratio > kLeastRatio && p < kLocateError) out.regions.push_back({region.words, ratio, p});
  }
  std::sort(out.regions.begin(), out.regions.end(), [](const auto& a, const auto& b) { return a.ratio > b.ratio; });
}
void test_quantities(MissingEffort& out, const std::vector<double>& d, const JointStates& states, double worth,
                     double joints) {
  const double tests = joints * static_cast<double>(quantities().size());
  const double n = worth * static_cast<double>(d.size());
  for (const auto& [words, quantity] : quantities()) {
    std::vector<double> x;
    for (std::size_t k = 0; k < d.size(); ++k) x.push_back(quantity(states, k));
    const double r = correlation(d, x);
    if (std::fabs(r) < kLeastCorrelation || n < 10.0) continue;
    // Fisher's transform; two-sided.
    const double z = std::atanh(std::min(std::fabs(r), 1.0 - 1e-12)) * std::sqrt(n - 3.0);
    const double p = std::min(1.0, 2.0 * tests * upper_tail(z));
    if (p < kLocateError) out.follows.push_back({words, r, p});
  }
  std::sort(out.follows.begin(), out.follows.end(),
            [](const auto& a, const auto& b) { return std::fabs(a.correlation) > std::fabs(b.correlation); });
}

void test_times(MissingEffort& out, const std::vector<double>& d,
                const std::vector<std::pair<const Segment*, double>>& places, double joints) {
  for (const PowerChange& change : power_changes(d, joints)) {
    const auto& [segment, time] = places[change.at];
    out.changes.push_back({segment->file, time, change.before, change.after, change.p_value});
  }
}

/// What is known of one joint: figures, the missing effort sample by sample, and its states.
struct JointEffort {
  MissingEffort found;
  std::vector<double> d;
  JointStates states;
  std::vector<std::pair<const Segment*, double>> places;  ///< of the samples: segment, time in its recording (s)
  double ratio = 1.0, effective = 1.0;                    ///< energy over the noise's; independent samples
};

JointEffort joint_effort(const Efforts& efforts, std::size_t joint, const std::vector<ResidualBlock>& layout,
                         const Eigen::VectorXd& missing, const Eigen::VectorXd& noise) {
  const Experiment& experiment = efforts.experiment();
  JointEffort out;
  out.found.joint = experiment.joint_names[joint];
  std::vector<ResidualBlock> own;
  double squares = 0.0, noise_squares = 0.0;
  for (const ResidualBlock& block : layout) {
    if (experiment.channels[block.channel].joint != static_cast<int>(joint)) continue;
    own.push_back(block);
    const Segment& segment = experiment.segments[block.segment];
    const JointStates here =
        joint_states(efforts.free_run(), efforts.free_run().segments[block.segment], joint, segment.compared);
    const auto part = missing.segment(block.first, block.count);
    if (out.d.empty()) {
      out.found.recording = segment.file;
      for (const double t : here.t) out.found.time.push_back(t - segment.session);
      out.found.trace.assign(part.begin(), part.end());
    }
    for (const double t : here.t) out.places.emplace_back(&segment, t - segment.session);
    out.states.append(here);
    out.d.insert(out.d.end(), part.begin(), part.end());
    squares += part.squaredNorm();
    noise_squares += noise.segment(block.first, block.count).squaredNorm();
  }
  const double n = std::max(1.0, static_cast<double>(out.d.size()));
  out.found.rms = std::sqrt(squares / n);
  out.found.noise = std::sqrt(noise_squares / n);
  out.ratio = squares / std::max(noise_squares, 1e-300);
  out.effective = effective_samples(missing, own);
  return out;
}

/// The law where its first variable is x; of two branches the one of the sign of `beside`.
double value_at(const LearnedLaw& law, double x, double beside) {
  const std::size_t columns = law.over.size() > 1 ? law.over[1].knots : 1, rows = law.curve.size() / columns;
  const std::size_t column = columns > 1 && beside > 0.0 ? columns - 1 : 0;
  const double spacing = (law.curve.back().at - law.curve.front().at) / static_cast<double>(rows - 1);
  const double at = std::clamp((x - law.curve.front().at) / spacing, 0.0, static_cast<double>(rows - 1));
  const std::size_t row = std::min(static_cast<std::size_t>(at), rows - 2);
  const double share = at - static_cast<double>(row);
  return (1.0 - share) * law.curve[row * columns + column].value +
         share * law.curve[(row + 1) * columns + column].value;
}

/// Where efforts were measured: by how much what the model predicts is more than they are, at the samples compared.
std::vector<std::pair<double, double>> cloud_of_efforts(const LearnedLaw& law, const CurrentModel& with_law,
                                                        const Experiment& experiment, const SimulatorOptions& options) {
  const Robot& robot = with_law.model.robot();
  const VariableName variable = variable_named(law.over.front().name);
  const int own = *robot.find_joint(law.place);
  const auto whose = static_cast<std::size_t>(variable.joint.empty() ? own : *robot.find_joint(variable.joint));
  std::size_t c = 0;
  const std::vector<Channel>& channels = experiment.channels;
  while (c < channels.size() && !(channels[c].kind == ChannelKind::effort && channels[c].joint == own)) ++c;
  if (c == channels.size()) return {};
  const std::vector<std::vector<double>> values{with_law.space.expand(with_law.fit.point)};
  std::vector<int> fitted = experiment.with_role(Role::train);
  const std::vector<int> validate = experiment.with_role(Role::validate);
  fitted.insert(fitted.end(), validate.begin(), validate.end());
  std::vector<std::vector<double>> predicted(experiment.segments.size());
  make_simulator(with_law.model, experiment, options)->run(values, fitted, [&](int, int segment, const auto& of) {
    predicted[segment] = of[c];
  });
  std::vector<std::pair<double, double>> out;
  for (const int s : fitted) {
    const Segment& segment = experiment.segments[s];
    const MeasuredMotion& motion = *segment.motion;
    for (std::size_t k = 0; k < segment.compared.size(); ++k) {
      const std::size_t at = segment.compared[k];
      const double x = (variable.quantity == "speed" ? motion.v : motion.q)[whose][at];
      const double beyond = predicted[s][k] - segment.measured[c][k];
      if (std::isfinite(beyond)) out.emplace_back(x, beyond + value_at(law, x, motion.v[own][at]));
    }
  }
  return out;
}

}  // namespace

bool can_invert(const Experiment& simulated) {
  const std::vector<int> channels = position_channels(simulated);
  if (std::any_of(channels.begin(), channels.end(), [](int c) { return c < 0; })) return false;
  return std::all_of(simulated.segments.begin(), simulated.segments.end(), [](const Segment& s) {
    const double rate = static_cast<double>(s.count - 1) / s.time(s.count - 1);
    const Thinning thinning(kLocateCutoff, rate);
    return kLocateCutoff < 0.25 * rate && s.count > 2 * thinning.edge + 20 * thinning.stride;
  });
}

std::vector<std::pair<double, double>> cloud_of(const LearnedLaw& law, const CurrentModel& with_law,
                                                const Scenario& scenario, const SimulatorOptions& options) {
  const bool map = law.over.size() > 1 && law.over[1].knots > 2;
  const int gain = with_law.model.find(law.place + ".gain");
  if (law.stage != Stage::link || map || law.curve.size() < 4) return {};
  if (std::holds_alternative<InverseDynamics>(scenario.prediction))
    return cloud_of_efforts(law, with_law, make_experiment(scenario), options);
  if (gain < 0) return {};
  const Parameter& drives = with_law.model.parameters()[gain];
  if (!drives.unit.starts_with("N")) return {};
  const Efforts efforts(with_law, scenario, options);
  if (!efforts.any()) return {};
  const Eigen::VectorXd missing = efforts.measured();
  if (!missing.allFinite()) return {};
  const VariableName variable = variable_named(law.over.front().name);
  const Robot& robot = with_law.model.robot();
  const std::size_t own = *robot.find_joint(law.place);
  const auto whose = variable.joint.empty() ? own : static_cast<std::size_t>(*robot.find_joint(variable.joint));
  const std::vector<ResidualBlock> layout = efforts.layout();
  const JointEffort here = joint_effort(efforts, own, layout, missing, missing);
  const JointEffort there = whose == own ? here : joint_effort(efforts, whose, layout, missing, missing);
  const std::vector<double>& x = variable.quantity == "speed" ? there.states.v : there.states.q;
  const double newtons = with_law.space.expand(with_law.fit.point)[gain];
  std::vector<std::pair<double, double>> out;
  for (std::size_t k = 0; k < std::min({x.size(), here.d.size(), here.states.v.size()}); ++k)
    out.emplace_back(x[k], newtons * here.d[k] + value_at(law, x[k], here.states.v[k]));
  return out;
}

std::vector<EffortCourse> effort_courses(const CurrentModel& model, const Scenario& scenario,
                                         const SimulatorOptions& options, const std::vector<std::string>& recordings) {
  if (std::holds_alternative<InverseDynamics>(scenario.prediction)) return {};
  const Efforts efforts(model, scenario, options, [&](const Segment& s) {
    return std::find(recordings.begin(), recordings.end(), s.file) != recordings.end();
  });
  if (!efforts.any()) return {};
  const Eigen::VectorXd missing = efforts.measured();
  if (!missing.allFinite()) return {};
  const Experiment& experiment = efforts.experiment();
  std::vector<EffortCourse> out;
  for (const ResidualBlock& block : efforts.layout()) {
    const Segment& segment = experiment.segments[block.segment];
    const std::size_t joint = experiment.channels[block.channel].joint;
    const JointStates states =
        joint_states(efforts.free_run(), efforts.free_run().segments[block.segment], joint, segment.compared);
    const auto part = missing.segment(block.first, block.count);
    if (states.t.size() != static_cast<std::size_t>(block.count)) continue;
    const std::string& name = experiment.joint_names[joint];
    auto course = std::find_if(out.begin(), out.end(),
                               [&](const EffortCourse& c) { return c.recording == segment.file && c.joint == name; });
    if (course == out.end()) {
      out.push_back({segment.file, name, {}, {}});
      course = std::prev(out.end());
    }
    for (const double t : states.t) course->time.push_back(t - segment.session);
    course->effort.insert(course->effort.end(), part.begin(), part.end());
  }
  return out;
}

std::vector<std::string> likely_joints(const std::vector<MissingEffort>& missing) {
  std::vector<std::string> out;
  for (const MissingEffort& m : missing)
    if (m.p_value < kLocateError && m.share >= kLikely) out.push_back(m.joint);
  return out;
}

std::vector<MissingEffort> missing_efforts(const CurrentModel& model, const Scenario& scenario,
                                           const SimulatorOptions& options, std::uint64_t seed) {
  if (std::holds_alternative<InverseDynamics>(scenario.prediction)) return {};
  const Efforts efforts(model, scenario, options);
  if (!efforts.any() || !efforts.noise_known()) return {};
  const std::vector<int> channels = position_channels(efforts.free_run());
  const Eigen::VectorXd missing = efforts.measured(), noise = efforts.noise(seed);
  if (!missing.allFinite() || !noise.allFinite()) return {};
  const std::vector<ResidualBlock> layout = efforts.layout();
  const double joints =
      static_cast<double>(std::count_if(channels.begin(), channels.end(), [](int c) { return c >= 0; }));
  std::vector<MissingEffort> out;
  double total = 0.0;
  for (std::size_t j = 0; j < channels.size(); ++j) {
    if (channels[j] < 0) continue;
    JointEffort joint = joint_effort(efforts, j, layout, missing, noise);
    if (joint.d.empty() || joint.d.size() != joint.states.t.size()) continue;
    MissingEffort& found = joint.found;
    found.unit = model.model.command_unit(static_cast<int>(j));
    found.p_value = std::min(1.0, joints * chance_of_energy(joint.ratio, joint.effective));
    found.share = std::max(0.0, joint.ratio - 1.0);
    total += found.share;
    if (found.p_value < kLocateError) {
      const double worth = joint.effective / static_cast<double>(joint.d.size());
      test_regions(found, joint.d, joint.states, worth, efforts.free_run(), j, joints);
      test_quantities(found, joint.d, joint.states, worth, joints);
      test_times(found, joint.d, joint.places, joints);
    }
    out.push_back(std::move(found));
  }
  for (MissingEffort& each : out) each.share = total > 0.0 ? each.share / total : 0.0;
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  return out;
}

}  // namespace lacuna
