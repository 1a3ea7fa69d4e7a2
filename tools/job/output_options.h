// Options for output images, shared by several subcommands: exposure, tone map or OpenColorIO view, and compression.
#pragma once

#include "core/image/display_transform.h"
#include "core/image/exr.h"
#include "tools/options/options.h"

#include <string>

namespace sheaf {

/// The options as given.
struct OutputArguments {
  std::string exposure, tone_map = "none";  ///< exposure: empty for the default
  std::string ocio_config, ocio_display, ocio_view;
  std::string compression = "zip";
  int jpeg_quality = 95;
};

/// The names of these options, without dashes.
inline constexpr const char* kOutputOptionNames[] = {"exposure",  "tone-map",    "ocio-config", "ocio-display",
                                                     "ocio-view", "compression", "jpeg-quality"};

/// Adds --exposure, --tone-map, --ocio-config, --ocio-display, --ocio-view, --compression and --jpeg-quality.
void add_output_options(Command& command, OutputArguments& arguments);

/// Options of displaying and storing images.
struct OutputSettings {
  DisplayTransform display;
  ExrCompression compression = ExrCompression::kZip;
  float dwa_level = 45;
  int jpeg_quality = 95;

  /// Whether .exr files lose precision.
  bool is_lossy() const { return compression == ExrCompression::kDwaa || compression == ExrCompression::kDwab; }
};

/// Converts the options, and reads the OpenColorIO configuration if a view is requested. Throws Error: exit code 2 for
/// malformed options, unreadable configurations and builds without OpenColorIO, 1 if the color library is missing.
OutputSettings output_settings(const OutputArguments& arguments);

/// Makes the exposure automatic if it is not given; the default of images of bare models.
void set_model_defaults(const OutputArguments& arguments, OutputSettings& settings);

/// "+1.25 stops".
std::string exposure_text(double stops);

}  // namespace sheaf
