// The layers of an image file, for `sheaf convert --layer`.
#pragma once

#include "core/image/image.h"

#include <string>
#include <vector>

namespace sheaf {

/// The name of the image itself, the channels R, G, B and A.
inline constexpr const char* kImageLayer = "image";

/// Names of the layers that an image has: kImageLayer, those of --aov, and for further channels the part of their names
/// before the last dot, such as "denoised".
std::vector<std::string> layer_names(const Image& image);

/// A layer as an image with the channels R, G, B and perhaps A, or Y. `displayed`: AOVs as displayed_layer() shows
/// them; otherwise the stored values. Throws Error (exit code 2) if the image does not have the layer.
Image layer_of(const Image& image, const std::string& name, bool displayed);

}  // namespace sheaf
