#include "diagnosis/surroundings.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/evidence.h"
#include "diagnosis/partial.h"
#include "diagnosis/prior.h"
#include "diagnosis/ripple_start.h"
#include "ga/sandwich.h"
#include "physics/effects/creep.h"

namespace lacuna {
namespace {

constexpr double kOwnStep = 1e-3;  ///< of a number of an effect, by which its sensitivity is taken

class Looker {
 public:
  Looker(const Hypotheses& sets, const Hypothesis& standing)
      : sets_(sets), experiment_(sets.context().experiment), standing_(standing) {}

  Surroundings look(bool with_rivals) const {
    const CurrentModel& now = standing_.model;
    Surroundings out;
    Problem problem = problem_of(now, sets_.context());
    out.train_blocks = problem.layout(sets_.train());
    out.validate_blocks = problem.layout(sets_.validate());
    std::vector<std::vector<double>> values{now.space.expand(now.fit.point)};
    std::vector<double> steps;
    for (std::size_t a = 0; a < now.space.size(); ++a) {
      const Axis& axis = now.space.axes()[a];
      const double x = now.fit.point[a], size = std::max(std::fabs(x), 1e-3 * std::min(axis.prior, 1e6));
      double step = 1e-6 * std::max(size, 1e-9);
      if (x + step > axis.upper) step = -step;
      std::vector<double> point = now.fit.point;
      point[a] += step;
      steps.push_back(point[a] - x);
      values.push_back(now.space.expand(point));
    }
    for (const EffectSpec& spec : standing_.effects) values.push_back(neutral(values.front(), spec));
    const std::vector<Rows> rows = rows_of(problem, values);
    out.train = rows[0].train, out.validate = rows[0].validate;
    std::vector<LinearColumn> all;
    for (std::size_t a = 0; a < now.space.size(); ++a) {
      const Rows& moved = rows[1 + a];
      all.push_back(column_of(now.space.axes()[a], now.fit.point[a], (moved.train - out.train) / steps[a],
                              (moved.validate - out.validate) / steps[a]));
    }
    std::set<std::size_t> owned;
    for (std::size_t k = 0; k < standing_.effects.size(); ++k) {
      Part part;
      part.spec = standing_.effects[k];
      part.present = true;
      part.choices = sets_.choices_of(part.spec);
      const Rows& without = rows[1 + now.space.size() + k];
      part.train = without.train - out.train, part.validate = without.validate - out.validate;
      for (const std::size_t a : own_axes(now, part.spec)) {
        part.columns.push_back(std::move(all[a]));
        owned.insert(a);
      }
      out.parts.push_back(std::move(part));
    }
    for (std::size_t a = 0; a < all.size(); ++a)
      if (owned.count(a) == 0) out.plain.push_back(std::move(all[a]));
    if (with_rivals) {
      add_shapes(values.front(), out);
      add_rivals(values.front(), out);
    }
    whiten(now, out);
    return out;
  }

  std::vector<EffectSpec> offered(const EffectInfo& info) const {
    std::vector<EffectSpec> out;
    if (std::string(info.name) == "effort_scale") return out;
    for (EffectSpec spec : places_of(info, standing_.model, experiment_)) {
      for (const ParameterInfo& p : info.parameters)
        if (p.optional) spec.parameters[p.name] = p.neutral;
      if (info.per_recording) {
        // What every recording carries is the last link's; a load shows by being on in some only.
        const CoarseLook here{sets_.context(), Eigen::VectorXd::Zero(standing_.model.fit.residual.size())};
        spec.recordings = likely_recordings(standing_.model, here, spec);
        if (spec.recordings.empty()) continue;
      }
      out.push_back(std::move(spec));
    }
    return out;
  }

 private:
  struct Rows {
    Eigen::VectorXd train, validate;
  };
  std::vector<Rows> rows_of(Problem& problem, const std::vector<std::vector<double>>& values) const {
    std::vector<int> both = sets_.train();
    both.insert(both.end(), sets_.validate().begin(), sets_.validate().end());
    const std::vector<Eigen::VectorXd> all = problem.residuals_of(values, both);
    const auto blocks = problem.layout(sets_.train());
    const Eigen::Index cut = blocks.empty() ? 0 : blocks.back().first + blocks.back().count;
    std::vector<Rows> out;
    for (const Eigen::VectorXd& r : all) out.push_back({r.head(cut), r.tail(r.size() - cut)});
    return out;
  }

