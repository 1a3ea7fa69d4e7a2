// Continuing a checkpoint with more samples per pixel than it was planned for.
#pragma once

#include "kernels/render/render_settings.h"
#include "kernels/render/render_state.h"

#include <string>

namespace sheaf {

/// Continuation of a render from a checkpoint.
struct Continuation {
  RenderSettings settings;  ///< of the render
  std::string problem;  ///< why the render would not have the same bits as one without interruption; empty: it has them
};

/// The continuation of `state` by a render with the `requested` settings. If the number of replicates was not
/// requested, chooses the default or, if the checkpoint has sets of another size, one that continues these sets. If the
/// checkpoint had a time limit but the request has none, takes all samples adaptively.
Continuation continue_from(const RenderSettings& requested, const RenderState& state);

}  // namespace sheaf
