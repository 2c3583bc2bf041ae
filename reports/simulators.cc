#include "reports/simulators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/json.h"
#include "reports/json_text.h"
#include "reports/sections.h"
#include "reports/wording.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

using SimulatorsJson = nlohmann::ordered_json;

SimulatorsJson number_or_null(double value) { return std::isfinite(value) ? SimulatorsJson(value) : SimulatorsJson(); }

SimulatorsJson side_record(const SimulatorSide& side, const std::string& folder) {
  SimulatorsJson effects = SimulatorsJson::array(), before = SimulatorsJson::object(), after = SimulatorsJson::object();
  for (const SimulatorSide::Effect& e : side.effects)
    effects.push_back({{"effect", e.effect}, {"where", e.place}, {"probability", e.probability}});
  for (const auto& [joint, rms] : side.before) before[joint] = number_or_null(rms);
  for (const auto& [joint, rms] : side.after) after[joint] = number_or_null(rms);
  return {{"step", side.step},   {"folder", folder}, {"verdict", side.verdict},
          {"findings", effects}, {"before", before}, {"after", after}};
}

SimulatorsJson joint_records(const SimulatorComparison& c) {
  SimulatorsJson out = SimulatorsJson::array();
  for (std::size_t j = 0; j < c.joints.size(); ++j)
    out.push_back({{"joint", c.joints[j]},
                   {"own_damping", c.losses[j].damping},
                   {"own_friction", c.losses[j].friction},
                   {"order", number_or_null(c.steps[j].order)},
                   {"integrator_error", {{"at_step", c.steps[j].error_at_step}, {"at_half", c.steps[j].error_at_half}}},
                   {"unit", c.steps[j].unit}});
  return out;
}

/// An effect's title at its place, and at which steps it was found.
struct EffectRow {
  std::string effect, place;
  const SimulatorSide::Effect *at_step = nullptr, *at_half = nullptr;
};

std::vector<EffectRow> effect_rows(const SimulatorComparison& c) {
  std::vector<EffectRow> out;
  const auto row = [&](const SimulatorSide::Effect& e) -> EffectRow& {
    const auto at =
        std::ranges::find_if(out, [&](const EffectRow& r) { return r.effect == e.effect && r.place == e.place; });
    if (at != out.end()) return *at;
    return out.emplace_back(EffectRow{e.effect, e.place});
  };
  for (const SimulatorSide::Effect& e : c.at_step.effects) row(e).at_step = &e;
  for (const SimulatorSide::Effect& e : c.at_half.effects) row(e).at_half = &e;
  return out;
}

Html effects_section(const SimulatorComparison& c) {
  Table table({{"effect"}, {"where"}, {"probability at h", true}, {"at h/2", true}});
  const auto words = [](const SimulatorSide::Effect* e) {
    return text(e == nullptr ? "not found" : probability(e->probability));
  };
  for (const EffectRow& row : effect_rows(c))
    table.row(
        {text(effect_title(row.effect)), element("code", text(row.place)), words(row.at_step), words(row.at_half)});
  return table.empty() ? paragraph("Nothing was found at either step.") : table.html();
}

Html numbers_section(const SimulatorComparison& c) {
  Table table({{"number"},
               {"unit"},
               {"built with", true},
               {"at h", true},
               {"at h/2", true},
               {"at step 0", true},
               {"95 %, either way", true},
               {"integrator's part", true},
               {"part that stays", true},
               {"origin"}});
  for (const SimulatorNumber& n : c.numbers)
    table.row({element("code", text(n.name)), text(n.unit), text(number(n.given)), text(number(n.at_step)),
               text(number(n.at_half)), text(number(n.at_zero)), text(number(n.uncertainty, 2)),
               text(number(n.integrator, 2)), text(number(n.physics, 2)), text(origin_words(n.origin))},
              n.origin != Origin::as_built);
  return table.html() +
         paragraph(
             "A number counts as another than what the machine was built with, or as moving with the step, where "
             "that exceeds its 95 % interval. The value at step 0 is Richardson's extrapolation.",
             "muted small");
}

Html joints_section(const SimulatorComparison& c) {
  Table table({{"joint"},
               {"own damping", true},
               {"own friction", true},
               {"integrator's error at h, rms", true},
               {"at h/2", true},
               {"unit"},
               {"order", true}});
  for (std::size_t j = 0; j < c.joints.size(); ++j)
    table.row({element("code", text(c.joints[j])), text(number(c.losses[j].damping)),
               text(number(c.losses[j].friction)), text(number(c.steps[j].error_at_step, 3)),
               text(number(c.steps[j].error_at_half, 3)), text(c.steps[j].unit), text(number(c.steps[j].order, 2))});
  return table.html();
}

