// The steps of scene compilation in order, with cameras, materials, bounds and the final tables.
#include "scene/compile/compile.h"

#include "core/io/memory.h"
#include "scene/compile/compile_camera.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/media/load_volume.h"
#include "scene/compile/render_origin.h"
#include "scene/compile/scene_compiler.h"

#include <algorithm>
#include <new>

namespace sheaf {

namespace {

constexpr const char* kFewerTriangles = "use fewer triangles, or instances in place of copies";

/// Runs a step. If memory runs out, throws an error that names the data and gives advice.
template <class Step> void with_memory_for(const char* what, const char* advice, Step&& step) {
  try {
    step();
  } catch (const std::bad_alloc&) { throw out_of_memory("the scene's " + std::string(what), advice); }
}

/// Compiles a scene relative to a point in world space.
std::unique_ptr<Scene> compile_from(Vec3d origin, const Description& description, const CompileOptions& options) {
  if (origin == Vec3d()) return SceneCompiler(description, origin, options).run();
  const Description moved = moved_to(description, origin);
  return SceneCompiler(moved, origin, options).run();
}

}  // namespace

std::unique_ptr<Scene> SceneCompiler::run() {
  // Copy the settings
  out_->color_ = options_.color;
  if (options_.color == ColorMode::kSpectral) spectra_.emplace();
  out_->film_ = in_.film;
  out_->sampler_ = in_.sampler;
  out_->integrator_ = in_.integrator;
  // Prepare cameras and pixel filter
  add_cameras();
  const bool weighted = in_.film.filter_mode == FilterMode::kWeighted;
  out_->sensor_.filter = weighted ? make_placement_table(in_.film.filter) : make_filter_table(in_.film.filter);
  if (weighted) out_->sensor_.filter_weights.emplace(in_.film.filter);
  // Read meshes and textures by all threads; compile textures and materials
  read_meshes_ahead();
  with_memory_for("textures", "use smaller images", [&] {
    const SecondsTimer timer(times_.texture_seconds);
    out_->textures_ = compile_textures(in_.textures, &places_of_texture_grids_);
  });
  out_->warnings_ = in_.warnings;
  out_->warnings_.insert(out_->warnings_.end(), out_->textures_.warnings.begin(), out_->textures_.warnings.end());
  attributes_.emplace(out_->textures_.attribute_names);
  add_materials();
  for (std::string& warning : clamped_texel_warnings(in_.textures, out_->textures_, out_->materials_.bindings))
    out_->warnings_.push_back(std::move(warning));
  // Add shapes, those of groups last, and instances
  with_memory_for("meshes and instances", kFewerTriangles, [&] {
    const SecondsTimer timer(times_.mesh_seconds);
    for (const ShapeDescription& shape : in_.shapes)
      if (!is_placed_by_motion(shape)) add_shape(shape);
    ungrouped_shapes_ = static_cast<std::uint32_t>(out_->geometry_.shapes.size());
    std::vector<GroupContents> groups;
    for (const ShapeGroup& group : in_.groups) groups.push_back(add_group(group.shapes, group.id));
    add_instances(groups);
    meshes_.reset();
  });
  if (const Vec3d origin = origin_of_mesh_files(); origin != Vec3d()) return compile_from(origin, in_, options_);
  for (const OpenBoundaries::Gap& gap : open_boundaries_.gaps())
    out_->warnings_.push_back(
        SceneError(gap.where,
                   "the mesh bounds a medium and has " + std::to_string(gap.edges) +
                       " open edges: unless other shapes close it, paths enter and leave the medium unnoticed")
            .what());
  check_attributes();
  set_bounds();
  // Compile media, and lights, which depend on the bounds and on emitting media
  with_memory_for("grids of media", "use coarser grids", [&] { add_media(); });
  with_memory_for("lights and environment map", "use a smaller environment map", [&] { add_lights(); });
  end_media();
  // Pad the tables and build the acceleration structure
  with_memory_for("acceleration structure", kFewerTriangles, [&] { finish_tables(); });
  out_->view_ = out_->make_view();
  if (options_.report != nullptr) *options_.report = report();
  return std::move(out_);
}

CompileReport SceneCompiler::report() const {
  CompileReport report = times_;
  report.grids = places_of_grids_;
  report.grids.insert(report.grids.end(), places_of_texture_grids_.begin(), places_of_texture_grids_.end());
  for (PlacedGrid& grid : report.grids) {
    const auto in_world = [&](Vec3f p) { return (Vec3d(p) + out_->origin_).rounded(); };
    grid.box = {in_world(grid.box.min), in_world(grid.box.max)};
  }
  report.envmap_width = out_->lights_.envmap.width;
  report.envmap_height = out_->lights_.envmap.height;
  report.envmap_bytes = out_->lights_.envmap.bytes();
  report.texture_bytes = out_->textures_.tile_count * sizeof(TexelTile);
  return report;
}

void SceneCompiler::add_cameras() {
  const auto count = static_cast<int>(in_.more_cameras.size()) + 1;
  if (in_.film.width % count != 0)
    throw SceneError(in_.camera.where, "the film's width of " + std::to_string(in_.film.width) +
                                           " pixels is not a multiple of the number of cameras, " +
                                           std::to_string(count));
  cameras_.push_back(place_camera(in_.camera, 0));
  for (const CameraDescription& camera : in_.more_cameras) cameras_.push_back(place_camera(camera, cameras_.size()));
  for (const CameraDescription& camera : cameras_) {
    const Camera made = make_camera(camera, in_.film.width / count, in_.film.height);
    if (&camera == cameras_.data())
      out_->sensor_.camera = made;
    else
      out_->sensor_.more_cameras.push_back(made);
  }
  if (in_.integrator.traits().connects_photons() && (count > 1 || !out_->sensor_.camera.sees_points))
    throw SceneError(
        in_.camera.where,
        "light tracing needs a single camera that forms an image: photons cannot be connected to this sensor");
}

void SceneCompiler::add_materials() {
  // Reject bump maps without slopes over uv
  for (const MaterialDescription& m : in_.materials) {
    const auto* bump = std::get_if<BumpMapDescription>(&m.model);
    if (bump == nullptr || static_cast<std::size_t>(bump->displacement) >= in_.textures.size()) continue;
    if (domain_of(in_.textures[static_cast<std::size_t>(bump->displacement)].model) == TextureDomain::kPoint)
      throw SceneError(m.where, "a volume grid cannot be a bump map (expected a texture over uv)");
  }
  // Flatten materials and phase functions into rows
  std::vector<PhaseDescription> phases = in_.phases;
  if (!in_.media.empty()) phases.push_back({IsotropicPhaseDescription{}, {}});
  naming_.add_materials(in_.materials);
  CompiledMaterials materials = compile_materials(in_.materials, spectra(), phases);
  row_of_phase_ = std::move(materials.row_of_phase);
  out_->warnings_.insert(out_->warnings_.end(), materials.warnings.begin(), materials.warnings.end());
  for (const MaterialSpectra& rows : materials.spectra)
    out_->spectra_.materials.insert(out_->spectra_.materials.end(), rows.begin(), rows.end());
  out_->materials_ = std::move(materials.tables);
  row_of_material_ = std::move(materials.row_of);
  default_material_ = materials.default_row;
  // Find out whether shadow rays may pass through surfaces
  const auto lets_pass = [](const MaterialRow& row) {
    return (row.flags & kComposite) != 0 &&
           (row.choice[0] == MaterialRow::kNothing || row.choice[1] == MaterialRow::kNothing);
  };
  out_->needs_transmittance_ =
      !in_.media.empty() || std::any_of(out_->materials_.rows.begin(), out_->materials_.rows.end(), lets_pass);
  out_->shadow_rays_pass_thin_dielectrics_ =
      in_.integrator.thin_dielectrics_are_free && shadow_rays_can_pass_thin_dielectrics();
  // Light tracing connects photons to the camera by shadow rays, which pass lights that the camera does not see.
  const bool passes_lights = in_.integrator.traits().connects_photons() && in_.integrator.hide_emitters;
  out_->needs_transmittance_ = out_->needs_transmittance_ || out_->shadow_rays_pass_thin_dielectrics_ || passes_lights;
  out_->counts_.materials = in_.materials.size();
}

bool SceneCompiler::shadow_rays_can_pass_thin_dielectrics() const {
  const std::vector<MaterialRow>& rows = out_->materials_.rows;
  const auto is_thin_dielectric = [&](std::uint32_t row) {
    return row != MaterialRow::kNothing && closure_info(rows[row].kind).is_thin_dielectric;
  };
  bool any = false;
  for (const MaterialRow& row : rows) {
    const bool composite = (row.flags & kComposite) != 0;
    if (composite && (is_thin_dielectric(row.choice[0]) || is_thin_dielectric(row.choice[1]))) return false;
    if (composite || !closure_info(row.kind).is_thin_dielectric) continue;
    if ((row.flags & (kNeedsUv | kMapped)) != 0 || row.binding_count > 0) return false;
    any = true;
  }
  return any;
}

void SceneCompiler::set_bounds() {
  if (!(lower_.x <= upper_.x)) lower_ = upper_ = {0, 0, 0};
  // Bound the shapes by a sphere
  out_->counts_.bounds_min = Vec3d(lower_) + out_->origin_;
  out_->counts_.bounds_max = Vec3d(upper_) + out_->origin_;
  out_->center_ = lower_ * 0.5f + upper_ * 0.5f;
  out_->radius_ = length(upper_ * 0.5f - lower_ * 0.5f);
  // Place distant sensors outside of the sphere
  const float sphere = std::max(out_->radius_, 1e-3f);
  place_distant(out_->sensor_.camera, cameras_[0], out_->center_, sphere);
  for (std::size_t i = 0; i < out_->sensor_.more_cameras.size(); ++i)
    place_distant(out_->sensor_.more_cameras[i], cameras_[i + 1], out_->center_, sphere);
  // Shadow rays to the environment end outside of everything, including the cameras.
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = i == 0 ? out_->sensor_.camera : out_->sensor_.more_cameras[i - 1];
    const MotionRow motion = i < out_->motion_.cameras.size() ? out_->motion_.cameras[i] : MotionRow{};
    for (const Vec3f p : places_along(motion, camera.origin))
      out_->radius_ = std::max(out_->radius_, length(p - out_->center_));
  }
  out_->radius_ = std::max(out_->radius_, 1e-3f);
}

