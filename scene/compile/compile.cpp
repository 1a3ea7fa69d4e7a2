// The steps of scene compilation in order. Each subject has a compiler of its own.
#include "scene/compile/compile.h"

#include "core/color/uplift.h"
#include "core/io/memory.h"
#include "scene/compile/compile_camera.h"
#include "scene/compile/compile_lights.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/geometry/compile_geometry.h"
#include "scene/compile/media/compile_media.h"
#include "scene/compile/render_origin.h"
#include "scene/compile/scene_naming.h"
#include "scene/compile/textures/mip_levels.h"
#include "scene/materials/flattener.h"

#include <tbb/task_group.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <functional>
#include <new>
#include <optional>
#include <span>
#include <utility>

namespace sheaf {

namespace {

constexpr const char* kFewerTriangles = "use fewer triangles, or instances instead of copies";
constexpr const char* kSmallerImages = "use smaller images";
constexpr const char* kMipLevels = "mip levels of textures";

/// Runs a step. If memory runs out, throws an error that names the data and gives advice.
template <class Step> void with_memory_for(const char* what, const char* advice, Step&& step) {
  try {
    step();
  } catch (const std::bad_alloc&) { throw out_of_memory("the scene's " + std::string(what), advice); }
}

/// Adds the time until its destruction, in seconds.
class SecondsTimer {
 public:
  explicit SecondsTimer(double& seconds) : seconds_(seconds) {}
  ~SecondsTimer() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  SecondsTimer(const SecondsTimer&) = delete;
  SecondsTimer& operator=(const SecondsTimer&) = delete;

