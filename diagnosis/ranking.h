// Which of several candidates is the most probable, and how probable it is.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/judge.h"

namespace lacuna {

/// Train and validate gain less the Schwarz penalty. All are counted at the effective samples of the strongest, since
/// the error of that count would otherwise outweigh the difference between two near-perfect candidates. An integration
/// error of e noise rms changes a residual's energy by up to e^2 of the noise's: gains nearer than that are not told
/// apart. That lifts no candidate over chance: what it has over nothing (`over_chance`) is its own.
void sort_by_evidence(std::vector<Tried>& tried, double integration_error);

/// The one with the most evidence that can be what is missing, re-identified if it was not yet; nothing where none can.
/// Every candidate has its objection from then on, and all stand in the order of the evidence that they have then.
std::optional<std::size_t> strongest_that_can(Judge& judge, std::vector<Tried>& tried, double integration_error);

/// Shares of exp(evidence) among the candidates that can be what is missing, chance (evidence 0, prior weight that of
/// all candidates together) included. The others have none: what removes a small part of the rest is no rival of what
/// removes most of it, however clearly it does. What is left of 1 is chance's.
std::vector<double> probabilities(const std::vector<Tried>& tried);

/// The `winner` with its probability, its rivals and its class.
Finding make_finding(const std::vector<Tried>& tried, std::size_t winner, std::uint64_t seed);

}  // namespace lacuna
