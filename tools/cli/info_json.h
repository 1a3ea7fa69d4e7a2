// The output of `sheaf info --json`.
#pragma once

#include "core/image/exr.h"
#include "scene/compile/compile.h"
#include "scene/description.h"
#include "scene/dialects/common/file_contents.h"
#include "tools/cli/file_formats.h"

#include <string>

namespace sheaf {

/// The settings, contents and memory of a scene as a JSON object. Bounds are null if the scene has no shapes; for
/// models they are those of the model alone. Sizes of memory are in bytes; those for rendering are null if the scene
/// cannot be rendered.
std::string info_json(const Description& description, const FileContents& contents, const Scene& scene,
                      const CompileReport& report);

/// The header of an OpenEXR file as a JSON object.
std::string info_json(const ExrHeader& header, const std::string& file);

/// The version of Sheaf and the formats as a JSON object.
std::string info_json(const std::vector<ListedFormat>& formats);

}  // namespace sheaf
