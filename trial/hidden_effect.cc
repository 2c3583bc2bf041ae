#include "trial/hidden_effect.h"

#include <cmath>

#include "physics/catalogue.h"
#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {

HiddenEffect parse_hidden_effect(const std::string& text) {
  const std::string where = "--effect " + printable(text, 80),
                    form = "NAME:WHERE, NAME:WHERE:VALUE or NAME:WHERE:p=VALUE,...";
  const std::size_t first = text.find(':');
  if (first == std::string::npos || first == 0) throw InputError(where, quoted(text), form);
  const std::size_t second = text.find(':', first + 1);
  HiddenEffect out;
  out.effect = text.substr(0, first);
  out.place = text.substr(first + 1, second == std::string::npos ? std::string::npos : second - first - 1);
  out.outside = outside_physics_named(out.effect);
  const int type = find_effect(out.effect);
  if (!out.outside && (type < 0 || effect_table()[type].learned)) {
    std::vector<std::string> names = outside_physics_names();
    for (const EffectInfo& info : effect_table())
      if (!info.learned) names.emplace_back(info.name);
    throw InputError(where, "the effect " + quoted(out.effect), one_of(near_names(out.effect, names)));
  }
  if (second == std::string::npos) return out;
  for (std::size_t begin = second + 1; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.find('=');
    const std::string name = equals == std::string::npos ? "" : part.substr(0, equals);
    const auto value = parse_number(equals == std::string::npos ? part : part.substr(equals + 1));
    if (!value || !std::isfinite(*value) || (name.empty() && (equals == 0 || !out.given.empty())))
      throw InputError(where, quoted(part), form);
    out.given.emplace_back(name, *value);
    begin = end + 1;
  }
  return out;
}

}  // namespace lacuna
