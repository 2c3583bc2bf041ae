// Nonlinear least squares within bounds: projected Levenberg-Marquardt, finished by Ceres; Jacobians by one population
// call.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ga/problem.h"

namespace lacuna {

struct LeastSquaresOptions {
  int iterations = 50;
  double tolerance = 1e-9;  ///< relative change of the cost at which it stops, if that is over .05 of chi-square
  bool polish = true;       ///< Ceres takes the coordinates off their bounds to the bottom
  const Eigen::MatrixXd* jacobian = nullptr;  ///< at the start, if it is known
  bool nearby = false;                        ///< that Jacobian is of a point or an integration step close by
  RunControl control;
};

struct LeastSquaresResult {
  std::vector<double> point;    ///< search coordinates
  Eigen::VectorXd residual;     ///< whitened, at `point`
  Eigen::MatrixXd jacobian;     ///< at `point`
  double sum_of_squares = 0.0;  ///< of the residual: the data's part of what was minimised
  double prior_cost = 0.0;      ///< the priors' part at `point`
  int iterations = 0;
  long evaluations = 0;  ///< simulations of all segments
  bool converged = false;
};

/// What brings each coordinate of a normal matrix J^T J to unit size; 0 for one without effect.
Eigen::VectorXd column_scales(const Eigen::MatrixXd& normal);

/// Curvatures below which a coordinate is as good as without effect: through its whole range all residuals together
/// change by a tenth of their weight. 0 where the range is infinite.
Eigen::VectorXd least_curvatures(std::span<const Axis> axes);

/// The step of Levenberg and Marquardt: (N + damping diag N + diag floor) x = -gradient, N normal matrix. Each column
/// is scaled by its own size first, so that units (1/k beside kg) neither damp nor drown a coordinate; one without
/// effect is left alone. `floor`: least_curvatures(), which keep a coordinate whose column is all rounding where it
/// stands.
Eigen::VectorXd damped_step(const Eigen::MatrixXd& normal, const Eigen::VectorXd& gradient, double damping,
                            const Eigen::VectorXd& floor);

/// 1 / prior^2 of each axis, what its prior adds to the diagonal of a normal matrix; 0 without a prior.
Eigen::VectorXd prior_information(std::span<const Axis> axes);
/// Sum over the axes of ((x - center) / prior)^2.
double prior_cost(std::span<const Axis> axes, std::span<const double> point);

/// Minimises |residual|^2 + prior_cost over `segments` from `start`: weights are noise, so both count in the same unit.
/// Throws WorkError when the start itself cannot be simulated, std::invalid_argument where it is no point of the
/// problem's space.
LeastSquaresResult solve_least_squares(Problem& problem, const std::vector<double>& start,
                                       std::span<const int> segments, const LeastSquaresOptions& options = {});

/// Samples' worth of independent information in a residual: sum over blocks of n / (1 + 2 sum of autocorrelations),
/// summed up to the first non-positive pair (Geyer's initial positive sequence), each block about its own mean. At most
/// the number of samples.
double effective_samples(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks);

/// What the data determine.
struct Identifiability {
  int rank = 0;                        ///< directions known better than their own size
  double condition = 0.0;              ///< of the sensitivities, columns scaled by the parameters' sizes
  Eigen::MatrixXd covariance;          ///< of the search point, priors included; see `rank` for what is infinite
  Eigen::MatrixXd by_data;             ///< the same of the data alone
  std::vector<double> relative_error;  ///< per axis: standard error by the data alone over the parameter's size
  struct Direction {
    double relative_error = 0.0;  ///< standard error along it, over its size
    std::vector<double> weights;  ///< unit vector over the axes, each scaled by its size
  };
  std::vector<Direction> undetermined;  ///< worst first
};

/// From the data's whitened Jacobian: priors narrow the covariance, but make nothing determined. `variance` is the
/// residual's variance (whitened), `samples_share` the effective share of the samples: together they scale the
/// covariance.
Identifiability identifiability(const SearchSpace& space, const std::vector<double>& point,
                                const Eigen::MatrixXd& jacobian, double variance, double samples_share);
/// The same with the sizes of the coordinates given: `sizes`, one per column, above 0; `prior`: prior_information(),
/// empty for none.
Identifiability identifiability(const Eigen::VectorXd& sizes, const Eigen::MatrixXd& jacobian, double variance,
                                double samples_share, const Eigen::VectorXd& prior = {});
/// What a coordinate's relative error is counted in: its value, or where that is near zero the width of its bounds.
double coordinate_size(double value, double lower, double upper);
/// The same of a search coordinate; a logarithm is relative by itself.
double coordinate_size(const Axis& axis, double value);

}  // namespace lacuna
