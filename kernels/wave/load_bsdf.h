// Loads BSDFs, with the parameters of a vertex, from the closures of a wave.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Loads the BSDFs of the items [column, column + L::width) of the wave's closure queue.
template <class L, template <class> class Bsdf>
SHEAF_INLINE Bsdf<L> load_bsdf(const SceneView& scene, const Wave& wave, int column) {
  float* const* words = wave.closures.columns().words;
  return bsdf_of_words<Bsdf<L>>(scene.materials.closure_tables,
                                [words, column](int k, Float<L>& word)
                                    SHEAF_LAMBDA_INLINE { load(words[k] + column, word); });
}

}  // namespace sheaf
