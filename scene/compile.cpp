#include "scene/compile.h"

#include "core/frame.h"
#include "scene/compile_materials.h"
#include "scene/compile_media.h"
#include "scene/instance.h"
#include "scene/light.h"
#include "scene/light_bounds.h"
#include "scene/medium_probe.h"
#include "scene/mesh.h"
#include "scene/mesh_io.h"
#include "scene/quadric.h"

#include <cmath>
#include <limits>
#include <map>

namespace sheaf {

namespace {

/// Overload set for std::visit.
template <class... F> struct Overloaded : F... { using F::operator()...; };
template <class... F> Overloaded(F...) -> Overloaded<F...>;

/// Vertices that kernels can address: byte-free word indices must fit 32 bits.
constexpr std::size_t kMaxWords = std::numeric_limits<std::uint32_t>::max() - 64;

void append(std::vector<VertexRow>& rows, const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3f p = mesh.positions[i];
    const Vec3f n = mesh.normals.empty() ? Vec3f{} : mesh.normals[i];
    const Vec2f uv = mesh.uvs.empty() ? Vec2f{} : mesh.uvs[i];
    rows.push_back({{p.x, p.y, p.z}, {n.x, n.y, n.z}, {uv.x, uv.y}});
  }
}

/// Whether squares of the coordinates of a box, and of its size, stay finite.
bool is_traceable(Vec3f lower, Vec3f upper) {
  constexpr float kLargest = 1e18f;
  return is_finite(upper - lower) && max_component(abs(upper)) <= kLargest && max_component(abs(lower)) <= kLargest;
}

/// The canonical shape's transform for a quadric of a description.
struct Placement {
  ShapeKind kind;
  Transform to_world;
};

Placement place(const SphereShape& s, const Transform& t) {
  return {ShapeKind::kSphere, t * Transform::translate(s.center) * Transform::scale({s.radius, s.radius, s.radius})};
}
Placement place(const DiskShape&, const Transform& t) { return {ShapeKind::kDisk, t}; }
Placement place(const CylinderShape& c, const Transform& t) {
  const Vec3f axis = c.p1 - c.p0;
  const float height = length(axis);
  if (!(height > 0.0f)) throw SceneError("cylinder of zero length");
  const Frame<Scalar> frame = Frame<Scalar>::from_normal(axis / height);
  Matrix4 m;
  const Vec3f columns[4] = {frame.s * c.radius, frame.t * c.radius, axis, c.p0};
  for (std::size_t j = 0; j < 4; ++j) {
    m.m[0][j] = columns[j].x;
    m.m[1][j] = columns[j].y;
    m.m[2][j] = columns[j].z;
  }
  return {ShapeKind::kCylinder, t * Transform(m)};
}

}  // namespace

/// Fills a Scene, table by table.
class SceneCompiler {
 public:
  SceneCompiler(const Description& description, const CompileOptions& options)
      : in_(description), options_(options), out_(std::make_unique<Scene>()) {}

  std::unique_ptr<Scene> run() {
    out_->color_ = options_.color;
    if (options_.color == ColorMode::kSpectral) spectra_.emplace();
    out_->film_ = in_.film;
    out_->sampler_ = in_.sampler;
    out_->integrator_ = in_.integrator;
    out_->camera_ = make_camera(in_.camera, in_.film.width, in_.film.height);
    out_->filter_ = make_filter_table(in_.film.filter);
    out_->textures_ = compile_textures(in_.textures);
    attributes_.emplace(out_->textures_.attribute_names);
    add_materials();
    for (const ShapeDescription& shape : in_.shapes) add_shape(shape);
    ungrouped_shapes_ = static_cast<std::uint32_t>(out_->shapes_.size());
    std::vector<GroupContents> groups;
    for (const ShapeGroup& group : in_.groups) groups.push_back(add_group(group));
    add_instances(groups);
    set_bounds();
    add_media();
    add_lights();
    finish_tables();
    return std::move(out_);
  }

