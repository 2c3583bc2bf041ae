#include "diagnosis/worth.h"

namespace lacuna {

double Worth::chance(int tries) const {
  return heldout ? lacuna::chance(train.log_likelihood, parameters, *heldout, tries)
                 : lacuna::chance(train.log_likelihood, parameters, tries);
}

Worth worth_over(const CurrentModel& with, const CurrentModel& without, const FitContext& context) {
  const std::vector<int> train = context.experiment.with_role(Role::train),
                         validate = context.experiment.with_role(Role::validate);
  Problem more = problem_of(with, context);
  Problem less = problem_of(without, context, with.weights);
  Worth out;
  out.parameters = static_cast<int>(with.space.size() - without.space.size());
  out.train = residual_gain(without.fit.residual, more.residual(with.fit.point, train), more.layout(train));
  if (validate.empty()) return out;
  const Eigen::VectorXd before = less.residual(without.fit.point, validate);
  const Eigen::VectorXd after = more.residual(with.fit.point, validate);
  Eigen::MatrixXd spread;
  if (before.allFinite() && without.space.size() > 0)
    spread =
        prediction_spread(without.fit.jacobian, without.fit.residual, less.layout(train),
                          less.jacobian(without.fit.point, before, validate), least_curvatures(without.space.axes()));
  out.heldout = heldout_gain(before, after, more.layout(validate), spread);
  return out;
}

}  // namespace lacuna
