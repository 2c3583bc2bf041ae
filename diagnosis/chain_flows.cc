#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "diagnosis/baseline.h"
#include "diagnosis/candidates.h"
#include "diagnosis/chain_samples.h"
#include "diagnosis/locate.h"
#include "diagnosis/regions.h"
#include "physics/filter.h"

namespace lacuna {
namespace {

/// Joints whose actuators give a flow: measured speeds against simulated ones, in the predictions as they are.
class Speeds {
 public:
  explicit Speeds(const FitContext& context)
      : experiment_(context.experiment),
        options_(context.simulator),
        segments_(not_fitted(experiment_)),
        commands_(experiment_) {}

  std::vector<JointSamples> mismatch(const CurrentModel& model) const {
    std::vector<std::vector<JointSamples>> parts(experiment_.segments.size());  // one a thread may write
    const std::vector<std::vector<double>> one{model.space.expand(model.fit.point)};
    make_simulator(model.model, experiment_, options_)->run(one, segments_, [&](int, int s, const auto& predicted) {
      const Segment& segment = experiment_.segments[s];
      std::vector<JointSamples>& part = parts[s];
      part.resize(experiment_.joint_names.size());
      for (std::size_t c = 0; c < predicted.size(); ++c)
        if (experiment_.channels[c].kind == ChannelKind::position)
          add(segment, c, predicted[c], part[experiment_.channels[c].joint]);
    });
    std::vector<JointSamples> out(experiment_.joint_names.size());
    for (const auto& part : parts)
      for (std::size_t j = 0; j < part.size(); ++j) out[j].append(part[j]);
    return out;
  }
  /// rad/s (m/s): what the noise of joint j's position makes of its speed.
  double noise(std::size_t joint) const {
    const std::vector<double> levels = noise_levels(experiment_);
    const int c = position_channels(experiment_)[joint];
    const double rate = 1.0 / experiment_.sample_period;
    if (!can_filter(rate)) return 0.0;
    return levels[c] * rate * filter_gain(ZeroPhaseLowPass(kLocateCutoff, rate), 1).slope;
  }

 private:
  void add(const Segment& segment, std::size_t channel, const std::vector<double>& predicted, JointSamples& out) const {
    const std::vector<double>& seen = segment.measured[channel];
    if (segment.count < kFewestInPart) return;
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
      const ChainPart part = commands_.at(segment, static_cast<std::size_t>(experiment_.channels[channel].joint), k);
      out.mismatch[index_of(part)].push_back(0.5 * rate * (error[k + 1] - error[k - 1]));
      out.signal[index_of(part)].push_back(0.5 * rate * (position[k + 1] - position[k - 1]));
    }
  }

  const Experiment& experiment_;
  SimulatorOptions options_;
  std::vector<int> segments_;
  CommandedParts commands_;
};

/// Joints whose areas nobody gives: the effort that the motion needs, against both pressures, each times an area.
class FittedAreas {
 public:
  /// `joints`: of the robot, whose pressures stand in the place of measured efforts, one after the other.
  FittedAreas(const Scenario& scenario, const SimulatorOptions& options, const std::vector<std::string>& joints)
      : options_(options) {
    Scenario whole = motions_of(scenario);
    if (joints.empty() || !can_invert(make_experiment(whole))) return;
    whole.prediction = InverseDynamics{kLocateCutoff};
    for (const std::size_t which : {0u, 1u}) {
      const auto& columns = scenario.channels.of.at(which == 0 ? ChannelKind::pressure_a : ChannelKind::pressure_b);
      for (const std::string& joint : joints) whole.channels.of[ChannelKind::effort][joint] = columns.at(joint);
      experiments_.push_back(make_experiment(whole));
    }
  }
  bool any() const { return !experiments_.empty(); }

  /// Of a joint: what areas fitted to the train recordings leave of the others' efforts, and the noise of that, N m
  /// (N), with the areas' own errors in it. Nothing where there is too little to fit them to.
  void look(const CurrentModel& before, const CurrentModel& after, int joint, std::uint64_t seed,
            JointLook& out) const {
    const std::optional<Fit> plain = fitted(before, joint), found = fitted(after, joint);
    if (!plain || !found) return;
    put(*plain, out.before), put(*found, out.after);
    out.noise[kLast] = noise(before, *plain, joint, seed);
  }

 private:
  struct Table {
    Eigen::MatrixXd columns;  ///< pressures of A and B, bar; 1
    Eigen::VectorXd needed;   ///< N m (N)
  };
  struct Fit {
    Eigen::VectorXd areas;     ///< N m (N) per bar of A and of B; offset
    Eigen::MatrixXd leverage;  ///< their covariance over the variance of what they leave
    Table rest;                ///< of the recordings that were not fitted

