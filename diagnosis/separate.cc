#include "diagnosis/separate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "diagnosis/baseline.h"
#include "diagnosis/contest.h"
#include "ga/random.h"
#include "physics/course.h"

namespace lacuna {
namespace {

constexpr std::size_t kDrawn = 24;     // motions in the first generation
constexpr int kDesignGenerations = 4;  // each further one: children of the best
constexpr std::size_t kParents = 6, kChildren = 3;
constexpr double kMutation = 0.15;                  // of a coordinate in [0, 1], rms
constexpr double kLongest = 20.0;                   // s
constexpr double kHighest = 3.0, kPerSample = 0.1;  // Hz; and cycles per sample at most
constexpr double kWeakenedTo = 0.7;                 // a motion beyond its limits is weakened to this share, so often:
constexpr int kMostWeakenings = 8;
constexpr std::uint32_t kDesignDraws = 61;  // of random draws

/// A motion by its coordinates, and what it is worth.
struct Course {
  Shape shape;
  std::vector<double> x;  ///< of all joints, one after the other, each in [0, 1]
  CommandTrack commands;  ///< weakened to the limits; empty: not even then within them
  double evidence = 0.0;  ///< against its hardest rival
  std::size_t hardest = 0;
};

/// The motions as segments of one experiment, measured as the found model moves.
Experiment segments_of(const Experiment& like, const std::vector<CommandTrack>& motions) {
  const std::vector<double> start = like.segments[like.with_role(Role::train).front()].q0;
  Experiment out = commanded(like, motions.front(), start);
  for (std::size_t k = 1; k < motions.size(); ++k)
    out.segments.push_back(commanded(like, motions[k], start).segments.front());
  return out;
}

std::vector<int> all_of(const Experiment& experiment) {
  std::vector<int> out(experiment.segments.size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = static_cast<int>(k);
  return out;
}

class SeparatingMotions {
 public:
  SeparatingMotions(const CurrentModel& found, const FitContext& context)
      : found_(found),
        experiment_(context.experiment),
        options_(context.simulator),
        limits_(recorded_limits(found.model.robot(), experiment_)) {
    const Segment& first = experiment_.segments[experiment_.with_role(Role::train).front()];
    own_commands_ = *first.commands;
    seconds_ = std::min(kLongest, own_commands_.time.back());
  }

  bool anything_driven() const {
    return std::any_of(limits_.command.begin(), limits_.command.end(), [](double peak) { return peak > 0.0; });
  }

  std::vector<Course> drawn(std::uint64_t seed) const {
    std::vector<Course> out;
    for (std::size_t k = 0; k < kDrawn; ++k) {
      Course course{static_cast<Shape>(k % 3), {}, {}, 0.0, 0};
      RandomStream random(seed, 0, static_cast<std::uint32_t>(k), kDesignDraws);
      course.x.resize(courses(course.shape).size() * limits_.command.size());
      for (double& coordinate : course.x) coordinate = random.uniform();
      out.push_back(std::move(course));
    }
    return out;
  }

  /// Children of the best of `courses`, which are sorted.
  std::vector<Course> children(const std::vector<Course>& courses, std::uint64_t seed, int generation) const {
    std::vector<Course> out;
    for (std::size_t k = 0; k < std::min(kParents, courses.size()) * kChildren; ++k) {
      Course child{courses[k / kChildren].shape, courses[k / kChildren].x, {}, 0.0, 0};
      RandomStream random(seed, static_cast<std::uint32_t>(generation), static_cast<std::uint32_t>(k), kDesignDraws);
      for (double& coordinate : child.x) coordinate = std::clamp(coordinate + kMutation * random.normal(), 0.0, 1.0);
      out.push_back(std::move(child));
    }
    return out;
  }

  /// Gives each course commands that keep to the limits, where there are any.
  void weaken(std::vector<Course>& all) const {
    std::vector<Course*> pending;
    for (Course& course : all) {
      course.commands = commands_of(course);
      pending.push_back(&course);
    }
    for (int round = 0; !pending.empty(); ++round) {
      std::vector<CommandTrack> tracks;
      for (const Course* course : pending) tracks.push_back(course->commands);
      const Experiment tried = segments_of(experiment_, tracks);
      const auto moved = predictions(tried);
      std::vector<Course*> beyond;
      for (std::size_t k = 0; k < pending.size(); ++k) {
        const SeenMotion seen = seen_motion(tried, tried.segments[k], moved[k], limits_);
        if (!seen.finite || seen.beyond > 0.0) beyond.push_back(pending[k]);
      }
      for (Course* course : beyond) {
        if (round == kMostWeakenings) course->commands = {};
        for (auto& column : course->commands.value)
          for (double& u : column) u *= kWeakenedTo;
      }
      if (round == kMostWeakenings) break;
      pending = std::move(beyond);
    }
  }

  /// One segment a motion, measured as the found model moves.
  Experiment recorded(const std::vector<CommandTrack>& motions) const {
    Experiment out = segments_of(experiment_, motions);
    auto moved = predictions(out);
    for (std::size_t k = 0; k < out.segments.size(); ++k) out.segments[k].measured = std::move(moved[k]);
    return out;
  }
  const CommandTrack& own_commands() const { return own_commands_; }

 private:
  Courses courses(Shape shape) const {
    return {shape, seconds_, std::min(kHighest, kPerSample / experiment_.sample_period)};
  }

  CommandTrack commands_of(const Course& course) const {
    const Courses maker = courses(course.shape);
    CommandTrack out = still_commands(limits_.command.size(), seconds_, experiment_.sample_period);
    for (std::size_t j = 0; j < out.value.size(); ++j) {
      const std::span<const double> x(course.x.data() + j * maker.size(), maker.size());
      if (limits_.command[j] > 0.0) out.value[j] = maker.course(x, out.time, limits_.command[j]);
    }
    return out;
  }

  /// [segment][channel][sample]
  std::vector<std::vector<std::vector<double>>> predictions(const Experiment& experiment) const {
    const std::vector<std::vector<double>> one{found_.space.expand(found_.fit.point)};
    std::vector<std::vector<std::vector<double>>> out(experiment.segments.size());
    make_simulator(found_.model, experiment, options_)
        ->run(one, all_of(experiment),
              [&](int, int s, const auto& predicted) { out[s].assign(predicted.begin(), predicted.end()); });
    return out;
  }

  const CurrentModel& found_;
  const Experiment& experiment_;
  SimulatorOptions options_;
  MotionLimits limits_;
  CommandTrack own_commands_;  ///< of the first train recording
  double seconds_ = 0.0;
};

/// Rows in units of the noise where that is known.
Eigen::VectorXd row_factors(const CurrentModel& model, const Experiment& experiment,
                            const std::vector<ResidualBlock>& blocks, Eigen::Index rows) {
  const std::vector<double> noise = noise_levels(experiment);
  Eigen::VectorXd out = Eigen::VectorXd::Ones(rows);
  for (const ResidualBlock& block : blocks) {
    const std::size_t c = block.channel;
    if (noise[c] > 0.0) out.segment(block.first, block.count).setConstant(model.weights[c] / noise[c]);
  }
  return out;
}

/// Log-likelihood to be expected against the rival from each motion, after it has been re-identified on that motion and
/// the train recordings together.
std::vector<double> evidence_against(const CurrentModel& rival, const FitContext& context, const Experiment& motions) {
  Problem old = problem_of(rival, context);
  const std::vector<int> train = context.experiment.with_role(Role::train);
  const Eigen::VectorXd known = row_factors(rival, context.experiment, old.layout(train), rival.fit.residual.size());
  const Eigen::MatrixXd before = known.asDiagonal() * rival.fit.jacobian;
  Eigen::MatrixXd information = before.transpose() * before;
  const Eigen::VectorXd deviation = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  information = deviation.asDiagonal() * information * deviation.asDiagonal();
  information.diagonal().array() += 1e-9;

  Problem next = problem_of(rival, context.on(motions));
  const std::vector<int> all = all_of(motions);
  const Eigen::VectorXd plain = next.residual(rival.fit.point, all);
  const std::vector<ResidualBlock> blocks = next.layout(all);
  const Eigen::VectorXd factors = row_factors(rival, context.experiment, blocks, plain.size());
  const Eigen::VectorXd missed = factors.cwiseProduct(plain);
  const Eigen::MatrixXd moves =
      factors.asDiagonal() * next.jacobian(rival.fit.point, plain, all) * deviation.asDiagonal();
  std::vector<double> out;
  for (const int s : all) {
    Eigen::MatrixXd normal = information;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(normal.rows());
    double energy = 0.0;
    for (const ResidualBlock& block : blocks) {
      if (block.segment != s) continue;
      const auto rows = moves.middleRows(block.first, block.count);
      const auto part = missed.segment(block.first, block.count);
      normal += rows.transpose() * rows;
      slope += rows.transpose() * part;
      energy += part.squaredNorm();
    }
    const double left = energy - slope.dot(normal.ldlt().solve(slope));
    out.push_back(std::isfinite(left) ? std::max(0.0, 0.5 * left) : 0.0);
  }
  return out;
}

/// The rivals of one finding, re-identified in its place.
struct Contest {
  std::vector<std::string> names;
  std::vector<CurrentModel> models;

  /// For each segment of `motions` the evidence against its hardest rival, and which that is.
  std::vector<std::pair<double, std::size_t>> hardest(const FitContext& context, const Experiment& motions) const {
    std::vector<std::pair<double, std::size_t>> out(motions.segments.size(), {HUGE_VAL, 0});
    for (std::size_t r = 0; r < models.size(); ++r) {
      const std::vector<double> against = evidence_against(models[r], context, motions);
      for (std::size_t s = 0; s < out.size(); ++s) out[s] = std::min(out[s], {against[s], r});
    }
    return out;
  }
};

/// The motion whose hardest rival is easiest, by a small evolution of drawn ones.
std::optional<Separation> best_motion(const SeparatingMotions& designer, const Contest& contest,
                                      const FitContext& context, std::uint64_t seed) {
  std::vector<Course> all;
  for (int generation = 0; generation < kDesignGenerations; ++generation) {
    std::vector<Course> next = generation == 0 ? designer.drawn(seed) : designer.children(all, seed, generation);
    designer.weaken(next);
    std::erase_if(next, [](const Course& c) { return c.commands.time.empty(); });
    if (!next.empty()) {
      std::vector<CommandTrack> tracks;
      for (const Course& course : next) tracks.push_back(course.commands);
      const auto worth = contest.hardest(context, designer.recorded(tracks));
      for (std::size_t k = 0; k < next.size(); ++k) std::tie(next[k].evidence, next[k].hardest) = worth[k];
    }
    std::move(next.begin(), next.end(), std::back_inserter(all));
    std::stable_sort(all.begin(), all.end(), [](const Course& a, const Course& b) { return a.evidence > b.evidence; });
  }
  const double repeat = contest.hardest(context, designer.recorded({designer.own_commands()}))[0].first;
  if (all.empty()) return std::nullopt;
  return Separation{all.front().commands, contest.names[all.front().hardest], all.front().evidence, repeat};
}

}  // namespace

void separate(std::vector<Finding>& findings, const CurrentModel& plain, const CurrentModel& current,
              const FitContext& context, std::uint64_t seed) {
  const bool merged =
      std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.members.size() > 1; });
  if (!merged || std::holds_alternative<InverseDynamics>(context.experiment.prediction)) return;
  const SeparatingMotions designer(current, context);
  if (!designer.anything_driven()) return;
  for (std::size_t k = 0; k < findings.size(); ++k) {
    Contest contest;
    for (const Rival& rival : findings[k].rivals) {
      const auto& members = findings[k].members;
      if (rival.place != findings[k].place || std::find(members.begin(), members.end(), rival.effect) == members.end())
        continue;
      auto model = exchanged(k, rival, plain, current, findings, context);
      if (!model) continue;
      contest.names.push_back(rival.effect);
      contest.models.push_back(std::move(*model));
    }
    if (!contest.names.empty()) findings[k].separation = best_motion(designer, contest, context, seed + k);
  }
}

}  // namespace lacuna
