// Applies the options of `sheaf render` to a scene.
#pragma once

#include "kernels/passes/render.h"
#include "scene/content/description.h"
#include "tools/render_arguments.h"

namespace sheaf {

/// The requested AOVs plus those that the denoiser uses.
AovSet wanted_aovs(const RenderArguments& arguments);

/// The requested color mode; otherwise that of the scene's dialect, with a note. Throws Error (exit code 2) if another
/// option needs another mode.
ColorMode choose_color(const RenderArguments& arguments, Description& scene);

/// Replaces the scene's settings by the given ones, with notes where they cannot be met exactly. Returns the pixels to
/// render. Throws Error (exit code 2) for sizes and crop windows that are not possible.
PixelRect apply_arguments(const RenderArguments& arguments, Description& scene);

/// The options of the render. `sampler`: of the scene after apply_arguments(). Throws Error (exit code 2) if the
/// denoiser needs more samples.
RenderOptions render_options(const RenderArguments& arguments, const SamplerSettings& sampler, AovSet aovs,
                             const PixelRect& crop);

}  // namespace sheaf
