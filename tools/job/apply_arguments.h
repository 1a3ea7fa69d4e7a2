// Applies the options of `sheaf render` to the settings of a scene.
#pragma once

#include "kernels/render/render_settings.h"
#include "scene/description.h"
#include "tools/job/render_arguments.h"

namespace sheaf {

/// Remarks on the settings of a render, for the user.
struct SettingsRemarks {
  std::vector<std::string> notes;    ///< options that cannot be applied exactly
  std::vector<std::string> details;  ///< differences from the scene file that do not affect the expectation, for -v
};

/// Replaces the denoiser `auto` by the best one on this machine. Throws Error (exit code 1) if the requested one cannot
/// be used.
void choose_denoiser(std::string& denoiser);

/// Converts the options for reading the scene; see read_options.h. Bare models are framed for an image of the requested
/// size. Throws Error (exit code 2).
ReadOptions read_options(const RenderArguments& arguments);

/// The settings of a render of the scene. Throws Error (exit code 2) for options that are malformed, out of range, or
/// not possible for the scene.
RenderSettings resolve_settings(const RenderArguments& arguments, const Description& scene, SettingsRemarks& remarks);

}  // namespace sheaf
