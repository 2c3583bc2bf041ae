// What a law that may be learned does to the residual, to first order: one column for each of its values.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/learnable.h"
#include "diagnosis/linear_look.h"

namespace lacuna {

class LawColumns {
 public:
  /// Along the present motion of `now` on `segments`, about which `look` is. All of these must outlive it.
  LawColumns(const LinearLook& look, const CurrentModel& now, const Experiment& experiment,
             const std::vector<int>& segments)
      : look_(look), now_(now), experiment_(experiment), segments_(segments) {}

  /// First and last knot at the ends of the range of a joint's variable; false where it stands still.
  bool cover(int joint, Learnable::Variable& variable) const;

  /// Changes of the whitened residual, a column a value. A law on a command that stands in the model must have the
  /// knots that it has there.
  Eigen::MatrixXd changes(const Learnable& law) const;

 private:
  /// Of the `at`-th segment: a variable's values in every interval.
  std::vector<double> course(std::size_t at, int joint, const Learnable::Variable& variable) const;
  /// How much every value counts: a row a value, a column an interval (of a reading: a sample).
  Eigen::MatrixXd weights(std::size_t at, const Learnable& law) const;
  /// Under a law on the command: through valve and actuator, of which the linearised plant knows no more than the
  /// efforts that come of it.
  Eigen::MatrixXd commanded(const Learnable& law) const;

  const LinearLook& look_;
  const CurrentModel& now_;
  const Experiment& experiment_;
  const std::vector<int>& segments_;
};

}  // namespace lacuna