 private:
  /// What makes rows of spectra; null in RGB mode.
  SpectrumSet* spectra() { return spectra_ ? &*spectra_ : nullptr; }

  /// The row of what a light emits, in spectral mode. Textures are relative to D65.
  SpectrumRow emission_row(const SpectrumInput& emission, const SourceLocation& where) {
    if (!spectra_) return {};
    const auto* spectrum = std::get_if<SpectrumDescription>(&emission);
    try {
      return spectra_->row(spectrum != nullptr ? *spectrum : SpectrumDescription::constant(1), SpectrumUse::kIlluminant);
    } catch (const SceneError& error) { throw SceneError(where, error.what()); }
  }

  void add_materials() {
    std::vector<PhaseDescription> phases = in_.phases;
    if (!in_.media.empty()) phases.push_back({IsotropicPhaseDescription{}, {}});
    CompiledMaterials materials = compile_materials(in_.materials, spectra(), phases);
    row_of_phase_ = std::move(materials.row_of_phase);
    for (const MaterialSpectra& rows : materials.spectra)
      out_->material_spectra_.insert(out_->material_spectra_.end(), rows.begin(), rows.end());
    out_->materials_ = std::move(materials.rows);
    row_of_material_ = std::move(materials.row_of);
    default_material_ = materials.default_row;
    out_->bindings_ = std::move(materials.bindings);
    out_->normal_maps_ = std::move(materials.normal_maps);
    out_->bucket_count_ = materials.bucket_count;
    std::copy(std::begin(materials.bucket_begin), std::end(materials.bucket_begin), out_->bucket_begin_);
    std::copy(std::begin(materials.kind_flags), std::end(materials.kind_flags), out_->kind_flags_);
    out_->has_composites_ = std::any_of(out_->materials_.begin(), out_->materials_.end(),
                                        [](const MaterialRow& row) { return (row.flags & kComposite) != 0; });
    const auto lets_pass = [](const MaterialRow& row) {
      return (row.flags & kComposite) != 0 &&
             (row.choice[0] == MaterialRow::kNothing || row.choice[1] == MaterialRow::kNothing);
    };
    out_->has_transparency_ =
        !in_.media.empty() || std::any_of(out_->materials_.begin(), out_->materials_.end(), lets_pass);
    out_->has_open_panes_ = in_.integrator.free_panes && panes_can_be_open();
    out_->has_transparency_ = out_->has_transparency_ || out_->has_open_panes_;
    out_->counts_.materials = in_.materials.size();
  }

  bool panes_can_be_open() const {
    const std::vector<MaterialRow>& rows = out_->materials_;
    const auto is_pane = [&](std::uint32_t row) { return row != MaterialRow::kNothing && is_pane_kind(rows[row].kind); };
    bool any = false;
    for (const MaterialRow& row : rows) {
      const bool composite = (row.flags & kComposite) != 0;
      if (composite && (is_pane(row.choice[0]) || is_pane(row.choice[1]))) return false;
      if (composite || !is_pane_kind(row.kind)) continue;
      if ((row.flags & (kTextured | kMapped)) != 0 || row.binding_count > 0) return false;
      any = true;
    }
    return any;
  }

  void add_shape(const ShapeDescription& shape) {
    ShapeRow row;
    row.material = shape.material ? row_of_material_.at(static_cast<std::size_t>(*shape.material)) : default_material_;
    try {
      std::visit(Overloaded{
                     [&](const MeshFileShape& s) {
                       MeshFile file = read_mesh(s);
                       for (const std::string& w : file.warnings) out_->warnings_.push_back(s.file.string() + ": " + w);
                       add_mesh(row, shape, std::move(file.mesh), shape.face_normals || file.face_normals);
                     },
                     [&](const Mesh& mesh) { add_mesh(row, shape, mesh, shape.face_normals); },
                     [&](const RectangleShape&) { add_mesh(row, shape, rectangle_mesh(), shape.face_normals); },
                     [&](const CubeShape&) { add_mesh(row, shape, cube_mesh(), shape.face_normals); },
                     [&](const auto& quadric) { add_quadric(row, shape, quadric); },
                 },
                 shape.geometry);
    } catch (const SceneError& error) {
      const std::string place = shape.where.file + ":" + std::to_string(shape.where.line);
      if (std::string(error.what()).rfind(place, 0) == 0) throw;
      throw SceneError(shape.where, error.what());
    }
  }

