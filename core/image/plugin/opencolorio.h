// Views of OpenColorIO configurations.
#pragma once

#include "core/image/image_library.h"

namespace sheaf {

/// Implements ImageLibrary::display_view().
std::unique_ptr<ColorProcessor> open_display_view(const DisplayView& view, std::string& problem);

}  // namespace sheaf
