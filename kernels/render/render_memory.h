// Estimates how much memory a render takes, before it allocates any.
#pragma once

#include "core/io/memory.h"
#include "kernels/render/render.h"
#include "kernels/wave/wave_needs.h"

#include <vector>

namespace sheaf {

/// Number of threads of the render.
int threads_of(const RenderControl& control);

/// The waves of the workers.
struct WaveSetup {
  WaveNeeds needs;  ///< of all passes of the render
  int size;         ///< paths in flight per worker
};
WaveSetup wave_setup(const Scene& scene, const RenderSettings& settings, const RenderControl& control);

/// Peak memory of a render without the scene, part by part. Stored photons and surfaces behind a pixel are not known
/// before rendering and are estimated. Throws the errors of light_group_layers().
std::vector<MemoryUse> render_memory(const Scene& scene, const RenderSettings& settings, const RenderControl& control);

}  // namespace sheaf
