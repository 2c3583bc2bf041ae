#include "ga/least_squares.h"

#include <ceres/ceres.h>

#include <Eigen/SVD>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "scenarios/error.h"

namespace lacuna {
namespace {

/// A direction whose standard error exceeds its own size is not determined by the data.
constexpr double kUndetermined = 1.0;

/// Change of all residuals together, in weights, through the whole range of a coordinate that is as good as without
/// effect.
constexpr double kFlat = 0.1;

/// Chi-square units: a step that lowers the cost by less is below anything that statistics could see.
constexpr double kLikelihoodShare = 0.05;

/// Steps in a row that gain less than that: where the linear look promises more, it promises what rounding makes of it.
constexpr int kIdle = 2;

/// The stacked residual, and below it a row for each prior, as one Ceres cost function over one parameter block.
class ResidualCost final : public ceres::CostFunction {
 public:
  ResidualCost(Problem& problem, std::span<const int> segments, Eigen::Index rows)
      : problem_(problem), segments_(segments) {
    const auto& axes = problem.space().axes();
    for (std::size_t a = 0; a < axes.size(); ++a) {
      if (std::isfinite(axes[a].prior)) priors_.push_back(a);
    }
    set_num_residuals(static_cast<int>(rows + static_cast<Eigen::Index>(priors_.size())));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.space().size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const std::vector<double> point(parameters[0], parameters[0] + problem_.space().size());
    // Ceres knows no bounds here; beyond them a mass may be negative, which engines refuse. A failed trial shortens the
    // step.
    for (std::size_t k = 0; k < point.size(); ++k) {
      const Axis& axis = problem_.space().axes()[k];
      if (!(point[k] >= axis.lower && point[k] <= axis.upper)) return false;
    }
    if (point != last_point_) {
      last_ = problem_.residual(point, segments_);
      last_point_ = point;
      ++evaluations;
    }
    if (!last_.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, last_.size()) = last_;
    for (std::size_t k = 0; k < priors_.size(); ++k) {
      const Axis& axis = problem_.space().axes()[priors_[k]];
      residuals[last_.size() + k] = (point[priors_[k]] - axis.center) / axis.prior;
    }
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Eigen::MatrixXd J = problem_.jacobian(point, last_, segments_);
    evaluations += J.cols();
    if (!J.allFinite()) return false;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> all(jacobians[0], num_residuals(), J.cols());
    all.topRows(J.rows()) = J;
    all.bottomRows(num_residuals() - J.rows()).setZero();
    for (std::size_t k = 0; k < priors_.size(); ++k) {
      all(J.rows() + static_cast<Eigen::Index>(k), priors_[k]) = 1.0 / problem_.space().axes()[priors_[k]].prior;
    }
    return true;
  }

  mutable long evaluations = 0;

 private:
  Problem& problem_;
  std::span<const int> segments_;
  std::vector<std::size_t> priors_;  ///< axes that have one
  mutable std::vector<double> last_point_;
  mutable Eigen::VectorXd last_;
};

/// Start pulled a hair inside the bounds: Ceres needs a feasible point.
std::vector<double> within_bounds(const SearchSpace& space, std::vector<double> point) {
  for (std::size_t a = 0; a < point.size(); ++a) {
    point[a] = std::clamp(point[a], space.axes()[a].lower, space.axes()[a].upper);
  }
  return point;
}

/// A value over its start value: motion equations are linear in gains, dampings, springs and masses, so the valleys
/// that data leave open are straight in the values, and curved in their logarithms.
bool is_ratio(const Axis& axis) { return axis.coordinate == Coordinate::logarithm && std::isfinite(axis.prior); }

/// Where a step along the axis ends: a ratio's value moves linearly as long as it is not halved.
double moved(const Axis& axis, double x, double step) {
  if (!is_ratio(axis)) return x + step;
  return x + (step > -0.5 ? std::log1p(step) : std::log(0.5) + step + 0.5);
}

/// Levenberg-Marquardt with projection: coordinates at a bound whose descent points outwards are held, the rest step
/// freely and are cut at their bounds. (Ceres' own bounded search takes several times the simulations here: its line
/// search asks for a Jacobian at every trial.) A Jacobian costs as many simulations as there are coordinates; so after
/// a step that did what it promised the old one is kept, with Broyden's rank-one update in the units of its columns,
/// and only the end is checked with a new one. Where a step does not, coarser dampings are tried in one call. Source:
/// C. G. Broyden, Math. Comp. 19 (1965).
class ProjectedDescent {
 public:
  /// From result.point, where `residual` stands.
  ProjectedDescent(Problem& problem, std::span<const int> segments, const LeastSquaresOptions& options,
                   Eigen::VectorXd residual, LeastSquaresResult& result)
      : problem_(problem),
        segments_(segments),
        result_(result),
        axes_(problem.space().axes()),
        floor_(least_curvatures(axes_)),
        prior_(prior_information(axes_)),
        residual_(std::move(residual)) {
    if (options.jacobian != nullptr) {
      jacobian_ = *options.jacobian;
      normal_ = squared(jacobian_);
      state_ = options.nearby ? State::updated : State::exact;
    }
  }