  /// The order of the steps is explained in scene/mesh.h.
  void add_mesh(ShapeRow row, const ShapeDescription& shape, Mesh mesh, bool face_normals) {
    const auto* file = std::get_if<MeshFileShape>(&shape.geometry);
    check_mesh(mesh, shape.where);
    if (face_normals) mesh.normals.clear();
    transform_mesh(mesh, shape.to_world);
    const std::size_t dropped = drop_degenerate_triangles(mesh);
    if (file && file->smooth_normals && !face_normals && mesh.normals.empty()) compute_vertex_normals(mesh);
    if (shape.flip_normals) flip_mesh(mesh);
    if (dropped > 0) warn(shape, std::to_string(dropped) + " degenerate or non-finite triangles left out");
    if (mesh.triangles.empty()) {
      warn(shape, shape.radiance ? "shape has no area: neither seen nor emitting" : "shape has no area: left out");
      return;
    }
    if (8 * (out_->vertices_.size() + mesh.positions.size()) > kMaxWords ||
        out_->triangles_.size() + 3 * mesh.triangles.size() > kMaxWords)
      throw SceneError("more than " + std::to_string(kMaxWords / 3) + " vertices or triangles in all");
    row.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    row.first_vertex = static_cast<std::uint32_t>(out_->vertices_.size());
    row.first_triangle = static_cast<std::uint32_t>(out_->triangles_.size() / 3);
    row.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    row.flags = (mesh.normals.empty() ? 0u : kHasNormals) | (mesh.uvs.empty() ? 0u : kHasUvs);
    append(out_->vertices_, mesh);
    for (const auto& t : mesh.triangles) out_->triangles_.insert(out_->triangles_.end(), t.begin(), t.end());
    GridBox box{mesh.positions[mesh.triangles[0][0]], mesh.positions[mesh.triangles[0][0]]};
    for (const auto& t : mesh.triangles)
      for (std::uint32_t vertex : t) grow(box.min, box.max, mesh.positions[vertex], mesh.positions[vertex]);
    grow(box.min, box.max);
    for (const Mesh::Attribute& attribute : mesh.attributes)
      if (attributes_->wants(attribute.name))
        attributes_->add(static_cast<std::uint32_t>(out_->shapes_.size()), row.first_triangle, row.triangle_count,
                         static_cast<std::uint32_t>(mesh.positions.size()), attribute, shape.where);
    vertex_counts_.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
    out_->counts_.triangles += mesh.triangles.size();
    out_->counts_.vertices += mesh.positions.size();
    push_shape(row, shape, box);
  }

  template <class Quadric> void add_quadric(ShapeRow row, const ShapeDescription& shape, const Quadric& quadric) {
    const Placement placement = place(quadric, shape.to_world);
    const QuadricRow q = make_quadric(placement.kind, placement.to_world, shape.flip_normals);
    const QuadricBounds bounds = quadric_bounds(q);
    if (!is_traceable(bounds.lower, bounds.upper) || !(q.determinant > 0.0f)) {
      warn(shape, "shape is degenerate or too large for single precision: left out");
      return;
    }
    grow(bounds.lower, bounds.upper);
    row.kind = static_cast<std::uint32_t>(placement.kind);
    row.first_triangle = static_cast<std::uint32_t>(out_->quadrics_.size());
    out_->quadrics_.push_back(q);
    vertex_counts_.push_back(0);
    ++out_->counts_.quadrics;
    push_shape(row, shape, {bounds.lower, bounds.upper});
  }

