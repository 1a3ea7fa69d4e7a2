// Continuing a checkpoint with more samples per pixel than it was planned for.
#pragma once

#include "kernels/render/render.h"

#include <string>

namespace sheaf {

/// How a render continues from a checkpoint.
struct Continuation {
  std::uint32_t samples = 0;  ///< per pixel, of the render
  int replicates = 0;         ///< RenderOptions::replicates that keeps the size of the sample sets
  std::string problem;  ///< why the render would not have the same bits as one without interruption; empty: it has them
};

/// The continuation of `state` by a render with `options`, whose RenderOptions::resume is ignored. If the options leave
/// the number of replicates open, chooses the default or, if the checkpoint has sets of another size, one that
/// continues these sets. Throws the errors of make_sample_layout().
Continuation continue_from(const Scene& scene, const RenderOptions& options, const RenderState& state);

}  // namespace sheaf
