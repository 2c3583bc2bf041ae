// Two sets of recordings compared: the record (FORMATS: diff.json) and the page.
#pragma once

#include <filesystem>
#include <string>

#include "reports/context.h"
#include "diff/diff.h"

namespace lacuna {

/// `diff.json`, format lacuna-diff/1.
std::string to_json(const Diff& diff, const Context& context);

/// The page alone. `scenario`: of either set, for units.
std::string diff_page(const Scenario& scenario, const Diff& diff, const Context& context);

/// `diff.json` and `report.html` in `folder`, each whole or not at all. Throws WriteError.
void write_diff_report(const std::filesystem::path& folder, const Scenario& scenario, const Diff& diff,
                       const Context& context);

/// What was found, in one plain sentence.
std::string diff_sentence(const Diff& diff);
/// With its interval; the value alone where it is exact (an effect that acts nowhere), nothing where there is none.
std::string number_words(const Estimate& estimate);
/// "Coulomb friction at joint_2", "the gain of joint_2", "the mass of link_3".
std::string change_words(const MachineChange& change);

}  // namespace lacuna
