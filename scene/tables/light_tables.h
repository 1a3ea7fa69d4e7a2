// The lights of a scene: rows, their parts, and the tables for light selection.
#pragma once

#include "core/io/error.h"
#include "core/sampling/alias_table.h"
#include "scene/tables/envmap.h"
#include "scene/tables/light.h"
#include "scene/tables/light_tree.h"
#include "scene/tables/table_bytes.h"

#include <vector>

namespace sheaf {

/// Number of lights, from the first, with separate statistics. More would be of little use, and their counters should
/// fit in the caches.
inline constexpr std::uint32_t kMaxReportedLights = 1024;

/// Lights for kernels.
struct LightView {
  const LightRow* rows = nullptr;  ///< lights at infinity last
  std::uint32_t count = 0;
  std::uint32_t bounded_count = 0;    ///< number of lights that are not at infinity
  std::uint32_t environment = kNone;  ///< row of the environment light, kConstant or kEnvmap
  const AliasEntry* alias = nullptr;  ///< selection by power
  LightTreeView tree;                 ///< over the lights with indices below bounded_count
  const Vec3f* powers = nullptr;      ///< power of each light, W in R, G and B; see light_power()
  const LightTriangleRow* triangles = nullptr;
  const AliasEntry* triangle_alias = nullptr;  ///< triangles of each mesh light by area; cells of volume lights
  const LightUvRow* uvs = nullptr;
  const LightFrameRow* frames = nullptr;
  const LightCoatRow* coats = nullptr;  ///< null: no light has one
  EnvmapView envmap;                    ///< if the environment is an environment map
  bool has_textured_area_lights = false;
  bool has_black_environment = false;  ///< not a light, but camera rays see it
};

/// Owns the tables of lights.
struct LightTables {
  std::vector<LightRow> rows;
  std::uint32_t bounded_count = 0;
  std::uint32_t environment = kNone;
  std::vector<AliasEntry> alias;
  LightTree tree;
  std::vector<Vec3f> powers;
  std::vector<LightTriangleRow> triangles;
  std::vector<AliasEntry> triangle_alias;
  std::vector<LightUvRow> uvs;
  std::vector<LightFrameRow> frames;
  std::vector<LightCoatRow> coats;
  Envmap envmap;
  bool has_textured_area_lights = false;
  bool has_black_environment = false;
  std::vector<SourceLocation> source_locations;  ///< by row; only for the first kMaxReportedLights

  LightView view() const {
    return {rows.data(),           static_cast<std::uint32_t>(rows.size()),
            bounded_count,         environment,
            alias.data(),          tree.view(),
            powers.data(),         triangles.data(),
            triangle_alias.data(), uvs.data(),
            frames.data(),         coats.empty() ? nullptr : coats.data(),
            envmap.view(),         has_textured_area_lights,
            has_black_environment};
  }
  /// Memory in bytes.
  std::size_t bytes() const {
    return bytes_of(rows, alias, tree.nodes, tree.trails, powers, triangles, triangle_alias, uvs, frames, coats) +
           envmap.bytes();
  }
};

}  // namespace sheaf
