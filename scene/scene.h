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
#include <utility>
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
  BvhSplits bvh_splits = BvhSplits::kNotNeeded;
  bool bvh_along_curve = false;  ///< whether a structure was built by BvhBuild::kMorton
};

/// All tables of a scene. Moving them does not move their rows, to which the acceleration structure refers.
struct SceneTables {
  GeometryTables geometry;
  MaterialTables materials;
  TextureTables textures;
  LightTables lights;
  MediumTables media;
  MotionTables motion;
  SensorTables sensor;
  SpectrumTables spectra;        ///< empty in RGB mode
  std::unique_ptr<Accel> accel;  ///< null while the scene is being compiled
  Vec3d origin{};                ///< see Scene::origin()
  Vec3f center{};                ///< see SceneView
  float radius = 0;
  bool needs_transmittance = false, shadow_rays_pass_thin_dielectrics = false;
  FilmSettings film;
  SamplerSettings sampler;
  IntegratorSettings integrator;
  ColorMode color = ColorMode::kRgb;
  SceneNames names;
  SceneInfo info;  ///< without sizes in bytes
  std::vector<std::string> warnings;

  /// The kernels' view of the tables as they are; valid until they are changed or moved.
  SceneView view() const;
};

/// An immutable scene. Not copyable or movable: its view refers to it.
class Scene {
 public:
  explicit Scene(SceneTables tables) : tables_(std::move(tables)), view_(tables_.view()) {}
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  /// Moves the tables out of a scene and destroys it.
  static SceneTables release(std::unique_ptr<Scene> scene) { return std::move(scene->tables_); }

  /// The kernels' view; valid during the scene's lifetime.
  const SceneView& view() const { return view_; }
  SceneInfo info() const;
  /// The memory of the tables and of the acceleration structure by cause. Without advice.
  std::vector<MemoryUse> memory() const;
  const FilmSettings& film() const { return tables_.film; }
  const SamplerSettings& sampler() const { return tables_.sampler; }
  /// The sampler that the scene specifies, with its seed and number of samples.
  SamplerView sampler_view() const {
    return make_sampler(sampler().kind, sampler().seed, sampler().sample_count,
                        static_cast<std::uint32_t>(film().width));
  }
  const IntegratorSettings& integrator() const { return tables_.integrator; }
  /// Locations of the lights in scene files, by row; only for the first kMaxReportedLights.
  const std::vector<SourceLocation>& light_source_locations() const { return tables_.lights.source_locations; }
  /// Names from files.
  const SceneNames& names() const { return tables_.names; }
  /// Remarks on repaired or dropped elements.
  const std::vector<std::string>& warnings() const { return tables_.warnings; }
  ColorMode color() const { return tables_.color; }
  /// All tables are relative to this point of world space; see scene/compile/render_origin.h.
  Vec3d origin() const { return tables_.origin; }

 private:
  SceneTables tables_;
  SceneView view_;
};

}  // namespace sheaf
