// OSMesa's own functions, loaded when the first picture is drawn: with the compiler of shaders behind it that library
// takes about as long to load as all others together, and most runs draw nothing.
#pragma once

#include <GL/gl.h>
#include <GL/osmesa.h>

namespace lacuna {

struct Osmesa {
  decltype(&OSMesaCreateContextAttribs) create = nullptr;
  decltype(&OSMesaMakeCurrent) make_current = nullptr;
  decltype(&OSMesaGetProcAddress) proc = nullptr;
};

/// Throws WorkError, with the loader's words, where it cannot be loaded.
const Osmesa& osmesa();

}  // namespace lacuna
