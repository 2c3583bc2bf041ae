#include "diagnosis/idim.h"

#include <Eigen/QR>
#include <cmath>

#include "backends/engine.h"
#include "physics/quantity.h"

namespace lacuna {
namespace {

constexpr int kOfLink = 10, kOfJoint = 4;  // numbers
constexpr double kRank = 1e-6;             // of the largest column: what is less is a combination of others
constexpr int kReweightings = 2;

/// First moments and inertia about the body's origin moved by one number; the engine takes those about its centre.
Inertial moved(const Inertial& body, int number, double by) {
  Eigen::Vector3d moment = body.mass * body.com;
  const auto about = [](const Eigen::Vector3d& c) -> Eigen::Matrix3d {
    return c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose();
  };
  Eigen::Matrix3d origin = body.inertia + body.mass * about(body.com);
  double mass = body.mass;
  static constexpr int kRow[] = {0, 0, 0, 1, 1, 2}, kColumn[] = {0, 1, 2, 1, 2, 2};
  if (number == 0) {
    mass += by;
  } else if (number <= 3) {
    moment(number - 1) += by;
  } else {
    const int i = kRow[number - 4], j = kColumn[number - 4];
    origin(i, j) += by;
    if (i != j) origin(j, i) += by;
  }
  const Eigen::Vector3d com = moment / mass;
  return {mass, com, origin - mass * about(com)};
}

/// What one unit of a number is tried with: about a link's own size.
double unit_of(const Inertial& body, int number) {
  const double reach = std::max(body.com.norm(), 0.1);
  return number == 0 ? body.mass : number <= 3 ? body.mass * reach : body.mass * reach * reach;
}

/// Columns of one segment before the filter: [joint](sample, column).
std::vector<Eigen::MatrixXd> columns_of(const PlantModel& model, const Segment& segment) {
  const int n = model.dof();
  const MeasuredMotion& m = *segment.motion;
  const auto samples = static_cast<Eigen::Index>(m.samples());
  std::vector<Eigen::MatrixXd> out(n, Eigen::MatrixXd::Zero(samples, n * (kOfLink + kOfJoint)));
  const std::unique_ptr<Dynamics> dynamics = find_engine("featherstone").build(model.robot_ptr(), model.gravity());
  const std::size_t size = n;
  std::vector<double> q(size), v(size), a(size), tau(size);
  Eigen::MatrixXd plain(n, samples);
  const auto pass = [&](const auto& take) {
    for (Eigen::Index k = 0; k < samples; ++k) {
      for (std::size_t j = 0; j < size; ++j) {
        q[j] = m.q[j][k], v[j] = m.v[j][k], a[j] = m.a[j][k];
      }
      dynamics->inverse_dynamics(q, v, a, tau);
      take(k);
    }
  };
  pass([&](Eigen::Index k) { plain.col(k) = Eigen::Map<const Eigen::VectorXd>(tau.data(), n); });
  for (int body = 0; body < n; ++body) {
    const Inertial own = model.robot().body_inertial(body);
    for (int number = 0; number < kOfLink; ++number) {
      const double unit = unit_of(own, number);
      dynamics->set_inertial(body, moved(own, number, unit));
      pass([&](Eigen::Index k) {
        for (int j = 0; j < n; ++j) out[j](k, body * kOfLink + number) = (tau[j] - plain(j, k)) / unit;
      });
    }
    dynamics->set_inertial(body, own);
  }
  for (int j = 0; j < n; ++j) {
    auto own = out[j].middleCols(n * kOfLink + j * kOfJoint, kOfJoint);
    for (Eigen::Index k = 0; k < samples; ++k) {
      own.row(k) << m.v[j][k], m.direction[j][k], 1.0, m.a[j][k];
    }
  }
  return out;
}

struct Rows {
  Eigen::MatrixXd columns;
  Eigen::VectorXd measured;
  std::vector<ResidualBlock> blocks;  ///< one a channel and segment
};

/// Effort per unit of a compared channel; 0: the command is no effort.
double effort_per_unit(const PlantModel& model, const Channel& channel) {
  if (channel.kind == ChannelKind::effort) return 1.0;
  const Component& c = model.actuators()[channel.joint];
  if (c.type < 0) return 1.0;  // passive: an effort of 0
  const ActuatorInfo& info = actuator_table()[c.type];
  if (info.input != Stage::effort || info.roles.gain < 0) return 0.0;
  return model.parameters()[c.first + info.roles.gain].value;
}

std::vector<std::size_t> effort_channels(const Experiment& experiment) {
  std::vector<std::size_t> out;
  for (std::size_t c = 0; c < experiment.channels.size(); ++c)
    if (is_leading(experiment, c)) out.push_back(c);
  return out;
}

Rows rows_of(const PlantModel& model, const Experiment& experiment, Role role) {
  const double cutoff = std::get<InverseDynamics>(experiment.prediction).cutoff_hz;
  const std::vector<int> segments = experiment.with_role(role);
  const std::vector<std::size_t> channels = effort_channels(experiment);
  Eigen::Index count = 0;
  Rows out;
  for (const int s : segments)
    for (const std::size_t c : channels) {
      const auto n = static_cast<Eigen::Index>(experiment.segments[s].compared.size());
      out.blocks.push_back({s, static_cast<int>(c), count, n});
      count += n;
    }
  out.columns.resize(count, model.dof() * (kOfLink + kOfJoint));
  out.measured.resize(count);
  std::size_t block = 0;
  for (const int s : segments) {
    const Segment& segment = experiment.segments[s];
    const ZeroPhaseLowPass filter(cutoff, segment.motion->rate);
    const std::vector<Eigen::MatrixXd> raw = columns_of(model, segment);
    for (const std::size_t c : channels) {
      const Channel& channel = experiment.channels[c];
      const Eigen::MatrixXd& of_joint = raw[channel.joint];
      const double unit = effort_per_unit(model, channel);
      const Eigen::Index first = out.blocks[block++].first;
      for (Eigen::Index column = 0; column < of_joint.cols(); ++column) {
        std::vector<double> signal(of_joint.col(column).data(), of_joint.col(column).data() + of_joint.rows());
        filter.apply(signal);
        for (std::size_t k = 0; k < segment.compared.size(); ++k)
          out.columns(first + static_cast<Eigen::Index>(k), column) = signal[segment.compared[k]] / unit;
      }
      for (std::size_t k = 0; k < segment.compared.size(); ++k)
        out.measured(first + static_cast<Eigen::Index>(k)) = segment.measured[c][k];
    }
  }
  return out;
}

/// rms of measured minus predicted by channel; missing samples left out.
std::vector<double> rms_of(const Rows& rows, const Eigen::VectorXd& x, std::size_t channels) {
  std::vector<double> sum(channels, 0.0), n = sum;
  const Eigen::VectorXd rest = rows.columns * x - rows.measured;
  for (const ResidualBlock& b : rows.blocks)
    for (Eigen::Index k = b.first; k < b.first + b.count; ++k) {
      if (!std::isfinite(rest(k))) continue;
      sum[b.channel] += rest(k) * rest(k);
      n[b.channel] += 1.0;
    }
  for (std::size_t c = 0; c < channels; ++c) sum[c] = n[c] > 0.0 ? std::sqrt(sum[c] / n[c]) : std::nan("");
  return sum;
}

/// Weighed rows; those of missing samples are zero.
Eigen::VectorXd solve(const Rows& rows, const std::vector<double>& weights, int& rank) {
  Eigen::MatrixXd A = rows.columns;
  Eigen::VectorXd b = rows.measured;
  for (const ResidualBlock& block : rows.blocks)
    for (Eigen::Index k = block.first; k < block.first + block.count; ++k) {
      const double w = std::isfinite(b(k)) ? 1.0 / weights[block.channel] : 0.0;
      A.row(k) *= w;
      b(k) = w > 0.0 ? w * b(k) : 0.0;
    }
  const Eigen::VectorXd size = A.colwise().norm().transpose().cwiseMax(1e-300);
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr;
  qr.setThreshold(kRank);
  qr.compute(A * size.cwiseInverse().asDiagonal());
  rank = static_cast<int>(qr.rank());
  return size.cwiseInverse().cwiseProduct(qr.solve(b));
}

}  // namespace

std::optional<Idim> regress_base_parameters(const PlantModel& model, const Experiment& experiment) {
  if (!std::holds_alternative<InverseDynamics>(experiment.prediction)) return std::nullopt;
  for (const std::size_t c : effort_channels(experiment))
    if (effort_per_unit(model, experiment.channels[c]) == 0.0) return std::nullopt;
  const Rows train = rows_of(model, experiment, Role::train);
  if (train.measured.size() < train.columns.cols()) return std::nullopt;
  Idim out;
  std::vector<double> weights(experiment.channels.size(), 1.0);
  Eigen::VectorXd x;
  for (int k = 0; k < kReweightings; ++k) {
    x = solve(train, weights, out.rank);
    weights = rms_of(train, x, weights.size());
    for (double& w : weights) w = w > 0.0 ? w : 1.0;
  }
  out.columns = static_cast<int>(train.columns.cols());
  for (int j = 0; j < model.dof(); ++j) {
    const Eigen::Index first = model.dof() * kOfLink + j * kOfJoint;
    out.joints.push_back({experiment.joint_names[j], x(first), x(first + 1), x(first + 2), x(first + 3)});
  }
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    const std::vector<double> rms =
        rms_of(role == Role::train ? train : rows_of(model, experiment, role), x, weights.size());
    JointRms named;
    for (const std::size_t c : effort_channels(experiment))
      named.emplace_back(experiment.joint_names[experiment.channels[c].joint], rms[c]);
    out.rms.emplace_back(role, std::move(named));
  }
  return out;
}

}  // namespace lacuna
