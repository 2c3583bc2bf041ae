#include "diagnosis/anew.h"

#include "diagnosis/baseline.h"
#include "diagnosis/contest.h"
#include "diagnosis/where.h"
#include "diagnosis/without.h"
#include "diagnosis/worth.h"

namespace lacuna {

void judge_anew(const CurrentModel& plain, const CurrentModel& current, std::vector<Finding>& findings,
                const FitContext& context, int tries, std::uint64_t seed) {
  for (std::size_t k = 0; k < findings.size(); ++k) {
    settle(findings[k], contest(k, plain, current, findings, context));
    CurrentModel rest = rebuilt(plain, current, findings, context.experiment, k);
    if (!refit(rest, context)) continue;
    const Worth worth = worth_over(current, rest, context);
    const HeldoutGain heldout = worth.heldout.value_or(HeldoutGain{});
    Finding& finding = findings[k];
    finding.p_value = worth.chance(tries);
    finding.heldout_gain = heldout.gain, finding.heldout_error = heldout.error, finding.heldout_share = heldout.share;
    finding.stability = stability(heldout.blocks, std::vector<double>(heldout.blocks.size(), 0.0), seed);
    describe_evidence(finding, rest, current, context);
  }
}

}  // namespace lacuna
