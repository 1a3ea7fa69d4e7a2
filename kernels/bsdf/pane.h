// Transmittance of thin dielectrics, for shadow rays that pass straight through them. Used where passing a thin
// dielectric costs no depth.
#pragma once

#include "kernels/bsdf/all.h"

namespace sheaf {

namespace pane_detail {

/// Loads the BSDF of material `row` at the wavelengths `lambda`.
template <template <class> class Bsdf>
Bsdf<Scalar> load_pane(const SceneView& scene, std::uint32_t row, const Spectrum4& lambda) {
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

}  // namespace pane_detail

/// Straight transmission of the thin dielectric with material `row`, at this cosine to the normal. `lambda`: the path's
/// wavelengths in spectral mode.
inline PanePassage<Scalar> pane_passage(const SceneView& scene, std::uint32_t row, float cos_theta,
                                        const Spectrum4& lambda) {
  PanePassage<Scalar> passage;
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (closure_info(Bsdf<Scalar>::kKind).is_thin_dielectric)
      if (kind == scene.materials.rows[row].kind)
        passage = pane_detail::load_pane<Bsdf>(scene, row, lambda).passage(cos_theta);
  });
  return passage;
}

}  // namespace sheaf