  /// What a shape emits, or nothing if that is black.
  std::optional<AreaEmission> emission_of(const ShapeDescription& shape) {
    if (!shape.radiance) return std::nullopt;
    if (const auto* texture = std::get_if<TextureId>(&*shape.radiance))
      return AreaEmission{{1, 1, 1}, texture_row(*texture, shape.where), emission_row(*texture, shape.where)};
    const Vec3f radiance = emission_rgb(std::get<SpectrumDescription>(*shape.radiance));
    if (!(max_component(radiance) > 0.0f)) return std::nullopt;
    return AreaEmission{radiance, kNone, emission_row(*shape.radiance, shape.where)};
  }

  std::uint32_t texture_row(TextureId id, const SourceLocation& where) const {
    if (static_cast<std::size_t>(id) >= in_.textures.size())
      throw SceneError(where, "refers to a texture that does not exist");
    return static_cast<std::uint32_t>(id);
  }

  /// Adds the row of a shape within `box`. If it emits, a light, which for shapes of groups waits for the instances.
  void push_shape(ShapeRow row, const ShapeDescription& shape, const GridBox& box) {
    const auto index = static_cast<std::uint32_t>(out_->shapes_.size());
    if (shape.interior || shape.exterior) {
      row.boundary = static_cast<std::uint32_t>(out_->boundaries_.size());
      out_->boundaries_.push_back({hold(shape.interior, shape, box), hold(shape.exterior, shape, box)});
      if (shape.exterior_is_surrounding) surrounded_shapes_.push_back(index);
    }
    if (const std::optional<AreaEmission> emission = emission_of(shape)) {
      if (group_emitters_ != nullptr) {
        row.light = static_cast<std::uint32_t>(group_emitters_->size());
        group_emitters_->push_back({index, *emission});
      } else {
        row.light = static_cast<std::uint32_t>(out_->lights_.size());
        add_area_light(row, {index, *emission}, nullptr);
      }
    }
    out_->shapes_.push_back(row);
  }

  /// A shape that emits.
  struct Emitter {
    std::uint32_t shape;
    AreaEmission emission;
  };

  void add_area_light(const ShapeRow& row, const Emitter& emitter, const InstanceRow* instance) {
    const ShapeTables tables{out_->vertices_.data(), out_->triangles_.data(), out_->quadrics_.data()};
    LightPlaces places{static_cast<std::uint32_t>(out_->triangle_alias_.size()),
                       static_cast<std::uint32_t>(out_->light_uvs_.size()), row.first_triangle};
    if (instance != nullptr) places.quadric = static_cast<std::uint32_t>(out_->quadrics_.size());
    AreaLight light = make_area_light(row, emitter.shape, tables, emitter.emission, places, instance);
    constexpr std::size_t kRowWords = sizeof(LightTriangleRow) / sizeof(float);
    if (kRowWords * (out_->light_triangles_.size() + light.triangles.size()) > kMaxWords)
      throw SceneError("the lights have more than " + std::to_string(kMaxWords / kRowWords) + " triangles in all");
    out_->lights_.push_back(light.row);
    out_->light_spectra_.push_back(emitter.emission.spectrum);
    out_->has_textured_lights_ = out_->has_textured_lights_ || light.row.texture != kNone;
    out_->triangle_alias_.insert(out_->triangle_alias_.end(), light.alias.begin(), light.alias.end());
    out_->light_triangles_.insert(out_->light_triangles_.end(), light.triangles.begin(), light.triangles.end());
    out_->light_uvs_.insert(out_->light_uvs_.end(), light.uvs.begin(), light.uvs.end());
    if (light.quadric) out_->quadrics_.push_back(*light.quadric);
  }

  /// What a group holds, for its instances.
  struct GroupContents {
    ShapeRange range;
    std::uint32_t index;  ///< among the groups that are not empty
    std::size_t triangles;
    Vec3f lower, upper;   ///< bounds in the group's space
    std::vector<Emitter> emitters;
  };