  /// One step, with as many trials as it takes; the share of the cost that it gained.
  double iterate() {
    if (state_ == State::doubtful && !renew()) return 0.0;
    const double cost = cost_of(residual_, result_.point);
    for (int tried = 0; tried < kDampings;) {
      const std::vector<std::vector<double>> fan = steps();
      if (const std::optional<Trial> best = best_of(fan, cost)) {
        damping_ = std::max(0.1 * damping_ * std::pow(kCoarser, static_cast<double>(best->at)), 1e-12);
        accept(fan[best->at], best->residual);
        return (cost - best->cost) / cost;
      }
      if (state_ != State::exact) {
        if (!renew()) return 0.0;
      } else {
        damping_ *= std::pow(kCoarser, static_cast<double>(fan.size()));
        tried += static_cast<int>(fan.size());
      }
    }
    return 0.0;
  }

  /// Whether a new Jacobian, too, promises no more than `tolerance` of the cost. The step asked is not damped: a
  /// combination that the data hardly determine may have far to go, of which a damped one would go a hair.
  bool at_the_bottom(double tolerance) {
    if (state_ != State::exact && !renew()) return true;
    const double undamped[] = {0.0};
    if (promise_of(way_to(ends(undamped).front())) <= tolerance * cost_of(residual_, result_.point)) return true;
    damping_ *= kFreer;
    return false;
  }

  const Eigen::VectorXd& residual() const { return residual_; }
  /// At result.point, once the bottom has been asked for.
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

 private:
  static constexpr int kDampings = 8;      ///< tried before it gives up
  static constexpr double kCoarser = 8.0;  ///< one over the next
  static constexpr double kFloor = 1e-13;  ///< damping that a singular matrix needs
  static constexpr double kFreer = 1e-3;   ///< where an undamped step has more to gain; coarser ones are still tried
  /// Of what a step promised: less, and other dampings are asked, and the next one begins with a new Jacobian.
  static constexpr double kKept = 0.5;
  enum class State { doubtful, updated, exact };
  struct Trial {
    std::size_t at;  ///< in the fan
    double cost;
    Eigen::VectorXd residual;
  };

  /// The one that costs least, if that is under `cost`. Where the first keeps its promise, nothing is gained by asking
  /// the others, which together cost as many passes of the lanes as several steps.
  std::optional<Trial> best_of(const std::vector<std::vector<double>>& fan, double cost) {
    std::optional<Trial> best;
    const auto ask = [&](std::size_t first, std::size_t count) {
      std::vector<Eigen::VectorXd> moved = problem_.residuals(std::span(fan).subspan(first, count), segments_);
      result_.evaluations += static_cast<long>(count);
      for (std::size_t k = 0; k < count; ++k) {
        const double sum = moved[k].allFinite() ? cost_of(moved[k], fan[first + k]) : HUGE_VAL;
        if (sum < (best ? best->cost : cost)) best = Trial{first + k, sum, std::move(moved[k])};
      }
    };
    ask(0, 1);
    const bool kept = best && cost - best->cost > kKept * promise_of(way_to(fan.front()));
    if (!kept && fan.size() > 1) ask(1, fan.size() - 1);
    return best;
  }

  bool renew() {
    jacobian_ = problem_.jacobian(result_.point, residual_, segments_);
    result_.evaluations += jacobian_.cols();
    normal_ = squared(jacobian_);
    state_ = State::exact;
    return normal_.allFinite();
  }

  static Eigen::MatrixXd squared(const Eigen::MatrixXd& rows) {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows.cols(), rows.cols());
    out.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
    return out.selfadjointView<Eigen::Lower>();
  }

  /// What is minimised: the data's part and the priors'.
  double cost_of(const Eigen::VectorXd& residual, const std::vector<double>& point) const {
    return residual.squaredNorm() + prior_cost(axes_, point);
  }

  /// Half of that cost's gradient at the present point.
  Eigen::VectorXd gradient() const {
    Eigen::VectorXd out = jacobian_.transpose() * residual_;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const Eigen::Index i = a;
      out(i) += prior_(i) * (result_.point[a] - axes_[a].center);
    }
    return out;
  }

