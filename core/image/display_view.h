// Views of OpenColorIO configurations. OpenColorIO is loaded when the first view is opened.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace sheaf {

/// A view of an OpenColorIO configuration.
class ColorProcessor {
 public:
  virtual ~ColorProcessor() = default;
  /// Converts `count` colors of three values, in place, from linear Rec.709 to values of the display.
  virtual void apply(float* rgb, std::size_t count) const = 0;
};

/// Names a view. An empty string means the default of the configuration.
struct DisplayView {
  std::string config;  ///< file, built-in name such as ocio://default or raw, or empty: the file that $OCIO names
  std::string display, view;
};

/// The library that links OpenColorIO. Builds without OpenColorIO lack it.
inline constexpr char kColorLibrary[] = "sheaf_color_io.so";

/// Reads the configuration of a view. On failure, or if this build lacks OpenColorIO, returns null and sets `problem`.
/// Throws Error (exit code 1) if the library is missing or cannot be loaded.
std::unique_ptr<ColorProcessor> open_display_view(const DisplayView& view, std::string& problem);

/// The function that the library exports. The caller owns the result.
using DisplayViewFunction = ColorProcessor*(const DisplayView& view, std::string& problem);
inline constexpr char kDisplayViewFunction[] = "sheaf_display_view";

}  // namespace sheaf
