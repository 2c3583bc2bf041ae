#include "diagnosis/between_recordings.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "diagnosis/colour.h"
#include "diagnosis/evidence.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/projector.h"

namespace lacuna {
namespace {

constexpr const char* kOffset = "valve_offset";
constexpr int kSizes = 60;     ///< standard deviations that are tried,
constexpr double kSpan = 1e4;  ///< from this part of what one recording tells to so many times it

/// The present model with an offset at every commanded joint, at neutral where there was none.
CurrentModel with_offsets(const CurrentModel& current, const Experiment& experiment) {
  CurrentModel out = current;
  for (const EffectSpec& spec : places_of(effect_info(kOffset), current, experiment))
    out = extended(out, experiment, spec, out.fit.point, {0.0});
  return out;
}

/// Residual and sensitivities on the recordings that may be looked at, whitened; what all recordings share is off.
class Rows {
 public:
  Rows(const CurrentModel& model, const FitContext& context) : model_(model), experiment_(context.experiment) {
    std::vector<int> seen = experiment_.with_role(Role::train);
    for (const int s : experiment_.with_role(Role::validate)) seen.push_back(s);
    Problem problem = problem_of(model, context);
    raw_ = problem.residual(model.fit.point, seen);
    blocks_ = problem.layout(seen);
    if (!raw_.allFinite()) return;
    raw_columns_ = problem.jacobian(model.fit.point, raw_, seen);
    if (!raw_columns_.allFinite()) return;
    const Colour colour(raw_, blocks_, noise_over_weight(experiment_, model.weights));
    rest_ = raw_, columns_ = raw_columns_;
    colour.whiten(rest_, blocks_);
    colour.whiten(columns_, blocks_);
    projector_.emplace(columns_);
    rest_ = projector_->rest(rest_);
    for (const ResidualBlock& block : blocks_) {
      const std::string& file = experiment_.segments[static_cast<std::size_t>(block.segment)].file;
      if (std::ranges::find(files_, file) == files_.end()) files_.push_back(file);
    }
  }

  bool are_known() const { return projector_.has_value() && files_.size() > 1; }
  std::optional<OffsetsByRecording> of(const std::string& joint) const {
    const std::optional<Eigen::Index> axis = axis_of(joint);
    if (!axis) return std::nullopt;
    const Eigen::MatrixXd G = by_recording(columns_.col(*axis)), off = projected(G);
    const Eigen::MatrixXd square = off.transpose() * off;
    const Eigen::VectorXd slope = -(off.transpose() * rest_);
    OffsetsByRecording out;
    out.joint = joint;
    std::tie(out.deviation, out.evidence) = most_likely(square, slope);
    if (!(out.evidence > kWorthLearning)) return std::nullopt;
    if (!(halves_gain(off, out.deviation) > kNotToldApart)) return std::nullopt;
    const Eigen::MatrixXd with_prior =
        square + Eigen::MatrixXd::Identity(square.rows(), square.cols()) / (out.deviation * out.deviation);
    const Eigen::VectorXd own = with_prior.ldlt().solve(slope);
    for (std::size_t k = 0; k < files_.size(); ++k)
      out.recordings.emplace_back(files_[k], own(static_cast<Eigen::Index>(k)));
    out.unit = model_.model.command_unit(*model_.model.robot().find_joint(joint));
    out.share = share_of(joint, by_recording(raw_columns_.col(*axis)) * own);
    return out;
  }

 private:
  std::optional<Eigen::Index> axis_of(const std::string& joint) const {
    const int at = model_.model.find_effect_at(kOffset, joint);
    if (at < 0) return std::nullopt;
    const int parameter = model_.model.effects()[static_cast<std::size_t>(at)].first;
    for (std::size_t a = 0; a < model_.space.size(); ++a)
      if (model_.space.axes()[a].parameter == parameter) return static_cast<Eigen::Index>(a);
    return std::nullopt;
  }
  std::size_t file_of(const ResidualBlock& block) const {
    const std::string& file = experiment_.segments[static_cast<std::size_t>(block.segment)].file;
    return static_cast<std::size_t>(std::ranges::find(files_, file) - files_.begin());
  }
  /// A column's rows, those of each recording in a column of their own.
  Eigen::MatrixXd by_recording(const Eigen::VectorXd& column) const {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(column.size(), static_cast<Eigen::Index>(files_.size()));
    for (const ResidualBlock& b : blocks_)
      out.block(b.first, static_cast<Eigen::Index>(file_of(b)), b.count, 1) = column.segment(b.first, b.count);
    return out;
  }
  Eigen::MatrixXd projected(Eigen::MatrixXd G) const {
    for (Eigen::Index k = 0; k < G.cols(); ++k) G.col(k) = projector_->rest(G.col(k));
    return G;
  }

