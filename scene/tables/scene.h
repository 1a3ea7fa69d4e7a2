// The compiled scene: flat, immutable tables that kernels access by index, and the kernels' view of them.
#pragma once

#include "core/distribution.h"
#include "core/error.h"
#include "core/spectral_sensor.h"
#include "core/spectrum_row.h"
#include "core/uplift.h"
#include "scene/tables/accel.h"
#include "scene/tables/camera.h"
#include "scene/tables/envmap.h"
#include "scene/tables/filter.h"
#include "scene/tables/light.h"
#include "scene/tables/light_tree.h"
#include "scene/tables/majorant_grid.h"
#include "scene/tables/material.h"
#include "scene/tables/medium.h"
#include "scene/tables/render_settings.h"
#include "scene/tables/scene_names.h"
#include "scene/tables/shape_rows.h"
#include "scene/tables/texture.h"

#include <memory>
#include <optional>
#include <vector>

namespace sheaf {

/// Spectra that replace the colours of other tables in spectral mode.
struct SpectralView {
  SpectrumTableView tables;
  /// Spectra of each material's closure parameters, in order: kMaxClosureSpectra rows per material.
  const SpectrumRow* materials = nullptr;
  /// Spectrum of each light in place of LightRecord::radiance. Colours of textures and maps are upsampled and
  /// multiplied by it.
  const SpectrumRow* lights = nullptr;
  const SpectrumRow* media = nullptr;  ///< see MediumRow
  const UpliftTable* uplift = nullptr;
  const SensorCurves* sensor = nullptr;
};

/// The scene for kernels: pointers to its tables, and small settings by value.
struct SceneView {
  const ShapeRow* shapes = nullptr;
  const VertexRow* vertices = nullptr;
  const std::uint32_t* triangles = nullptr;  ///< three per triangle, relative to the shape's first vertex
  const QuadricRow* quadrics = nullptr;
  const CurvePointRow* curve_points = nullptr;
  const std::uint32_t* curve_segments = nullptr;  ///< first point of each segment, relative to the shape's first point
  const SdfGridRow* sdf_grids = nullptr;
  const float* sdf_values = nullptr;
  const std::uint32_t* sdf_cells = nullptr;
  const InstanceRow* instances = nullptr;  ///< null: no instances
  const MaterialRow* materials = nullptr;
  const TextureBinding* bindings = nullptr;
  const NormalMapRow* normal_maps = nullptr;
  const float* closure_tables = nullptr;  ///< see scene/tables/closure_tables.h; null: no tables
  TextureView textures;
  const MediumRow* media = nullptr;
  const BoundaryRow* boundaries = nullptr;
  BrickGridView grids;  ///< grids of media
  const MajorantGridRow* majorant_grids = nullptr;
  const BlackbodyTable* blackbodies = nullptr;  ///< RGB mode, if a medium has a temperature
  bool needs_transmittance = false;             ///< whether shadow rays may pass through surfaces or media
  /// Whether shadow rays pass through thin dielectrics. This requires that passing costs no depth, and that no thin
  /// dielectric has a texture or is part of a composite material.
  bool has_open_panes = false;
  std::uint32_t camera_medium = 0;  ///< medium that contains the camera: 0 for vacuum, else 1 + row
  std::uint32_t outer_medium = 0;   ///< medium that surrounds the scene, likewise
  const LightRow* lights = nullptr;
  const AliasEntry* light_alias = nullptr;  ///< selection by power
  LightTreeView light_tree;                 ///< over the lights with indices below bounded_light_count
  std::uint32_t bounded_light_count = 0;
  const AliasEntry* triangle_alias = nullptr;
  const LightTriangleRow* light_triangles = nullptr;
  const LightFrameRow* light_frames = nullptr;
  const LightUvRow* light_uvs = nullptr;
  const Vec3f* light_powers = nullptr;  ///< power of each light, W in R, G and B; see light_power()
  EnvmapView envmap;                    ///< if the environment is an environment map
  bool has_textured_lights = false;     ///< whether any area light has a texture
  std::uint32_t shape_count = 0, material_count = 0, light_count = 0;
  std::uint32_t bucket_count = 1;
  std::uint32_t bucket_begin[kClosureKinds + 1] = {};  ///< buckets of each kind are contiguous
  std::uint32_t kind_flags[kClosureKinds] = {};        ///< MaterialFlags of all materials of a kind
  bool has_composites = false;                         ///< whether any material is a composite
  std::uint32_t environment = kNone;                   ///< row of the environment light, kConstant or kEnvmap
  Vec3f center{};                                      ///< centre of the bounding sphere
  float radius = 0;
  /// Radius around `center` at which unbounded media end; infinite if no light is at infinity.
  float medium_radius = kInfinity;
  Camera camera;                         ///< the first camera
  const Camera* more_cameras = nullptr;  ///< cameras of the film's further columns
  std::uint32_t more_camera_count = 0;
  float column_width = 0;               ///< pixels per camera's column of the film, if there are several
  const FilterTable* filter = nullptr;  ///< placement of samples in a pixel
  /// weights of samples in neighbouring pixels; null: samples count only in their own pixel
  const FilterWeights* filter_weights = nullptr;
  LightSelector light_selector = LightSelector::kBvh;
  const Accel* accel = nullptr;
  ColorMode color = ColorMode::kRgb;
  SpectralView spectral;  ///< only in spectral mode
};

/// Sizes for reports.
struct SceneInfo {
  std::size_t groups = 0, instances = 0, instanced_triangles = 0;  ///< the last: sum over instances of their triangles
  std::size_t shapes = 0, triangles = 0, quadrics = 0, curve_segments = 0, vertices = 0, materials = 0, lights = 0;
  std::size_t sdf_cells = 0;  ///< SDF grids: cells that contain the surface
  Vec3f bounds_min{}, bounds_max{};
  std::size_t table_bytes = 0, accel_bytes = 0;
};

/// Number of lights, from the first, with separate statistics. More would be of little use, and their counters should
/// fit in the caches.
inline constexpr std::uint32_t kMaxReportedLights = 1024;

/// Owns the tables. Not copyable or movable: Embree holds pointers to them.
class Scene {
 public:
  Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// The kernels' view; valid during the scene's lifetime.
  SceneView view() const;
  SceneInfo info() const;
  const FilmSettings& film() const { return film_; }
  const SamplerSettings& sampler() const { return sampler_; }
  /// The sampler that the scene specifies, with its seed and number of samples.
  SamplerView sampler_view() const {
    return make_sampler(sampler_.kind, sampler_.seed, sampler_.sample_count, static_cast<std::uint32_t>(film_.width));
  }
  const IntegratorSettings& integrator() const { return integrator_; }
  /// Locations of the lights in scene files, by row; only for the first kMaxReportedLights.
  const std::vector<SourceLocation>& light_source_locations() const { return light_places_; }
  /// Names from files.
  const SceneNames& names() const { return names_; }
  /// Remarks on repaired or dropped elements.
  const std::vector<std::string>& warnings() const { return warnings_; }
  ColorMode color() const { return color_; }

