// Signals as short JSON, for a page's scripts to unpack (reports/page/data.js).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

namespace lacuna {

/// A number of six digits; null where it is not finite.
nlohmann::ordered_json six_digits(double value);

/// {"from", "step", "d"}: value i is from + step times the sum of d up to i, null where it is not finite; the step is a
/// power of ten, at most 1e-5 of the range. Of at most 200 values, of extreme ones and with `log` (what is seen on a
/// logarithmic axis keeps its relative precision) a list of six_digits.
nlohmann::ordered_json packed(std::span<const double> values, bool log = false);

}  // namespace lacuna
