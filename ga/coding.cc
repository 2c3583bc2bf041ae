#include "ga/coding.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ga/enum_names.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 2> coding_names = {"mvbs", "integer"};

}  // namespace

const char* to_string(Coding coding) { return coding_names[static_cast<std::size_t>(coding)]; }
Coding coding_from_name(const std::string& name) { return enum_from_name<Coding>("coding", coding_names, name); }

double decode_gene(Gene gene, double lower, double upper) {
  // The last gene is the bound itself, not the bound after rounding.
  if (gene == largest_gene) return upper;
  return lower + (upper - lower) * gene / largest_gene;
}

Gene encode_gene(double value, double lower, double upper) {
  const double place = (value - lower) / (upper - lower) * largest_gene;
  return static_cast<Gene>(std::lround(std::clamp(place, 0.0, double{largest_gene})));
}

std::vector<double> decode(const Chromosome& chromosome, const Box& box) {
  std::vector<double> values(chromosome.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = decode_gene(chromosome[i], box.lower[i], box.upper[i]);
  return values;
}

Chromosome encode(std::span<const double> values, const Box& box) {
  Chromosome chromosome(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) chromosome[i] = encode_gene(values[i], box.lower[i], box.upper[i]);
  return chromosome;
}

int string_length(Coding coding, std::size_t genes) {
  return static_cast<int>(genes) * (coding == Coding::mvbs ? bits_per_gene : 1);
}

}  // namespace lacuna
