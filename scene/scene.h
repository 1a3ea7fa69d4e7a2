// The compiled scene: owner of the tables, and of the acceleration structure that refers to them.
#pragma once

#include "core/io/error.h"
#include "core/io/memory.h"
#include "core/sampling/sampler.h"
#include "scene/accel/accel.h"
#include "scene/tables/scene_names.h"
#include "scene/tables/scene_view.h"

#include <memory>
#include <string>
#include <vector>

namespace sheaf {

/// Sizes for reports.
struct SceneInfo {
  std::size_t groups = 0, instances = 0, instanced_triangles = 0;  ///< the last: sum over instances of their triangles
  std::size_t shapes = 0, triangles = 0, quadrics = 0, curve_segments = 0, vertices = 0, materials = 0, lights = 0;
  std::size_t sdf_cells = 0;         ///< SDF grids: cells that contain the surface
  Vec3d bounds_min{}, bounds_max{};  ///< world space
  std::size_t table_bytes = 0, accel_bytes = 0;
  BvhLayout bvh = BvhLayout::kFast;
};

/// Owns the tables. Not copyable or movable: Embree holds pointers to them.
class Scene {
 public:
  Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// The kernels' view; valid during the scene's lifetime.
  const SceneView& view() const { return view_; }
  SceneInfo info() const;
  /// The memory of the tables and of the acceleration structure by cause. Without advice.
  std::vector<MemoryUse> memory() const;
  const FilmSettings& film() const { return film_; }
  const SamplerSettings& sampler() const { return sampler_; }
  /// The sampler that the scene specifies, with its seed and number of samples.
  SamplerView sampler_view() const {
    return make_sampler(sampler_.kind, sampler_.seed, sampler_.sample_count, static_cast<std::uint32_t>(film_.width));
  }
  const IntegratorSettings& integrator() const { return integrator_; }
  /// Locations of the lights in scene files, by row; only for the first kMaxReportedLights.
  const std::vector<SourceLocation>& light_source_locations() const { return lights_.source_locations; }
  /// Names from files.
  const SceneNames& names() const { return names_; }
  /// Remarks on repaired or dropped elements.
  const std::vector<std::string>& warnings() const { return warnings_; }
  ColorMode color() const { return color_; }
  /// All tables are relative to this point of world space; see scene/compile/render_origin.h.
  Vec3d origin() const { return origin_; }

 private:
  friend class SceneCompiler;

  /// The view of the tables as they are.
  SceneView make_view() const;

  GeometryTables geometry_;
  MaterialTables materials_;
  TextureTables textures_;
  LightTables lights_;
  MediumTables media_;
  MotionTables motion_;
  SensorTables sensor_;
  SpectrumTables spectra_;
  std::unique_ptr<Accel> accel_;
  Vec3d origin_;
  Vec3f center_{};
  float radius_ = 0;
  bool needs_transmittance_ = false, shadow_rays_pass_thin_dielectrics_ = false;
  FilmSettings film_;
  SamplerSettings sampler_;
  IntegratorSettings integrator_;
  ColorMode color_ = ColorMode::kRgb;
  SceneNames names_;
  SceneInfo counts_;
  std::vector<std::string> warnings_;
  SceneView view_;  ///< of the finished tables
};

}  // namespace sheaf
