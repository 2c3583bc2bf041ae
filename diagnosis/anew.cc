#include "diagnosis/anew.h"

#include "diagnosis/baseline.h"
#include "diagnosis/contest.h"
#include "diagnosis/where.h"
#include "diagnosis/without.h"
#include "diagnosis/worth.h"

namespace lacuna {

void judge_anew(const CurrentModel& plain, const CurrentModel& current, std::vector<Finding>& findings,
                const Experiment& experiment, const SimulatorOptions& options, const RunControl& control, int tries,
                std::uint64_t seed) {
  for (std::size_t k = 0; k < findings.size(); ++k) {
    settle(findings[k], contest(k, plain, current, findings, experiment, options, control));
    CurrentModel rest = rebuilt(plain, current, findings, experiment, k);
    if (!refit(rest, experiment, options, control)) continue;
    const Worth worth = worth_over(current, rest, experiment, options);
    const HeldoutGain heldout = worth.heldout.value_or(HeldoutGain{});
    Finding& finding = findings[k];
    finding.p_value = worth.chance(tries);
    finding.heldout_gain = heldout.gain, finding.heldout_error = heldout.error, finding.heldout_share = heldout.share;
    finding.stability = stability(heldout.blocks, std::vector<double>(heldout.blocks.size(), 0.0), seed);
    describe_evidence(finding, rest, current, experiment, options);
  }
}

}  // namespace lacuna