Html rests_section(const SimulatorComparison& c) {
  Table table({{"joint"},
               {"noise", true},
               {"plain model, h", true},
               {"found model, h", true},
               {"found model, h/2", true},
               {"unit"},
               {"what remains is"}});
  for (const SimulatorRest& r : c.rests)
    table.row({element("code", text(r.joint)), text(number(r.noise, 3)), text(number(r.before, 3)),
               text(number(r.at_step, 3)), text(number(r.at_half, 3)), text(r.unit),
               text(r.origin == Origin::as_built ? "noise" : origin_words(r.origin))});
  return table.html();
}

template <typename Entries>
std::vector<std::string> names_with(const Entries& entries, std::initializer_list<Origin> origins) {
  std::vector<std::string> out;
  for (const auto& entry : entries)
    if (std::ranges::find(origins, entry.origin) != origins.end()) {
      if constexpr (requires { entry.name; })
        out.push_back(entry.name);
      else
        out.push_back(entry.joint);
    }
  return out;
}

std::string some_of(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  constexpr std::size_t kShown = 6;
  std::vector<std::string> shown(names.begin(),
                                 names.begin() + static_cast<std::ptrdiff_t>(std::min(kShown, names.size())));
  if (names.size() > kShown) shown.push_back(fmt::format("{} more", names.size() - kShown));
  return list_of(shown);
}

}  // namespace

std::string origin_words(Origin origin) {
  switch (origin) {
    case Origin::as_built: return "as built";
    case Origin::integrator: return "the integrator";
    case Origin::physics: return "physics";
    default: return "both";
  }
}

std::string simulators_sentence(const SimulatorComparison& c) {
  return fmt::format(
      "{}'s own {} at {} and its own losses, diagnosed on {}: its integrator moves {}; other than built at every step "
      "are {}; beyond the noise the integrator leaves a rest at {}, physics at {}.",
      c.method.engine, c.method.integrator, quantity(1e3 * c.step, "ms", 3), c.other,
      some_of(names_with(c.numbers, {Origin::integrator, Origin::both})),
      some_of(names_with(c.numbers, {Origin::physics, Origin::both})),
      some_of(names_with(c.rests, {Origin::integrator, Origin::both})),
      some_of(names_with(c.rests, {Origin::physics, Origin::both})));
}

std::string to_json(const SimulatorComparison& c, const Context& context) {
  SimulatorsJson numbers = SimulatorsJson::array(), rests = SimulatorsJson::array();
  for (const SimulatorNumber& n : c.numbers)
    numbers.push_back({{"name", n.name},
                       {"unit", n.unit},
                       {"built_with", number_or_null(n.given)},
                       {"at_step", n.at_step},
                       {"at_half", n.at_half},
                       {"at_zero", n.at_zero},
                       {"half_of_ci95", number_or_null(n.uncertainty)},
                       {"integrator", n.integrator},
                       {"physics", number_or_null(n.physics)},
                       {"origin", to_string(n.origin)}});
  for (const SimulatorRest& r : c.rests)
    rests.push_back({{"joint", r.joint},
                     {"unit", r.unit},
                     {"noise", number_or_null(r.noise)},
                     {"before", number_or_null(r.before)},
                     {"at_step", number_or_null(r.at_step)},
                     {"at_half", number_or_null(r.at_half)},
                     {"origin", to_string(r.origin)}});
  return json_text(
      {{"format", "lacuna-simulators/1"},
       {"scenario", c.scenario},
       {"recorded_by", {{"engine", c.method.engine}, {"integrator", c.method.integrator}, {"step", c.step}}},
       {"diagnosed_on", c.other},
       {"version", context.version},
       {"order", c.order},
       {"joints", joint_records(c)},
       {"diagnoses", {side_record(c.at_step, "step"), side_record(c.at_half, "half_step")}},
       {"numbers", numbers},
       {"rests", rests},
       {"notes", c.notes},
       {"seconds", c.seconds},
       {"context", SimulatorsJson::parse(to_json(context))}});
}

std::string simulators_page(const SimulatorComparison& c, const Context& context) {
  Page page(c.scenario, "Lacuna simulator against simulator");
  const auto apart = [](const auto& entry) { return entry.origin != Origin::as_built; };
  page.lead(simulators_sentence(c), std::ranges::any_of(c.rests, apart) ? "open" : "found");
  page.tile("Step h", quantity(1e3 * c.step, "ms", 3));
  page.tile("Order in the step", number(c.order, 2), "median over joints and recordings");
  page.section("What is found at both steps", effects_section(c));
  page.section("Numbers", numbers_section(c));
  page.section("What remains", rests_section(c));
  page.section("Losses and integrator, joint by joint", joints_section(c));
  page.section("Notes", bullets(c.notes));
  page.section("Context", context_section(context));
  return page.str();
}

void write_simulators_report(const std::filesystem::path& folder, const SimulatorComparison& comparison,
                             const Context& context) {
  write_file_atomically(folder / "simulators.json", to_json(comparison, context));
  write_file_atomically(folder / "report.html", simulators_page(comparison, context));
}

}  // namespace lacuna
