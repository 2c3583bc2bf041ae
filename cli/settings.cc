#include "cli/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

struct Setting {
  std::string name;
  double value = 0.0;
  std::string where;
};

Setting parse(const std::string& text) {
  const std::size_t at = text.find('=');
  const std::string where = "--set " + printable(text, 80);
  if (at == std::string::npos || at == 0) throw InputError(where, "no value", "NAME=NUMBER, as joint_2.gain=210");
  const std::optional<double> value = parse_number(text.substr(at + 1));
  if (!value || std::isnan(*value)) throw InputError(where, quoted(text.substr(at + 1)), "a number");
  return {text.substr(0, at), *value, where};
}

/// "joint_2.coulomb_friction.Fc" as an effect at a place, where the catalogue has one of that name and parameter.
std::optional<EffectSpec> effect_in(const Setting& setting) {
  const std::size_t last = setting.name.rfind('.');
  const std::size_t middle = last == std::string::npos || last == 0 ? last : setting.name.rfind('.', last - 1);
  if (last == std::string::npos || middle == std::string::npos) return std::nullopt;
  const std::string effect = setting.name.substr(middle + 1, last - middle - 1);
  const std::string parameter = setting.name.substr(last + 1);
  const int index = find_effect(effect);
  if (index < 0) return std::nullopt;
  const auto& infos = effect_table()[index].parameters;
  const bool known = std::any_of(infos.begin(), infos.end(), [&](const auto& info) { return parameter == info.name; });
  if (!known) return std::nullopt;
  return EffectSpec{effect, setting.name.substr(0, middle), {}, {}, setting.where};
}

/// All names that could be meant: the plant's own, and every effect at every place.
std::vector<std::string> all_names(const PlantModel& model) {
  std::set<std::string> names;
  for (const Parameter& parameter : model.parameters()) names.insert(parameter.name);
  for (const EffectInfo& effect : effect_table()) {
    std::vector<std::string> places{"arm"};
    if (effect.where == Where::joint) {
      places.clear();
      for (const Joint& joint : model.robot().joints()) places.push_back(joint.name);
    }
    for (const std::string& place : places)
      for (const ParameterInfo& info : effect.parameters)
        names.insert(fmt::format("{}.{}.{}", place, effect.name, info.name));
  }
  return {names.begin(), names.end()};
}

void put(const PlantModel& model, const Setting& setting, std::vector<double>& values) {
  const int index = model.find(setting.name);
  if (index < 0) {
    throw InputError(setting.where, "the parameter " + quoted(setting.name) + ", which the plant does not have",
                     one_of(near_names(setting.name, all_names(model))));
  }
  const Parameter& parameter = model.parameters()[index];
  if (setting.value < parameter.lower || setting.value > parameter.upper) {
    throw InputError(setting.where, format_number(setting.value),
                     fmt::format("a value from {} to {} {}", format_number(parameter.lower),
                                 format_number(parameter.upper), parameter.unit));
  }
  values[index] = setting.value;
}

}  // namespace

SetPlant plant_with(const Scenario& scenario, const std::vector<std::string>& settings) {
  std::vector<Setting> parsed;
  parsed.reserve(settings.size());
  for (const std::string& text : settings) parsed.push_back(parse(text));
  PlantModel model(scenario);
  for (const Setting& setting : parsed) {
    if (model.find(setting.name) >= 0) continue;
    if (const auto effect = effect_in(setting)) model = model.with_effects({*effect});
  }
  std::vector<double> values = model.values();
  for (const Setting& setting : parsed) put(model, setting, values);
  return {std::move(model), std::move(values)};
}

}  // namespace lacuna
