// Chromosomes and what they mean: 16 bits a gene in both codings of the seed paper. The codings decode alike; they
// differ in what an operator may touch: single bits (MVBS, multivariable binary string) or whole genes (integer).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ga/optimizer.h"

namespace lacuna {

enum class Coding { mvbs, integer };
const char* to_string(Coding coding);
Coding coding_from_name(const std::string& name);

using Gene = std::uint16_t;
using Chromosome = std::vector<Gene>;
inline constexpr int bits_per_gene = 16;
inline constexpr Gene largest_gene = 65535;

/// lower + (upper - lower) * gene / 65535; exactly lower for 0 and exactly upper for 65535.
double decode_gene(Gene gene, double lower, double upper);

/// The gene whose value is nearest; values outside the interval give its ends. Off by at most half a step,
/// (upper - lower) / 131070.
Gene encode_gene(double value, double lower, double upper);

/// Gene by gene; `chromosome` or `values` has the box's length.
std::vector<double> decode(const Chromosome& chromosome, const Box& box);
Chromosome encode(std::span<const double> values, const Box& box);

/// Places at which operators can act on a chromosome of `genes` genes: its bits (MVBS) or its genes (integer).
int string_length(Coding coding, std::size_t genes);

}  // namespace lacuna