Vec3d SceneCompiler::origin_of_mesh_files() const {
  const auto is_file = [](const ShapeDescription& s) { return std::holds_alternative<MeshFileShape>(s.geometry); };
  if (out_->origin_ != Vec3d() || std::none_of(in_.shapes.begin(), in_.shapes.end(), is_file)) return {};
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < ungrouped_shapes_; ++i) {
    const ShapeRow& shape = out_->geometry_.shapes[i];
    if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh)
      points.push_back(out_->geometry_.vertices[shape.first_vertex].position);
  }
  return render_origin(in_.camera.to_world.translation(), points);
}

void SceneCompiler::finish_tables() {
  GeometryTables& geometry = out_->geometry_;
  LightTables& lights = out_->lights_;
  out_->counts_.shapes = geometry.shapes.size();
  // Pad the tables of geometry: triangles are loaded four words at a time, and inactive lanes read row zero
  if (geometry.vertices.empty()) geometry.vertices.emplace_back();
  geometry.vertices.shrink_to_fit();
  if (!geometry.tangents.empty()) geometry.tangents.resize(geometry.vertices.size());
  geometry.triangles.insert(geometry.triangles.end(), kTrianglePadding, 0u);
  geometry.triangles.shrink_to_fit();
  if (geometry.quadrics.empty()) geometry.quadrics.emplace_back();
  if (geometry.shapes.empty()) geometry.shapes.emplace_back();
  // Lay out mesh attributes
  attributes_->finish(static_cast<std::uint32_t>(geometry.shapes.size()));
  out_->textures_.attributes = attributes_->entries();
  out_->textures_.attribute_values = attributes_->values();
  // Pad the tables of lights
  if (lights.triangle_alias.empty()) lights.triangle_alias.emplace_back();
  if (lights.triangles.empty()) lights.triangles.emplace_back();
  if (lights.frames.empty()) lights.frames.emplace_back();
  if (lights.uvs.empty()) lights.uvs.emplace_back();
  if (out_->spectra_.lights.empty()) out_->spectra_.lights.emplace_back();
  for (const MediumRow& medium : out_->media_.rows)
    if ((medium.flags & kMediumEmits) != 0 && medium.light == kNone) out_->names_.has_other_light = true;
  // Build the tables for light selection and the acceleration structure
  if (spectra_) out_->spectra_.samples = spectra_->samples();
  finish_motion();
  select_lights();
  build_accel();
  probe_media();
}

void SceneCompiler::warn(const ShapeDescription& shape, const std::string& message) {
  out_->warnings_.push_back(SceneError(shape.where, message).what());
}

std::unique_ptr<Scene> compile_scene(const Description& description, const CompileOptions& options) {
  return compile_from(render_origin(description), description, options);
}

}  // namespace sheaf
