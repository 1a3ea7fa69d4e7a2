// Estimates how much memory a render takes, before it allocates any.
#pragma once

#include "core/io/memory.h"
#include "kernels/render/render.h"
#include "kernels/wave/wave_needs.h"

#include <vector>

namespace sheaf {

struct SampleLayout;

/// Number of threads, and of paths in flight per worker, for these options.
int threads_of(const RenderOptions& options);
int wave_size_of(const RenderOptions& options, const WaveNeeds& needs);

/// Peak memory of a render without the scene, part by part. Stored photons and surfaces behind a pixel are not known
/// before rendering and are estimated. Throws as render() does for invalid options.
std::vector<MemoryUse> render_memory(const Scene& scene, const RenderOptions& options);

/// The same with the sample layout of these options.
std::vector<MemoryUse> render_memory(const Scene& scene, const RenderOptions& options, const SampleLayout& layout);

}  // namespace sheaf
