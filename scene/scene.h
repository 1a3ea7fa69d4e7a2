// The compiled scene: flat, immutable tables that kernels read by index, and the view of them that kernels get.
#pragma once

#include "core/distribution.h"
#include "core/spectral_sensor.h"
#include "core/spectrum_row.h"
#include "core/uplift.h"
#include "scene/accel.h"
#include "scene/camera.h"
#include "scene/description.h"
#include "scene/envmap.h"
#include "scene/filter.h"
#include "scene/light_tree.h"
#include "scene/majorant_grid.h"
#include "scene/material.h"
#include "scene/medium.h"
#include "scene/texture.h"

#include <memory>
#include <vector>

namespace sheaf {

/// "No such row" in any table.
inline constexpr std::uint32_t kNone = 0xffffffffu;

enum class ShapeKind : std::uint32_t { kMesh, kSphere, kDisk, kCylinder };

/// Bits of ShapeRow::flags.
enum ShapeFlags : std::uint32_t {
  kHasNormals = 1,  ///< vertices have normals; else the shape is faceted
  kHasUvs = 2,      ///< vertices have uv; else barycentric coordinates serve as such
};

/// One shape. Those of shape groups follow the others, group by group, in the space of their group. Eight words, read
/// as one 32-byte row.
struct ShapeRow {
  std::uint32_t kind = 0;            ///< ShapeKind
  std::uint32_t first_triangle = 0;  ///< meshes: into SceneView::triangles; quadrics: into SceneView::quadrics
  std::uint32_t first_vertex = 0;    ///< meshes: into SceneView::vertices
  std::uint32_t flags = 0;           ///< ShapeFlags
  std::uint32_t material = 0;          ///< into SceneView::materials
  /// Into SceneView::lights, in groups counted from the instance's first; kNone: does not emit.
  std::uint32_t light = kNone;
  std::uint32_t triangle_count = 0;
  std::uint32_t boundary = kNone;  ///< into SceneView::boundaries; kNone: the same medium on both sides
};
static_assert(sizeof(ShapeRow) == 32);

/// A vertex of a mesh, in half a cache line: whoever needs its position needs the rest as well.
struct alignas(32) VertexRow {
  float position[3];
  float normal[3];  ///< unit length; zero without kHasNormals
  float uv[2];      ///< zero without kHasUvs
};
static_assert(sizeof(VertexRow) == 32);

/// A sphere, disk or cylinder: an affine image of the canonical one (unit sphere around the origin; unit disk at z = 0;
/// side of radius 1 for z in [0, 1]).
struct QuadricRow {
  float to_world[12];   ///< rows of the 3x4 matrix
  float to_object[12];  ///< its inverse
  float normal_sign;    ///< -1 if normals are flipped
  float determinant;    ///< |det| of the linear part
  float uniform_scale;  ///< the factor, if the linear part is a rotation times a factor; else 0
  ShapeKind kind;       ///< not kMesh
};

/// A group's shapes placed in the world: one cache line.
struct alignas(64) InstanceRow {
  float to_world[12];         ///< rows of the 3x4 matrix
  float determinant;          ///< of its linear part; negative if it mirrors
  std::uint32_t first_shape;  ///< of the group; into SceneView::shapes
  std::uint32_t group;        ///< index of the group
  std::uint32_t first_light;  ///< into SceneView::lights
};
static_assert(sizeof(InstanceRow) == 64);

enum class LightKind : std::uint32_t {
  kPoint, kConstant, kMesh, kSphere, kQuadric,
  kSpot,        ///< linear in the angle
  kSmoothSpot,  ///< a smooth step in the angle's cosine
  kDirectional, kProjector, kEnvmap,
  kVolume,  ///< a medium
};

/// One light. Those that shine from outside of the scene stand behind the others. Sixteen words.
struct LightRow {
  std::uint32_t kind = 0;            ///< LightKind
  std::uint32_t shape = kNone;       ///< area lights; kVolume: into SceneView::media
  /// kMesh: of triangle_alias, light_triangles; kSphere, kQuadric: of quadrics; kVolume: of triangle_alias, cells.
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
  /// Radiance (W / (m^2 sr)); kPoint, spots, kProjector: intensity (W / sr); kDirectional: irradiance (W / m^2). Where
  /// there is a texture, what it is multiplied by. kEnvmap: the mean over all directions. kVolume: what it emits in
  /// all, W / sr.
  float radiance[4] = {};
  /// kPoint, spots, kProjector, kSphere (centre), kVolume (least corner): metres; kDirectional: unit vector to the
  /// light.
  float position[3] = {};
  float area = 0;    ///< area lights: of the world-space surface; kQuadric: of the canonical shape; kVolume: width
  float radius = 0;  ///< kSphere; kVolume: height
  float depth = 0;   ///< kVolume
  std::uint32_t texture = kNone;  ///< into SceneView::textures; kNone: the same everywhere
  /// Spots, kProjector: into light_frames. Meshes with a texture: into light_uvs, the first triangle's. kSphere,
  /// kQuadric: bits of the distance by which their points are moved off the surface at least. kVolume: numbers of cells
  /// along the axes, ten bits each.
  std::uint32_t detail = 0;
};
static_assert(sizeof(LightRow) == 64);

/// What only lights with a direction have. One cache line.
struct alignas(64) LightFrameRow {
  float to_light[12];  ///< rows of the 3x4 matrix to the light's space, where it looks along +z
  /// kSpot: cutoff angle (radians), 1 / (cutoff - beam width), 1 / tan cutoff. kSmoothSpot: cosine of the cutoff angle,
  /// 1 / (cosine of the beam width less that). kProjector: the reciprocals of the picture's width and height at z = 1.
  float words[4];
};
static_assert(sizeof(LightFrameRow) == 64);

/// Texture coordinates of a triangle of a light, two for each vertex.
struct LightUvRow {
  float uv[6];
  float unused[2];
};
static_assert(sizeof(LightUvRow) == 32);

/// One triangle of an area light, with all that sampling a point on it needs. Sixteen words: one cache line instead of
/// a walk over indices and vertices.
struct LightTriangleRow {
  float p[3];       ///< first vertex; world space
  float offset;     ///< see SurfacePoint::offset; the largest on the triangle
  float edge1[4];   ///< second vertex less the first
  float edge2[4];   ///< third vertex less the first
  float normal[4];  ///< geometric, unit length
};
static_assert(sizeof(LightTriangleRow) == 64);

/// What kernels read in spectral mode in place of the colours in other tables.
struct SpectralView {
  SpectrumTableView tables;
  /// Of each material the spectra among its closure's parameters, in their order: kMaxClosureSpectra rows.
  const SpectrumRow* materials = nullptr;
  /// Of each light what LightRow::radiance is. A texture's or a map's colours are uplifted and multiplied by it.
  const SpectrumRow* lights = nullptr;
  const SpectrumRow* media = nullptr;  ///< see MediumRow
  const UpliftTable* uplift = nullptr;
  const SensorCurves* sensor = nullptr;
};

/// What kernels see of a scene: pointers into its tables, and small settings by value.
struct SceneView {
  const ShapeRow* shapes = nullptr;
  const VertexRow* vertices = nullptr;
  const std::uint32_t* triangles = nullptr;  ///< three per triangle, relative to the shape's first vertex
  const QuadricRow* quadrics = nullptr;
  const InstanceRow* instances = nullptr;    ///< null: there are none
  const MaterialRow* materials = nullptr;
  const TextureBinding* bindings = nullptr;
  const NormalMapRow* normal_maps = nullptr;
  TextureView textures;
  const MediumRow* media = nullptr;
  const BoundaryRow* boundaries = nullptr;
  BrickGridView grids;  ///< of the media
  const MajorantGridRow* majorant_grids = nullptr;
  const BlackbodyTable* blackbodies = nullptr;  ///< RGB mode, where a medium has a temperature
  bool has_transparency = false;  ///< whether shadow rays may pass a surface, or there are media
  /// Whether shadow rays pass thin panes: where passing costs no depth, and no pane has a texture or is part of a
  /// composite material.
  bool has_open_panes = false;
  std::uint32_t camera_medium = 0;  ///< 0: none, else 1 + the row of what the camera is in
  const LightRow* lights = nullptr;
  const AliasEntry* light_alias = nullptr;  ///< by power
  LightTreeView light_tree;                 ///< over the lights below bounded_light_count
  std::uint32_t bounded_light_count = 0;
  const AliasEntry* triangle_alias = nullptr;
  const LightTriangleRow* light_triangles = nullptr;
  const LightFrameRow* light_frames = nullptr;
  const LightUvRow* light_uvs = nullptr;
  const Vec3f* light_powers = nullptr;  ///< of every light, W in R, G and B; see light_power()
  EnvmapView envmap;                    ///< if the environment is one
  bool has_textured_lights = false;     ///< whether any area light has a texture
  std::uint32_t shape_count = 0, material_count = 0, light_count = 0;
  std::uint32_t bucket_count = 1;
  std::uint32_t bucket_begin[kClosureKinds + 1] = {};  ///< buckets of each kind are contiguous
  std::uint32_t kind_flags[kClosureKinds] = {};        ///< MaterialFlags of all materials of a kind
  bool has_composites = false;                         ///< whether any material is a choice between others
  std::uint32_t environment = kNone;                   ///< light row of the environment, kConstant or kEnvmap
  Vec3f center{};                                      ///< of the bounding sphere
  float radius = 0;
  SamplerView sampler;
  Camera camera;
  const FilterTable* filter = nullptr;
  IntegratorDescription integrator;
  const Accel* accel = nullptr;
  ColorMode color = ColorMode::kRgb;
  SpectralView spectral;  ///< only in spectral mode
};

/// Sizes, for people.
struct SceneInfo {
  std::size_t groups = 0, instances = 0, instanced_triangles = 0;  ///< the last: instances times triangles of each
  std::size_t shapes = 0, triangles = 0, quadrics = 0, vertices = 0, materials = 0, lights = 0;
  Vec3f bounds_min{}, bounds_max{};
  std::size_t table_bytes = 0, accel_bytes = 0;
};

/// Owns the tables. Neither copied nor moved: Embree points into them.
class Scene {
 public:
  Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// The kernels' view; valid as long as the scene.
  SceneView view() const;
  SceneInfo info() const;
  const FilmDescription& film() const { return film_; }
  const SamplerDescription& sampler() const { return sampler_; }
  const IntegratorDescription& integrator() const { return integrator_; }
  /// Remarks on what was repaired or left out.
  const std::vector<std::string>& warnings() const { return warnings_; }
  ColorMode color() const { return color_; }

