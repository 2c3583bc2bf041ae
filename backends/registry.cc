#include "backends/registry.h"

#include "scenarios/error.h"

namespace lacuna {

const std::vector<const Engine*>& engines() {
#define LACUNA_ADDRESS(name) &name##_engine(),
  static const std::vector<const Engine*> all = {LACUNA_ENGINES(LACUNA_ADDRESS)};
#undef LACUNA_ADDRESS
  return all;
}

const Engine& find_engine(const std::string& name) {
  std::string names;
  for (const Engine* engine : engines()) {
    const std::string known = engine->info().name;
    if (known == name) return *engine;
    names += (names.empty() ? "" : ", ") + known;
  }
  throw InputError("engine", quoted(name), "one of " + names);
}

}  // namespace lacuna
