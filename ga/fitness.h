// The seed's six fitness functions: -norm_a(e) (its eq. 3), -norm_a(e) / norm_a(data) (its eq. 2), a = 1, 2, infinity.
// The cost to be lowered is -fitness. For one recording the two of the same a differ by a constant factor, so they rank
// alike and only their curves look different.
#pragma once

#include <limits>
#include <span>
#include <string>

namespace lacuna {

enum class Fitness { norm_1, norm_1_relative, norm_2, norm_2_relative, norm_inf, norm_inf_relative };
const char* to_string(Fitness fitness);
Fitness fitness_from_name(const std::string& name);

/// a of the norm: 1, 2 or infinity.
double norm_order(Fitness fitness);
/// True if the error's norm is divided by the data's.
bool is_relative(Fitness fitness);

/// Norms of errors and data that arrive sample by sample, so that nothing needs to be stored. It keeps what all three
/// norms need: one pass serves any fitness, and the output error index (the infinity norm) beside it.
///
/// A sample without data (NaN) is missing: left out and counted. A sample with data but without a finite error is a
/// failed simulation: every norm of the error becomes infinity.
class NormAccumulator {
 public:
  /// `error` = simulated - measured, `data` = measured, both in the channel's unit.
  void add(double error, double data);

  /// Adds what another one saw. Exact for counts and the infinity norm; sums round in the order of merging.
  void merge(const NormAccumulator& other);

  /// Norm of the errors; infinity if nothing was compared.
  double error_norm(Fitness fitness) const;
  /// Norm of the data of the samples that were compared.
  double data_norm(Fitness fitness) const;

  /// One of the seed's six, at most 0, -infinity for a failed simulation or relative to data that are all zero.
  double fitness(Fitness fitness) const;
  /// -fitness, what an optimiser lowers.
  double cost(Fitness fitness) const { return -this->fitness(fitness); }

  long used() const { return used_; }
  long missing() const { return missing_; }

 private:
  struct Sums {
    double absolute = 0.0, squares = 0.0, largest = 0.0;
    void add(double value);
    void merge(const Sums& other);
    double norm(double order) const;
  };

  Sums errors_, data_;
  long used_ = 0, missing_ = 0;
};

/// Norm of order 1, 2 or infinity of a vector, NaN left out; 0 if nothing is left. Throws std::invalid_argument for
/// another order.
double norm(std::span<const double> values, double order);

/// The same over vectors of equal length.
double fitness_of(Fitness fitness, std::span<const double> errors, std::span<const double> data);

}  // namespace lacuna