  GroupContents add_group(const ShapeGroup& group) {
    const Vec3f lower = lower_, upper = upper_;
    const std::size_t triangles = out_->counts_.triangles;
    const auto first = static_cast<std::uint32_t>(out_->shapes_.size());
    lower_ = {kInfinity, kInfinity, kInfinity};
    upper_ = {-kInfinity, -kInfinity, -kInfinity};
    std::vector<Emitter> emitters;
    group_emitters_ = &emitters;
    for (const ShapeDescription& shape : group.shapes) add_shape(shape);
    group_emitters_ = nullptr;
    const ShapeRange range{first, static_cast<std::uint32_t>(out_->shapes_.size()) - first};
    GroupContents contents{range, static_cast<std::uint32_t>(group_ranges_.size()),
                           out_->counts_.triangles - triangles, lower_, upper_, std::move(emitters)};
    if (range.shape_count > 0) group_ranges_.push_back(range);
    lower_ = lower;
    upper_ = upper;
    return contents;
  }

  void add_instances(const std::vector<GroupContents>& groups) {
    out_->instances_.reserve(in_.instances.size());
    std::size_t too_large = 0;
    for (const InstanceDescription& instance : in_.instances) {
      const GroupContents& group = groups.at(instance.group);
      if (group.range.shape_count == 0) continue;
      InstanceRow row = make_instance(instance.to_world, group.range.first_shape, group.index);
      const InstanceBounds bounds = instance_bounds(row, group.lower, group.upper);
      if (!is_traceable(bounds.lower, bounds.upper)) {
        ++too_large;
        continue;
      }
      grow(bounds.lower, bounds.upper);
      row.first_light = static_cast<std::uint32_t>(out_->lights_.size());
      for (const Emitter& emitter : group.emitters) add_area_light(out_->shapes_[emitter.shape], emitter, &row);
      out_->instances_.push_back(row);
      out_->counts_.instanced_triangles += group.triangles;
    }
    if (too_large > 0)
      out_->warnings_.push_back(std::to_string(too_large) + " instances too large for single precision: left out");
    if (out_->shapes_.size() + out_->instances_.size() >= kNone)
      throw SceneError("more than 2^32 shapes and instances");
    out_->counts_.groups = group_ranges_.size();
    out_->counts_.instances = out_->instances_.size();
  }

  /// The medium on a side of a shape as BoundaryRow has it.
  std::uint32_t hold(std::optional<MediumId> medium, const ShapeDescription& shape, const GridBox& box) {
    if (!medium) return 0;
    const auto index = static_cast<std::size_t>(*medium);
    const MediumDescription& m = in_.media.at(index);
    const auto* by_albedo = std::get_if<MediumDescription::ExtinctionAlbedo>(&m.coefficients);
    const bool has_grid = m.density || m.temperature ||
                          (by_albedo && (std::holds_alternative<GridVolumeDescription>(by_albedo->sigma_t) ||
                                         std::holds_alternative<GridVolumeDescription>(by_albedo->albedo)));
    if (group_emitters_ != nullptr && (has_grid || m.emission))
      throw SceneError(shape.where, "a medium in a shape group must be homogeneous and must not emit");
    medium_boxes_.resize(in_.media.size());
    medium_boxes_[index].push_back(box);
    return static_cast<std::uint32_t>(index) + 1;
  }

  void add_media() {
    medium_boxes_.resize(in_.media.size());
    if (in_.media.size() > kMostMedia) throw SceneError("more than " + std::to_string(kMostMedia) + " media");
    std::vector<PlacedMedium> placed;
    for (std::size_t i = 0; i < in_.media.size(); ++i) {
      const MediumDescription& m = in_.media[i];
      const std::size_t phase = m.phase ? static_cast<std::size_t>(*m.phase) : row_of_phase_.size() - 1;
      placed.push_back({&m, row_of_phase_.at(phase), medium_boxes_[i], {lower_, upper_}});
      if (m.temperature && !spectra_ && !out_->blackbodies_) out_->blackbodies_.emplace();
    }
    CompiledMedia media = compile_media(placed, spectra(), in_.integrator.step_size);
    out_->media_ = std::move(media.rows);
    out_->medium_spectra_ = std::move(media.spectra);
    if (spectra_) out_->spectrum_tables_ = spectra_->samples();
    out_->grids_ = std::move(media.grids);
    out_->grid_rows_ = std::move(media.grid_rows);
    out_->majorant_grids_ = std::move(media.majorants);
    out_->majorant_rows_ = std::move(media.majorant_rows);
    out_->warnings_.insert(out_->warnings_.end(), media.warnings.begin(), media.warnings.end());
    if (in_.camera.medium) out_->camera_medium_ = static_cast<std::uint32_t>(*in_.camera.medium) + 1;
  }

