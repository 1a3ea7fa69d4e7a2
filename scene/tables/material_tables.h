// The materials of a scene: rows, what they refer to, and the buckets by which surfaces are sorted.
#pragma once

#include "scene/tables/material.h"
#include "scene/tables/table_bytes.h"
#include "scene/tables/texture.h"

#include <vector>

namespace sheaf {

/// Maximum number of buckets.
inline constexpr int kMaxBuckets = 256;

/// Buckets for sorting surfaces by material. The buckets of each kind of closure are contiguous.
struct MaterialBuckets {
  std::uint32_t count = 1;
  std::uint32_t begin[kMaxClosureKinds + 1] = {};   ///< first bucket of each kind
  std::uint32_t kind_flags[kMaxClosureKinds] = {};  ///< MaterialFlags of all materials of a kind
};

/// Materials for kernels.
struct MaterialView {
  const MaterialRow* rows = nullptr;  ///< sorted by kind, composites last
  const TextureBinding* bindings = nullptr;
  const NormalMapRow* normal_maps = nullptr;
  const float* closure_tables = nullptr;  ///< see scene/tables/closure_tables.h; null: no tables
  MaterialBuckets buckets;
  bool has_composites = false;  ///< whether any material is a composite
};

/// Owns the tables of materials. Phase functions have rows, too.
struct MaterialTables {
  std::vector<MaterialRow> rows;
  std::vector<TextureBinding> bindings;
  std::vector<NormalMapRow> normal_maps;
  std::vector<float> closure_tables;
  MaterialBuckets buckets;
  bool has_composites = false;

  MaterialView view() const {
    return {rows.data(), bindings.data(), normal_maps.data(), closure_tables.empty() ? nullptr : closure_tables.data(),
            buckets,     has_composites};
  }
  /// Memory in bytes.
  std::size_t bytes() const { return bytes_of(rows, bindings, normal_maps, closure_tables); }
};

}  // namespace sheaf