 private:
  double& seconds_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Work that runs beside the calling thread. Destruction waits for its end.
class BesideTask {
 public:
  explicit BesideTask(std::function<void()> work) : work_(std::move(work)) {
    group_.run([this] {
      try {
        work_();
      } catch (...) { error_ = std::current_exception(); }
    });
  }
  ~BesideTask() { group_.wait(); }
  BesideTask(const BesideTask&) = delete;
  BesideTask& operator=(const BesideTask&) = delete;
  /// Waits for the end, and throws the exception of the work, if any.
  void finish() {
    group_.wait();
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::function<void()> work_;
  std::exception_ptr error_;  ///< written by the work, read after its end
  tbb::task_group group_;
};

/// Appends warnings.
void append(std::vector<std::string>& warnings, const std::vector<std::string>& more) {
  warnings.insert(warnings.end(), more.begin(), more.end());
}

/// Whether shadow rays may pass through the thin dielectrics among materials.
bool can_pass_thin_dielectrics(const std::vector<MaterialRow>& rows) {
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

/// Adds materials and phase functions, the last of which is isotropic if there are media.
CompiledMaterials add_materials(const Description& in, SpectrumSet* spectra, ErrorSink& errors, SceneTables& scene) {
  // Replace bump maps without slopes over uv
  std::vector<MaterialDescription> all = in.materials;
  for (MaterialDescription& m : all) {
    const auto* bump = std::get_if<BumpMapDescription>(&m.model);
    if (bump == nullptr || static_cast<std::size_t>(bump->displacement) >= in.textures.size()) continue;
    if (domain_of(in.textures[static_cast<std::size_t>(bump->displacement)].model) != TextureDomain::kPoint) continue;
    errors.report(SceneError(m.where, "a volume grid cannot be a bump map (expected a texture over uv)"),
                  kDiffuseSubstitute);
    m.model = DiffuseDescription{};
  }
  // Flatten materials and phase functions into rows
  std::vector<PhaseDescription> phases = in.phases;
  if (!in.media.empty()) phases.push_back({IsotropicPhaseDescription{}, {}});
  CompiledMaterials materials = compile_materials(all, spectra, phases, &errors);
  append(scene.warnings, materials.warnings);
  for (const MaterialSpectra& rows : materials.spectra)
    scene.spectra.materials.insert(scene.spectra.materials.end(), rows.begin(), rows.end());
  scene.materials = std::move(materials.tables);
  append(scene.warnings, clamped_texel_warnings(in.textures, scene.textures, scene.materials.bindings));
  return materials;
}

/// Finds out whether shadow rays may pass through surfaces.
void set_transmittance(const Description& in, SceneTables& scene) {
  const std::vector<MaterialRow>& rows = scene.materials.rows;
  const auto lets_pass = [](const MaterialRow& row) {
    return (row.flags & kComposite) != 0 &&
           (row.choice[0] == MaterialRow::kNothing || row.choice[1] == MaterialRow::kNothing);
  };
  scene.shadow_rays_pass_thin_dielectrics =
      scene.integrator.thin_dielectrics_are_free && can_pass_thin_dielectrics(rows);
  // Light tracing connects photons to the camera by shadow rays, which pass lights that the camera does not see.
  const bool passes_lights = scene.integrator.traits().connects_photons() && scene.integrator.hide_emitters;
  scene.needs_transmittance = !in.media.empty() || std::any_of(rows.begin(), rows.end(), lets_pass) ||
                              scene.shadow_rays_pass_thin_dielectrics || passes_lights;
}

/// The origin that suits the vertices of mesh files; zero if the present one does.
Vec3d origin_of_mesh_files(const Description& in, const CompiledGeometry& geometry, Vec3d origin) {
  const auto is_file = [](const ShapeDescription& s) { return std::holds_alternative<MeshFileShape>(s.geometry); };
  if (origin != Vec3d() || std::none_of(in.shapes.begin(), in.shapes.end(), is_file)) return {};
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < geometry.ungrouped_shapes; ++i) {
    const ShapeRow& shape = geometry.tables.shapes[i];
    if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh)
      points.push_back(geometry.tables.vertices[shape.first_vertex].position);
  }
  return render_origin(in.camera.to_world.translation(), points);
}

/// Moves the tables of geometry to the scene, and names their shapes.
void set_geometry(CompiledGeometry& geometry, SceneNaming& naming, SceneTables& scene) {
  scene.info = geometry.info;
  scene.geometry = std::move(geometry.tables);
  scene.textures.attributes = geometry.attributes.entries();
  scene.textures.attribute_values = geometry.attributes.values();
  for (const auto& [shape, group] : geometry.sources) naming.add_shape(*shape, group);
  append(scene.warnings, geometry.warnings);
}

/// Bounds the shapes and the cameras by a sphere, and places distant sensors outside of the shapes.
void set_bounds(const Bounds3f& shapes, std::span<const CameraDescription> cameras, const MotionCompiler& motion,
                SceneTables& scene) {
  scene.info.bounds_min = Vec3d(shapes.min) + scene.origin;
  scene.info.bounds_max = Vec3d(shapes.max) + scene.origin;
  scene.center = shapes.min * 0.5f + shapes.max * 0.5f;
  scene.radius = length(shapes.max * 0.5f - shapes.min * 0.5f);
  const float sphere = std::max(scene.radius, 1e-3f);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    move_outside_scene(scene.sensor.camera_of(i), cameras[i], scene.center, sphere);
  // Shadow rays to the environment end outside of everything, including the cameras.
  for (std::size_t i = 0; i < cameras.size(); ++i)
    for (const Vec3f p :
         motion.positions(MotionCompiler::of(scene.motion.cameras, i), scene.sensor.camera_of(i).origin))
      scene.radius = std::max(scene.radius, length(p - scene.center));
  scene.radius = std::max(scene.radius, 1e-3f);
}

/// Adds media, whose grids it describes, and lights, which depend on the bounds and on emitting media.
std::vector<PlacedGrid> add_media_and_lights(const Description& in, const CompiledGeometry& geometry,
                                             const std::vector<std::uint32_t>& row_of_phase, SpectrumSet* spectra,
                                             MotionCompiler& motion, SceneNaming& naming, ErrorSink& errors,
                                             SceneTables& scene) {
  const auto store_samples = [&] {
    if (spectra != nullptr) scene.spectra.samples = spectra->samples();
  };
  CompiledMedia media;
  with_memory_for("grids of media", "use coarser grids", [&] {
    media = compile_media(in, scene.integrator, geometry, row_of_phase, spectra, motion, errors, scene.geometry.shapes);
    scene.media = std::move(media.tables);
    scene.spectra.media = std::move(media.spectra);
    append(scene.warnings, media.warnings);
    store_samples();
    check_media(in.media, errors, scene);
  });
  with_memory_for("lights and environment map", "use a smaller environment map", [&] {
    CompiledLights lights = compile_lights(in, geometry, media, spectra, motion, naming, errors, scene);
    scene.info.lights = lights.tables.rows.size();
    scene.lights = std::move(lights.tables);
    scene.spectra.lights = std::move(lights.spectra);
    append(scene.warnings, lights.warnings);
    store_samples();
  });
  for (const MediumRow& medium : scene.media.rows)
    if ((medium.flags & kMediumEmits) != 0 && medium.light == kNone) scene.names.has_other_light = true;
  bound_outer_medium(motion, scene);
  // Extend the tables of motions to all rows
  const auto extend = [](std::vector<MotionRow>& rows, std::size_t count) {
    if (!rows.empty()) rows.resize(count);
  };
  extend(scene.motion.instances, scene.geometry.instances.size());
  extend(scene.motion.lights, scene.lights.rows.size());
  extend(scene.motion.cameras, scene.sensor.more_cameras.size() + 1);
  extend(scene.motion.media, scene.media.rows.size());
  select_lights(motion, scene);
  connect_media(media, scene);
  return media.grids;
}

/// Adds to the report what is known of the finished tables. `grids`: relative to the scene's origin.
void complete(CompileReport& report, std::vector<PlacedGrid> grids, const SceneTables& scene) {
  for (PlacedGrid& grid : grids) {
    const auto in_world = [&](Vec3f p) { return (Vec3d(p) + scene.origin).rounded(); };
    grid.box = {in_world(grid.box.min), in_world(grid.box.max)};
  }
  report.grids = std::move(grids);
  report.envmap_width = scene.lights.envmap.width;
  report.envmap_height = scene.lights.envmap.height;
  report.envmap_bytes = scene.lights.envmap.bytes();
  report.texture_bytes = scene.textures.texel_bytes();
}

/// A scene with its settings, and with the warnings of its description.
SceneTables scene_without_rows(const Description& in, const SceneSettings& settings, ColorMode color, Vec3d origin) {
  SceneTables scene;
  scene.origin = origin;
  scene.color = color;
  scene.film = settings.film;
  scene.sampler = settings.sampler;
  scene.integrator = settings.integrator;
  scene.warnings = in.warnings;
  return scene;
}

/// Compiles a description relative to a point in world space; see moved_to().
std::unique_ptr<Scene> compile_moved(const Description& in, Vec3d origin, const CompileOptions& options,
                                     ErrorSink& errors) {
  CompileReport report;
  const SceneSettings& settings = options.settings != nullptr ? *options.settings : in;
  SceneTables scene = scene_without_rows(in, settings, options.color, origin);
  std::optional<SpectrumSet> set;
  if (options.color == ColorMode::kSpectral) set.emplace();
  SpectrumSet* const spectra = set ? &*set : nullptr;
  SceneNaming naming(scene.names);
  MotionCompiler motion(in, scene.motion);
  CompiledCameras cameras = compile_cameras(in, settings, motion, errors);
  scene.sensor = std::move(cameras.tables);
  // Compute the table of spectra beside everything else
  std::optional<BesideTask> uplift;
  if (spectra != nullptr && !in.textures.empty()) uplift.emplace([] { UpliftTable::get(); });
  // Read meshes and textures by all threads; compile textures, materials, shapes and instances
  MeshReader meshes(in);
  std::vector<PlacedGrid> texture_grids;
  with_memory_for("textures", kSmallerImages, [&] {
    const SecondsTimer timer(report.texture_seconds);
    scene.textures = compile_textures(in.textures, &texture_grids, &errors);
  });
  append(scene.warnings, scene.textures.warnings);
  naming.add_materials(in.materials);
  const CompiledMaterials materials = add_materials(in, spectra, errors, scene);
  set_transmittance(in, scene);
  CompiledGeometry geometry(scene.textures.attribute_names);
  with_memory_for("meshes and instances", kFewerTriangles, [&] {
    const SecondsTimer timer(report.mesh_seconds);
    geometry = compile_geometry(in, meshes, scene.textures, materials, motion, errors);
  });
  errors.throw_errors();
  // Start again with another origin if mesh files lie far from the present one
  if (const Vec3d better = origin_of_mesh_files(in, geometry, origin); better != Vec3d())
    return compile_moved(moved_to(in, better), better, options, errors);
  set_geometry(geometry, naming, scene);
  std::optional<BesideTask> mip_levels;
  with_memory_for(kMipLevels, kSmallerImages,
                  [&] { mip_levels.emplace(add_mip_levels(scene.materials, scene.textures)); });
  scene.info.materials = in.materials.size();
  append(scene.warnings, check_attributes(in, geometry, errors, scene));
  set_bounds(geometry.bounds, cameras.at_open, motion, scene);
  // Compile media and lights, build the acceleration structure beside the mip levels, and trace probe rays
  std::vector<PlacedGrid> grids =
      add_media_and_lights(in, geometry, materials.row_of_phase, spectra, motion, naming, errors, scene);
  errors.throw_errors();
  with_memory_for("acceleration structure", kFewerTriangles, [&] {
    const SecondsTimer timer(report.accel_seconds);
    build_accel(geometry, options, scene);
  });
  with_memory_for(kMipLevels, kSmallerImages, [&] {
    const SecondsTimer timer(report.texture_seconds);
    mip_levels->finish();
  });
  probe_media(in, geometry, cameras.at_open, scene);
  grids.insert(grids.end(), texture_grids.begin(), texture_grids.end());
  complete(report, std::move(grids), scene);
  if (options.report != nullptr) *options.report = std::move(report);
  return std::make_unique<Scene>(std::move(scene));
}

}  // namespace

std::unique_ptr<Scene> compile_scene(const Description& description, const CompileOptions& options) {
  std::vector<std::string> unused;
  ErrorSink strict(false, unused);
  ErrorSink& errors = options.errors != nullptr ? *options.errors : strict;
  const Vec3d origin = render_origin(description);
  std::unique_ptr<Scene> scene;
  errors.run([&] {
    scene = origin == Vec3d() ? compile_moved(description, origin, options, errors)
                              : compile_moved(moved_to(description, origin), origin, options, errors);
  });
  return scene;
}

}  // namespace sheaf
