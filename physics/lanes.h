// SIMD packs as a scalar type. Include before any kernel template that shall run over packs.
#pragma once

#include <xsimd/xsimd.hpp>

#include "backends/featherstone/scalar.h"

namespace lacuna {

template <class Arch>
struct ScalarTraits<xsimd::batch<double, Arch>> {
  using Mask = xsimd::batch_bool<double, Arch>;
  static constexpr int lanes = static_cast<int>(xsimd::batch<double, Arch>::size);
};

template <class Arch>
void sincos(const xsimd::batch<double, Arch>& a, xsimd::batch<double, Arch>& s, xsimd::batch<double, Arch>& c) {
  trigonometry::sincos_of(a, s, c);
}

}  // namespace lacuna
