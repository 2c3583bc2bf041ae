// What `lacuna conceal` hides: a true machine that differs from the scenario's model, and what its recordings would
// hold.
//
// The true machine is the scenario's plant with every free parameter moved by a drawn share, plus the effects asked
// for. It is simulated by physics/truth.h: another engine and another integrator than those which identify. The
// recordings keep the scenario's commands, clocks and roles.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/truth.h"
#include "trial/hidden_effect.h"
#include "trial/imperfections.h"

namespace lacuna {

enum class NoiseKind {
  white,
  coloured,  ///< first-order autoregressive, correlated over five sampling periods
  quantised  ///< steps of a transducer over a little white noise
};
const char* to_string(NoiseKind kind);
/// Throws InputError.
NoiseKind noise_from_name(const std::string& name);

struct ConcealOptions {
  std::vector<HiddenEffect> effects;
  NoiseKind noise = NoiseKind::white;
  double perturb_least = 0.1, perturb_most = 0.3;  ///< share by which each free parameter is moved, up or down
  Imperfections imperfections;
  std::optional<double> visibility;  ///< left rms over noise that each effect alone shall have after a plain refit
  std::string engine = "simbody";
  int threads = 1;
  std::uint64_t seed = 1;
  const StopFlag* stop = nullptr;
};

/// A hidden effect as it came out.
struct ConcealedEffect {
  HiddenEffect asked;
  double strength = 0.0;                                   ///< the leading parameter
  std::vector<std::pair<std::string, double>> parameters;  ///< all of them, catalogue effects only
  std::optional<LawRecord> law;                            ///< outside the catalogue only: its curve, or what happened
  std::optional<UnevenLaw> uneven = {};                    ///< where its strength changes along its way
  std::vector<std::pair<std::string, double>> drift = {};  ///< strength by recording, where these differ
};

struct Concealment {
  Scenario scenario;  ///< the plain model; its recordings hold what the true machine did, noise included
  std::vector<ConcealedEffect> effects;
  std::vector<EffectSpec> misplaced;                  ///< centres of mass, as effects
  std::vector<std::pair<std::string, double>> truth;  ///< true values of the scenario's free parameters, full names
  std::vector<std::pair<std::string, double>> noise;  ///< rms per joint and kind, channel units
  double raw_rms_over_noise = 0.0;                    ///< what the effects change, before any refit
  double left_rms_over_noise = 0.0;  ///< what a refit of the plain model leaves of it (train recordings, all channels)
};

/// Throws InputError for effects or places that do not exist, values out of range, a scenario without a train
/// recording; WorkError where the visibility cannot be reached or the motion diverges; Interrupted. Recordings of the
/// result are named as the scenario names them, `.csv` at the end, without folders above the scenario's.
Concealment conceal(const Scenario& scenario, const ConcealOptions& options);

}  // namespace lacuna
