// `compare.json` and the page beside it: a comparison of engines, its verdict, and what changed since an older one.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "reports/context.h"
#include "reports/report.h"
#include "compare/comparison.h"

namespace lacuna {

/// Which engine serves one need, with the figures that say so.
struct Recommendation {
  std::string need;
  std::vector<std::string> best;                        ///< engines that are the best or as good
  std::string measure;                                  ///< what the figures are, with their unit
  std::vector<std::pair<std::string, double>> figures;  ///< per engine; NaN: not measured, or never reached
  std::string remark;
};
/// Figures over several scenarios are medians (times, memory) or the worst (errors, drifts) of those that all engines
/// in the verdict could run.
std::vector<Recommendation> recommendations(const Comparison& comparison);

/// One figure that differs from an older comparison by more than its noise.
struct Change {
  std::string scenario, engine, quantity;
  double before = 0.0, after = 0.0;
  double limit = 0.0;  ///< factor beyond which it counts
  bool better = false;
};
struct Baseline {
  std::string file, date, commit;  ///< of the older comparison
  std::size_t compared = 0;        ///< figures that both have
  std::vector<Change> changes;
  bool empty() const { return file.empty(); }
};
/// Timings count in units of Featherstone's evaluation in the same run, so that a busier or slower machine is no
/// change; beyond noise is what exceeds three times both runs' quartile spread and 10 %. Errors and drifts count where
/// they change by over 10 % and exceed rounding. Throws InputError for text that is no compare.json.
Baseline changes_since(const std::string& old_json, const std::string& file, const Comparison& now);

/// format lacuna-compare/1. `engines` has one record each with the worst errors and median times over all scenarios;
/// `scenarios` has everything.
std::string to_json(const Comparison& comparison, const Baseline& baseline, const Context& context);

std::string comparison_page(const Comparison& comparison, const Baseline& baseline, const Context& context,
                            std::span<const Picture> pictures);

/// `compare.json` and `report.html` in `folder`, created where it is missing. Throws WriteError.
void write_comparison_report(const std::filesystem::path& folder, const Comparison& comparison,
                             const Baseline& baseline, const Context& context, std::span<const Picture> pictures);

}  // namespace lacuna
