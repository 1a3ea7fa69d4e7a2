#include "tools/job/render_job.h"

#include "core/io/error.h"
#include "core/io/memory.h"
#include "core/io/version.h"
#include "core/simd/saturate.h"
#include "core/soa/large_pages.h"
#include "kernels/denoise/denoise.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/render/render_memory.h"
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/common/setting_names.h"
#include "tools/job/interrupted_image.h"
#include "tools/options/process_command_line.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// World to OpenEXR's camera space, which looks along -z with x to the right. Sheaf's looks along +z with x to the
/// left.
std::optional<Matrix4> world_to_camera(const CameraDescription& camera) {
  Matrix4 half_turn;
  half_turn.m[0][0] = half_turn.m[2][2] = -1;
  return half_turn * camera.to_world.inverse_matrix();
}

/// How the BVH was built, and why.
std::string describe_build(const SceneInfo& info, double rays) {
  if (info.bvh_splits == BvhSplits::kNotNeeded && !info.bvh_along_curve) return "spatial splits not needed";
  const double rays_per_triangle = rays / std::max(static_cast<double>(info.triangles), 1.0);
  const std::string reason =
      rays < kInfinity ? fmt::format(", at most {:.2g} rays per triangle", rays_per_triangle) : "";
  if (info.bvh_along_curve) return "along a Morton curve" + reason;
  return (info.bvh_splits == BvhSplits::kBuilt ? "with spatial splits" : "without spatial splits") + reason;
}

/// Samples per pixel taken so far, rounded.
int taken_samples(const RenderReport& report) {
  return report.interrupted ? saturate<int>(std::round(report.mean_samples)) : saturate<int>(report.spp);
}

}  // namespace

double expected_rays(const RenderSettings& settings) {
  constexpr std::uint32_t kFewSamples = 32;
  const bool may_be_long = settings.spp >= kFewSamples || settings.replicates > 1 || settings.adapts ||
                           settings.integrator.kind != IntegratorKind::kPath;
  if (may_be_long) return kInfinity;
  // Paths of no more than 4 vertices on average, each with a shadow ray and a scattered ray; few paths train the guide
  constexpr int kVertices = 4;
  const int depth = settings.integrator.max_depth;
  const int vertices = depth < 0 ? kVertices : std::min(depth, kVertices);
  return (1.0 + 2.0 * vertices) * settings.spp * settings.film.width * settings.film.height;
}

void prepare(const RenderArguments& arguments, LoadedScene& loaded) {
  if (!arguments.integrator.empty())
    apply_integrator_name(arguments.integrator, arguments.read.lenient, loaded.description);
  loaded.remarks = {loaded.description.notes, {}};
  loaded.settings = resolve_settings(arguments, loaded.description, loaded.remarks);
}

RenderControl control_of(const RenderArguments& arguments) { return {arguments.threads, arguments.wave_size}; }

void compile(const RenderArguments& arguments, LoadedScene& loaded, KeptGeometry* kept) {
  loaded.compiled = {};
  CompileOptions options{arguments.watertight, loaded.settings.color, &loaded.settings, &loaded.compiled};
  options.bvh = kBvhChoices.option("bvh", arguments.bvh);
  options.expected_rays = expected_rays(loaded.settings);
  options.render_bytes = [&](const Scene& scene) {
    double bytes = 0;
    for (const MemoryUse& use : render_memory(scene, loaded.settings, control_of(arguments))) bytes += use.bytes;
    return bytes;
  };
  options.kept = kept;
  ErrorSink errors(arguments.read.lenient, loaded.description.substitutions);
  options.errors = &errors;
  loaded.scene = compile_scene(loaded.description, options);
  // Moving takes some 1.2 ns per byte, and saves up to 60 ns per ray
  constexpr double kBytesPerRay = 50;
  const SceneInfo info = loaded.scene->info();
  if (kBytesPerRay * options.expected_rays > static_cast<double>(info.table_bytes + info.accel_bytes))
    move_to_large_pages();
}

