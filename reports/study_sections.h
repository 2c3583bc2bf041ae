// Sections of the study's page; each is empty where its part was left out.
#pragma once

#include "reports/html.h"
#include "study/study.h"

namespace lacuna {

// The paper's tables and figures beside ours (study_paper_sections.cc).
Html conclusions_section(const Study& study);
Html parameters_section(const Study& study);
Html curves_section(const Study& study);
Html settings_section(const Study& study);
Html fitness_section(const Study& study);
Html output_section(const Study& study);
Html study_engines_section(const Study& study);

// What it is worth (study_worth_sections.cc).
Html excitation_section(std::span<const Excitation> excitations);
Html rivals_section(const Study& study);
Html robustness_section(const Study& study);
Html recovery_section(const Study& study);

/// "0.645 (0.61 to 0.70)"; a dash where nothing is known.
std::string quartile_words(const Quartiles& q, int digits = 3);

}  // namespace lacuna
