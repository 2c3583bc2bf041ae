#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/diff.h"
#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

const char* tone_of_diff(DiffVerdict verdict) {
  switch (verdict) {
    case DiffVerdict::same: return "good";
    case DiffVerdict::changed: return "found";
    default: return "open";
  }
}

std::string from_to(const ChangedNumber& n) {
  return fmt::format("{} from {} to {}", n.key, number_words(n.a), number_words(n.b));
}

Html changes_section(const Diff& diff) {
  Table table({{"what"},
               {"where"},
               {"probability", true},
               {"number"},
               {"A", true},
               {"B", true},
               {"difference", true},
               {"may as well be"}});
  for (const MachineChange& c : diff.changes) {
    std::vector<std::string> others(c.members.begin() + 1, c.members.end());
    others.insert(others.end(), c.look_alikes.begin(), c.look_alikes.end());
    for (std::size_t k = 0; k < c.numbers.size(); ++k) {
      const ChangedNumber& n = c.numbers[k];
      const bool first = k == 0;
      const std::string what = c.effect.empty() ? n.key : effect_title(c.effect);
      table.row({text(first ? what : ""), element("code", text(first ? c.place : "")),
                 text(first ? probability(c.class_probability) : ""), text(n.key), text(number_words(n.a)),
                 text(number_words(n.b)), text(number_words(n.difference)), text(first ? list_of(others) : "")},
                first);
    }
  }
  if (table.empty()) return {};
  return table.html() + paragraph(
                            "In brackets 95 % intervals. The probability is that of the change or another that "
                            "the recordings do not tell from it.",
                            "muted small");
}

/// Half of a 95 % interval where it has two ends.
double half_of(const Estimate& e) {
  const double half = 0.5 * (e.upper95 - e.lower95);
  return std::isfinite(half) ? half : 0.0;
}

/// Before and after of each changed number, with intervals.
Html values_section(const Diff& diff) {
  Html out;
  for (const MachineChange& c : diff.changes) {
    for (const ChangedNumber& n : c.numbers) {
      if (std::isnan(n.difference.value)) continue;  // of one set only
      BarChart chart;
      chart.title = c.place + ": " + n.key;
      chart.description = "The number in set A and in set B, with 95 % intervals.";
      chart.x_label = n.b.unit;
      chart.bars = {{"A: " + diff.a.name, n.a.value, half_of(n.a), number_words(n.a), false},
                    {"B: " + diff.b.name, n.b.value, half_of(n.b), number_words(n.b), true}};
      out += element("figure", element("h3", text(c.name + " \u00b7 " + n.key)) + to_svg(chart));
    }
  }
  return out;
}

Html shared_section(const Diff& diff) {
  Table table({{"number"}, {"both sets", true}, {"95 %", true}, {"unit"}, {"probability that it changed", true}});
  for (const SharedNumber& s : diff.shared)
    table.row({element("code", text(s.pooled.name)), text(value_of(s.pooled)), text(interval(s.pooled)),
               text(s.pooled.unit), text(probability(s.changed))});
  return table.empty() ? Html{} : table.html();
}

Html refused_section(const Diff& diff) {
  Table table({{"change"}, {"probability", true}, {"why it is not claimed"}});
  for (const RefusedChange& r : diff.refused)
    table.row({element("code", text(r.name)), text(probability(r.probability)), text(r.reason)});
  return table.empty() ? Html{} : table.html();
}

