// What the diagnosed model leaves: where it is more than noise, what room that leaves to the claims, and the verdict.
//
// While a rest stays unexplained the model is known to be wrong, and what explains the rest may explain a finding as
// well. What tells them apart is the finding's share in what would be missing at its place without it: what it removes
// over that and the rest. A law that stands for another explains little of it; one that is there explains as much as it
// may. So each finding's probability is multiplied by w(share), odds w / (1 - w) = A / (1 - share)^B, with A and B from
// the project's own concealed machines (docs/method.md). Of several findings at a place one may do what another does.
// They are taken out one after the other, the one that is missed least first, and each has the largest share that it
// comes to: the last has all that no other could do.
#pragma once

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Fills in out.unexplained, leaves room for it in out.findings, and sets out.verdict: `unknown_physics` where a rest
/// is left and no finding that is more likely than not explains most of what was missing at its place. Judged by the
/// validate recordings (the train ones where there are none). `before`: the plain model; `after`: with the findings,
/// and no law without a name.
void judge_rest(Diagnosis& out, const CurrentModel& before, const CurrentModel& after, const FitContext& context);

/// A rest on the test recordings that those which decide do not have: it changes no verdict, but is said.
void note_test_rest(Diagnosis& out, const CurrentModel& after, const FitContext& context);

}  // namespace lacuna
