#include "diagnosis/screen.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "diagnosis/coarse.h"
#include "diagnosis/partial.h"
#include "diagnosis/projector.h"

namespace lacuna {
namespace {

/// Relative step of the difference that starts an effect's own sensitivity; coarse, since many effects have kinks.
constexpr double kOwnDifference = 1e-2;
constexpr double kLeastStep = 1e-9;    ///< of that difference, relative to the range searched
constexpr int kSizings = 3;            ///< rounds that bring a start's strength down
constexpr double kStrongest = 2.0;     ///< change of the prediction over what is to be explained, both rms
constexpr double kTwin = 0.05;         ///< starts nearer than this share of their size are one
constexpr int kStartsKept = 2;         ///< of every effect, place and variant, after the first look
constexpr std::size_t kChains = 40;    ///< starts that are re-identified; and the best one of every effect
constexpr int kSteps = 5;              ///< of Gauss and Newton, of promising starts
constexpr double kWorthwhile = 0.2;    ///< promised gain over the best one's, under which a start is given
constexpr int kFewSteps = 2;           ///< so many steps only
constexpr double kStepDamping = 1e-6;  ///< of Gauss-Newton, relative to the normal matrix' diagonal

/// One start of one effect at one place on its way.
struct Chain {
  int component = 0;       ///< in the effect's model
  bool refined = false;    ///< optional parameters are free, too
  std::vector<Axis> axes;  ///< the effect's own free ones
  Eigen::VectorXd x;       ///< base coordinates, then own
  Eigen::VectorXd residual;
  Eigen::MatrixXd own_columns;  ///< sensitivities of the own coordinates at the start
  std::vector<std::pair<Eigen::VectorXd, Eigen::VectorXd>> updates;  ///< Broyden: J += a b^T
  Eigen::VectorXd tried;                                             ///< next x
  double step_scale = 1.0;
  double promise = HUGE_VAL;      ///< residual energy expected after the first step
  std::vector<double> first_own;  ///< own coordinates at the start
  bool alive = true;
};

/// All starts of one effect, in a model that holds it at every place at its neutral value.
class EffectScreen {
 public:
  EffectScreen(const CurrentModel& current, const CoarseLook& coarse, std::vector<EffectSpec> specs,
               std::vector<int> train)
      : current_(current),
        experiment_(coarse.context.experiment),
        coarse_(coarse),
        specs_(std::move(specs)),
        train_(std::move(train)),
        model_(current.model.with_effects(specs_)),
        problem_(model_, experiment_, current.space, coarse.context.simulator, current.weights),
        base_(current.space.size()) {}

