// Applies the options of `sheaf render` to a scene.
#pragma once

#include "kernels/render/render.h"
#include "scene/description.h"
#include "tools/job/render_arguments.h"

namespace sheaf {

/// The requested AOVs plus those that the denoiser uses.
AovSet wanted_aovs(const RenderArguments& arguments);

/// The requested color mode; otherwise that of the scene's dialect. Appends to `details` if that is not the default.
/// Throws Error (exit code 2) if another option needs another mode.
ColorMode choose_color(const RenderArguments& arguments, std::vector<std::string>& details);

/// Replaces the scene's settings by the given ones, with notes where they cannot be met exactly. Appends to `details`
/// what differs from the scene without affecting the expectation. Returns the pixels to render. Throws Error (exit code
/// 2) for sizes and crop windows that are not possible.
PixelRect apply_arguments(const RenderArguments& arguments, Description& scene, std::vector<std::string>& details);

/// The options of the render. `sampler`: of the scene after apply_arguments(). Throws Error (exit code 2) if the
/// denoiser needs more samples.
RenderOptions render_options(const RenderArguments& arguments, const SamplerSettings& sampler, AovSet aovs,
                             const PixelRect& crop);

}  // namespace sheaf