Html fit_section(const Scenario& scenario, const Diff& diff) {
  Table table({{"recordings of"},
               {"role"},
               {"joint"},
               {"model of A", true},
               {"model of B", true},
               {"shared and changed", true},
               {"unit"}});
  for (const auto& [label, set] : {std::pair("A", &diff.a), std::pair("B", &diff.b)}) {
    for (const DiffFit& f : set->fit) {
      for (const auto& [joint, rms] : f.joint)
        table.row({text(label), text(to_string(f.role)), element("code", text(joint)),
                   text(steady(entry_of(f.of_a, joint))), text(steady(entry_of(f.of_b, joint))), text(steady(rms)),
                   text(residual_unit(scenario, nullptr, joint))});
    }
  }
  if (table.empty()) return {};
  return table.html() +
         paragraph(
             "rms of simulated minus measured. A model of one set was fitted to that set's train recordings alone. "
             "Test recordings took no part in fitting or choosing.",
             "muted small");
}

Html method_words() {
  return paragraph(
      "Both sets are diagnosed by themselves. What either needs stands in the structure of both, and its numbers are "
      "fitted to either. Which of them changed is a choice among subsets: the evidence of each, that it explains both "
      "sets with all other numbers common, with the catalogue's sizes as priors and a prior that makes every further "
      "change less likely. A change is claimed if it also predicts recordings that were not fitted.");
}

}  // namespace

std::string number_words(const Estimate& e) {
  if (std::isnan(e.value)) return "";
  return e.lower95 == e.upper95 ? quantity(e.value, e.unit) : with_interval(e);
}

namespace {

std::vector<std::string> joined_rests(const Diff& diff) {
  std::vector<std::string> out;
  for (const std::string& joint : diff.rest_in_a) out.push_back(joint + " (A)");
  for (const std::string& joint : diff.rest_in_b) out.push_back(joint + " (B)");
  return out;
}

}  // namespace

std::string change_words(const MachineChange& c) {
  if (!c.effect.empty()) return effect_title(c.effect) + " at " + place_words(c.effect, c.place);
  return fmt::format("the {} of {}", c.numbers.front().key, c.place);
}

std::string diff_sentence(const Diff& diff) {
  if (diff.verdict == DiffVerdict::same)
    return fmt::format("Nothing changed between {} and {} that these recordings show (probability {}).", diff.a.name,
                       diff.b.name, probability(diff.no_change));
  if (diff.verdict == DiffVerdict::unknown_change)
    return fmt::format("{} and {} differ, but no change of the model's numbers says how{}.", diff.a.name, diff.b.name,
                       diff.rest_in_a.empty() && diff.rest_in_b.empty()
                           ? ": each set's own model predicts recordings that were not fitted better than a common one"
                           : "; what is left is more than noise in one set alone, at " + list_of(joined_rests(diff)));
  std::string out;
  for (const MachineChange& c : diff.changes) {
    std::string words = change_words(c);
    if (out.empty()) words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
    out += (out.empty() ? "" : "; ") + words +
           fmt::format(" changed (probability {}): {}", probability(c.class_probability), from_to(c.numbers.front()));
  }
  return out + ".";
}

std::string diff_page(const Scenario& scenario, const Diff& diff, const Context& context) {
  Page page(diff.a.name + " and " + diff.b.name, "Lacuna difference");
  page.lead(diff_sentence(diff), tone_of_diff(diff.verdict));
  page.tile("Changes", std::to_string(diff.changes.size()), fmt::format("{} numbers in common", diff.shared.size()));
  page.tile("Nothing changed", probability(diff.no_change), "probability");
  page.tile("Time", duration(diff.seconds));
  page.section("What changed", changes_section(diff));
  page.section("Before and after", values_section(diff));
  page.section("Residuals", fit_section(scenario, diff));
  page.section("In common", shared_section(diff));
  page.section("Preferred by the evidence, not claimed", refused_section(diff));
  page.section("Notes", bullets(diff.notes));
  page.section("Method", method_words());
  page.section("Context", context_section(context));
  return page.str();
}

void write_diff_report(const std::filesystem::path& folder, const Scenario& scenario, const Diff& diff,
                       const Context& context) {
  write_file_atomically(folder / "diff.json", to_json(diff, context));
  write_file_atomically(folder / "report.html", diff_page(scenario, diff, context));
}

}  // namespace lacuna
