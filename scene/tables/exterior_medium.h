// The medium outside of a boundary, which may depend on the instance and on the time.
#pragma once

#include "scene/tables/medium_tables.h"

#include <algorithm>
#include <utility>

namespace sheaf {

/// The medium outside of a boundary: 0 for vacuum, else 1 + the row. `instance`: of the surface, or kNone. `time`: in
/// [0, 1] over the shutter.
inline std::uint32_t exterior_medium(const MediumView& media, std::uint32_t boundary, std::uint32_t instance,
                                     float time) {
  const BoundaryRow& sides = media.boundaries[boundary];
  if (sides.surrounding_count == 0) return sides.exterior;
  const SurroundingRow* const first = media.surroundings + sides.first_surrounding;
  const auto is_before = [](const auto& key, const SurroundingRow& row) {
    return key < std::pair(row.instance, row.time);
  };
  const auto after = std::upper_bound(first, first + sides.surrounding_count, std::pair(instance, time), is_before);
  return after != first && (after - 1)->instance == instance ? (after - 1)->medium : sides.exterior;
}

}  // namespace sheaf
