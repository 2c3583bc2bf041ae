// Bodies of the sections that reports share.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "reports/html.h"
#include "reports/marks.h"
#include "reports/report.h"

namespace lacuna {

/// Estimates with their intervals and what limits them; names that start with one of `emphasised` stand out.
Html parameter_section(const std::vector<Estimate>& estimates, const std::vector<std::string>& emphasised = {});

/// What the data determine, in words.
Html identifiability_section(const FitResult& fit);

/// The population search: cost by generation.
Html convergence_section(const FitResult& fit);

struct TraceWords {
  std::string before = "before", after = "after";
};
/// Measured against simulated with the residual below it: one pair of plots per trace. Joints in `leading` are drawn
/// over the full width and first, the others two to a row. `noise` may be empty. `shaded`: times to mark, by joint.
struct TraceOptions {
  TraceWords words;
  std::vector<std::string> leading;
  JointRms noise;
  std::vector<Finding> findings;  ///< whose times are shaded in traces of the same recording
};
Html trace_section(std::span<const Trace> traces, const TraceOptions& options);

/// Joint by joint, the effort that the plain model lacks.
Html missing_effort_section(std::span<const MissingEffort> missing);

/// The chain from command to motion of joints whose pressures are measured, with its parts' mismatches; `two`: of the
/// plain and of the diagnosed model, else of the plain one.
Html chain_section(std::span<const JointChain> chains, bool two);

/// The laws that were learned: each as a curve with its band, and what it looks like.
Html learned_section(std::span<const LearnedLaw> laws);
/// What happened once in a recording, one row an event.
Html events_section(std::span<const LearnedEvent> events, Marks& marks);

/// The colour of what is left; the joints in `drawn` as plots. `two`: before and after, else after alone.
Html whiteness_section(std::span<const Whiteness> joints, std::span<const std::string> drawn, bool two);

Html picture_section(std::span<const Picture> pictures);

Html context_section(const Context& context);

/// A list of terms and what they are.
Html facts(const std::vector<std::pair<std::string, Html>>& entries);

}  // namespace lacuna
