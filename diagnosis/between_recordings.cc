#include "diagnosis/between_recordings.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "diagnosis/baseline.h"
#include "diagnosis/colour.h"
#include "diagnosis/evidence.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/projector.h"

namespace lacuna {
namespace {

constexpr const char* kOffset = "valve_offset";
constexpr int kSizes = 60;              ///< standard deviations that are tried,
constexpr double kSpan = 1e4;           ///< from this part of what one recording tells to so many times it
constexpr std::size_t kMostMoving = 3;  ///< numbers of a joint

/// The present model with an offset at every commanded joint, at neutral where there was none; a measured effort has no
/// valve before it.
CurrentModel with_offsets(const CurrentModel& current, const Experiment& experiment) {
  CurrentModel out = current;
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) return out;
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
      const std::string& file = experiment_.segments[block.segment].file;
      if (std::ranges::find(files_, file) == files_.end()) files_.push_back(file);
    }
    find_halves();
  }

  bool are_known() const { return projector_.has_value() && files_.size() > 1; }

  std::vector<NumberByRecording> at(const std::string& joint) const {
    std::vector<NumberByRecording> out;
    std::vector<Moving> chosen;
    double left = energy_at(joint, raw_);
    const double before = left;
    std::vector<std::size_t> open = axes_at(joint);
    while (chosen.size() < kMostMoving) {
      std::optional<Moving> next = next_moving(open, chosen);
      if (!next) break;
      chosen.push_back(std::move(*next));
      const double after = energy_at(joint, raw_ + change_by(chosen));
      out.push_back(described(joint, chosen.back()));
      out.back().share = before > 0.0 ? (left - after) / before : 0.0;
      left = after;
    }
    const Eigen::VectorXd own = own_of(chosen);
    for (std::size_t k = 0; k < out.size(); ++k) put_recordings(out[k], chosen[k], own.segment(first_of(k), files()));
    return out;
  }

 private:
  /// A number with one value for each recording.
  struct Moving {
    std::size_t axis = 0;
    double deviation = 0.0;   ///< in its search coordinate,
    double evidence = 0.0;    ///< over none, beside those chosen before it
    Eigen::MatrixXd columns;  ///< whitened, one a recording, of one standard deviation
  };
  Eigen::Index files() const { return static_cast<Eigen::Index>(files_.size()); }
  Eigen::Index first_of(std::size_t k) const { return static_cast<Eigen::Index>(k) * files(); }

  /// Of the joint's own numbers; a learned law's points are none, nor is what lies at infinity.
  std::vector<std::size_t> axes_at(const std::string& joint) const {
    std::vector<std::size_t> out;
    for (std::size_t a = 0; a < model_.space.size(); ++a) {
      const Parameter& p = parameter(a);
      const bool own = p.info != nullptr && !p.info->per_knot && p.name.starts_with(joint + ".");
      if (own && std::isfinite(model_.space.axes()[a].value(model_.fit.point[a]))) out.push_back(a);
    }
    return out;
  }
  const Parameter& parameter(std::size_t axis) const {
    return model_.model.parameters()[model_.space.axes()[axis].parameter];
  }
  std::size_t file_of(const ResidualBlock& block) const {
    const std::string& file = experiment_.segments[block.segment].file;
    return static_cast<std::size_t>(std::ranges::find(files_, file) - files_.begin());
  }
  /// A column's rows, those of each recording in a column of their own.
  Eigen::MatrixXd by_recording(const Eigen::VectorXd& column) const {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(column.size(), files());
    for (const ResidualBlock& b : blocks_)
      out.block(b.first, file_of(b), b.count, 1) = column.segment(b.first, b.count);
    return out;
  }

  /// Columns of all that was chosen, side by side.
  Eigen::MatrixXd beside(const std::vector<Moving>& chosen) const {
    Eigen::MatrixXd out(rest_.size(), first_of(chosen.size()));
    for (std::size_t k = 0; k < chosen.size(); ++k) out.middleCols(first_of(k), files()) = chosen[k].columns;
    return out;
  }
  /// The axis' number as one that moves, its standard deviation that of most evidence beside the chosen ones.
  Moving moving(std::size_t axis, const std::vector<Moving>& chosen) const {
    Moving out{axis, 0.0, -HUGE_VAL, by_recording(columns_.col(axis))};
    for (Eigen::Index k = 0; k < files(); ++k) out.columns.col(k) = projector_->rest(out.columns.col(k));
    Eigen::MatrixXd square = out.columns.transpose() * out.columns;
    Eigen::VectorXd slope = out.columns.transpose() * rest_;
    if (!chosen.empty()) {  // what these take up is no news
      const Eigen::MatrixXd E = beside(chosen), shared = E.transpose() * out.columns;
      const auto with_prior = with_unit_prior(E);
      square -= shared.transpose() * with_prior.solve(shared);
      slope -= shared.transpose() * with_prior.solve(E.transpose() * rest_);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> of(square);
    const Eigen::ArrayXd tell = of.eigenvalues().array().max(0.0),
                         say = (of.eigenvectors().transpose() * slope).array().square();
    const double usual = 1.0 / std::sqrt(std::max(tell.mean(), 1e-300));
    for (int k = 0; k < kSizes; ++k) {
      const double s = usual * std::pow(kSpan, 2.0 * k / (kSizes - 1) - 1.0);
      const Eigen::ArrayXd more = 1.0 + s * s * tell;
      const double evidence = 0.5 * (s * s * say / more - more.log()).sum();
      if (evidence > out.evidence) out.deviation = s, out.evidence = evidence;
    }
    out.columns *= out.deviation;
    return out;
  }
  /// Of the open axes' numbers the one of most evidence whose halves confirm it; it and those that they refuse are open
  /// no longer.
  std::optional<Moving> next_moving(std::vector<std::size_t>& open, const std::vector<Moving>& chosen) const {
    std::vector<Moving> offered;
    for (const std::size_t axis : open) offered.push_back(moving(axis, chosen));
    std::ranges::stable_sort(offered, std::ranges::greater(), &Moving::evidence);
    for (Moving& one : offered) {
      if (!(one.evidence > kWorthLearning)) break;
      std::erase(open, one.axis);
      if (halves_gain(one, chosen) > kNotToldApart) return std::move(one);
    }
    return std::nullopt;
  }
  static Eigen::LDLT<Eigen::MatrixXd> with_unit_prior(const Eigen::MatrixXd& E) {
    return (E.transpose() * E + Eigen::MatrixXd::Identity(E.cols(), E.cols())).ldlt();
  }

  /// Each recording's own, of one chosen number after the other, in standard deviations.
  Eigen::VectorXd own_of(const std::vector<Moving>& chosen) const {
    const Eigen::MatrixXd E = beside(chosen);
    return -with_unit_prior(E).solve(E.transpose() * rest_);
  }
  /// What they make of the residual.
  Eigen::VectorXd change_by(const std::vector<Moving>& chosen) const {
    const Eigen::VectorXd own = own_of(chosen);
    Eigen::VectorXd out = Eigen::VectorXd::Zero(raw_.size());
    for (std::size_t k = 0; k < chosen.size(); ++k)
      out += chosen[k].deviation * (by_recording(raw_columns_.col(chosen[k].axis)) * own.segment(first_of(k), files()));
    return out;
  }

  using Halves = std::array<std::vector<Eigen::Index>, 2>;  ///< rows
  /// Of every recording, earlier and later: of one in a piece within it, else of its windows.
  void find_halves() {
    std::vector<std::vector<int>> segments(files_.size());
    for (const ResidualBlock& b : blocks_) {
      std::vector<int>& own = segments[file_of(b)];
      if (std::ranges::find(own, b.segment) == own.end()) own.push_back(b.segment);
    }
    halves_.resize(files_.size());
    for (const ResidualBlock& b : blocks_) {
      const std::vector<int>& own = segments[file_of(b)];
      const auto rank = std::ranges::find(own, b.segment) - own.begin(), all = std::ssize(own);
      for (Eigen::Index k = 0; k < b.count; ++k) {
        const bool later = all > 1 ? 2 * rank >= all : 2 * k >= b.count;
        halves_[file_of(b)][later ? 1 : 0].push_back(b.first + k);
      }
    }
  }
  /// What either half of every recording gains, beside the chosen ones, by the number that its other half shows.
  double halves_gain(const Moving& one, const std::vector<Moving>& chosen) const {
    std::vector<Moving> with = chosen;
    with.push_back(one);
    return halves_energy(chosen) - halves_energy(with);
  }
  /// Half the energy of either half of every recording after what its other half says of these numbers.
  double halves_energy(const std::vector<Moving>& numbers) const {
    double out = 0.0;
    for (std::size_t f = 0; f < files_.size(); ++f) {
      Eigen::MatrixXd own(rest_.size(), numbers.size());
      for (std::size_t k = 0; k < numbers.size(); ++k) own.col(k) = numbers[k].columns.col(f);
      for (const std::size_t half : {0u, 1u}) {
        const std::vector<Eigen::Index>&said = halves_[f][half], &asked = halves_[f][1 - half];
        const Eigen::MatrixXd X = own(said, Eigen::all);
        const Eigen::VectorXd numbers_there = -with_unit_prior(X).solve(X.transpose() * rest_(said));
        out += 0.5 * (rest_(asked) + own(asked, Eigen::all) * numbers_there).squaredNorm();
      }
    }
    return out;
  }

  /// Of a residual at the joint's channels.
  double energy_at(const std::string& joint, const Eigen::VectorXd& residual) const {
    double out = 0.0;
    for (const ResidualBlock& b : blocks_) {
      const int j = experiment_.channels[b.channel].joint;
      if (experiment_.joint_names[j] == joint) out += residual.segment(b.first, b.count).squaredNorm();
    }
    return out;
  }

  NumberByRecording described(const std::string& joint, const Moving& number) const {
    const Parameter& p = parameter(number.axis);
    NumberByRecording out;
    out.joint = joint, out.number = p.name.substr(joint.size() + 1), out.unit = p.unit;
    out.value = model_.space.axes()[number.axis].value(model_.fit.point[number.axis]);
    out.deviation = std::fabs(in_its_unit(number));
    out.evidence = number.evidence;
    return out;
  }
  /// `own`: in standard deviations.
  void put_recordings(NumberByRecording& out, const Moving& number, const Eigen::VectorXd& own) const {
    for (std::size_t f = 0; f < files_.size(); ++f)
      out.recordings.emplace_back(files_[f], in_its_unit(number) * own(f));
  }
  /// One standard deviation, in the parameter's unit: as linear as all else here.
  double in_its_unit(const Moving& number) const {
    const Axis& axis = model_.space.axes()[number.axis];
    const double x = model_.fit.point[number.axis];
    switch (axis.coordinate) {
      case Coordinate::inverse: return -number.deviation * axis.unit / (x * x);
      case Coordinate::logarithm: return number.deviation * axis.value(x);
      default: return number.deviation * axis.unit;
    }
  }

  const CurrentModel& model_;
  const Experiment& experiment_;
  std::vector<ResidualBlock> blocks_;
  std::vector<std::string> files_;
  std::vector<Halves> halves_;             ///< [file]
  Eigen::VectorXd raw_, rest_;             ///< weighted; whitened, what all recordings share off
  Eigen::MatrixXd raw_columns_, columns_;  ///< weighted; whitened
  std::optional<Projector> projector_;
};

}  // namespace

std::vector<NumberByRecording> numbers_by_recording(const CurrentModel& current, const FitContext& context,
                                                    const std::vector<std::string>& joints) {
  std::vector<NumberByRecording> out;
  if (joints.empty()) return out;
  const CurrentModel model = with_offsets(current, context.experiment);
  const Rows rows(model, context);
  if (!rows.are_known()) return out;
  for (const std::string& joint : joints)
    for (NumberByRecording& one : rows.at(joint)) out.push_back(std::move(one));
  return out;
}

}  // namespace lacuna
