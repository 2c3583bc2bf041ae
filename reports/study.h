// The study's record and its page.
#pragma once

#include <span>
#include <string>

#include "reports/context.h"
#include "study/excitation.h"
#include "study/study.h"

namespace lacuna {

/// `study.json`, format lacuna-study/1: one record a scenario.
std::string to_json(std::span<const Study> studies, const Context& context);
/// `report.html` beside it.
std::string study_page(std::span<const Study> studies, const Context& context);

/// `excitation.json`, format lacuna-excitation/1. `file`: where the commands were written.
std::string to_json(const DesignResult& result, const std::string& scenario, const std::string& file,
                    const Context& context);
/// `report.html` beside it. `joints`: the plant's, with the `units` of their commands.
std::string excitation_page(const DesignResult& result, const std::string& scenario,
                            const std::vector<std::string>& joints, const std::vector<std::string>& units,
                            const Context& context);

}  // namespace lacuna
