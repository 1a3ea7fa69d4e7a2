// Random parameters for any BSDF, for tests and benchmarks that iterate over the list of all BSDFs.
#pragma once

#include "core/sampling/rng.h"
#include "kernels/bsdf/list.h"
#include "scene/materials/rough_coat.h"
#include "tests/support/measured_testing.h"

#include <algorithm>

namespace sheaf {

/// Stores `nested` as the closure below a coat.
template <template <class> class Nested> void set_nested(CoatedParameters<Scalar>& coat, Nested<Scalar> nested) {
  coat.nested_kind = static_cast<std::uint32_t>(kKindOf<Nested<Scalar>>);
  int k = 0;
  const auto set = [&](float word) {
    const int at = coated_word<Nested>(k++);
    float* spectra = &coat.nested_spectra[0].c0;
    (at < 4 * kCoatableSpectra ? spectra[at] : coat.nested_numbers[at - 4 * kCoatableSpectra]) = word;
  };
  std::apply([&](const auto&... leaf) { (set(word_of_leaf(leaf)), ...); }, leaves(nested));
}

/// The `i`-th random parameter set: values in [0.05, 0.95], flags and enumerators from 0 to 2, a valid index of
/// refraction, and valid table references.
template <template <class> class Bsdf> Bsdf<Scalar> any_bsdf(std::uint32_t i) {
  const auto number = [i](std::uint32_t k, std::uint32_t stream) {
    return random4<Scalar>(stream, i * 64 + k, 0, 0).x;
  };
  auto bsdf = bsdf_of_words<Bsdf<Scalar>>(any_tables().floats.data(), [&](int k, float& word) {
    word = 0.05f + 0.9f * number(static_cast<std::uint32_t>(k), 7);
  });
  const auto set_flag = [i]<class Leaf>(Leaf& leaf) {
    if constexpr (std::is_same_v<Leaf, std::uint32_t>) leaf = i % 3;
  };
  std::apply([&](auto&... leaf) { (set_flag(leaf), ...); }, leaves(bsdf));
  const float eta = 1.3f + 0.4f * number(0, 8);
  if constexpr (requires { bsdf.eta = 1.5f; })
    bsdf.eta = eta;
  else if constexpr (requires { bsdf.eta.c0, bsdf.transmittance.c0; })
    bsdf.eta = {eta, eta * 1.01f, eta * 1.02f, eta * 1.03f};
  if constexpr (requires { bsdf.transmittance[0] = 0.0f; }) {
    static const RoughCoat coat = rough_coat(RoughnessDescription::Distribution::kGgx, 0.2, 1.5);
    std::copy(coat.transmittance.begin(), coat.transmittance.end(), bsdf.transmittance);
  }
  if constexpr (kIsPhaseFunction<Bsdf<Scalar>> && kHasTables<Bsdf<Scalar>>)
    bsdf.table = any_tables().phase[i % 2];
  else if constexpr (kHasTables<Bsdf<Scalar>>)
    bsdf.table = any_tables().measured[i % 4];
  if constexpr (std::is_base_of_v<CoatedParameters<Scalar>, Bsdf<Scalar>>) {
    bsdf.coat_eta = eta;
    // The first choice is a rough metal: it has a lobe, a pdf and all of its spectra.
    int left = static_cast<int>((i + 1) % 4);
    for_each_coatable_bsdf([&]<template <class> class Nested>(ClosureKind, BsdfTag<Nested>) {
      if (left-- == 0) set_nested(bsdf, any_bsdf<Nested>(i));
    });
  }
  return bsdf;
}

}  // namespace sheaf
