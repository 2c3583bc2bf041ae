#include "compare/conservation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/engine.h"

namespace lacuna {
namespace {

constexpr double kDefaultErp = 0.2;  // of an ODE world that nobody changed

}  // namespace

double energy_drift(const Motion& motion, const Trajectory& run) {
  const auto dynamics = build_engine("featherstone", motion);
  double change = 0.0, kinetic = 0.0, start = 0.0;
  for (std::size_t k = 0; k < run.q.size(); ++k) {
    const Energy energy = dynamics->energy(run.q[k], run.v[k]);
    if (k == 0) start = energy.total();
    change = worse(change, std::fabs(energy.total() - start));
    kinetic = worse(kinetic, energy.kinetic);
  }
  const double drift = change / kinetic;
  return std::isfinite(drift) ? drift : HUGE_VAL;
}

double momentum_drift(const Motion& motion, const Trajectory& run) {
  const auto dynamics = build_engine("featherstone", motion);
  double change = 0.0, size = 0.0, start = 0.0;
  Eigen::MatrixXd mass;
  for (std::size_t k = 0; k < run.q.size(); ++k) {
    dynamics->mass_matrix(run.q[k], mass);
    double momentum = 0.0, parts = 0.0;
    for (Eigen::Index j = 0; j < mass.cols(); ++j) {
      const double part = mass(0, j) * run.v[k][j];
      momentum += part;
      parts += std::fabs(part);
    }
    if (k == 0) start = momentum;
    change = worse(change, std::fabs(momentum - start));
    size = worse(size, parts);
  }
  const double drift = change / size;
  return std::isfinite(drift) ? drift : HUGE_VAL;
}

std::vector<JointDrift> joint_drift(const std::string& engine, const Motion& motion, double step) {
  std::vector<JointDrift> out;
  const auto dynamics = build_engine(engine, motion);
  const Segment& segment = motion.phases.front().segment;
  const int steps = static_cast<int>(std::lround(motion.duration() / step));
  for (const double correction : {0.0, kDefaultErp}) {
    const auto gap = dynamics->native_joint_gap(segment.q0, segment.v0, step, steps, correction);
    if (!gap) return {};
    out.push_back({fmt::format("correction (ERP) {}{}", correction, correction == kDefaultErp ? ", the default" : ""),
                   gap->distance, gap->angle});
  }
  return out;
}

}  // namespace lacuna