  /// `values` with an effect taken out.
  std::vector<double> neutral(std::vector<double> values, const EffectSpec& spec) const {
    const PlantModel& model = standing_.model.model;
    const Component& c = model.effects()[model.find_effect_at(spec.effect, spec.place)];
    for (int p = c.first; p < c.first + c.count; ++p) {
      const Parameter& parameter = model.parameters()[p];
      if (is_strength(*parameter.info) || parameter.info->coordinate != Coordinate::linear)
        values[p] = parameter.neutral;
    }
    return values;
  }

  /// Optional numbers of the effects that stand, freed at each of several sizes.
  void add_shapes(const std::vector<double>& base, Surroundings& out) const {
    const CurrentModel& now = standing_.model;
    Problem problem = problem_of(now, sets_.context());
    std::vector<std::vector<double>> values;
    std::vector<Part> parts;
    std::vector<std::pair<Axis, double>> moved;  // axis, step
    for (std::size_t k = 0; k < standing_.effects.size(); ++k) {
      const EffectSpec& spec = standing_.effects[k];
      if (spec.parameters.empty()) continue;
      EffectSpec free = spec;
      for (const ParameterInfo& p : effect_info(spec.effect).parameters)
        if (p.optional) free.parameters.erase(p.name);
      const Component& c = now.model.effects()[now.model.find_effect_at(spec.effect, spec.place)];
      for (const Axis& axis : effect_axes(now.model, experiment_, c, free)) {
        const Parameter& p = now.model.parameters()[axis.parameter];
        if (spec.parameters.count(p.key) == 0 || is_creep_speed(*p.info)) continue;
        const double size = typical_size(p.info->scale, now.model, experiment_, p.joint, now.model.values());
        for (const double factor : {0.3, 1.0, 3.0}) {
          Part part;
          part.spec = spec;
          part.spec.parameters.erase(p.key);
          part.needs = static_cast<int>(k);
          const double x = std::clamp(factor * p.info->starts.front() * size, axis.lower, axis.upper);
          part.start = {{x}};
          values.push_back(base);
          values.back()[axis.parameter] = x;
          values.push_back(values.back());
          const double step = kOwnStep * std::max(std::fabs(x), 1e-9);
          values.back()[axis.parameter] += step;
          Axis own = axis;
          own.prior = std::max(std::fabs(x), 1e-9), own.center = x;
          moved.emplace_back(own, step);
          parts.push_back(std::move(part));
        }
      }
    }
    if (values.empty()) return;
    const std::vector<Rows> rows = rows_of(problem, values);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Rows &at = rows[2 * k], &next = rows[2 * k + 1];
      if (!at.train.allFinite() || !next.train.allFinite() || !at.validate.allFinite()) continue;
      const auto& [axis, step] = moved[k];
      parts[k].train = at.train - out.train, parts[k].validate = at.validate - out.validate;
      parts[k].columns.push_back(
          column_of(axis, parts[k].start[0][0], (next.train - at.train) / step, (next.validate - at.validate) / step));
      out.parts.push_back(std::move(parts[k]));
    }
  }

  /// Every effect of the catalogue that does not stand yet, at every place and start.
  void add_rivals(const std::vector<double>& base, Surroundings& out) const {
    const CurrentModel& now = standing_.model;
    for (const EffectInfo& info : effect_table()) {
      const std::vector<EffectSpec> specs = offered(info);
      if (specs.empty()) continue;
      const PlantModel model = now.model.with_effects(specs);
      Problem problem(model, experiment_, now.space, sets_.context().simulator, now.weights);
      const std::size_t first = model.effects().size() - specs.size();
      std::vector<double> whole = model.values();
      std::copy(base.begin(), base.end(), whole.begin());
      std::vector<std::vector<double>> values;
      std::vector<Part> parts;
      std::vector<std::vector<std::pair<Axis, double>>> moved;
      for (std::size_t k = 0; k < specs.size(); ++k) {
        const Component& c = model.effects()[first + k];
        const std::vector<Axis> axes = effect_axes(model, experiment_, c, specs[k]);
        for (const std::vector<double>& start : starts_of(specs[k], model, axes))
          add_start(model, specs[k], axes, start, whole, values, parts, moved);
      }
      const std::vector<Rows> rows = rows_of(problem, values);
      std::size_t at = 0;
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const Rows& here = rows[at++];
        bool finite = here.train.allFinite() && here.validate.allFinite();
        for (const auto& [axis, step] : moved[k]) {
          const Rows& next = rows[at++];
          finite = finite && next.train.allFinite();
          if (!finite) continue;
          const double x = to_search(axis.coordinate, axis.start);
          parts[k].columns.push_back(
              column_of(axis, x, (next.train - here.train) / step, (next.validate - here.validate) / step));
        }
        if (!finite) continue;
        parts[k].train = here.train - out.train, parts[k].validate = here.validate - out.validate;
        out.parts.push_back(std::move(parts[k]));
      }
    }
  }

