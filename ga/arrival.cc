#include "ga/arrival.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ga/random.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr std::uint32_t kStartStream = 0x57a27;  ///< purpose of the draws
constexpr double kBeyondNoise = 2.0;             ///< standard deviations of a chi-square over its mean
constexpr double kSpread = 0.5;                  ///< of the draws, in standard deviations of the prior
constexpr double kLeastDamping = 1e-9;           ///< of the look beyond a bound: what is near singular stays

/// A draw about the axis' prior; without one about its start, bounds read as a prior's are: two standard deviations
/// either way, of the ratio to the start where both are of its sign.
double drawn(const Axis& axis, RandomStream& random) {
  const double z = kSpread * random.normal(), range = axis.upper - axis.lower;
  if (std::isfinite(axis.prior)) return axis.center + axis.prior * z;
  if (!std::isfinite(range)) return axis.start;
  const bool one_sign = axis.lower / axis.start > 0.0 && axis.upper / axis.start > 0.0;
  if (axis.coordinate == Coordinate::linear && one_sign)
    return axis.start * std::exp(0.25 * std::fabs(std::log(axis.upper / axis.lower)) * z);
  return axis.start + 0.25 * range * z;
}

/// A start within the bounds, from the inner half of what the priors allow: further out lie other robots, whose valleys
/// end elsewhere.
std::vector<double> drawn_start(const std::vector<Axis>& axes, std::uint64_t seed, int k) {
  RandomStream random(seed, 0, static_cast<std::uint32_t>(k), kStartStream);
  std::vector<double> point;
  for (const Axis& axis : axes) point.push_back(std::clamp(drawn(axis, random), axis.lower, axis.upper));
  return point;
}

bool at_lower(const Axis& axis, double x) { return x <= axis.lower; }
bool at_upper(const Axis& axis, double x) { return x >= axis.upper; }

/// How far the linear look expects the energy to fall with the coordinates `free` alone.
double promised(const Eigen::MatrixXd& normal, const Eigen::VectorXd& slope, const std::vector<Eigen::Index>& free,
                const Eigen::VectorXd& floor) {
  if (free.empty()) return 0.0;
  const Eigen::MatrixXd N = normal(free, free);
  const Eigen::VectorXd way = damped_step(N, slope(free), kLeastDamping, floor(free));
  return -way.dot(2.0 * slope(free) + N * way);
}

/// From an end that iterations ran out at, on to the bottom.
void follow(Problem& problem, std::span<const int> segments, const LeastSquaresOptions& options, int iterations,
            LeastSquaresResult& end, long& evaluations) {
  LeastSquaresOptions further = options;
  further.iterations = iterations;
  const Eigen::MatrixXd known = std::move(end.jacobian);
  further.jacobian = &known;
  const int before = end.iterations;
  end = solve_least_squares(problem, end.point, segments, further);
  end.iterations += before;
  evaluations += end.evaluations;
}

}  // namespace

bool down_to_noise(double sum, double n) { return sum <= n + kBeyondNoise * std::sqrt(2.0 * n); }

bool noise_is_known(const Experiment& experiment) {
  const std::vector<Channel>& channels = experiment.channels;
  return std::all_of(channels.begin(), channels.end(), [](const Channel& c) { return c.noise > 0.0; });
}

std::string pushed_against_bounds(const PlantModel& model, const SearchSpace& space,
                                  const LeastSquaresResult& solution) {
  const std::vector<Axis>& axes = space.axes();
  if (solution.jacobian.cols() != static_cast<Eigen::Index>(axes.size())) return "";
  Eigen::MatrixXd normal = solution.jacobian.transpose() * solution.jacobian;
  normal.diagonal() += prior_information(axes);
  Eigen::VectorXd slope = solution.jacobian.transpose() * solution.residual;
  std::vector<Eigen::Index> inside, all;
  std::string names;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const Eigen::Index i = a;
    const double x = solution.point[a];
    slope(i) += std::pow(axes[a].prior, -2) * (x - axes[a].center);
    const bool cut = (at_lower(axes[a], x) && slope(i) > 0.0) || (at_upper(axes[a], x) && slope(i) < 0.0);
    all.push_back(i);
    if (!cut) inside.push_back(i);
    if (cut) names += (names.empty() ? "" : ", ") + model.parameters()[axes[a].parameter].name;
  }
  const Eigen::VectorXd floor = least_curvatures(axes);
  const double gain = promised(normal, slope, all, floor) - promised(normal, slope, inside, floor);
  return gain > kSameEnd * energy(solution) ? names : "";
}

SeveralStarts from_several_starts(Problem& problem, std::span<const int> segments, std::vector<LeastSquaresResult> ends,
                                  bool noise_known, std::uint64_t seed, const LeastSquaresOptions& options,
                                  const FurtherStarts& further) {
  SeveralStarts out;
  const auto better = [](const LeastSquaresResult& a, const LeastSquaresResult& b) { return energy(a) < energy(b); };
  const auto settled = [&] {
    const auto best = std::min_element(ends.begin(), ends.end(), better);
    if (noise_known && down_to_noise(best->sum_of_squares, static_cast<double>(best->residual.size()))) return true;
    if (!best->converged) return false;
    const double most = (1.0 + kSameEnd) * energy(*best);
    return std::count_if(ends.begin(), ends.end(), [&](const auto& end) { return energy(end) <= most; }) > 1;
  };
  LeastSquaresOptions drawn = options;
  drawn.jacobian = nullptr;
  const auto follow_best = [&] {
    const auto best = std::min_element(ends.begin(), ends.end(), better);
    if (!best->converged && !settled()) follow(problem, segments, options, further.followed, *best, out.evaluations);
  };
  follow_best();
  for (int k = 0; k < further.drawn && !settled(); ++k) {
    try {
      ends.push_back(solve_least_squares(problem, drawn_start(problem.space().axes(), seed, k), segments, drawn));
      out.evaluations += ends.back().evaluations;
    } catch (const WorkError&) {
      continue;  // nothing can be simulated there
    }
    follow_best();
  }
  out.starts = static_cast<int>(ends.size());
  const bool met = out.met = settled();
  const auto best = std::min_element(ends.begin(), ends.end(), better);
  double next = HUGE_VAL;
  for (auto end = ends.begin(); end != ends.end(); ++end)
    if (end != best) next = std::min(next, energy(*end));
  const std::string pushed = pushed_against_bounds(problem.model(), problem.space(), *best);
  if (!met && !best->converged) {
    out.doubt = fmt::format("least squares did not come to an end within {} iterations", best->iterations);
  } else if (!met && !std::isfinite(next)) {
    out.doubt = "no second start could be simulated, so nothing says whether the best was reached";
  } else if (!met) {
    out.doubt = fmt::format("starts disagree: of {} descents no other came within {:.0f} % of the best ({:.3g} times)",
                            out.starts, 100.0 * kSameEnd, next / energy(*best));
  } else if (!pushed.empty()) {
    out.doubt = "gradient along a bound: the fit would be better beyond the bounds of " + pushed;
  }
  out.arrived = out.doubt.empty();
  out.best = std::move(*best);
  return out;
}

}  // namespace lacuna