  /// First look: every start with the optional parameters neutral, linearised. Keeps the most promising ones of a
  /// place.
  void look(const Projector& projector) {
    std::vector<Chain> starts;
    for (std::size_t k = 0; k < specs_.size(); ++k) add_starts(first_component() + static_cast<int>(k), false, starts);
    chains_ = looked_at(std::move(starts), projector);
  }
  /// The same with the optional parameters free, at places where a start without them promises less than `limit`.
  void look_closer(const Projector& projector, double limit) {
    if (!has_optional()) return;
    std::set<int> promising;
    for (const Chain& chain : chains_) {
      if (chain.promise < limit) promising.insert(chain.component);
    }
    std::vector<Chain> starts;
    for (const int component : promising) add_starts(component, true, starts);
    for (Chain& chain : looked_at(std::move(starts), projector)) chains_.push_back(std::move(chain));
    std::stable_sort(chains_.begin(), chains_.end(),
                     [](const Chain& a, const Chain& b) { return a.promise < b.promise; });
  }
  /// Residual energy that each surviving start promises to leave.
  std::vector<double> promises() const {
    std::vector<double> out;
    for (const Chain& chain : chains_) out.push_back(chain.promise);
    return out;
  }
  /// Drops starts that promise no less than `limit`, but for the best one.
  void drop_above(double limit) {
    for (std::size_t k = chains_.size(); k-- > 1;) {
      if (chains_[k].promise >= limit) chains_.erase(chains_.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }

  /// Second look: the surviving starts re-identified with all parameters; those that promise little of what the most
  /// promising start of all does (`most_promising`), by a few steps only.
  std::vector<ScreenedEffect> run(double most_promising) {
    const double present = current_.fit.residual.squaredNorm();
    for (int step = 0; step < kSteps; ++step) {
      std::vector<Chain*> walking;
      for (Chain& chain : chains_) {
        const bool worthwhile = present - chain.promise >= kWorthwhile * (present - most_promising);
        if (chain.alive && (worthwhile || step < kFewSteps)) walking.push_back(&chain);
      }
      if (walking.empty()) break;
      propose(walking);
      judge(walking);
    }
    std::vector<ScreenedEffect> out;
    for (std::size_t k = 0; k < specs_.size(); ++k) {
      for (const bool refined : {false, true}) {
        ScreenedEffect best = best_of(k, refined);
        if (std::isfinite(best.sum_of_squares)) out.push_back(std::move(best));
      }
    }
    return out;
  }

 private:
  int first_component() const { return static_cast<int>(model_.effects().size() - specs_.size()); }

  /// The starts, sized, with their promises; the most promising ones of every place and variant, best first.
  std::vector<Chain> looked_at(std::vector<Chain> chains, const Projector& projector) {
    size_starts(projector, chains);
    begin(chains);
    for (Chain& chain : chains) {
      chain.first_own.assign(chain.x.data() + base_, chain.x.data() + chain.x.size());
      chain.promise =
          chain.alive ? projector.left_over(chain.residual, chain.own_columns, own_bounds(chain)) : HUGE_VAL;
    }
    std::stable_sort(chains.begin(), chains.end(),
                     [](const Chain& a, const Chain& b) { return a.promise < b.promise; });
    std::map<std::pair<int, bool>, int> kept;
    std::erase_if(chains, [&](const Chain& chain) {
      return !chain.alive || ++kept[{chain.component, chain.refined}] > kStartsKept;
    });
    return chains;
  }

  bool has_optional() const {
    const EffectInfo& info = effect_table()[model_.effects().back().type];
    return std::any_of(info.parameters.begin(), info.parameters.end(),
                       [](const ParameterInfo& p) { return p.optional; });
  }
  /// The place's spec with the optional parameters fixed at neutral, or left free.
  EffectSpec variant(std::size_t place, bool refined) const {
    EffectSpec spec = specs_[place];
    const EffectInfo& info = effect_table()[model_.effects().back().type];
    for (const ParameterInfo& p : info.parameters) {
      if (p.optional && !refined) spec.parameters[p.name] = p.neutral;
    }
    return spec;
  }

  void add_starts(int component, bool refined, std::vector<Chain>& out) const {
    const Component& c = model_.effects()[component];
    const std::size_t place = component - first_component();
    const std::vector<Axis> axes = effect_axes(model_, experiment_, c, variant(place, refined));
    for (const auto& start : starting_points(model_, experiment_, axes)) {
      Chain chain;
      chain.component = component;
      chain.refined = refined;
      chain.axes = axes;
      chain.x.resize(base_ + static_cast<Eigen::Index>(axes.size()));
      for (Eigen::Index a = 0; a < base_; ++a) chain.x(a) = current_.fit.point[a];
      for (std::size_t p = 0; p < axes.size(); ++p) {
        chain.x(base_ + static_cast<Eigen::Index>(p)) = std::clamp(start[p], axes[p].lower, axes[p].upper);
      }
      out.push_back(std::move(chain));
    }
  }

  std::vector<double> values_at(const Chain& chain, const Eigen::VectorXd& x) const {
    const std::vector<double> point(x.data(), x.data() + base_);
    const std::vector<double> plain = current_.space.expand(point);
    std::vector<double> values = model_.values();
    std::copy(plain.begin(), plain.end(), values.begin());
    for (std::size_t p = 0; p < chain.axes.size(); ++p) {
      const double own = x(base_ + static_cast<Eigen::Index>(p));
      values[chain.axes[p].parameter] = from_search(chain.axes[p].coordinate, own);
    }
    return values;
  }

  /// Brings every start's strength down until the effect changes the prediction by no more than what there is to
  /// explain (plain parameters projected off): beyond that its linearisation says nothing.
  void size_starts(const Projector& projector, std::vector<Chain>& chains) {
    const Eigen::VectorXd& plain = current_.fit.residual;
    const double target = projector.rest(plain).norm();
    for (int round = 0; round < kSizings; ++round) {
      const std::vector<Chain*> changed = simulate_new(chains);
      if (changed.empty()) break;
      for (Chain* chain : changed) {
        const bool runs = chain->residual.allFinite();
        const double size = runs ? projector.rest(chain->residual - plain).norm() : HUGE_VAL;
        if (size <= kStrongest * target) continue;
        weaken(*chain, std::clamp(target / size, 1e-3, 0.5));
        chain->residual.resize(0);
      }
    }
    drop_twins(chains);
  }
  /// Residuals of the chains that have none yet; those chains.
  std::vector<Chain*> simulate_new(std::vector<Chain>& chains) {
    std::vector<Chain*> out;
    std::vector<std::vector<double>> values;
    for (Chain& chain : chains) {
      if (chain.residual.size() > 0) continue;
      out.push_back(&chain);
      values.push_back(values_at(chain, chain.x));
    }
    std::vector<Eigen::VectorXd> residuals = coarse_.residuals_of(problem_, values, train_);
    for (std::size_t k = 0; k < out.size(); ++k) out[k]->residual = std::move(residuals[k]);
    return out;
  }
  void weaken(Chain& chain, double factor) const {
    const EffectInfo& info = effect_table()[model_.effects().back().type];
    for (std::size_t p = 0; p < chain.axes.size(); ++p) {
      const Axis& axis = chain.axes[p];
      const ParameterInfo& own = *model_.parameters()[axis.parameter].info;
      double& x = chain.x(base_ + static_cast<Eigen::Index>(p));
      const double value = strengthened(info, own, from_search(axis.coordinate, x), factor);
      x = std::clamp(to_search(axis.coordinate, value), axis.lower, axis.upper);
    }
  }
  /// Starts that sizing has brought together are one.
  static void drop_twins(std::vector<Chain>& chains) {
    for (std::size_t k = chains.size(); k-- > 1;) {
      const Chain& chain = chains[k];
      const bool twin =
          std::any_of(chains.begin(), chains.begin() + static_cast<std::ptrdiff_t>(k), [&](const Chain& c) {
            return c.component == chain.component && c.refined == chain.refined &&
                   ((c.x - chain.x).array().abs() <= kTwin * chain.x.array().abs().max(1e-300)).all();
          });
      if (twin) chains.erase(chains.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }

  /// Residuals at every start, and the effect's own sensitivities there.
  void begin(std::vector<Chain>& chains) {
    simulate_new(chains);
    std::vector<std::vector<double>> values;
    std::vector<Eigen::VectorXd> points;
    for (const Chain& chain : chains) {
      for (std::size_t p = 0; p < chain.axes.size(); ++p) {
        Eigen::VectorXd moved = chain.x;
        double& own = moved(base_ + static_cast<Eigen::Index>(p));
        const double step = kOwnDifference * std::max(std::fabs(own), kLeastStep * width(chain.axes[p]));
        own += own + step <= chain.axes[p].upper ? step : -step;
        points.push_back(moved);
        values.push_back(values_at(chain, moved));
      }
    }
    const std::vector<Eigen::VectorXd> residuals = coarse_.residuals_of(problem_, values, train_);
    std::size_t k = 0;
    for (Chain& chain : chains) {
      chain.alive = chain.residual.allFinite();
      chain.own_columns.resize(chain.residual.size(), chain.axes.size());
      for (std::size_t p = 0; p < chain.axes.size(); ++p, ++k) {
        const Eigen::Index own = base_ + static_cast<Eigen::Index>(p);
        const Eigen::Index column = p;
        chain.own_columns.col(column) = (residuals[k] - chain.residual) / (points[k](own) - chain.x(own));
        chain.alive = chain.alive && chain.own_columns.col(column).allFinite();
      }
    }
  }

  static double width(const Axis& axis) {
    const double width = axis.upper - axis.lower;
    return std::isfinite(width) ? width : 1.0;
  }

  /// Room of a chain's own coordinates for a step: lower and upper, one column each.
  Eigen::MatrixX2d own_bounds(const Chain& chain) const {
    Eigen::MatrixX2d out(chain.axes.size(), 2);
    for (std::size_t p = 0; p < chain.axes.size(); ++p) {
      const double own = chain.x(base_ + static_cast<Eigen::Index>(p));
      out.row(p) << chain.axes[p].lower - own, chain.axes[p].upper - own;
    }
    return out;
  }

  Eigen::MatrixXd sensitivities(const Chain& chain) const {
    Eigen::MatrixXd J(chain.residual.size(), chain.x.size());
    J.leftCols(base_) = current_.fit.jacobian;
    J.rightCols(chain.own_columns.cols()) = chain.own_columns;
    for (const auto& [a, b] : chain.updates) J.noalias() += a * b.transpose();
    return J;
  }

  /// Damped Gauss-Newton step of one chain from `tried`, which is where it stands, cut at the bounds.
  void propose_step(Chain& chain) const {
    std::vector<Axis> axes = current_.space.axes();
    axes.insert(axes.end(), chain.axes.begin(), chain.axes.end());
    const Eigen::MatrixXd J = sensitivities(chain);
    const Eigen::VectorXd step =
        damped_step(J.transpose() * J, J.transpose() * chain.residual, kStepDamping, least_curvatures(axes));
    if (!step.allFinite()) return;
    for (Eigen::Index i = 0; i < step.size(); ++i) {
      const Axis& axis = axes[i];
      chain.tried(i) = std::clamp(chain.x(i) + chain.step_scale * step(i), axis.lower, axis.upper);
    }
  }

  void propose(const std::vector<Chain*>& walking) {
    std::uint64_t key = hash_of({});
    for (Chain* chain : walking) {
      chain->tried = chain->x;
      key = hash_of(std::as_bytes(std::span(chain->x.data(), static_cast<std::size_t>(chain->x.size()))), key);
    }
    const SimulatorOptions& on = coarse_.context.simulator;
    make_executor(on.threads, on.ranks, on.stop)
        ->run(
            static_cast<int>(walking.size()), [&](int, int k) { propose_step(*walking[k]); },
            [&](int k) -> std::vector<std::span<std::byte>> {
              Eigen::VectorXd& tried = walking[k]->tried;
              return {std::as_writable_bytes(std::span(tried.data(), static_cast<std::size_t>(tried.size())))};
            },
            key);
  }

  /// Simulates the proposals, keeps the better ones, and brings the sensitivities up to date.
  void judge(const std::vector<Chain*>& walking) {
    std::vector<std::vector<double>> values;
    for (const Chain* chain : walking) values.push_back(values_at(*chain, chain->tried));
    const std::vector<Eigen::VectorXd> residuals = coarse_.residuals_of(problem_, values, train_);
    for (std::size_t k = 0; k < walking.size(); ++k) {
      Chain& chain = *walking[k];
      const Eigen::VectorXd step = chain.tried - chain.x;
      if (!residuals[k].allFinite() || step.norm() == 0.0) {
        chain.step_scale *= 0.25;
        continue;
      }
      // Scaled so that a coordinate's unit does not decide which sensitivity is blamed.
      const Eigen::VectorXd size = chain.x.cwiseAbs().cwiseMax(1e-9);
      const Eigen::VectorXd b = step.cwiseQuotient(size.cwiseAbs2());
      Eigen::VectorXd predicted = chain.residual + current_.fit.jacobian * step.head(base_) +
                                  chain.own_columns * step.tail(chain.own_columns.cols());
      for (const auto& [u, w] : chain.updates) predicted += u * w.dot(step);
      chain.updates.emplace_back((residuals[k] - predicted) / step.dot(b), b);
      if (residuals[k].squaredNorm() < chain.residual.squaredNorm()) {
        chain.x = chain.tried;
        chain.residual = residuals[k];
        chain.step_scale = std::min(1.0, 2.0 * chain.step_scale);
      } else {
        chain.step_scale *= 0.5;
      }
    }
  }

  ScreenedEffect best_of(std::size_t place, bool refined) const {
    const int component = first_component() + static_cast<int>(place);
    ScreenedEffect out{variant(place, refined), {}, {}, HUGE_VAL, {}, 0, HUGE_VAL, {}};
    for (const Chain& chain : chains_) {
      if (chain.component != component || chain.refined != refined || !chain.alive) continue;
      if (chain.promise < out.promise) out.promise = chain.promise, out.first_own = chain.first_own;
      const double sum = chain.residual.squaredNorm();
      if (!(sum < out.sum_of_squares)) continue;
      out.sum_of_squares = sum;
      out.residual = chain.residual;
      out.parameters = static_cast<int>(chain.axes.size());
      out.point.assign(chain.x.data(), chain.x.data() + base_);
      out.own.assign(chain.x.data() + base_, chain.x.data() + chain.x.size());
    }
    return out;
  }

  const CurrentModel& current_;
  const Experiment& experiment_;
  const CoarseLook& coarse_;
  std::vector<EffectSpec> specs_;
  std::vector<int> train_;
  PlantModel model_;
  Problem problem_;
  Eigen::Index base_;
  std::vector<Chain> chains_;
};

/// Residual energy that the last of the `kChains` most promising starts promises; infinite where there are no more.
double least_promising(const std::vector<std::unique_ptr<EffectScreen>>& screens) {
  std::vector<double> all;
  for (const auto& screen : screens) {
    for (const double promise : screen->promises()) all.push_back(promise);
  }
  std::sort(all.begin(), all.end());
  return all.size() > kChains ? all[kChains] : HUGE_VAL;
}

}  // namespace

std::vector<ScreenedEffect> screen_effects(const CurrentModel& current, const FitContext& context,
                                           const ScreenOptions& options) {
  const Experiment& experiment = context.experiment;
  const std::vector<int> train = experiment.with_role(Role::train);
  const Projector projector(current.fit.jacobian);
  std::vector<std::unique_ptr<EffectScreen>> screens;
  const CoarseLook coarse = coarse_look(current, context);
  auto look = [&](std::vector<EffectSpec> specs) {
    screens.push_back(std::make_unique<EffectScreen>(current, coarse, std::move(specs), train));
    screens.back()->look(projector);
  };
  const auto& table = effect_table();
  for (std::size_t e = 0; e < table.size(); ++e) {
    if (options.progress) options.progress(0.6 * static_cast<double>(e) / static_cast<double>(table.size()));
    std::vector<EffectSpec> specs = places_of(table[e], current, experiment);
    std::erase_if(specs, [&](const EffectSpec& spec) {
      return !options.where(spec.place) || (options.skipped && options.skipped(spec));
    });
    if (specs.empty()) continue;
    look(specs);
    if (!table[e].per_recording) continue;
    for (EffectSpec partial : specs) {
      partial.recordings = likely_recordings(current, coarse, partial);
      if (!partial.recordings.empty()) look({partial});
    }
  }
  const double limit = least_promising(screens);
  for (const auto& screen : screens) screen->look_closer(projector, limit);
  const double closer = least_promising(screens);
  double best = HUGE_VAL;
  for (const auto& screen : screens) {
    for (const double promise : screen->promises()) best = std::min(best, promise);
  }
  std::vector<ScreenedEffect> out;
  for (std::size_t k = 0; k < screens.size(); ++k) {
    if (options.progress) options.progress(0.6 + 0.4 * static_cast<double>(k) / static_cast<double>(screens.size()));
    screens[k]->drop_above(closer);
    for (ScreenedEffect& found : screens[k]->run(best)) out.push_back(std::move(found));
    screens[k].reset();  // its sensitivities are large
  }
  return out;
}

}  // namespace lacuna
