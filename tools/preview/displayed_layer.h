// Layers of a render as a page shows them.
#pragma once

#include "core/image/image.h"
#include "kernels/film/aovs.h"
#include "scene/tables/render_settings.h"

#include <string_view>
#include <vector>

namespace sheaf {

/// The layers that pages can show besides the image.
inline constexpr Aov kShownLayers[] = {aov_named("albedo"), aov_named("normal"), aov_named("depth")};

/// Those that a render with this integrator can have.
AovSet page_layers(const IntegratorSettings& integrator);

/// Names of those that the image has.
std::vector<std::string_view> shown_layers(const Image& image);

/// A layer, by its name in kAovList, as linear R, G, B and A: colors as they are, normals with each component mapped
/// from [-1, 1] to a displayed value in [0, 1], and depths from white (near) to black. Layers of surfaces are
/// transparent where the depth is zero, because no surface is there. Empty if the image does not have the layer.
Image displayed_layer(const Image& image, std::string_view layer);

}  // namespace sheaf
