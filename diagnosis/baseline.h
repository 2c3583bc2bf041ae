// Step 1: the plain model identified as well as it can be, residuals weighed by what each channel really leaves.
#pragma once

#include <span>

#include "diagnosis/diagnosis.h"
#include "diagnosis/screen.h"

namespace lacuna {

/// rms of white noise that would leave what sixth differences show of the channel, median over segments; NaN: unknown.
double noise_seen(const Experiment& experiment, std::size_t channel);

/// rms of each predicted channel's noise: what the scenario states or the recordings show, whichever is larger (a
/// stated figure may leave out the transducer's steps). NaN where nothing is known.
std::vector<double> noise_levels(const Experiment& experiment);
/// The same in units of the weights, as whitened residuals are.
std::vector<double> noise_over_weight(const Experiment& experiment, std::span<const double> weights);

/// Weights for the next fit: the noise where the residual is down to it, the residual's own rms elsewhere, so that a
/// joint with a misfit does not outweigh the others.
std::vector<double> weights_from(const CurrentModel& current, const FitContext& context);

/// Other weights, and the model's residual and sensitivities on the train recordings in them.
void change_weights(CurrentModel& model, const FitContext& context, std::vector<double> weights);

constexpr double kRefitTolerance = 1e-3;  ///< relative change of the energy at which a refit has arrived
constexpr int kRefitIterations = 25;

/// Least squares on the train recordings from the model's present point, with its present weights, until a step gains
/// less than `tolerance` of the energy. `jacobian`: there, if it is known. False, the model as it was, where it cannot
/// be simulated from that point.
bool refit(CurrentModel& model, const FitContext& context, double tolerance = kRefitTolerance,
           const Eigen::MatrixXd* jacobian = nullptr, int iterations = kRefitIterations);

/// Least squares from the model's present point, weights brought up to date and the fit repeated until they stand.
void refine(CurrentModel& current, const FitContext& context, int iterations = kRefitIterations);

/// The model refined at the step that its numbers need: the context's, halved as long as the integration error moves
/// one of them by more than a fifth of its standard error (shift_by_integration). That step, s.
double settle(CurrentModel& current, FitContext context);

/// The model at a point, its residual and sensitivities on the train recordings evaluated there: same point, same bits.
void evaluate_at(CurrentModel& model, std::vector<double> point, const FitContext& context);

/// The model at its point on other recordings than it was fitted to.
CurrentModel seen_in(const CurrentModel& model, const FitContext& context);

/// Least squares from the scenario's start values and from draws about them until two of them meet
/// (from_several_starts); where none do, or where they have found little of the motion, the population search that
/// `options` names and least squares from its best as well; the best of all refined. `fit` receives the record of it,
/// and with priors whether it has arrived.
CurrentModel identify_plain(const PlantModel& model, const Experiment& experiment, const SearchSpace& space,
                            const IdentifyOptions& options, FitResult& fit);

/// Record of a refined model: estimates, identifiability, rms per role.
void record_fit(const CurrentModel& current, const FitContext& context, FitResult& fit);

}  // namespace lacuna