  /// Media that glow become lights, where lights are sampled and the estimator can weigh them.
  void add_volume_lights() {
    if (in_.integrator.strategy == LightStrategy::kBsdfOnly ||
        in_.integrator.medium_estimator == MediumEstimator::kMarching)
      return;
    for (std::uint32_t i = 0; i < out_->media_.size(); ++i) {
      const auto light = make_volume_light(out_->view(), i, medium_boxes_[i], static_cast<std::uint32_t>(out_->triangle_alias_.size()));
      if (!light) continue;
      out_->media_[i].light = static_cast<std::uint32_t>(out_->lights_.size());
      out_->lights_.push_back(light->row);
      out_->light_spectra_.emplace_back();
      out_->triangle_alias_.insert(out_->triangle_alias_.end(), light->alias.begin(), light->alias.end());
    }
  }

  /// What only looking around can tell: media around shapes and around the camera.
  void probe_media() {
    if (out_->boundaries_.empty()) return;
    const std::uint32_t otherwise = out_->camera_medium_;
    for (const std::uint32_t shape : surrounded_shapes_) {
      const SceneView view = out_->view();
      out_->boundaries_[out_->shapes_[shape].boundary].exterior = medium_around(view, shape, otherwise);
    }
    if (!in_.camera.medium) out_->camera_medium_ = medium_at(out_->view(), out_->camera_.origin, kNone, 0);
  }

  static void grow(Vec3f& lower, Vec3f& upper, Vec3f to_lower, Vec3f to_upper) {
    lower = {std::min(lower.x, to_lower.x), std::min(lower.y, to_lower.y), std::min(lower.z, to_lower.z)};
    upper = {std::max(upper.x, to_upper.x), std::max(upper.y, to_upper.y), std::max(upper.z, to_upper.z)};
  }
  void grow(Vec3f lower, Vec3f upper) { grow(lower_, upper_, lower, upper); }

  void set_bounds() {
    if (!(lower_.x <= upper_.x)) lower_ = upper_ = {0, 0, 0};
    out_->counts_.bounds_min = lower_;
    out_->counts_.bounds_max = upper_;
    out_->center_ = lower_ * 0.5f + upper_ * 0.5f;
    out_->radius_ = length(upper_ * 0.5f - lower_ * 0.5f);
    // Shadow rays to the environment end outside of everything, the camera included.
    out_->radius_ = std::max(out_->radius_, length(out_->camera_.origin - out_->center_));
    out_->radius_ = std::max(out_->radius_, 1e-3f);
  }

  /// Those that are somewhere join the area lights, the others come last.
  void add_lights() {
    std::vector<std::pair<PlacedLight, SourceLocation>> placed;
    for (const LightDescription& light : in_.lights)
      if (auto row = std::visit([&](const auto& model) { return place_light(model, light.where); }, light.model)) {
        row->spectrum = spectrum_of(light);
        placed.emplace_back(std::move(*row), light.where);
      }
    for (const bool infinite : {false, true}) {
      for (const auto& [light, where] : placed)
        if (is_infinite(light.row) == infinite) push_light(light, where);
      if (!infinite) add_volume_lights();
      if (!infinite) out_->bounded_light_count_ = static_cast<std::uint32_t>(out_->lights_.size());
    }
    out_->counts_.lights = out_->lights_.size();
  }

