// Parts of COLLADA files that Sheaf reads itself: cameras, lights, animations of transforms, and polygons with holes.
#pragma once

#include "tools/importer/parts.h"

#include <string>

namespace sheaf::importer {

/// Reads these parts and replaces `bytes` by a document for Assimp: without cameras, lights and animations, with
/// one node for each animated element of a transform, and with holes joined to the outline of their polygon. A file
/// that is not XML stays as it is.
FileParts take_collada_parts(std::string& bytes);

}  // namespace sheaf::importer
