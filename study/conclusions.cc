#include "study/conclusions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lacuna {
namespace {

constexpr double kReasonableShare = 25.0;  // percent of a parameter, on average: what "reasonable accuracy" is read as
constexpr double kTracksShare = 0.05;      // of the range travelled: what "tracks reasonably well" is read as

const char* const kComparison = "rank-sum test of the runs' final values, two-sided, 5 %; the direction by the medians";

std::string quartile_words(const std::vector<double>& values, const std::string& unit = "") {
  const Quartiles q = quartiles_of(values);
  return fmt::format("{:.4g} ({:.4g} to {:.4g}){}{}", q.median, q.low, q.high, unit.empty() ? "" : " ", unit);
}

/// One comparison, `paper_best` expected to end lower than each of the others.
Conclusion comparison(const GridRecord& grid, const std::string& source, const std::string& claim,
                      double (*what)(const SearchRun&), const std::string& unit, const std::string& paper_best,
                      const std::vector<std::string>& others) {
  Conclusion out{source, claim, kComparison, "", Judgement::holds};
  const SettingRecord& best = *grid.find(paper_best);
  const std::vector<double> ours = best.each(what);
  out.finding = fmt::format("{}: {}", best.title, quartile_words(ours, unit));
  bool open = false, against = false;
  for (const std::string& key : others) {
    const SettingRecord& other = *grid.find(key);
    const std::vector<double> theirs = other.each(what);
    const Judgement verdict = compare_runs(ours, theirs);
    open = open || verdict == Judgement::cannot_be_told;
    against = against || verdict == Judgement::does_not_hold;
    out.finding +=
        fmt::format("; {}: {}, p = {:.2g}", other.title, quartile_words(theirs, unit), rank_sum_p(ours, theirs));
  }
  out.verdict = against ? Judgement::does_not_hold : open ? Judgement::cannot_be_told : Judgement::holds;
  return out;
}

/// A share of the runs that meets a criterion: holds when most do, does not when fewer than half.
Conclusion majority(const std::string& source, const std::string& claim, const std::string& rule,
                    const std::vector<double>& values, double most, const std::string& unit) {
  const auto hits = std::count_if(values.begin(), values.end(), [&](double x) { return x <= most; });
  const double share = static_cast<double>(hits) / static_cast<double>(values.size());
  return {source, claim, rule, fmt::format("{} of {} runs; {}", hits, values.size(), quartile_words(values, unit)),
          share > 0.5   ? Judgement::holds
          : share < 0.5 ? Judgement::does_not_hold
                        : Judgement::cannot_be_told};
}

/// Two settings that cannot differ, because one ranks as the other does, end alike: then neither is the lower.
Conclusion denominator(const GridRecord& grid, const std::string& unit) {
  Conclusion out =
      comparison(grid, "table 3", "the infinity norm without denominator gives a lower output error index than with it",
                 output_largest, unit, "final", {"fitness.norm_inf_relative"});
  out.rule += "; does not hold where every run ends at the very same parameters with and without";
  for (const RankingCheck& check : grid.rankings) {
    if (check.norm != to_string(Fitness::norm_inf) || check.runs == 0 || check.same_answer < check.runs) continue;
    out.verdict = Judgement::does_not_hold;
    out.finding =
        fmt::format("{} of {} runs end at the very same parameters; {}", check.same_answer, check.runs, out.finding);
  }
  return out;
}

Conclusion overshoots(const OutputTrace& output) {
  Conclusion out{
      "fig. 8", "the estimated output overshoots at the peaks",
      "share of the measured motion's turning points that the median run goes beyond, within 0.1 s: most, or "
      "fewer than half",
      fmt::format("{:.0f} of {} turning points", output.overshot * output.peaks, output.peaks),
      Judgement::cannot_be_told};
  if (output.peaks > 0 && output.overshot > 0.5) out.verdict = Judgement::holds;
  if (output.peaks > 0 && output.overshot < 0.5) out.verdict = Judgement::does_not_hold;
  return out;
}

}  // namespace

const char* to_string(Judgement verdict) {
  switch (verdict) {
    case Judgement::holds: return "holds";
    case Judgement::does_not_hold: return "does not hold";
    case Judgement::cannot_be_told: return "cannot be told";
  }
  return "";
}

Judgement compare_runs(std::span<const double> better, std::span<const double> worse) {
  if (rank_sum_p(better, worse) >= kSignificance) return Judgement::cannot_be_told;
  return quartiles_of(better).median < quartiles_of(worse).median ? Judgement::holds : Judgement::does_not_hold;
}

std::vector<Conclusion> judge(const GridRecord& grid, const std::string& unit, std::size_t parameters) {
  std::vector<Conclusion> out;
  if (grid.settings.empty()) return out;
  const auto add = [&](const char* source, const char* claim, auto what, const std::string& in, const char* best,
                       const std::vector<std::string>& others) {
    out.push_back(comparison(grid, source, claim, what, in, best, others));
  };
  add("fig. 3", "MVBS coding ends better than integer coding", final_cost, unit, "final", {"coding.integer"});
  add("fig. 4", "pointwise crossover ends better than uniform crossover by gene", final_cost, unit, "final",
      {"crossover.uniform_gene"});
  add("fig. 5", "a crossover rate of 0.8 ends lower than 0.6 and 1.0", final_cost, unit, "final",
      {"crossover_rate.0.6", "crossover_rate.1.0"});
  add("fig. 7", "the two-norm reaches its final value in the fewest generations", convergence_generation, "generations",
      "fitness.norm_2", {"final", "fitness.norm_1"});
  add("table 3", "the infinity norm gives a lower output error index than one-norm and two-norm", output_largest, unit,
      "final", {"fitness.norm_1", "fitness.norm_2"});
  out.push_back(denominator(grid, unit));
  const std::vector<double> index = grid.settings.front().each(parameter_index);
  const bool known = std::none_of(index.begin(), index.end(), [](double x) { return std::isnan(x); });
  if (known) {
    add("table 3", "the infinity norm gives a lower parameter error index than the other norms", parameter_index, "%",
        "final", {"fitness.norm_inf_relative", "fitness.norm_1", "fitness.norm_2"});
    out.push_back(
        majority("table 5, conclusions", "the GA estimates the parameters with reasonable accuracy",
                 fmt::format("most runs of the final setting have a parameter error index of at most {:.0f} % a "
                             "parameter ({:.0f} % in all)",
                             kReasonableShare, kReasonableShare * static_cast<double>(parameters)),
                 index, kReasonableShare * static_cast<double>(parameters), "%"));
  }
  if (grid.output.measured.empty()) return out;
  std::vector<double> finite;
  std::copy_if(grid.output.measured.begin(), grid.output.measured.end(), std::back_inserter(finite),
               [](double x) { return std::isfinite(x); });
  const auto [low, high] = std::minmax_element(finite.begin(), finite.end());
  out.push_back(
      majority("fig. 8", "the estimated output tracks the true one reasonably well",
               "most runs of the final setting have an rms output error of at most 5 % of the range travelled",
               grid.settings.front().each(output_rms), kTracksShare * (*high - *low), unit));
  out.push_back(overshoots(grid.output));
  return out;
}

}  // namespace lacuna