  std::vector<std::vector<double>> starts_of(const EffectSpec& spec, const PlantModel& model,
                                             const std::vector<Axis>& axes) const {
    if (spec.effect != "gear_ripple") return starting_points(model, experiment_, axes);
    const int joint = *model.robot().find_joint(spec.place);
    return ripple_starts(standing_.model, sets_.context(), joint);
  }

  /// One start of an effect: its values, and those with each of its strengths moved.
  void add_start(const PlantModel& model, const EffectSpec& spec, const std::vector<Axis>& axes,
                 const std::vector<double>& start, const std::vector<double>& whole,
                 std::vector<std::vector<double>>& values, std::vector<Part>& parts,
                 std::vector<std::vector<std::pair<Axis, double>>>& moved) const {
    Part part;
    part.spec = spec;
    part.choices = sets_.choices_of(spec);
    std::vector<double> own, here = whole;
    for (std::size_t a = 0; a < axes.size(); ++a) {
      own.push_back(std::clamp(start[a], axes[a].lower, axes[a].upper));
      here[axes[a].parameter] = from_search(axes[a].coordinate, own[a]);
    }
    values.push_back(here);
    std::vector<std::pair<Axis, double>> steps;
    for (std::size_t a = 0; a < axes.size(); ++a) {
      const Parameter& p = model.parameters()[axes[a].parameter];
      if (!is_strength(*p.info)) continue;
      const double step = kOwnStep * std::max(std::fabs(own[a]), 1e-9);
      std::vector<double> next = here;
      next[axes[a].parameter] = from_search(axes[a].coordinate, own[a] + step);
      values.push_back(std::move(next));
      Axis axis = prior_axis(model, axes[a], own[a]);
      steps.emplace_back(axis, step);
    }
    part.start = {own};
    parts.push_back(std::move(part));
    moved.push_back(std::move(steps));
  }

  Axis prior_axis(const PlantModel& model, const Axis& axis, double x) const {
    SearchSpace space = standing_.model.space;
    space.add(model, axis);
    std::vector<double> point = standing_.model.fit.point;
    point.push_back(x);
    set_priors(model, experiment_, space, point);
    Axis out = space.axes().back();
    out.start = from_search(out.coordinate, x);
    return out;
  }

  void whiten(const CurrentModel& now, Surroundings& s) const {
    const Colour colour = sets_.colour(now, s.train, s.train_blocks);
    for (std::size_t c = 0; c < experiment_.channels.size(); ++c)
      s.correlation = std::max(s.correlation, colour.correlation_samples(static_cast<int>(c)));
    const auto white = [&](Eigen::VectorXd& rows, const std::vector<ResidualBlock>& blocks) {
      if (rows.size() > 0) colour.whiten(rows, blocks);
    };
    white(s.train, s.train_blocks), white(s.validate, s.validate_blocks);
    const auto column = [&](LinearColumn& c) { white(c.train, s.train_blocks), white(c.validate, s.validate_blocks); };
    for (LinearColumn& c : s.plain) column(c);
    for (Part& part : s.parts) {
      white(part.train, s.train_blocks), white(part.validate, s.validate_blocks);
      for (LinearColumn& c : part.columns) column(c);
    }
  }

  const Hypotheses& sets_;
  const Experiment& experiment_;
  const Hypothesis& standing_;
};

}  // namespace

Surroundings surroundings_of(const Hypotheses& sets, const Hypothesis& standing, bool with_rivals) {
  return Looker(sets, standing).look(with_rivals);
}

std::vector<EffectSpec> offered_beside(const Hypotheses& sets, const Hypothesis& standing, const EffectInfo& effect) {
  return Looker(sets, standing).offered(effect);
}

Linearised linearised(Surroundings s, bool for_bagging) {
  std::vector<int> blocks(s.train.size(), 0);
  if (for_bagging) blocks = time_blocks(s.train_blocks, s.correlation);
  return Linearised(std::move(s.train), std::move(s.validate), std::move(s.plain), std::move(s.parts), blocks);
}

}  // namespace lacuna
