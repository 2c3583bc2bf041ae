// The true machine behind `lacuna conceal`: the scenario's plant with every free parameter moved by a drawn share, the
// hidden effects, and physics outside the catalogue. Simulated by physics/truth.h.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ga/search_space.h"
#include "physics/experiment.h"
#include "trial/conceal.h"
#include "trial/imperfections.h"
#include "trial/outside_case.h"

namespace lacuna {

constexpr double kTruthTolerance = 1e-8;  ///< of the truth's steps

/// An effect of the catalogue at its place with all its parameters.
class Hidden {
 public:
  /// Strengths that are not given are typical of `plain` in the experiment's motion. Throws InputError.
  Hidden(const HiddenEffect& asked, const PlantModel& plain, const Experiment& experiment,
         std::span<const double> values);

  const HiddenEffect& asked() const { return asked_; }
  double strength() const;  ///< the leading parameter
  /// The same of the effect as it was made weaker or stronger.
  double strength_of(const EffectSpec& spec) const;
  const char* contains() const { return info_.contains; }
  /// Of a joint's law other than a contact's or a delay of the command: one whose strength may change with the place,
  /// the command or the recording.
  bool varies() const;
  Stage stage() const { return info_.stage; }
  /// Positions among its parameters of those that may change along the way: its strength, and what grows or falls with
  /// it. None of a law that masses, readings or delays alone enter.
  std::vector<int> along_the_way() const;
  /// The effect `factor` times as strong; a contact whose place was not given: so many times as far inside the end of
  /// the travel.
  EffectSpec spec(double factor) const;
  void scale(double factor);
  std::vector<std::pair<std::string, double>> parameters() const;

 private:
  void put_given(const std::string& where);
  double brought_nearer(const ParameterInfo& p, double value, double factor) const;

  HiddenEffect asked_;
  const EffectInfo& info_;
  std::vector<EffectParameter> parameters_;
  std::vector<double> values_;
  std::optional<std::pair<double, double>> reach_;  ///< rad (m), the travel in which a contact is moved
};

/// What acts in a machine besides its plain plant.
struct TrueLaws {
  std::vector<EffectSpec> effects = {};
  std::vector<OutsidePhysics> outside = {};
  Background background = {};
  bool imperfect = false;  ///< the first effects are the hidden ones, uneven and drifting as the options say
};

/// What it does, and what a plain refit leaves of that. Keeps references to the scenario and the options.
class TrueMachine {
 public:
  using Channels = std::vector<std::vector<double>>;  ///< [channel][sample]

  /// Throws InputError, WorkError where a background cannot be made as large as asked.
  TrueMachine(const Scenario& scenario, const ConcealOptions& options);

  std::vector<Hidden> hidden;
  std::vector<OutsidePhysics> outside;
  const Experiment& experiment() const { return experiment_; }
  const SearchSpace& space() const { return space_; }
  const PlantModel& plain() const { return plain_; }
  const std::vector<double>& values() const { return values_; }

  /// [segment][channel][sample], noise-free; repeated samples not yet repeated.
  std::vector<Channels> motion(std::span<const int> segments, const TrueLaws& laws, double tolerance) const;
  /// Where it goes in the train recordings with these.
  Travel travel(const TrueLaws& laws) const;
  /// Raw and left rms over noise of the train recordings: against the plain plant at the true values, and refitted,
  /// together with `besides` where given.
  std::pair<double, double> visibility(const TrueLaws& laws, double tolerance,
                                       const std::vector<EffectSpec>& besides = {}) const;
  /// Scales each effect to what the options ask of its visibility. Throws WorkError where that cannot be reached.
  void set_strengths();
  /// Everything that is hidden, at its strength.
  TrueLaws laws() const;
  /// The laws' effects, as strong as they are in this recording.
  std::vector<EffectSpec> effects_in(int recording, const TrueLaws& laws) const;
  const std::vector<UnevenLaw>& uneven() const { return uneven_; }  ///< one a hidden effect, or none at all
  const std::vector<EffectSpec>& misplaced() const { return misplaced_; }

 private:
  void add(const HiddenEffect& asked, std::size_t index);
  void add_outside(const HiddenEffect& asked, std::size_t index);
  double typical_strength(OutsidePhysics::Kind kind, int joint) const;
  std::vector<std::vector<double>> drawn_times(std::size_t index) const;
  void set_strength(OutsidePhysics& physics, double strength) const;
  void begin_at_samples(std::vector<std::vector<double>>& times) const;
  std::vector<Channels> simulated(std::span<const int> segments, const std::vector<Channel>& channels,
                                  const TrueLaws& laws, double tolerance) const;
  void add_uneven();
  void add_background();
  double response(const std::vector<Channels>& still, const Background& background) const;
  std::vector<UnevenParameter> uneven_in(const PlantModel& model) const;
  const Travel& plain_travel();

  const Scenario& scenario_;
  const ConcealOptions& options_;
  PlantModel plain_;
  Experiment experiment_;
  SearchSpace space_;
  std::vector<double> values_;
  std::vector<int> train_;
  std::optional<Travel> plain_travel_;  ///< once a form was drawn within it
  std::vector<UnevenLaw> uneven_;       ///< one a hidden effect
  Background background_;
  std::vector<EffectSpec> misplaced_;
};

}  // namespace lacuna
