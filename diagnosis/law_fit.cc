#include "diagnosis/law_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/evidence.h"
#include "diagnosis/linear_look.h"
#include "diagnosis/projector.h"

namespace lacuna {
namespace {

constexpr std::array kFine{8, 16, 32, 64, 128, 256};  ///< knots over the range travelled
constexpr std::array kSharp{8, 16, 32, 64};           ///< where something may turn within a small part of it
constexpr std::array kCoarse{8, 16, 32};              ///< where nothing repeats itself many times
constexpr std::array kOfOthers{8, 16};                ///< over what another joint does
constexpr std::array kOfMaps{6};                      ///< of either variable
constexpr int kInPeriod = 24;                         ///< of a curve that repeats itself
constexpr double kAtRest = 0.05;                      ///< of a joint's rms speed, within which it moves neither way

constexpr int kBends = 8;            ///< times that a curve is learned anew about the motion with it
constexpr int kHalvings = 2;         ///< of steps that leave more
constexpr double kLawStands = 0.01;  ///< relative change of what is left, under which it stays as it is

/// Of laws that differ in their knots alone the one of most evidence; most first.
std::vector<Learnable> best_of_each(std::vector<Learnable> out) {
  std::stable_sort(out.begin(), out.end(),
                   [](const Learnable& a, const Learnable& b) { return a.evidence > b.evidence; });
  std::vector<Learnable> best;
  for (Learnable& law : out)
    if (law.evidence > 0.0 && std::ranges::none_of(best, [&](const Learnable& b) { return b.is_alike(law); }))
      best.push_back(std::move(law));
  return best;
}

}  // namespace

/// The present motion of a model, linearised, and what its fit leaves.
struct LawFit::About {
  About(const LawFit& of, const CurrentModel& model)
      : now(model),
        look(model, of.sets_.context(), of.sets_.train()),
        along(look, model, of.experiment_, of.sets_.train()),
        projector(model.fit.jacobian),
        rest(projector.rest(model.fit.residual)),
        effective(of.effective_samples(model)) {}
  const CurrentModel& now;
  LinearLook look;
  LawColumns along;
  Projector projector;
  Eigen::VectorXd rest;
  double effective;
};

std::vector<Learnable> LawFit::offer(const std::vector<int>& joints) const {
  const About about(*this, standing_.model);
  std::vector<Learnable> out;
  if (!about.look.is_linearised()) return out;
  for (const int joint : joints)
    for (const Family& family : families(about.along, joint))
      for (const int knots : family.resolutions) {
        out.push_back(family.law);
        out.back().over.knots = knots;
      }
  // What goes through valve and actuator is simulated, which has threads of its own.
  const auto simulated = std::ranges::partition(out, [](const Learnable& l) { return l.stage != Stage::command; });
  const auto weigh = [&](Learnable& law) {
    law.values = Eigen::VectorXd::Zero(law.size());
    bend(about, nullptr, law);
  };
  parallel_for(
      sets_.context().simulator.threads, static_cast<int>(simulated.begin() - out.begin()),
      [&](int, int k) { weigh(out[k]); }, sets_.context().simulator.stop);
  std::ranges::for_each(simulated, weigh);
  return best_of_each(std::move(out));
}

/// What a law of a joint may depend on, where it has none of that stage yet.
std::vector<LawFit::Family> LawFit::families(const LawColumns& along, int joint) const {
  using enum LearnedCurve::Variable;
  std::vector<Family> out;
  const auto add = [&](Stage stage, Learnable::Variable over, std::span<const int> resolutions,
                       std::optional<Learnable::Variable> beside = {}) {
    const std::string& name = experiment_.joint_names[joint];
    if (standing_.model.model.find_effect_at(learned_effect(stage), name) >= 0) return;
    if (!along.cover(joint, over) || (beside && beside->knots > 2 && !along.cover(joint, *beside))) return;
    out.push_back({{joint, stage, over, beside, {over.from, over.to}, 0.0, {}, {}, -HUGE_VAL}, resolutions});
  };
  add(Stage::link, {kPosition}, kFine);
  add(Stage::link, {kSpeed}, kSharp);
  // In hundreds of windows of a second or two more than a joint's own position and speed costs minutes.
  if (std::holds_alternative<Windows>(experiment_.prediction)) return out;
  const double rest = kAtRest * experiment_.speed_rms[joint];
  if (rest > 0.0) add(Stage::link, {kPosition}, kCoarse, Learnable::Variable{kSpeed, 0, -rest, rest, 2});
  add(Stage::link, {kPosition}, kOfMaps, Learnable::Variable{kSpeed, 0, 0.0, 0.0, kOfMaps.front()});
  for (int other = 1; other <= standing_.model.model.dof(); ++other) {
    if (other == joint + 1) continue;
    add(Stage::link, {kPosition, other}, kOfOthers);
    add(Stage::link, {kSpeed, other}, kOfOthers);
    add(Stage::link, {kPosition}, kOfMaps, Learnable::Variable{kPosition, other, 0.0, 0.0, kOfMaps.front()});
  }
  if (!std::holds_alternative<FreeRun>(experiment_.prediction))
    return out;  // what is compared is measured, motion and effort
  add(Stage::command, {kCommand}, kCoarse);
  add(Stage::reading, {kPosition}, kSharp);
  return out;
}

/// Changes of the whitened residual, one a value of the law; what the fitted parameters take up is off.
Eigen::MatrixXd LawFit::sensitivities(const About& about, const Learnable& law) const {
  Eigen::MatrixXd G = about.along.changes(law);
  if (!G.allFinite()) return {};
  for (Eigen::Index k = 0; k < G.cols(); ++k) G.col(k) = about.projector.rest(G.col(k));
  return G;
}
/// What the rest would be without the law that the model has.
Eigen::VectorXd LawFit::rest_without(const About& about, const Learnable* stands) const {
  if (stands == nullptr) return about.rest;
  const Eigen::MatrixXd G = sensitivities(about, *stands);
  return G.size() > 0 ? Eigen::VectorXd(about.rest - G * stands->values) : Eigen::VectorXd();
}
CurveData LawFit::data_of(const About& about, const Eigen::MatrixXd& G, const Eigen::VectorXd& without) {
  return {G.transpose() * G, -(G.transpose() * without), without.squaredNorm(), static_cast<double>(about.rest.size()),
          about.effective};
}

/// The curve anew, about a motion of which `stands` (null: nothing) is part. No evidence: it cannot be had.
void LawFit::bend(const About& about, const Learnable* stands, Learnable& law) const {
  law.evidence = -HUGE_VAL;
  const Eigen::VectorXd without = rest_without(about, stands);
  const Eigen::MatrixXd G = sensitivities(about, law);
  if (G.size() == 0 || without.size() == 0) return;
  if (law.period <= 0.0) return weigh_curve(data_of(about, G, without), law);
  const auto data = [&](const Learnable& of) { return data_of(about, sensitivities(about, of), without); };
  sharpen_period(data, period_share(law, law.period), law);
}

/// Of the whole residual: as many as say one thing each.
double LawFit::effective_samples(const CurrentModel& now) const {
  const Problem problem = problem_of(now, sets_.context());
  const auto blocks = problem.layout(sets_.train());
  const Colour colour = sets_.colour(now, now.fit.residual, blocks);
  double out = 0.0;
  for (const ResidualBlock& block : blocks)
    out += static_cast<double>(block.count) / colour.correlation_samples(block.channel);
  return out;
}

/// A model with a law, everything else fitted again.
std::optional<Hypothesis> LawFit::with(const Learnable& law, const Hypothesis& base) const {
  SetChange change;
  change.in.push_back(law.spec(name_of(law))), change.own.emplace_back();
  return sets_.changed(base, change, kRefitSteps);
}

std::optional<FittedLaw> LawFit::fitted(const Learnable& start, const Hypothesis& base, int finest) const {
  std::optional<FittedLaw> best;
  Learnable tried = start;
  for (int k = 0, halved = 0; k < kBends; ++k) {
    std::optional<Hypothesis> next = with(tried, base);
    const double now = left_by(best ? best->set : base), then = next ? left_by(*next) : HUGE_VAL;
    if (!(then < now)) {
      if (++halved > kHalvings || (best && best->law.size() != tried.size())) break;
      const Eigen::VectorXd from = best ? best->law.values : Eigen::VectorXd::Zero(start.values.size());
      tried.values = 0.5 * (tried.values + from);
      continue;
    }
    const bool stands = best && then > (1.0 - kLawStands) * now;
    best.emplace(tried, std::move(*next));
    const About about(*this, best->set.model);
    bend(about, &best->law, tried);
    if (!std::isfinite(tried.evidence)) break;
    best->law.evidence = tried.evidence, best->law.occam = tried.occam, best->law.errors = tried.errors;
    const bool finer = 2 * tried.over.knots <= finest && refine(about, best->law, tried);
    if (!finer && stands) break;
  }
  return best;
}

/// Twice the knots, where the motion with the law in it speaks for them: before, its own trace hid what they show.
bool LawFit::refine(const About& about, const Learnable& stands, Learnable& law) const {
  Learnable finer = law;
  finer.over.knots *= 2;
  const bool simulated = law.stage == Stage::command;  // about the law's own knots, as the model has them
  if (simulated || law.period > 0.0 || finer.over.knots > kMostKnots || finer.size() > kMostValues) return false;
  bend(about, &stands, finer);
  if (!(finer.evidence > law.evidence + kNotToldApart)) return false;
  law = finer;
  return true;
}

void LawFit::look_for_a_period(FittedLaw& smooth) const {
  const About about(*this, smooth.set.model);
  const Eigen::VectorXd without = rest_without(about, &smooth.law);
  const Eigen::MatrixXd G = sensitivities(about, smooth.law);
  if (G.size() == 0) return;
  const std::optional<double> longest = period_of(data_of(about, G, without), smooth.law);
  if (!longest) return;
  std::optional<Learnable> best;
  for (const int parts : {1, 2, 3}) {
    Learnable law = smooth.law;
    law.over.knots = kInPeriod;
    law.set_period(*longest / parts);
    law.values = Eigen::VectorXd::Zero(law.size());
    bend(about, &smooth.law, law);
    if (std::isfinite(law.evidence) && (!best || law.evidence > best->evidence - kNotToldApart)) best = law;
  }
  std::optional<FittedLaw> found = best ? fitted(*best, standing_) : std::nullopt;
  if (found && sets_.heldout_difference(found->set, smooth.set).gain >= 0.0) smooth = std::move(*found);
}

double LawFit::left_by(const Hypothesis& one) const {
  double out = 0.0;
  const Problem problem = problem_of(one.model, sets_.context());
  for (const ResidualBlock& b : problem.layout(sets_.train())) {
    const std::size_t c = b.channel;
    const double unit = one.model.weights[c] / standing_.model.weights[c];
    out += unit * unit * one.model.fit.residual.segment(b.first, b.count).squaredNorm();
  }
  return out;
}

}  // namespace lacuna
