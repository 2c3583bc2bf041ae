#include "ga/fitness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "ga/enum_names.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 6> fitness_names = {"norm_1",          "norm_1_relative", "norm_2",
                                                      "norm_2_relative", "norm_inf",        "norm_inf_relative"};
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

const char* to_string(Fitness fitness) { return fitness_names[static_cast<std::size_t>(fitness)]; }
Fitness fitness_from_name(const std::string& name) { return enum_from_name<Fitness>("fitness", fitness_names, name); }

double norm_order(Fitness fitness) {
  switch (fitness) {
    case Fitness::norm_1:
    case Fitness::norm_1_relative: return 1.0;
    case Fitness::norm_2:
    case Fitness::norm_2_relative: return 2.0;
    default: return infinity;
  }
}

bool is_relative(Fitness fitness) {
  return fitness == Fitness::norm_1_relative || fitness == Fitness::norm_2_relative ||
         fitness == Fitness::norm_inf_relative;
}

void NormAccumulator::Sums::add(double value) {
  const double size = std::abs(value);
  absolute += size;
  squares += size * size;
  largest = std::max(largest, size);
}

void NormAccumulator::Sums::merge(const Sums& other) {
  absolute += other.absolute;
  squares += other.squares;
  largest = std::max(largest, other.largest);
}

double NormAccumulator::Sums::norm(double order) const {
  if (order == 1.0) return absolute;
  return order == 2.0 ? std::sqrt(squares) : largest;
}

void NormAccumulator::add(double error, double data) {
  if (std::isnan(data)) {
    ++missing_;
    return;
  }
  ++used_;
  errors_.add(std::isfinite(error) ? error : infinity);
  data_.add(data);
}

void NormAccumulator::merge(const NormAccumulator& other) {
  errors_.merge(other.errors_);
  data_.merge(other.data_);
  used_ += other.used_;
  missing_ += other.missing_;
}

double NormAccumulator::error_norm(Fitness fitness) const {
  return used_ == 0 ? infinity : errors_.norm(norm_order(fitness));
}

double NormAccumulator::data_norm(Fitness fitness) const { return data_.norm(norm_order(fitness)); }

double NormAccumulator::fitness(Fitness fitness) const {
  const double error = error_norm(fitness);
  if (!is_relative(fitness)) return -error;
  const double data = data_norm(fitness);
  return data > 0.0 && std::isfinite(error) ? -error / data : -infinity;
}

double norm(std::span<const double> values, double order) {
  if (order != 1.0 && order != 2.0 && order != infinity) {
    throw std::invalid_argument("norm: order = " + std::to_string(order) + ", allowed: 1, 2, infinity");
  }
  double sum = 0.0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    const double size = std::abs(value);
    sum = order == 1.0 ? sum + size : order == 2.0 ? sum + size * size : std::max(sum, size);
  }
  return order == 2.0 ? std::sqrt(sum) : sum;
}

double fitness_of(Fitness fitness, std::span<const double> errors, std::span<const double> data) {
  if (errors.size() != data.size()) throw std::invalid_argument("fitness_of: errors and data differ in length");
  NormAccumulator norms;
  for (std::size_t i = 0; i < errors.size(); ++i) norms.add(errors[i], data[i]);
  return norms.fitness(fitness);
}

}  // namespace lacuna