  void push_light(PlacedLight light, const SourceLocation& where) {
    const Vec3f emitted{light.row.radiance[0], light.row.radiance[1], light.row.radiance[2]};
    if (!(max_component(emitted) > 0.0f)) return;
    const auto kind = static_cast<LightKind>(light.row.kind);
    if (kind == LightKind::kConstant || kind == LightKind::kEnvmap) {
      if (out_->environment_ != kNone) throw SceneError(where, "a scene may have only one environment light");
      out_->environment_ = static_cast<std::uint32_t>(out_->lights_.size());
    }
    if (light.frame) {
      light.row.detail = static_cast<std::uint32_t>(out_->light_frames_.size());
      out_->light_frames_.push_back(*light.frame);
    }
    out_->lights_.push_back(light.row);
    out_->light_spectra_.push_back(light.spectrum);
  }

  /// The row of what LightRow::radiance is.
  SpectrumRow spectrum_of(const LightDescription& light) {
    return std::visit(Overloaded{
                          [&](const PointLightDescription& l) { return emission_row(l.intensity, light.where); },
                          [&](const ConstantLightDescription& l) { return emission_row(l.radiance, light.where); },
                          [&](const SpotLightDescription& l) { return emission_row(l.intensity, light.where); },
                          [&](const DirectionalLightDescription& l) { return emission_row(l.irradiance, light.where); },
                          [&](const ProjectorDescription& l) {
                            SpectrumRow row = emission_row(l.irradiance, light.where);
                            row.scale *= kPi * l.scale;
                            return row;
                          },
                          [&](const EnvmapDescription&) {
                            return emission_row(SpectrumDescription::constant(1), light.where);
                          },
                      },
                      light.model);
  }

  std::optional<PlacedLight> place_light(const PointLightDescription& light, const SourceLocation&) const {
    return make_point_light(emission_rgb(light.intensity), light.position);
  }
  std::optional<PlacedLight> place_light(const ConstantLightDescription& light, const SourceLocation&) const {
    return make_constant_light(emission_rgb(light.radiance));
  }
  std::optional<PlacedLight> place_light(const SpotLightDescription& light, const SourceLocation& where) const {
    if (light.texture) texture_row(*light.texture, where);
    return make_spot_light(light, where);
  }
  std::optional<PlacedLight> place_light(const DirectionalLightDescription& light, const SourceLocation& where) const {
    return make_directional_light(light, where);
  }
  std::optional<PlacedLight> place_light(const ProjectorDescription& light, const SourceLocation& where) const {
    double aspect = 1;
    if (const auto* id = std::get_if<TextureId>(&light.irradiance)) {
      const TextureRow& row = out_->textures_.rows[texture_row(*id, where)];
      if (row.kind == TextureKind::kBitmap) aspect = double(row.bitmap.width) / row.bitmap.height;
    }
    return make_projector(light, aspect, where);
  }
  std::optional<PlacedLight> place_light(const EnvmapDescription& light, const SourceLocation& where) {
    const EnvmapPicture picture = read_envmap_picture(light.file);
    if (const std::size_t bad = count_unusable(picture); bad > 0)
      out_->warnings_.push_back(light.file.string() + ": " + std::to_string(bad) +
                                " values that are negative or not finite count as 0");
    // Without BSDF sampling what is not sampled would be lost.
    const bool compensate = light.mis_compensation && in_.integrator.strategy == LightStrategy::kMis;
    Envmap map = make_envmap(picture, light.scale, compensate);
    set_rotation(map, light.to_world, where);
    if (!(max_component(map.mean) > 0.0f)) {
      out_->warnings_.push_back(light.file.string() + ": the environment map is black");
      return std::nullopt;
    }
    if (out_->color_ == ColorMode::kSpectral) uplift_nodes(map);
    const PlacedLight placed = make_envmap_light(map);
    if (out_->environment_ == kNone) out_->envmap_ = std::move(map);
    return placed;
  }

