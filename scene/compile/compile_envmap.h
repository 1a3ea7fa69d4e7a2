// From the picture of an environment map to its tables.
#pragma once

#include "core/error.h"
#include "core/transform.h"
#include "scene/tables/envmap.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace sheaf {

/// A picture in linear Rec.709, three floats to a pixel, row by row from the top.
struct EnvmapPicture {
  std::uint32_t width = 0, height = 0;
  std::vector<float> rgb;
};

/// Builds the tables. `mis_compensation` takes the mean brightness off the density, so that directions of less than it
/// are not sampled at all and left to BSDF sampling (Karlik et al., "MIS Compensation", 2019). Values that are negative
/// or not finite become 0. to_map is left at identity. Gives the picture's memory back while it goes along, so that it
/// takes hardly more than the larger of the two. Throws SceneError for pictures of more than 2^28 pixels.
Envmap make_envmap(EnvmapPicture picture, float scale, bool mis_compensation);

/// The solid angle that a node of row `row` stands for, in a map of `width` by `height` nodes.
double node_solid_angle(std::uint32_t row, std::uint32_t width, std::uint32_t height);

/// Fills `spectra` from the nodes' colours through UpliftTable, for spectral mode. Runs in parallel.
void uplift_nodes(Envmap& map);

/// Reads a picture: integers are decoded by the sRGB curve unless they are `raw`, grey stands for all channels, alpha
/// is dropped. Throws SceneError if it is missing, broken, too large or has channels without a meaning.
EnvmapPicture read_envmap_picture(const std::filesystem::path& file, bool raw = false);

/// The part of the transform that turns directions from world space to the map's. Throws SceneError at `where` if it
/// stretches.
void set_rotation(Envmap& map, const Transform& to_world, const SourceLocation& where);

/// What an infinite value of an environment map counts as: the largest number of 16 bits, the brightest that most files
/// can hold.
inline constexpr float kInfiniteTexel = 65504;

/// Values that no radiance can have.
struct UnusableValues {
  std::size_t infinite = 0;  ///< count as kInfiniteTexel
  std::size_t dark = 0;      ///< negative, or NaN: count as 0
};

/// Replaces them, and returns how many there were.
UnusableValues replace_unusable(EnvmapPicture& picture);

}  // namespace sheaf
