// Textures of a scene.
#pragma once

#include "core/error.h"
#include "scene/description/grid_volume.h"
#include "scene/description/inputs.h"
#include "scene/tables/interpolation.h"

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>

namespace sheaf {

struct Image;

/// An image from a file or from memory, repeated over the uv plane.
struct BitmapDescription {
  std::filesystem::path file;  ///< resolved path
  TextureFilter filter = TextureFilter::kBilinear;
  TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
  bool raw = false;  ///< values are data, not colours: integers are not decoded by the sRGB curve
  /// Transform of each value of the image after decoding.
  struct ColorTransform {
    float scale = 1;      ///< first: multiply by this
    bool invert = false;  ///< second: replace x by 1 - x and clamp negative values to 0
    float exponent = 1;   ///< last: raise to this power
    friend constexpr auto operator<=>(const ColorTransform&, const ColorTransform&) = default;
  } change = {};
  /// Replaces `file`: channels Y, or R, G and B, with linear values.
  std::shared_ptr<const Image> made = {};
};
/// Alternating squares: `color0` where floor(2u) + floor(2v) is even, with the texture's transform applied.
struct CheckerboardDescription {
  SpectrumInput color0 = SpectrumDescription::constant(0.4f), color1 = SpectrumDescription::constant(0.2f);
};
/// Lines of a grid of unit squares. The colour is `color1` within `line_width` of integer u or v, and `color0`
/// elsewhere.
struct GridTextureDescription {
  SpectrumInput color0 = SpectrumDescription::constant(0.2f), color1 = SpectrumDescription::constant(0.4f);
  float line_width = 0.01f;
};
/// Values stored with a mesh's vertices or faces, e.g. "vertex_color". Zero on shapes that lack them.
struct MeshAttributeDescription {
  std::string name;  ///< begins with "vertex_" or "face_"
  float scale = 1;
};
/// Edges of a mesh's triangles: `edge` within `line_width` of an edge, `interior` elsewhere. Distances are measured in
/// the space in which the shape is compiled. A smooth step blends the two over the outer `step_width` (a fraction) of
/// that distance. Shapes other than meshes show `interior`.
struct WireframeDescription {
  SpectrumInput interior = SpectrumDescription::constant(0.5f), edge = SpectrumDescription::constant(0.1f);
  float line_width = 0;  ///< metres; 0: 1/10 of the mean edge length of each mesh
  float step_width = 0.5f;
};

/// A volume grid as a surface texture: evaluated at the world-space position of the surface point.
struct VolumeTextureDescription {
  GridVolumeDescription grid;
  float scale = 1;
};

/// (1 - amount) color0 + amount color1. The transforms of both inputs apply; the texture's own does not.
struct MixTextureDescription {
  SpectrumInput color0 = SpectrumDescription::constant(0), color1 = SpectrumDescription::constant(1);
  ScalarInput amount = 0.5f;  ///< may lie outside [0, 1]
};

struct TextureDescription {
  std::variant<BitmapDescription, CheckerboardDescription, GridTextureDescription, MeshAttributeDescription,
               VolumeTextureDescription, MixTextureDescription, WireframeDescription>
      model;
  /// Rows of the 2x3 matrix that maps the surface's uv to the texture's: u' = m[0] u + m[1] v + m[2]. (0, 0) is the
  /// lower left corner of an image.
  std::array<float, 6> to_uv{1, 0, 0, 0, 1, 0};
  std::string id;  ///< name for messages; may be empty
  SourceLocation where;
};

}  // namespace sheaf
