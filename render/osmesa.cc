#include "render/osmesa.h"

#include <dlfcn.h>

#include <string>

#include "scenarios/error.h"

namespace lacuna {
namespace {

template <class Function>
void find(void* library, const char* name, Function*& to) {
  to = reinterpret_cast<Function*>(::dlsym(library, name));
  if (to == nullptr) throw WorkError(std::string("OSMesa lacks ") + name);
}

/// Never closed: Mesa keeps its screen.
Osmesa load() {
  void* library = ::dlopen(LACUNA_OSMESA, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw WorkError(std::string("OSMesa cannot be loaded: ") + ::dlerror());
  Osmesa out;
  find(library, "OSMesaCreateContextAttribs", out.create);
  find(library, "OSMesaMakeCurrent", out.make_current);
  find(library, "OSMesaGetProcAddress", out.proc);
  return out;
}

}  // namespace

const Osmesa& osmesa() {
  static const Osmesa loaded = load();
  return loaded;
}

}  // namespace lacuna
