#include <fmt/format.h>

#include <algorithm>

#include "reports/sections.h"
#include "reports/study.h"
#include "reports/study_sections.h"
#include "reports/svg.h"
#include "reports/wording.h"

namespace lacuna {
namespace {

std::string lead_sentence(std::span<const Study> studies) {
  int holds = 0, fails = 0, open = 0;
  for (const Study& study : studies) {
    for (const Conclusion& c : study.conclusions) {
      if (c.source == kBeyondThePaper) continue;
      holds += c.verdict == Judgement::holds;
      fails += c.verdict == Judgement::does_not_hold;
      open += c.verdict == Judgement::cannot_be_told;
    }
  }
  const int all = holds + fails + open;
  std::string out = all == 0
                        ? fmt::format("{} studied.", studies.front().scenario)
                        : fmt::format("Of {} judgements on the paper's claims {} hold, {} do not, {} cannot be told.",
                                      all, holds, fails, open);
  for (const Study& study : studies) {
    if (!study.rivals.methods.empty()) return out + " " + study.rivals.reason;
  }
  return out;
}

Html about_section(const Study& study) {
  std::vector<std::string> skipped;
  for (const SkippedPart& part : study.skipped) skipped.push_back(part.part + ": " + part.reason);
  return facts(
      {{"data", text(study.data)},
       {"truth", text(study.truth.empty() ? "unknown" : study.truth_file + ", used only to score")},
       {"locked joints", text(study.fixed.empty() ? "" : list_of(study.fixed) + ", simulated as fixed")},
       {"search", text(fmt::format("{} parameters, population {}, {} generations, {} seeds", study.parameters.size(),
                                   study.population, study.generations, study.seeds))},
       {"integration step", text(fmt::format("{}, error {} of the noise", quantity(1e3 * study.step.step, "ms"),
                                             number(study.step.error_over_noise, 2)))},
       {"work", text(fmt::format("{} evaluations, {} of computing", study.evaluations, duration(study.run_seconds)))},
       {"left out", skipped.empty() ? Html{} : bullets(skipped)}});
}

void add_sections(Page& page, const Study& study, bool several) {
  const auto add = [&](const std::string& title, const Html& body) {
    page.section(several ? study.scenario + ": " + title : title, body);
  };
  add("The paper's conclusions", conclusions_section(study));
  add("What the data determine", excitation_section(study.identifiability));
  add("Is it recovered?", recovery_section(study));
  add("Beside the GA", rivals_section(study));
  add("Tables 1 and 5: parameters", parameters_section(study));
  add("Tables 2 and 3: fitness functions", fitness_section(study));
  add("Figures 3 to 7: convergence", curves_section(study));
  add("Figure 8: the output", output_section(study));
  add("Table 4: every setting", settings_section(study));
  add("On every engine", study_engines_section(study));
  add("Bad data, bad bounds", robustness_section(study));
  add("About this study", about_section(study));
}

}  // namespace

std::string study_page(std::span<const Study> studies, const Context& context) {
  std::vector<std::string> names;
  long evaluations = 0;
  double seconds = 0.0;
  for (const Study& study : studies) {
    names.push_back(study.scenario);
    evaluations += study.evaluations;
    seconds += study.run_seconds;
  }
  Page page(list_of(names), "Lacuna study of the genetic algorithm");
  page.lead(lead_sentence(studies), "found");
  page.tile("Evaluations", std::to_string(evaluations), duration(seconds) + " of computing");
  page.tile("Seeds a setting", std::to_string(studies.front().seeds));
  for (const Study& study : studies) add_sections(page, study, studies.size() > 1);
  page.section("Context", context_section(context));
  return page.str();
}

}  // namespace lacuna
