#include "compare/agreement.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "backends/featherstone/tree.h"
#include "ga/random.h"

namespace lacuna {
namespace {

constexpr double kFastest = 2.0, kStrongestEffort = 20.0, kSlide = 0.5;  // rad/s (m/s), N m (N), m
constexpr std::uint32_t kStateDraws = 72;                                // purpose of the random stream
constexpr int kPoseStates = 64;

double relative(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0.0, size = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    off += (a[i] - b[i]) * (a[i] - b[i]);
    size += b[i] * b[i];
  }
  return std::sqrt(off / size);
}

Tree<long double> extended_tree(const Motion& motion) {
  const std::vector<double>& values = motion.phases.front().values;
  Tree<long double> tree(motion.model.robot());
  const std::vector<Inertial> bodies = motion.model.inertials(values);
  for (int i = 0; i < motion.model.dof(); ++i) tree.set_inertial(i, 0, bodies[i]);
  tree.set_gravity(0, motion.model.gravity(values));
  return tree;
}

std::vector<double> extended_acceleration(Tree<long double>& tree, const RandomState& state) {
  const auto widened = [](const std::vector<double>& x) { return std::vector<long double>(x.begin(), x.end()); };
  const std::vector<long double> q = widened(state.q), v = widened(state.v), tau = widened(state.tau);
  std::vector<long double> a(q.size()), imbalance(q.size());
  const std::vector<long double> free(q.size(), 1.0L);
  tree.forward_dynamics(q.data(), v.data(), tau.data(), free.data(), a.data(), imbalance.data());
  std::vector<double> out;
  for (const long double x : a) out.push_back(static_cast<double>(x));
  return out;
}

double pose_difference(const std::vector<Eigen::Isometry3d>& a, const std::vector<Eigen::Isometry3d>& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Matrix4d off = a[i].matrix() - b[i].matrix();
    worst = worse(worst, off.allFinite() ? off.cwiseAbs().maxCoeff() : kUnmeasured);
  }
  return worst;
}

struct StateResult {
  double difference = 0.0, error = 0.0, pose = 0.0;
};

/// One thread's builds.
struct Worker {
  std::unique_ptr<Dynamics> engine, featherstone;
  Tree<long double> extended;

  StateResult compare(const RandomState& state, bool poses) {
    std::vector<double> a(state.q.size()), b(a.size());
    engine->forward_dynamics(state.q, state.v, state.tau, a);
    featherstone->forward_dynamics(state.q, state.v, state.tau, b);
    StateResult out{relative(a, b), relative(a, extended_acceleration(extended, state)), 0.0};
    if (!poses) return out;
    std::vector<Eigen::Isometry3d> ours, theirs;
    engine->body_poses(state.q, theirs);
    featherstone->body_poses(state.q, ours);
    out.pose = pose_difference(theirs, ours);
    return out;
  }
};

}  // namespace

RandomState random_state(const Robot& robot, std::uint64_t seed, int index) {
  RandomStream stream(seed, 0, static_cast<std::uint32_t>(index), kStateDraws);
  RandomState state;
  for (const Joint& joint : robot.joints()) {
    const double reach = joint.prismatic() ? kSlide : std::numbers::pi;
    const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper) && joint.lower < joint.upper;
    state.q.push_back(limited ? stream.uniform(joint.lower, joint.upper) : stream.uniform(-reach, reach));
    state.v.push_back(stream.uniform(-kFastest, kFastest));
    state.tau.push_back(stream.uniform(-kStrongestEffort, kStrongestEffort));
  }
  return state;
}

void measure_agreement(const Motion& motion, std::uint64_t seed, int threads, const StopFlag* stop,
                       EngineComparison& out, int states) {
  std::vector<Worker> workers;
  for (int w = 0; w < std::max(1, threads); ++w)
    workers.push_back({build_engine(out.engine, motion), build_engine("featherstone", motion), extended_tree(motion)});
  std::vector<StateResult> results(states);
  parallel_for(
      static_cast<int>(workers.size()), states,
      [&](int worker, int k) {
        results[k] = workers[worker].compare(random_state(motion.model.robot(), seed, k), k < kPoseStates);
      },
      stop);
  for (int k = 0; k < states; ++k) {
    const StateResult& result = results[k];
    const std::string where = fmt::format("random state {} of seed {}", k, seed);
    out.acceleration_difference.see(result.difference, where);
    out.acceleration_error.see(result.error, where);
    if (k < kPoseStates) out.pose_difference.see(result.pose, where);
  }
  out.states = states;
}

}  // namespace lacuna
