// Optimisers of the pagmo2 library behind the same call as the genetic algorithm, so that a user sees what it buys.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ga/optimizer.h"

namespace lacuna {

enum class PagmoMethod {
  cmaes,  ///< covariance matrix adaptation (N. Hansen), clipped to the box, first step 0.3 of its width
  de,     ///< differential evolution that adapts its own factors (jDE: J. Brest et al.; pagmo's sade)
  pso,    ///< particle swarm, generational
  sga     ///< pagmo's simple real-coded genetic algorithm
};
const char* to_string(PagmoMethod method);
PagmoMethod pagmo_method_from_name(const std::string& name);

struct PagmoOptions {
  PagmoMethod method = PagmoMethod::cmaes;
  int population = 70;    ///< at least 5 (cmaes), 7 (de), 2 (pso, sga)
  int generations = 200;  ///< populations evaluated, the first one included; at least 1
  std::uint64_t seed = 1;
  std::vector<std::vector<double>> start_points;  ///< replace the first individuals of the random first population
};

/// Throws std::invalid_argument with the option's name, the value found and the range allowed.
void validate(const PagmoOptions& options, const Box& box);

/// Runs the method with its library defaults otherwise, on the box scaled to a unit cube. The cost is asked for whole
/// generations. The same options, box and cost give the same result to the last bit, resumed or not.
///
/// A method that has converged before its budget is spent starts anew from a random population; the best point of all
/// starts is returned. Failed evaluations count as worse than any other. As with the genetic algorithm, the checkpoint
/// is kept until the caller removes it, and may be resumed with more generations.
OptimizerResult run_pagmo(const Box& box, const BatchCost& cost, const PagmoOptions& options,
                          const RunControl& control = {});

}  // namespace lacuna