    Eigen::VectorXd left() const { return rest.needed - rest.columns * areas; }
  };
  static constexpr std::size_t kLast = static_cast<std::size_t>(ChainPart::pressure_to_motion);
  static constexpr double kBar = 1e-5;  ///< bar/Pa
  static bool is_train(const Segment& s) { return s.role == Role::train; }
  static bool is_rest(const Segment& s) { return s.role != Role::train; }

  std::optional<Fit> fitted(const CurrentModel& model, int joint) const {
    const std::optional<std::size_t> c = channel_of(joint);
    if (!c) return std::nullopt;
    const Table train = table(model, experiments_[0], *c, is_train);
    Fit out{{}, {}, table(model, experiments_[0], *c, is_rest)};
    if (train.needed.size() < 3 * static_cast<Eigen::Index>(kFewestInPart) || out.rest.needed.size() == 0)
      return std::nullopt;
    out.areas = train.columns.colPivHouseholderQr().solve(train.needed);
    out.leverage = (train.columns.transpose() * train.columns).completeOrthogonalDecomposition().pseudoInverse();
    return out;
  }
  static void put(const Fit& fit, JointSamples& out) {
    const Eigen::VectorXd left = fit.left();
    out.mismatch[kLast].assign(left.begin(), left.end());
    out.signal[kLast].assign(fit.rest.needed.begin(), fit.rest.needed.end());
    take_off_mean(out.signal[kLast]);
  }
  double noise(const CurrentModel& model, const Fit& fit, int joint, std::uint64_t seed) const {
    Experiment noisy = experiments_[0];
    for (std::size_t s = 0; s < noisy.segments.size(); ++s)
      set_motion(noisy.segments[s], with_noise(*noisy.segments[s].raw, seed, static_cast<int>(s)), kLocateCutoff);
    const std::size_t c = *channel_of(joint);
    const Eigen::VectorXd moved = table(model, noisy, c, is_rest).needed - fit.rest.needed;
    const double n = static_cast<double>(moved.size());
    double squares = moved.squaredNorm() / n;
    for (const std::size_t which : {0u, 1u})
      squares += std::pow(fit.areas(which) * kBar * noise_levels(experiments_[which])[c], 2);
    // The areas were fitted to recordings with as much noise.
    const double spread = (fit.rest.columns * fit.leverage).cwiseProduct(fit.rest.columns).sum() / n;
    return std::sqrt(squares * (1.0 + spread));
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
        const auto pressure = [&](std::size_t which) { return kBar * experiments_[which].segments[s].measured[c][k]; };
        const std::array<double, 3> row{pressure(0), pressure(1), efforts[k]};
        if (std::ranges::all_of(row, [](double x) { return std::isfinite(x); })) rows.push_back(row);
      }
    Table out{Eigen::MatrixXd(rows.size(), 3), Eigen::VectorXd(rows.size())};
    for (Eigen::Index k = 0; k < out.needed.size(); ++k) {
      const auto& row = rows[k];
      out.columns.row(k) << row[0], row[1], 1.0;
      out.needed(k) = row[2];
    }
    return out;
  }

  SimulatorOptions options_;
  std::vector<Experiment> experiments_;  ///< with the pressures of A and of B as measured efforts
};

}  // namespace

std::vector<JointLook> flow_looks(const CurrentModel& before, const CurrentModel& after, const Scenario& scenario,
                                  const FitContext& context, std::uint64_t seed, const std::vector<int>& joints) {
  const Speeds speeds(context);
  std::vector<JointSamples> plain = speeds.mismatch(before), found = speeds.mismatch(after);
  std::vector<std::string> names;
  for (const int j : joints) names.push_back(context.experiment.joint_names[j]);
  const FittedAreas areas(scenario, context.simulator, names);
  std::vector<JointLook> out(plain.size());
  for (const int joint : joints) {
    JointLook& look = out[joint];
    look.why_not[index_of(ChainPart::supply)] = take_together_where_needed({&plain[joint], &found[joint]});
    look.before = std::move(plain[joint]), look.after = std::move(found[joint]);
    for (const ChainPart part : {ChainPart::command_to_flow, ChainPart::supply})
      look.noise[index_of(part)] = speeds.noise(joint);
    look.why_not[index_of(ChainPart::flow_to_pressure)] =
        "the actuator has no chambers: areas and volumes are not given";
    if (areas.any())
      areas.look(before, after, joint, seed, look);
    else
      look.why_not[index_of(ChainPart::pressure_to_motion)] = kCannotInvert;
  }
  return out;
}

}  // namespace lacuna