  /// Once textures can be looked up.
  void select_lights() {
    const SceneView view = out_->view();
    std::vector<float> weights;
    for (std::uint32_t i = 0; i < view.light_count; ++i) {
      const Vec3f power = light_power(view, i);
      out_->light_powers_.push_back(power);
      // Much of what an environment sends through the bounding sphere meets nothing: at its full power it would take
      // the samples of lights inside.
      constexpr double kEnvironmentShare = 0.25;
      const double share = i == view.environment ? kEnvironmentShare : 1.0;
      const double mean = (double(power.x) + power.y + power.z) / 3.0 * share;
      // Weights must be positive and finite however large the light.
      weights.push_back(static_cast<float>(std::clamp(mean, 1e-30, 1e30)));
    }
    if (weights.empty()) return;
    out_->light_alias_ = build_alias_table(weights);
    std::vector<LightBounds> bounds;
    for (std::uint32_t i = 0; i < view.bounded_light_count; ++i) bounds.push_back(bounds_of_light(view, i, weights[i]));
    out_->light_tree_ = build_light_tree(bounds);
  }

  void finish_tables() {
    out_->counts_.shapes = out_->shapes_.size();
    // Triangles are read four words wide, and absent tables are read at index zero by lanes that are switched off.
    if (out_->vertices_.empty()) out_->vertices_.emplace_back();
    out_->vertices_.shrink_to_fit();
    out_->triangles_.insert(out_->triangles_.end(), 8, 0u);
    out_->triangles_.shrink_to_fit();
    if (out_->quadrics_.empty()) out_->quadrics_.emplace_back();
    if (out_->shapes_.empty()) out_->shapes_.emplace_back();
    attributes_->finish(static_cast<std::uint32_t>(out_->shapes_.size()), out_->textures_);
    out_->attributes_ = attributes_->entries();
    out_->attribute_values_ = attributes_->values();
    if (out_->triangle_alias_.empty()) out_->triangle_alias_.emplace_back();
    if (out_->light_triangles_.empty()) out_->light_triangles_.emplace_back();
    if (out_->light_frames_.empty()) out_->light_frames_.emplace_back();
    if (out_->light_uvs_.empty()) out_->light_uvs_.emplace_back();
    if (out_->light_spectra_.empty()) out_->light_spectra_.emplace_back();
    if (spectra_) out_->spectrum_tables_ = spectra_->samples();
    select_lights();
    const AccelInput input{out_->shapes_.data(), ungrouped_shapes_, out_->vertices_.data(), out_->triangles_.data(),
                           out_->quadrics_.data(), vertex_counts_.data(), options_.watertight,
                           group_ranges_.data(), static_cast<std::uint32_t>(group_ranges_.size()),
                           out_->instances_.data(), static_cast<std::uint32_t>(out_->instances_.size())};
    out_->accel_ = std::make_unique<Accel>(input);
    probe_media();
  }

  void warn(const ShapeDescription& shape, const std::string& message) {
    out_->warnings_.push_back(SceneError(shape.where, message).what());
  }

  const Description& in_;
  const CompileOptions& options_;
  std::unique_ptr<Scene> out_;
  std::vector<std::uint32_t> row_of_material_;
  std::uint32_t default_material_ = 0;
  std::optional<SpectrumSet> spectra_;        ///< in spectral mode
  std::optional<AttributeTable> attributes_;  ///< once textures are known
  std::vector<std::uint32_t> vertex_counts_;
  std::vector<std::uint32_t> row_of_phase_;              ///< the last: isotropic
  std::vector<std::vector<GridBox>> medium_boxes_;       ///< around the shapes that hold each medium
  std::vector<std::uint32_t> surrounded_shapes_;         ///< whose exterior is yet to be found
  std::uint32_t ungrouped_shapes_ = 0;
  std::vector<ShapeRange> group_ranges_;
  std::vector<Emitter>* group_emitters_ = nullptr;  ///< of the group whose shapes are being added
  Vec3f lower_{kInfinity, kInfinity, kInfinity}, upper_{-kInfinity, -kInfinity, -kInfinity};
};

std::unique_ptr<Scene> compile_scene(const Description& description, const CompileOptions& options) {
  return SceneCompiler(description, options).run();
}

}  // namespace sheaf