  /// How far the linear look expects the cost to fall along `way`.
  double promise_of(const Eigen::VectorXd& way) const {
    return -way.dot(2.0 * gradient() + normal_ * way + prior_.cwiseProduct(way));
  }

  /// The step to `next` as the linear look sees it.
  Eigen::VectorXd way_to(const std::vector<double>& next) const {
    Eigen::VectorXd way(next.size());
    for (std::size_t a = 0; a < next.size(); ++a) {
      const double change = next[a] - result_.point[a];
      way(a) = is_ratio(axes_[a]) ? std::expm1(change) : change;
    }
    return way;
  }

  void accept(const std::vector<double>& next, const Eigen::VectorXd& moved) {
    const Eigen::VectorXd way = way_to(next), expected = residual_ + jacobian_ * way;
    const double cost = cost_of(residual_, result_.point), promised = cost - cost_of(expected, next);
    const bool kept_its_word = cost - cost_of(moved, next) > kKept * promised;
    state_ = kept_its_word ? State::updated : State::doubtful;
    const Eigen::VectorXd weighed = normal_.diagonal().cwiseProduct(way);
    if (const double length = weighed.dot(way); length > 0.0) update(moved - expected, weighed / length);
    transport(next);
    result_.point = next;
    residual_ = moved;
  }

  /// Sensitivities to relative changes grow with the values.
  void transport(const std::vector<double>& next) {
    Eigen::VectorXd growth = Eigen::VectorXd::Ones(next.size());
    for (std::size_t a = 0; a < next.size(); ++a)
      if (is_ratio(axes_[a])) growth(a) = std::exp(next[a] - result_.point[a]);
    jacobian_ = jacobian_ * growth.asDiagonal();
    normal_ = growth.asDiagonal() * normal_ * growth.asDiagonal();
  }

  /// J += a b^T, and J^T J with it.
  void update(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const Eigen::VectorXd along = jacobian_.transpose() * a;
    normal_ += along * b.transpose() + b * along.transpose() + a.squaredNorm() * b * b.transpose();
    jacobian_.noalias() += a * b.transpose();
  }

  /// Where the step ends at the present damping and at coarser ones.
  std::vector<std::vector<double>> steps() const {
    std::vector<double> dampings(fan(), damping_);
    for (std::size_t k = 1; k < dampings.size(); ++k) dampings[k] = kCoarser * dampings[k - 1];
    return ends(dampings);
  }

  /// Where steps at these dampings end.
  std::vector<std::vector<double>> ends(std::span<const double> dampings) const {
    const Eigen::VectorXd slope = gradient();
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < slope.size(); ++i) {
      const bool stuck = (result_.point[i] <= axes_[i].lower && slope(i) > 0.0) ||
                         (result_.point[i] >= axes_[i].upper && slope(i) < 0.0);
      if (!stuck) free.push_back(i);
    }
    if (free.empty()) return {result_.point};
    Eigen::MatrixXd normal = normal_(free, free);
    normal.diagonal() += prior_(free);
    std::vector<std::vector<double>> out;
    for (const double damping : dampings) {
      const Eigen::VectorXd delta = damped_step(normal, slope(free), damping + kFloor, floor_(free));
      std::vector<double>& next = out.emplace_back(result_.point);
      for (std::size_t k = 0; k < free.size(); ++k) {
        const std::size_t a = free[k];
        next[a] = std::clamp(moved(axes_[a], next[a], delta(k)), axes_[a].lower, axes_[a].upper);
      }
    }
    return out;
  }

  /// Dampings that a step has a choice of: all where so few segments leave lanes idle, two where they fill them.
  std::size_t fan() const {
    const std::size_t lanes = problem_.simulator().lanes();
    if (lanes == 1) return 1;
    return segments_.size() < lanes ? kDampings : 2;
  }

  Problem& problem_;
  std::span<const int> segments_;
  LeastSquaresResult& result_;
  const std::vector<Axis>& axes_;
  Eigen::VectorXd floor_, prior_;
  Eigen::VectorXd residual_;
  Eigen::MatrixXd jacobian_, normal_;  ///< normal_: J^T J
  State state_ = State::doubtful;
  double damping_ = 1e-4;
};

