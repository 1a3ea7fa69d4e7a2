// Builds the tables of an environment map from its image.
#pragma once

#include "core/io/error.h"
#include "core/math/transform.h"
#include "scene/tables/envmap.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace sheaf {

/// An image in linear Rec.709, three floats per pixel, row by row from the top.
struct EnvmapImage {
  std::uint32_t width = 0, height = 0;
  std::vector<float> rgb;
};

/// Builds the tables. `mis_compensation` subtracts the mean brightness from the density, so that darker directions are
/// not sampled and are left to BSDF sampling (Karlik et al., "MIS Compensation", 2019). Negative and non-finite values
/// become 0. to_map is the identity. The image's memory is freed progressively, so peak memory is hardly more than the
/// larger of the two. Throws SceneError for images of more than 2^28 pixels or with too long rows or columns.
Envmap make_envmap(EnvmapImage image, float scale, bool mis_compensation);

/// Envmap::mean of make_envmap() at scale 1. Throws SceneError as it does.
Vec3f envmap_mean(const EnvmapImage& image);

/// Solid angle of a node of row `row`, in a map of `width` by `height` nodes.
double node_solid_angle(std::uint32_t row, std::uint32_t width, std::uint32_t height);

/// Fills `spectra` from the nodes' colors with UpliftTable, for spectral mode. Runs in parallel.
void uplift_nodes(Envmap& map);

/// Reads an image. Integers are decoded by the sRGB curve unless `raw`; gray is used for all channels; alpha is
/// dropped. Throws SceneError if the image is missing, broken, too large, or has unknown channels.
EnvmapImage read_envmap_image(const std::filesystem::path& file, bool raw = false);

/// Sets the rotation from world space to the map's space. Throws SceneError at `where` if the transform scales.
void set_rotation(Envmap& map, const Transform& to_world, const SourceLocation& where);

/// Replacement of infinite values in environment maps: the largest 16-bit float, the maximum of most files.
inline constexpr float kInfiniteTexel = 65504;

/// Counts of invalid radiance values.
struct UnusableValues {
  std::size_t infinite = 0;  ///< replaced by kInfiniteTexel
  std::size_t dark = 0;      ///< negative or NaN; replaced by 0
};

/// Replaces invalid values, and returns their counts.
UnusableValues replace_unusable(EnvmapImage& image);

}  // namespace sheaf
