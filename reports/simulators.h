// One simulator against another: the record (`simulators.json`) and the page.
#pragma once

#include <filesystem>
#include <string>

#include "reports/context.h"
#include "compare/simulators.h"

namespace lacuna {

/// What was found, in one or two plain sentences.
std::string simulators_sentence(const SimulatorComparison& comparison);
/// "physics", "the integrator", ...
std::string origin_words(Origin origin);

/// format lacuna-simulators/1.
std::string to_json(const SimulatorComparison& comparison, const Context& context);
std::string simulators_page(const SimulatorComparison& comparison, const Context& context);

/// `simulators.json` and `report.html` in `folder`, each whole or not at all. Throws WriteError.
void write_simulators_report(const std::filesystem::path& folder, const SimulatorComparison& comparison,
                             const Context& context);

}  // namespace lacuna