  /// The standard deviation of most evidence, and its log evidence over none.
  static std::pair<double, double> most_likely(const Eigen::MatrixXd& square, const Eigen::VectorXd& slope) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> of(square);
    const Eigen::ArrayXd tell = of.eigenvalues().array().max(0.0),
                         say = (of.eigenvectors().transpose() * slope).array().square();
    std::pair<double, double> best{0.0, -HUGE_VAL};
    const double usual = 1.0 / std::sqrt(std::max(tell.mean(), 1e-300));
    for (int k = 0; k < kSizes; ++k) {
      const double s = usual * std::pow(kSpan, 2.0 * k / (kSizes - 1) - 1.0);
      const Eigen::ArrayXd more = 1.0 + s * s * tell;
      const double evidence = 0.5 * (s * s * say / more - more.log()).sum();
      if (evidence > best.second) best = {s, evidence};
    }
    return best;
  }

  using Halves = std::array<std::vector<Eigen::Index>, 2>;  ///< rows
  /// Of every recording, earlier and later: of one in a piece within it, else of its windows.
  std::vector<Halves> halves() const {
    std::vector<std::vector<int>> segments(files_.size());
    for (const ResidualBlock& b : blocks_) {
      std::vector<int>& own = segments[file_of(b)];
      if (std::ranges::find(own, b.segment) == own.end()) own.push_back(b.segment);
    }
    std::vector<Halves> out(files_.size());
    for (const ResidualBlock& b : blocks_) {
      const std::vector<int>& own = segments[file_of(b)];
      const auto rank = std::ranges::find(own, b.segment) - own.begin(), all = std::ssize(own);
      for (Eigen::Index k = 0; k < b.count; ++k) {
        const bool later = all > 1 ? 2 * rank >= all : 2 * k >= b.count;
        out[file_of(b)][later ? 1 : 0].push_back(b.first + k);
      }
    }
    return out;
  }
  /// What either half of every recording gains by the offset that its other half shows.
  double halves_gain(const Eigen::MatrixXd& off, double deviation) const {
    double gain = 0.0;
    const std::vector<Halves> all = halves();
    for (std::size_t f = 0; f < files_.size(); ++f)
      for (const std::size_t half : {0u, 1u}) {
        const Eigen::VectorXd column = off.col(static_cast<Eigen::Index>(f));
        const Eigen::VectorXd x = column(all[f][half]), y = rest_(all[f][half]), u = column(all[f][1 - half]),
                              v = rest_(all[f][1 - half]);
        const double own = -x.dot(y) / (x.squaredNorm() + 1.0 / (deviation * deviation));
        gain += 0.5 * (v.squaredNorm() - (v + own * u).squaredNorm());
      }
    return gain;
  }

  /// Of the residual's energy at the joint's channels, what goes with a change of it.
  double share_of(const std::string& joint, const Eigen::VectorXd& change) const {
    double before = 0.0, after = 0.0;
    for (const ResidualBlock& b : blocks_) {
      const int j = experiment_.channels[static_cast<std::size_t>(b.channel)].joint;
      if (experiment_.joint_names[static_cast<std::size_t>(j)] != joint) continue;
      before += raw_.segment(b.first, b.count).squaredNorm();
      after += (raw_ + change).segment(b.first, b.count).squaredNorm();
    }
    return before > 0.0 ? 1.0 - after / before : 0.0;
  }

  const CurrentModel& model_;
  const Experiment& experiment_;
  std::vector<ResidualBlock> blocks_;
  std::vector<std::string> files_;
  Eigen::VectorXd raw_, rest_;             ///< weighted; whitened, what all recordings share off
  Eigen::MatrixXd raw_columns_, columns_;  ///< weighted; whitened
  std::optional<Projector> projector_;
};

}  // namespace

std::vector<OffsetsByRecording> offsets_by_recording(const CurrentModel& current, const FitContext& context,
                                                     const std::vector<std::string>& joints) {
  std::vector<OffsetsByRecording> out;
  if (joints.empty() || std::holds_alternative<InverseDynamics>(context.experiment.prediction)) return out;
  const CurrentModel model = with_offsets(current, context.experiment);
  const Rows rows(model, context);
  if (!rows.are_known()) return out;
  for (const std::string& joint : joints)
    if (std::optional<OffsetsByRecording> one = rows.of(joint)) out.push_back(std::move(*one));
  return out;
}

}  // namespace lacuna
