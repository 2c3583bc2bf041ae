// The paper's figures, cited, and its conclusions, judged by what the repeated runs show.
//
// A comparison of two settings holds when the runs' rank-sum test is below 5 % (two-sided) and the medians lie as the
// paper says, does not when it is below 5 % and they lie the other way round, and cannot be told otherwise. The rule of
// every other claim is stated in its `rule`.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "study/grid.h"

namespace lacuna {

enum class Judgement { holds, does_not_hold, cannot_be_told };
const char* to_string(Judgement verdict);

struct Conclusion {
  std::string source;   ///< "fig. 3"
  std::string claim;    ///< the paper's, in short
  std::string rule;     ///< how it is judged
  std::string finding;  ///< the figures that decide
  Judgement verdict = Judgement::cannot_be_told;
};

inline constexpr double kSignificance = 0.05;
inline constexpr const char* kBeyondThePaper = "beyond the paper";  ///< source of judgements on what it does not claim

/// Judgement of "`better` ends lower than `worse`".
Judgement compare_runs(std::span<const double> better, std::span<const double> worse);

/// In the paper's order. Claims about parameters are left out where the truth is unknown (their figures are NaN).
std::vector<Conclusion> judge(const GridRecord& grid, const std::string& unit, std::size_t parameters);

/// What the paper prints, one run each. Source: "A genetic algorithm approach for parameter optimization of a 7DOF
/// robotic manipulator", tables 1 to 5.
namespace paper {

inline constexpr std::array<const char*, 9> kParameters = {"joint_2.gain", "joint_2.damping", "joint_2.stiffness",
                                                           "link_1.mass",  "link_2.mass",     "link_3.mass",
                                                           "link_4.mass",  "link_5.mass",     "link_6.mass"};
/// Units as understood here: gain kN m/V, damping N m s/rad, stiffness N m/deg, masses kg (the paper prints none).
struct Values {
  const char* table;
  const char* row;
  std::array<double, 9> numbers;
};
inline constexpr std::array<Values, 4> kValues = {
    {{"table 1", "true", {0.2, 231.8, 53.4, 4.6, 5.1, 22.5, 1.6, 4.1, 4.7}},
     {"table 1", "initial", {0.1, 100, 20, 0.6, 1.3, 2.8, 1.2, 2.2, 1.7}},
     {"table 5", "estimated", {0.03, 93, 99.9, 9.2, 20, 5.9, 9.6, 15.54, 1.2}},
     {"table 5", "true", {0.02, 48, 87.4, 5.8, 12.7, 6.9, 7.75, 8.31, 4.2}}}};

/// Tables 2 and 3, by fitness function: relative errors of the nine parameters in percent, lowest fitness, errors.
struct FitnessRow {
  const char* fitness;  ///< as to_string(Fitness) says
  std::array<double, 9> relative_errors;
  double lowest_fitness, output_error_index, parameter_error_index;
};
inline constexpr std::array<FitnessRow, 4> kFitness = {
    {{"norm_inf", {50, 26.0, 42.5, 19.6, 5.9, 43.1, 12.5, 22.0, 106.4}, -0.6458, 0.645, 327},
     {"norm_inf_relative", {50, 32.5, 47.6, 23.9, 80.4, 78.2, 393.8, 24.4, 12.8}, -0.1275, 0.651, 743},
     {"norm_1", {100, 82.6, 43.1, 84.8, 94.1, 96.4, 250.0, 146.3, 72.3}, -836.54, 0.85, 969},
     {"norm_2", {50, 57.9, 29.4, 23.9, 9.8, 84.0, 93.8, 19.5, 21.3}, -14.5172, 0.82, 389}}};

}  // namespace paper
}  // namespace lacuna