 private:
  friend class SceneCompiler;

  std::vector<ShapeRow> shapes_;
  std::vector<VertexRow> vertices_;
  std::vector<std::uint32_t> triangles_;
  std::vector<QuadricRow> quadrics_;
  std::vector<InstanceRow> instances_;
  std::vector<MaterialRow> materials_;
  std::vector<TextureBinding> bindings_;
  std::vector<NormalMapRow> normal_maps_;
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
  std::uint32_t camera_medium_ = 0;
  std::vector<LightRow> lights_;
  std::vector<AliasEntry> light_alias_, triangle_alias_;
  LightTree light_tree_;
  std::uint32_t bounded_light_count_ = 0;
  std::vector<LightTriangleRow> light_triangles_;
  std::vector<LightFrameRow> light_frames_;
  std::vector<LightUvRow> light_uvs_;
  std::vector<Vec3f> light_powers_;
  Envmap envmap_;
  bool has_textured_lights_ = false;
  std::uint32_t bucket_count_ = 1;
  std::uint32_t bucket_begin_[kClosureKinds + 1] = {};
  std::uint32_t kind_flags_[kClosureKinds] = {};
  bool has_composites_ = false;
  std::uint32_t environment_ = kNone;
  Vec3f center_{};
  float radius_ = 0;
  SceneInfo counts_;
  Camera camera_;
  FilterTable filter_;
  FilmDescription film_;
  SamplerDescription sampler_;
  IntegratorDescription integrator_;
  std::vector<std::string> warnings_;
  std::unique_ptr<Accel> accel_;
  ColorMode color_ = ColorMode::kRgb;
  std::vector<float> spectrum_tables_;
  std::vector<SpectrumRow> material_spectra_, light_spectra_, medium_spectra_;
};

}  // namespace sheaf
