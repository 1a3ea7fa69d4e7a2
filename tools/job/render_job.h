// The steps of a render around render(), from reading the scene to the metadata of the image. `sheaf render` and the
// Python module take them.
#pragma once

#include "core/image/exr.h"
#include "kernels/film/aovs.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tools/job/render_arguments.h"

#include <memory>
#include <string>
#include <vector>

namespace sheaf {

/// A scene with the options of a render.
struct LoadedScene {
  Description description;           ///< with the options applied
  std::vector<std::string> details;  ///< what differs from the scene file, for -v
  ColorMode color = ColorMode::kRgb;
  std::unique_ptr<Scene> scene;  ///< null until compile()
  CompileReport compiled = {};

  const char* color_name() const { return kColorModes.name_of(color); }
};

/// Sets the colour mode and applies the options to the description. Returns the pixels to render. Throws Error (exit
/// code 2).
PixelRect prepare(const RenderArguments& arguments, LoadedScene& loaded);

/// Compiles the scene for a render with `options`. `kept`: geometry of an earlier scene; null: none. Throws SceneError.
void compile(const RenderArguments& arguments, const RenderOptions& options, LoadedScene& loaded, KeptGeometry* kept);

/// Warnings about the scene, before it is rendered.
std::vector<std::string> scene_warnings(const LoadedScene& loaded);

/// Adds the times of reading the scene file and of compiling the scene, in seconds, and the memory of the scene to the
/// report of its render.
void add_loading(RenderReport& report, const LoadedScene& loaded, double load_seconds, double build_seconds);

/// Metadata of the image.
ExrMetadata make_metadata(const RenderArguments& arguments, const LoadedScene& loaded, AovSet aovs,
                          const RenderReport& report, const Image& image);

/// Adds the denoised image if requested. Throws Error.
void add_denoised(const RenderArguments& arguments, Image& image, ExrMetadata& metadata);

}  // namespace sheaf
