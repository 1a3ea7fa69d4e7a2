// Parameters for whatever BSDF, for tests and benchmarks that go over the list of all.
#pragma once

#include "core/rng.h"
#include "kernels/bsdf/all.h"
#include "scene/compile/plastic.h"

#include <algorithm>

namespace sheaf {

/// The `i`-th of many: parameters in [0.05, 0.95], indices of refraction and what must be computed put right.
template <template <class> class Bsdf> Bsdf<Scalar> any_bsdf(std::uint32_t i) {
  const auto number = [i](std::uint32_t k, std::uint32_t stream) {
    return random4<Scalar>(stream, i * 64 + k, 0, 0).x;
  };
  auto bsdf = bsdf_of_words<Bsdf<Scalar>>(
      [&](int k, float& word) { word = 0.05f + 0.9f * number(static_cast<std::uint32_t>(k), 7); });
  const float eta = 1.3f + 0.4f * number(0, 8);
  if constexpr (requires { bsdf.eta = 1.5f; }) bsdf.eta = eta;
  else if constexpr (requires { bsdf.eta.c0, bsdf.transmittance.c0; })
    bsdf.eta = {eta, eta * 1.01f, eta * 1.02f, eta * 1.03f};
  if constexpr (requires { bsdf.transmittance[0] = 0.0f; }) {
    static const RoughCoat coat = rough_coat(RoughnessDescription::Distribution::kGgx, 0.2, 1.5);
    std::copy(coat.transmittance.begin(), coat.transmittance.end(), bsdf.transmittance);
  }
  return bsdf;
}

}  // namespace sheaf
