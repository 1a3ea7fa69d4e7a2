// Thin panes where passing them costs no depth: shadow rays pass them as paths do.
#pragma once

#include "kernels/bsdf/dispersive_dielectric.h"
#include "kernels/bsdf/thin_dielectric.h"
#include "scene/scene.h"

namespace sheaf {

namespace pane_detail {

/// The BSDF of a material's row at a path's wavelengths.
template <template <class> class Bsdf>
Bsdf<Scalar> load_pane(const SceneView& scene, std::uint32_t row, const Spectrum4& lambda) {
  float words[kLeafCount<Bsdf>];
  std::copy_n(scene.materials[row].words, kLeafCount<Bsdf>, words);
  if (scene.color == ColorMode::kSpectral) {
    constexpr ClosureSpectra kSpectra = closure_spectra<Bsdf>();
    for (int k = 0; k < kSpectra.count; ++k) {
      const std::uint32_t index = row * std::uint32_t{kMaxClosureSpectra} + static_cast<std::uint32_t>(k);
      const Spectrum4 value = evaluate<Scalar>(scene.spectral.materials, index, scene.spectral.tables, lambda);
      std::copy_n(&value.c0, 4, words + kSpectra.word[k]);
    }
  }
  Bsdf<Scalar> bsdf;
  int k = 0;
  std::apply([&](auto&... leaf) { ((leaf = words[k++]), ...); }, leaves(bsdf));
  return bsdf;
}

}  // namespace pane_detail

/// What passes the pane of a material's row at this cosine to the normal. `lambda`: in spectral mode.
inline PanePassage<Scalar> pane_passage(const SceneView& scene, std::uint32_t row, float cos_theta,
                                        const Spectrum4& lambda) {
  using namespace pane_detail;
  if (scene.materials[row].kind == ClosureKind::kThinDielectric)
    return load_pane<ThinDielectricBsdf>(scene, row, lambda).passage(cos_theta);
  return load_pane<DispersiveThinDielectricBsdf>(scene, row, lambda).passage(cos_theta);
}

}  // namespace sheaf
