// The steps of a render around render(), from reading the scene to the metadata of the image. `sheaf render` and the
// Python module take them.
#pragma once

#include "core/image/exr.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tools/job/apply_arguments.h"

#include <memory>
#include <string>
#include <vector>

namespace sheaf {

/// A scene and the settings of its render.
struct LoadedScene {
  Description description;       ///< from compile() on with `settings`
  RenderSettings settings;       ///< of prepare()
  SettingsRemarks remarks;       ///< also the notes of reading
  std::unique_ptr<Scene> scene;  ///< null until compile()
  CompileReport compiled = {};

  const char* color_name() const { return kColorModes.name_of(settings.color); }
};

/// Resolves the settings. An integrator by --integrator replaces that of the description; ao and av also replace its
/// materials and lights. Throws Error (exit code 2).
void prepare(const RenderArguments& arguments, LoadedScene& loaded);

/// Threads and waves of the render.
RenderControl control_of(const RenderArguments& arguments);

/// Upper estimate of the number of rays of a render that is short for certain, otherwise infinity. Parts of an image
/// and renders that continue a checkpoint get the same BVH: a single set of few samples cannot be continued with more.
double expected_rays(const RenderSettings& settings);

/// Compiles the scene. `kept`: geometry of an earlier scene; null: none. Throws SceneError.
void compile(const RenderArguments& arguments, LoadedScene& loaded, KeptGeometry* kept);

/// Warnings about the scene, before it is rendered.
std::vector<std::string> scene_warnings(const LoadedScene& loaded);

/// Adds the times of reading the scene file and of compiling the scene, in seconds, and the memory of the scene to the
/// report of its render.
void add_loading(RenderReport& report, const LoadedScene& loaded, double load_seconds, double build_seconds);

/// Metadata of the image.
ExrMetadata make_metadata(const RenderArguments& arguments, const LoadedScene& loaded, const RenderReport& report,
                          const Image& image);

/// Adds the denoised image if requested. Throws Error.
void add_denoised(const RenderArguments& arguments, Image& image, ExrMetadata& metadata);

}  // namespace sheaf