 private:
  friend class SceneCompiler;

  std::vector<ShapeRow> shapes_;
  std::vector<VertexRow> vertices_;
  std::vector<std::uint32_t> triangles_;
  std::vector<QuadricRow> quadrics_;
  std::vector<CurvePointRow> curve_points_;
  std::vector<std::uint32_t> curve_segments_;
  std::vector<SdfGridRow> sdf_grids_;
  std::vector<float> sdf_values_;
  std::vector<std::uint32_t> sdf_cells_;
  std::vector<InstanceRow> instances_;
  std::vector<MaterialRow> materials_;
  std::vector<TextureBinding> bindings_;
  std::vector<NormalMapRow> normal_maps_;
  std::vector<float> closure_tables_;
  CompiledTextures textures_;
  std::vector<AttributeEntry> attributes_;
  std::vector<float> attribute_values_;
  std::vector<MediumRow> media_;
  std::vector<BoundaryRow> boundaries_;
  std::vector<BrickGrid> grids_;
  std::vector<BrickGridRow> grid_rows_;
  std::vector<MajorantGrid> majorant_grids_;
  std::vector<MajorantGridRow> majorant_rows_;
  std::optional<BlackbodyTable> blackbodies_;
  bool has_transparency_ = false, has_open_panes_ = false;
  std::uint32_t camera_medium_ = 0, outer_medium_ = 0;
  std::vector<LightRow> lights_;
  std::vector<AliasEntry> light_alias_, triangle_alias_;
  LightTree light_tree_;
  std::uint32_t bounded_light_count_ = 0;
  std::vector<LightTriangleRow> light_triangles_;
  std::vector<LightFrameRow> light_frames_;
  std::vector<LightUvRow> light_uvs_;
  std::vector<Vec3f> light_powers_;
  std::vector<SourceLocation> light_places_;
  SceneNames names_;
  Envmap envmap_;
  bool has_textured_lights_ = false;
  std::uint32_t bucket_count_ = 1;
  std::uint32_t bucket_begin_[kClosureKinds + 1] = {};
  std::uint32_t kind_flags_[kClosureKinds] = {};
  bool has_composites_ = false;
  std::uint32_t environment_ = kNone;
  Vec3f center_{};
  float radius_ = 0, medium_radius_ = kInfinity;
  SceneInfo counts_;
  Camera camera_;
  std::vector<Camera> more_cameras_;
  FilterTable filter_;
  std::optional<FilterWeights> filter_weights_;
  FilmSettings film_;
  SamplerSettings sampler_;
  IntegratorSettings integrator_;
  std::vector<std::string> warnings_;
  std::unique_ptr<Accel> accel_;
  ColorMode color_ = ColorMode::kRgb;
  std::vector<float> spectrum_tables_;
  std::vector<SpectrumRow> material_spectra_, light_spectra_, medium_spectra_;
};

}  // namespace sheaf
