// Transmittance of thin dielectrics, for shadow rays that pass straight through them. Used where passing a thin
// dielectric costs no depth.
#pragma once

#include "kernels/bsdf/list.h"

namespace sheaf {

namespace thin_dielectric_detail {

/// Loads the BSDF of material `row` at the wavelengths `lambda`.
template <template <class> class Bsdf>
Bsdf<Scalar> load_thin_dielectric(const SceneView& scene, std::uint32_t row, const Spectrum4& lambda) {
  float words[kLeafCount<Bsdf>];
  std::copy_n(scene.materials.rows[row].words, kLeafCount<Bsdf>, words);
  if (scene.color == ColorMode::kSpectral) {
    constexpr ClosureSpectra kSpectra = closure_spectra<Bsdf>();
    for (int k = 0; k < kSpectra.count; ++k) {
      const Spectrum4 value = closure_spectrum<Scalar>(scene, row, k, lambda);
      std::copy_n(&value.c0, 4, words + kSpectra.word[k]);
    }
  }
  return bsdf_of_words<Bsdf<Scalar>>(scene.materials.closure_tables, [&words](int k, float& word) { word = words[k]; });
}

}  // namespace thin_dielectric_detail

/// Straight transmission of the thin dielectric with material `row`, at this cosine to the normal. `lambda`: the path's
/// wavelengths in spectral mode.
inline StraightTransmission<Scalar> thin_dielectric_passage(const SceneView& scene, std::uint32_t row, float cos_theta,
                                                            const Spectrum4& lambda) {
  StraightTransmission<Scalar> passage;
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (Bsdf<Scalar>::Closure::kInfo.is_thin_dielectric)
      if (kind == scene.materials.rows[row].kind)
        passage = thin_dielectric_detail::load_thin_dielectric<Bsdf>(scene, row, lambda).passage(cos_theta);
  });
  return passage;
}

}  // namespace sheaf