std::vector<std::string> scene_warnings(const LoadedScene& loaded) {
  const Scene& scene = *loaded.scene;
  std::vector<std::string> warnings = loaded.description.substitutions;
  warnings.insert(warnings.end(), scene.warnings().begin(), scene.warnings().end());
  if (scene.view().lights.count == 0 && !scene.names().has_other_light && scene.integrator().traits().uses_lights())
    warnings.emplace_back("the scene has no lights: the image will be black");
  return warnings;
}

void add_loading(RenderReport& report, const LoadedScene& loaded, double load_seconds, double build_seconds) {
  report.load_seconds = load_seconds;
  report.build_seconds = build_seconds;
  const CompileReport& compiled = loaded.compiled;
  report.loading = {report.load_seconds + compiled.mesh_seconds, compiled.texture_seconds,
                    report.build_seconds - compiled.mesh_seconds - compiled.texture_seconds - compiled.accel_seconds,
                    compiled.accel_seconds};
  const std::vector<MemoryUse> scene = loaded.scene->memory();
  report.memory.insert(report.memory.begin(), scene.begin(), scene.end());
  const SceneInfo info = loaded.scene->info();
  report.triangles = info.triangles;
  report.bvh = info.bvh == BvhLayout::kCompact ? "compact" : "fast";
  report.bvh_build = describe_build(info, expected_rays(loaded.settings));
}

ExrMetadata make_metadata(const RenderArguments& arguments, const LoadedScene& loaded, const RenderReport& report,
                          const Image& image) {
  const RenderSettings& settings = loaded.settings;
  const SceneNames& names = loaded.scene->names();
  ExrMetadata metadata;
  // Set the standard attributes
  metadata.software = fmt::format("Sheaf {}", kSheafVersion);
  metadata.world_to_camera = world_to_camera(loaded.description.camera);
  metadata.attributes = {{kVersionAttribute, std::string(kSheafVersion)},
                         {"sheaf/isa", report.isa},
                         {"sheaf/integrator", report.integrator},
                         {"sheaf/color", report.color},
                         {"sheaf/sampler", std::string(kSamplers.name_of(settings.sampler.kind))},
                         {"sheaf/scene", fs::path(arguments.scene).filename().string()},
                         integer_attribute("sheaf/seed", report.seed),
                         {"sheaf/samplesPerPixel", taken_samples(report)},
                         integer_attribute("sheaf/droppedRays", report.stats.dropped.rays),
                         integer_attribute("sheaf/droppedSamples", report.stats.dropped.samples)};
  if (report.noise) metadata.attributes.push_back({kNoiseAttribute, static_cast<float>(*report.noise)});
  // Add attributes that depend on the options
  if (report.interrupted) add_interrupted_attributes(metadata, report.mean_samples, report.spp);
  if (arguments.noise_target) metadata.attributes.push_back({"sheaf/noiseTarget", *arguments.noise_target});
  if (settings.spectral_bins > 0) {
    metadata.attributes.push_back({"spectralLayoutVersion", std::string("1.0")});
    metadata.attributes.push_back({"emissiveUnits", std::string("W.m^-2.sr^-1")});
  }
  for (auto& [name, value] : cryptomatte_attributes(settings.aovs, names)) metadata.attributes.push_back({name, value});
  if (settings.is_part)
    for (auto& [name, value] : part_id_attributes(settings.aovs, names)) metadata.attributes.push_back({name, value});
  if (!arguments.full_floats) metadata.half_channels = half_channels(image.channels);
  if (!arguments.no_timestamps) {
    metadata.capture_date = fmt::format("{:%Y:%m:%d %H:%M:%S}", fmt::localtime(std::time(nullptr)));
    metadata.attributes.push_back({kCommandLineAttribute, command_line()});
    metadata.attributes.push_back({kRenderSecondsAttribute, static_cast<float>(report.render_seconds)});
  }
  return metadata;
}

void add_denoised(const RenderArguments& arguments, Image& image, ExrMetadata& metadata) {
  if (arguments.denoiser.empty()) return;
  DenoiseResult result = denoise(image, kDenoisers.option("denoiser", arguments.denoiser), arguments.threads);
  add_denoise_attribute(metadata, result);
  image = std::move(result.image);
}

}  // namespace sheaf
