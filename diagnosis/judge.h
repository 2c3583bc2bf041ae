// A candidate on its way through a decision, and what can be done with it: weighing on held-out recordings,
// re-identification, objections.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/decide.h"

namespace lacuna {

/// A candidate with its model, re-identified, and both residuals.
struct Tried {
  ScreenedEffect effect;
  CurrentModel model;
  Gain train;
  HeldoutGain heldout;
  double p_value = 1.0;
  bool refitted = false;

  double evidence = 0.0;     ///< against other candidates, see sort_by_evidence
  double over_chance = 0.0;  ///< the same against nothing: no tie makes it larger
  std::string objection{};   ///< why it cannot be what is missing; empty: it can
};

/// Whether a number of that effect, which the model has, was driven to the end of its range, as seen at its typical
/// size. Optional ones and those of every joint may stand there, and those that the recordings would as soon have
/// neutral; all but the leading one may stand at an end at or beyond which their neutral value lies.
bool at_end(const CurrentModel& model, const Component& effect, const Experiment& experiment);

/// Weighs candidates for one model. Residuals are kept in that model's weights, so that candidates compare.
class Judge {
 public:
  /// `tries`: by which chances are multiplied. The model must outlive it.
  Judge(const CurrentModel& current, const FitContext& context, int tries);

  Tried weigh(ScreenedEffect effect);

  /// Share of the train energy that the first, linear look expected to remain.
  double promised_rest(const Tried& tried) const;
  /// Whether it stands far above what that look expected.
  bool disappoints(const Tried& tried) const;
  /// Re-identified from where that look stood; kept if that is the better end.
  void refit_from_first_look(Tried& tried);

  /// Least squares to the end: first with the present weights, then with those of what it leaves, since a joint that
  /// the candidate brings down to its noise decides by that noise how well it does. Returns whether it could: one that
  /// cannot be simulated from where it stands is left as it is.
  bool refit(Tried& tried);
  /// A re-identified candidate once more, from where it stands, at the step in use.
  void follow(Tried& tried);
  /// Calls work(candidate) for several at once, each with its share of the threads; ranks compute each one together.
  template <class Work>
  void share(const std::vector<Tried*>& those, const Work& work) {
    const int threads = context_.simulator.threads, count = static_cast<int>(those.size());
    const bool at_once = context_.simulator.ranks == nullptr && count > 1;
    if (at_once) context_.simulator.threads = std::max(1, threads / count);
    parallel_for(at_once ? threads : 1, count, [&](int, int k) { work(*those[k]); });
    context_.simulator.threads = threads;
  }

  /// The step in use; a candidate may need a finer one than the present model does.
  double step() const { return context_.simulator.max_step; }
  void set_step(double step) { context_.simulator.max_step = step; }
  double step_for(const Tried& tried) const;
  /// By how much the evidence of a re-identified candidate might change at a finer step, nats: its integration error,
  /// as halving the step in use shows it on the train recordings, could have worked wholly for it or wholly against it.
  double doubt(const Tried& tried) const;

  /// The same effect with its optional parameters free, re-identified from where it stands; nothing where none is
  /// fixed.
  std::optional<Tried> freed(const Tried& tried);
  /// Special cases of `tried` or effects that it is a special case of, from where it stands; with optional shapes and
  /// without.
  std::vector<Tried> kin_of(const Tried& tried, const EffectInfo& kin);

  /// Whether the held-out recordings are predicted alike by an effect and a special case of it at the same place, to a
  /// tenth of the noise: a found effect's law is seldom the machine's to the last digit.
  bool cannot_tell(const Tried& special, const Tried& rich) const;

  /// Why it cannot be what is missing; empty: it can.
  std::string objection(const Tried& tried) const;

 private:
  void take_over(Tried& tried);
  bool settle(CurrentModel& model);
  /// Whitened energy on the validate recordings: of the present residual, and what the noise alone would leave (0 where
  /// it is unknown).
  struct Energy {
    double before = 0.0, noise = 0.0;
  };
  std::vector<Energy> heldout_energy() const;
  void set_recordings(Tried& tried);
  void judge_heldout(Tried& tried);
  /// Share that the candidate removes of what stands above the noise, on the channel where it removes most.
  double share_of_excess(const Tried& tried) const;

  const CurrentModel& current_;
  FitContext context_;
  int tries_;
  std::vector<int> train_, validate_;
  Problem plain_;
  Eigen::VectorXd before_validate_;
  Eigen::MatrixXd spread_;              ///< of the present model's predictions of the validate recordings
  std::vector<Energy> heldout_energy_;  ///< by channel, those without samples left out
  double floor_ = 0.0;                  ///< noise of all channels
};

}  // namespace lacuna
