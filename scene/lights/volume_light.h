// Emitting media as lights.
#pragma once

#include "core/sampling/alias_table.h"
#include "scene/lights/light.h"

namespace sheaf {

struct Bounds3f;

/// Resolution of a volume light's box: cells along the axes, each in [1, 1023].
struct VolumeCells {
  std::uint32_t x = 1, y = 1, z = 1;

  std::uint32_t count() const { return x * y * z; }
  /// Conversion to and from VolumeLightData::cells.
  std::uint32_t word() const { return x | y << 10 | z << 20; }
  static VolumeCells of_word(std::uint32_t word) { return {word & 0x3ffu, word >> 10 & 0x3ffu, word >> 20}; }
};

/// Data of an emitting medium as a light: an axis-aligned box divided into cells. LightRecord::radiance is the
/// intensity that the whole box emits, W / sr.
template <class L> struct VolumeLightData {
  typename L::Uint medium;      ///< into MediumView::rows
  typename L::Uint first_cell;  ///< into LightView::triangle_alias
  typename L::Uint cells;       ///< see VolumeCells
  Vec3<L> corner;               ///< minimum corner of the box, world space
  Vec3<L> extent;               ///< size of the box, meters

  static constexpr auto fields(auto& s) { return std::tie(s.medium, s.first_cell, s.cells, s.corner, s.extent); }
};

/// See scene/lights/light.h.
struct VolumeLightKind {
  static constexpr const char* kLabel = "medium";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
};

/// A medium as a light, with the data for sampling points in it (kernels/lights/volume_light.h).
struct MediumLight {
  LightRow row;
  std::vector<AliasEntry> alias;  ///< over the cells
};

/// Makes the light of the medium in row `medium`; empty if it does not emit. `boxes`: bounding boxes of the shapes that
/// contain it. The alias table will start at `first_cell`.
std::optional<MediumLight> make_volume_light(const SceneView& scene, std::uint32_t medium,
                                             std::span<const Bounds3f> boxes, std::uint32_t first_cell);

}  // namespace sheaf
