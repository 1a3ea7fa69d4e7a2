// How much memory a render will take, before it takes any.
#pragma once

#include "core/memory.h"
#include "kernels/passes/render.h"
#include "kernels/wave/wave_needs.h"

#include <vector>

namespace sheaf {

struct SamplePlan;

/// Threads and paths in flight of a render with these options.
int threads_of(const RenderOptions& options);
int wave_size_of(const RenderOptions& options, const WaveNeeds& needs);

/// What a render takes besides the scene while most of it is there, part by part. What depends on what is found on the
/// way, photons that are stored and surfaces behind a pixel, is estimated. Throws as render() does for options that
/// cannot be.
std::vector<MemoryUse> render_memory(const Scene& scene, const RenderOptions& options);

/// The same where the plan of these options is made already.
std::vector<MemoryUse> render_memory(const Scene& scene, const RenderOptions& options, const SamplePlan& plan);

}  // namespace sheaf
