// Finds the medium that contains a point, by probe rays.
#pragma once

#include "scene/tables/scene_view.h"

#include <vector>

namespace sheaf {

/// A shape with the transform of one of its instances.
struct PlacedShape {
  std::uint32_t shape = kNone;     ///< kNone: no shape
  std::uint32_t instance = kNone;  ///< kNone: the shape is not part of a group
};

/// The medium at `p` (world space) at a time in [0, 1] over the shutter: 0 for vacuum, else 1 + its row. A point is
/// inside a shape with an interior if a ray from it leaves the shape before entering it. Of several shapes, the first
/// one left counts, which is the innermost. Sixteen rays in all directions vote. `ignored`: rays pass through it.
/// `default_value`: the medium outside of all shapes.
std::uint32_t medium_at(const SceneView& scene, Vec3f p, float time, PlacedShape ignored, std::uint32_t default_value);

/// The medium around a shape at a time in [0, 1]: the majority of medium_at() just outside of it, ignoring the shape
/// itself.
std::uint32_t medium_around(const SceneView& scene, PlacedShape placed, float time, std::uint32_t default_value);

/// The medium that surrounds the scene when the shutter opens: the near side of the first boundary hit by rays from far
/// outside. `default_value` if no ray hits a boundary.
std::uint32_t medium_outside(const SceneView& scene, std::uint32_t default_value);

/// A medium from a time in [0, 1] on.
struct TimedMedium {
  float time;
  std::uint32_t medium;
};

/// The media at a point over the shutter, of which `at(time)` returns one, in the order of time; the first one from 0
/// on. Probes at the ends of `parts` equal parts of the interval, and bisects changes in between. Media that are there
/// for less than a part may be missed. `parts` = 0: only the medium at time 0.
template <class At> std::vector<TimedMedium> media_over_time(int parts, At&& at) {
  constexpr int kMaxChanges = 4, kBisections = 22;  ///< within a part
  std::vector<TimedMedium> out{{0.0f, at(0.0f)}};
  for (int i = 0; i < parts; ++i) {
    const float end = static_cast<float>(i + 1) / static_cast<float>(parts);
    const std::uint32_t last = at(end);
    float from = static_cast<float>(i) / static_cast<float>(parts);
    for (int change = 0; change < kMaxChanges && out.back().medium != last; ++change) {
      TimedMedium next{end, last};
      for (int k = 0; k < kBisections; ++k) {
        const float middle = 0.5f * (from + next.time);
        const std::uint32_t medium = at(middle);
        if (medium == out.back().medium)
          from = middle;
        else
          next = {middle, medium};
      }
      out.push_back(next);
      from = next.time;
    }
    if (out.back().medium != last) out.push_back({end, last});
  }
  return out;
}

}  // namespace sheaf