/// Leaves point, residual and Jacobian of the end in `result`.
void descend(Problem& problem, std::span<const int> segments, const LeastSquaresOptions& options,
             Eigen::VectorXd residual, LeastSquaresResult& result) {
  ProjectedDescent descent(problem, segments, options, std::move(residual), result);
  const Eigen::Index rows = problem.layout(segments).back().first + problem.layout(segments).back().count;
  const double least = kLikelihoodShare / static_cast<double>(rows), tolerance = std::max(options.tolerance, least);
  int idle = 0;
  for (result.iterations = 0; !result.converged && result.iterations < options.iterations; ++result.iterations) {
    const RunControl& control = options.control;
    if (control.stop != nullptr && *control.stop) throw Interrupted();
    if (control.progress) {
      control.progress({"least squares", static_cast<double>(result.iterations) / options.iterations, 0.0, 0});
    }
    const double gained = descent.iterate();
    idle = gained > least ? 0 : idle + 1;
    result.converged = gained <= tolerance && (descent.at_the_bottom(tolerance) || idle == kIdle);
  }
  descent.at_the_bottom(tolerance);
  result.residual = descent.residual();
  result.jacobian = descent.jacobian();
}

/// Ceres takes the coordinates that are off their bounds to the bottom; the others are held by its manifold.
void polish(Problem& problem, std::span<const int> segments, Eigen::Index rows, LeastSquaresResult& result) {
  std::vector<double> point = result.point;
  std::vector<int> held;
  for (std::size_t a = 0; a < point.size(); ++a) {
    const Axis& axis = problem.space().axes()[a];
    const double margin = 1e-6 * std::min(axis.upper - axis.lower, std::fabs(point[a]) + 1e-12);
    if (point[a] <= axis.lower + margin || point[a] >= axis.upper - margin) held.push_back(static_cast<int>(a));
  }
  if (held.size() == point.size()) return;
  ceres::Problem solver;
  auto* cost = new ResidualCost(problem, segments, rows);  // owned by `solver`
  solver.AddResidualBlock(cost, nullptr, point.data());
  if (!held.empty()) {
    solver.SetManifold(point.data(), new ceres::SubsetManifold(static_cast<int>(point.size()), held));
  }
  ceres::Solver::Options settings;
  settings.max_num_iterations = 2;
  settings.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  settings.function_tolerance = kLikelihoodShare / static_cast<double>(rows);
  settings.initial_trust_region_radius = 1e8;
  settings.num_threads = 1;
  settings.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(settings, &solver, &summary);
  result.evaluations += cost->evaluations;
  for (std::size_t a = 0; a < point.size(); ++a) {
    const Axis& axis = problem.space().axes()[a];
    if (point[a] < axis.lower || point[a] > axis.upper) return;  // it left the box: the descent's answer stands
  }
  if (summary.IsSolutionUsable() && summary.final_cost <= summary.initial_cost) result.point = point;
}

}  // namespace

Eigen::VectorXd column_scales(const Eigen::MatrixXd& normal) {
  return normal.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
}

Eigen::VectorXd least_curvatures(std::span<const Axis> axes) {
  Eigen::VectorXd out(axes.size());
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const double range = axes[a].upper - axes[a].lower;
    out(a) = range > 0.0 ? std::pow(kFlat / range, 2) : 0.0;
  }
  return out;
}

Eigen::VectorXd prior_information(std::span<const Axis> axes) {
  Eigen::VectorXd out(axes.size());
  for (std::size_t a = 0; a < axes.size(); ++a) out(a) = std::pow(axes[a].prior, -2);
  return out;
}

double prior_cost(std::span<const Axis> axes, std::span<const double> point) {
  double sum = 0.0;
  for (std::size_t a = 0; a < axes.size(); ++a) sum += std::pow((point[a] - axes[a].center) / axes[a].prior, 2);
  return sum;
}

Eigen::VectorXd damped_step(const Eigen::MatrixXd& normal, const Eigen::VectorXd& gradient, double damping,
                            const Eigen::VectorXd& floor) {
  const Eigen::VectorXd scale = column_scales(normal);
  Eigen::MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
  unit.diagonal() = scale.cwiseAbs2().cwiseProduct(floor).array() + (1.0 + damping);
  return scale.cwiseProduct(unit.ldlt().solve(-scale.cwiseProduct(gradient)));
}

LeastSquaresResult solve_least_squares(Problem& problem, const std::vector<double>& start,
                                       std::span<const int> segments, const LeastSquaresOptions& options) {
  if (start.size() != problem.space().size())
    throw std::invalid_argument("least squares from a point of another search space");
  LeastSquaresResult result;
  result.point = within_bounds(problem.space(), start);
  const auto blocks = problem.layout(segments);
  const Eigen::Index rows = blocks.empty() ? 0 : blocks.back().first + blocks.back().count;
  Eigen::VectorXd residual = problem.residual(result.point, segments);
  if (!residual.allFinite()) {
    throw WorkError("the simulation diverges at the start values: no least-squares fit can begin there");
  }
  if (problem.space().size() > 0) descend(problem, segments, options, std::move(residual), result);
  const std::vector<double> descended = result.point;
  if (problem.space().size() > 0 && options.polish) polish(problem, segments, rows, result);
  if (problem.space().size() == 0 || result.point != descended) {
    result.residual = problem.residual(result.point, segments);
    result.jacobian = problem.jacobian(result.point, result.residual, segments);
  }
  result.sum_of_squares = result.residual.squaredNorm();
  result.prior_cost = prior_cost(problem.space().axes(), result.point);
  return result;
}

