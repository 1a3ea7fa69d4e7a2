// Cameras, lights and visibility of FBX files: what FbxCamera, FbxLight and FbxNode of the FBX SDK say.
#pragma once

#include "tools/importer/parts.h"

#include <string_view>

namespace sheaf::importer {

/// Reads the parts of all nodes. Damaged files give fewer parts.
FileParts fbx_parts(std::string_view bytes);

}  // namespace sheaf::importer
