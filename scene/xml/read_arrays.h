// Meshes, images and volumes from arrays of a program. All functions throw SceneError, which names the array, its type
// and its shape, for arrays of other types or shapes and for numbers that are not finite.
#pragma once

#include "core/image/image.h"
#include "scene/description/shapes.h"
#include "scene/description/voxels.h"
#include "scene/xml/properties.h"

namespace sheaf {

/// Reads `vertices` (V x 3), `faces` (F x 3, indices of vertices), and optionally `normals` (V x 3), `uv` (V x 2), and
/// attributes whose names begin with "vertex_" or "face_" (V or F, x 1 or 3).
Mesh read_mesh_arrays(Properties& p);

/// Reads an image, H x W or H x W x C with 1, 3 or 4 channels, rows from the top. Bytes are decoded by the sRGB curve,
/// except alpha, and not if `raw`.
Image read_image_array(Properties& p, const char* name, bool raw);

/// Reads a volume, Z x Y x X or Z x Y x X x C with 1 or 3 channels. Voxels are cells of the unit cube.
DenseVolume read_volume_array(Properties& p, const char* name);

}  // namespace sheaf