double effective_samples(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks) {
  double total = 0.0;
  for (const ResidualBlock& block : blocks) {
    const Eigen::Index n = block.count;
    if (n < 8) {
      total += static_cast<double>(n);
      continue;
    }
    const Eigen::VectorXd r = residual.segment(block.first, n).array() - residual.segment(block.first, n).mean();
    const double variance = r.squaredNorm() / static_cast<double>(n);
    if (!(variance > 0.0)) {
      total += static_cast<double>(n);
      continue;
    }
    auto correlation = [&](Eigen::Index lag) {
      return r.head(n - lag).dot(r.tail(n - lag)) / (static_cast<double>(n) * variance);
    };
    double sum = 1.0;
    for (Eigen::Index lag = 1; lag + 1 < n / 2; lag += 2) {
      const double pair = correlation(lag) + correlation(lag + 1);
      if (pair <= 0.0) break;
      sum += 2.0 * pair;
    }
    total += std::min(static_cast<double>(n), static_cast<double>(n) / sum);
  }
  return std::max(total, 1.0);
}

double coordinate_size(double value, double lower, double upper) {
  const double size = std::fabs(value), range = upper - lower;
  return size > 1e-3 * range || !std::isfinite(range) ? std::max(size, 1e-12) : range;
}

double coordinate_size(const Axis& axis, double value) {
  return axis.coordinate == Coordinate::logarithm ? 1.0 : coordinate_size(value, axis.lower, axis.upper);
}

namespace {

/// Covariance, in units of `sizes`, of what data of variance `scale` and priors know together.
Eigen::MatrixXd posterior(const Eigen::MatrixXd& scaled, const Eigen::VectorXd& sizes, double scale,
                          const Eigen::VectorXd& prior) {
  Eigen::MatrixXd known = scaled.transpose() * scaled / scale;
  known.diagonal() += sizes.cwiseAbs2().cwiseProduct(prior);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(known);
  const double least = 1e-15 * std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(least).cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

Identifiability identifiability(const SearchSpace& space, const std::vector<double>& point,
                                const Eigen::MatrixXd& jacobian, double variance, double samples_share) {
  Eigen::VectorXd sizes(jacobian.cols());
  for (std::size_t a = 0; a < space.size(); ++a) sizes(a) = coordinate_size(space.axes()[a], point[a]);
  return identifiability(sizes, jacobian, variance, samples_share, prior_information(space.axes()));
}

Identifiability identifiability(const Eigen::VectorXd& sizes, const Eigen::MatrixXd& jacobian, double variance,
                                double samples_share, const Eigen::VectorXd& prior) {
  Identifiability out;
  const Eigen::Index n = jacobian.cols();
  if (n == 0) return out;
  const Eigen::MatrixXd scaled = jacobian * sizes.asDiagonal();
  // The normal matrix has the singular values squared; sizes are scaled, so double precision resolves what matters.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() * scaled);
  const double scale = variance / std::max(samples_share, 1e-12);
  const double largest = std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double value = std::max(eigen.eigenvalues()(k), 1e-15 * largest);
    const double error = std::sqrt(scale / value);
    const Eigen::VectorXd direction = eigen.eigenvectors().col(k);
    covariance += error * error * direction * direction.transpose();
    if (error < kUndetermined) {
      ++out.rank;
    } else {
      out.undetermined.push_back({error, {direction.data(), direction.data() + n}});
    }
  }
  out.condition = std::sqrt(largest / std::max(eigen.eigenvalues().minCoeff(), 1e-15 * largest));
  for (Eigen::Index a = 0; a < n; ++a) out.relative_error.push_back(std::sqrt(covariance(a, a)));
  out.by_data = sizes.asDiagonal() * covariance * sizes.asDiagonal();
  if (prior.size() == n && prior.maxCoeff() > 0.0) covariance = posterior(scaled, sizes, scale, prior);
  out.covariance = sizes.asDiagonal() * covariance * sizes.asDiagonal();
  return out;
}

}  // namespace lacuna
