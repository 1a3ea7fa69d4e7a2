#include "tools/render_arguments.h"

#include "kernels/denoise/denoise.h"
#include "kernels/film/aovs.h"
#include "scene/dialects/common/integrator_name.h"
#include "scene/dialects/common/light_selector_name.h"
#include "scene/dialects/common/medium_estimator_name.h"
#include "scene/dialects/common/sampler_name.h"

#include <limits>

namespace sheaf {

namespace {

/// Adds options for inputs, outputs and image quality.
void add_image_options(Command& command, RenderArguments& arguments) {
  command.add_option("scene", arguments.scene, "Scene file").required();
  command.add_option("-o,--output", arguments.outputs,
                     "Output image: .exr (linear floats, all layers) or .png (8 bits, sRGB); may be repeated. Default: "
                     "the scene's name with .exr, in the current folder");
  command
      .add_option(
          "--denoise", arguments.denoiser,
          "Denoise the final image with nlm (non-local means) or oidn (Open Image Denoise, if installed). Writes the "
          "layers denoised.R/G/B to .exr, and the denoised image to .png. nlm implies --replicates 4, or 2 below 16 "
          "samples per pixel; oidn implies --filter-mode importance, because it expects uncorrelated pixel noise")
      .one_of(kDenoisers.names());
  command.add_flag("--watertight", arguments.watertight,
                   "Watertight intersection: no ray passes between triangles that share an edge. Up to a third slower "
                   "in small scenes");
  command.add_option("--spp", arguments.spp, "Samples per pixel. Default: the scene's").in_range(1u, 1u << 24);
  command
      .add_option("--noise-target", arguments.noise_target,
                  "Adaptive sampling: sample each tile until the relative standard error of its pixels reaches this "
                  "value (0.01 or 1%), or --spp samples are taken (then 65536 by default). For path tracing with the "
                  "samplers sobol and independent")
      .share()
      .positive();
  command
      .add_option(
          "--time-limit", arguments.time_limit,
          "Stop sampling after this time, but not before every pixel has samples. Combines with --noise-target, "
          "or with --spp as the maximum. Seconds, or with units: 90s, 5m, 1h30m")
      .seconds()
      .positive();
  command.add_option("--seed", arguments.seed, "Seed of the random numbers. Default: the scene's")
      .in_range(0u, std::numeric_limits<std::uint32_t>::max());
  command.add_option("--threads", arguments.threads, "Worker threads. Default: 0, one per logical core")
      .in_range(0, 4096);
  command
      .add_option(
          "--color", arguments.color,
          "Colour mode: rgb, or spectral with four wavelengths per path. Default: spectral for pbrt scenes, else rgb")
      .one_of(kColorModes.names());
  command
      .add_option("--spectral-bins", arguments.spectral_bins,
                  "Also write the spectrum of each pixel to .exr, in this many equal bins from 360 to 830 nm, as the "
                  "layers S0.<wavelength>nm. Needs --color spectral")
      .in_range(1, kMaxSpectralBins);
}

/// Adds options for AOVs and other layers.
void add_layer_options(Command& command, RenderArguments& arguments) {
  std::string names;
  for (const AovEntry& entry : kAovList) names += std::string(entry.name) + ", ";
  command.add_option("--aov", arguments.aovs,
                     "Additional .exr layers, separated by commas: " + names + "or all; see docs/layers.md");
  command.add_flag(
      "--light-groups", arguments.light_groups,
      "Write the contribution of each light to its own layer, light_<id of the light>; see docs/layers.md");
  command.add_flag("--float", arguments.full_floats,
                   "Store all layers as 32-bit floats. Default: 16 bits for layers with small values");
}

/// Adds options for light transport.
void add_transport_options(Command& command, RenderArguments& arguments) {
  command.add_option("--integrator", arguments.integrator,
                     "Integrator, named as in scene files, e.g. path, direct, path_mats, path_ems, path_ris, whitted, "
                     "ptracer, photonmapper, sppm, ao, av, normals, depth. Default: the scene's");
  command.add_option("--sampler", arguments.sampler,
                     "Sampler: sobol (Owen-scrambled), zsobol (blue noise over pixels; rounds --spp up to a power of "
                     "two), independent, stratified or multijitter (round --spp up to a grid). Default: the scene's, "
                     "but sobol for independent");
  command
      .add_option("--filter-mode", arguments.filter_mode,
                  "Application of the pixel filter. weighted (default): a sample contributes to every pixel within the "
                  "filter radius. importance: filter importance sampling, where a sample contributes to one pixel; "
                  "noisier, but uncorrelated between pixels")
      .one_of(kFilterModes.names());
  command
      .add_option("--replicates", arguments.replicates,
                  "Number of independent sample sets, from which the layers variance.R/G/B are estimated. 4 to 16 give "
                  "good estimates, at a slight loss of stratification. Default: 8 with the sampler independent; "
                  "otherwise 1 (no variance layers) below 32 samples per pixel, 2 below 128, 4 below 512, else 8")
      .in_range(1, 1024);
  command.add_option(
      "--light-sampler", arguments.light_sampler,
      "Light selection: bvh (light BVH, by estimated contribution), power or uniform. Default: the scene's, else bvh");
  command
      .add_option("--candidates", arguments.candidates,
                  "Light samples per vertex, of which resampled importance sampling (RIS) keeps one for the shadow "
                  "ray. Default: the scene's, else 1; 8 for path_ris")
      .in_range(1, kMaxCandidates);
  command.add_flag("--guiding", arguments.guiding,
                   "Path guiding: learn the incident radiance in training passes and sample directions from it. Helps "
                   "with light that is hard to find, e.g. through a small opening. Training covers the whole frame, "
                   "regardless of --crop. For path, direct and the other path tracing integrators");
  command.add_option("--medium-estimator", arguments.medium_estimator,
                     "Estimator for media: null_mis (spectral MIS over all wavelengths), delta or ratio (tracking by "
                     "one wavelength), or marching (ray marching; biased). Default: the scene's, else null_mis");
  command
      .add_option("--step-size", arguments.step_size,
                  "Step size of ray marching, in metres. Default: the scene's, else 1/100 of the medium's diagonal")
      .positive();
  command
      .add_option("--max-depth", arguments.max_depth,
                  "Maximum path depth in segments: -1 unlimited, 1 emission only, 2 direct light. Default: the scene's")
      .in_range(-1, 1'000'000);
  command
      .add_option("--rr-depth", arguments.rr_depth,
                  "Depth at which Russian roulette starts. Default: the scene's, else 2; 5 in scenes with media, and "
                  "for ptracer and photonmapper")
      .in_range(1, 1'000'000);
}

/// Adds options for the rendered part of the scene, and for the run.
void add_run_options(Command& command, RenderArguments& arguments) {
  command
      .add_option("--crop", arguments.crop,
                  "Crop window to render, in pixels: x0,y0,x1,y1 (x1, y1 exclusive). Default: the scene's")
      .list(',', 4);
  command.add_option("--samples", arguments.samples,
                     "Range of samples per pixel to render, FIRST:COUNT (counted from 0), for 'sheaf merge'. The range "
                     "must consist of whole sample sets (--replicates). Default: all");
  command.add_option("--size", arguments.size, "Frame size in pixels, WxH. Default: the scene's");
  command
      .add_option("--scale", arguments.scale,
                  "Scale factor for the frame's width and height, e.g. 0.25 or 25% for a quick look. Default: 1")
      .share()
      .positive();
  add_read_options(command, arguments.read);
  command.add_option("--stats", arguments.stats, "Write times and counters to this JSON file");
  command
      .add_option("--wave-size", arguments.wave_size,
                  "Paths in flight per worker; affects speed, not results. Default: 0, derived from the L2 cache size")
      .in_range(0, kMaxWaveSize);
  command.add_flag("--no-timestamps", arguments.no_timestamps,
                   "Omit the date from the files, so that repeated renders are byte-identical");
  command.add_flag("--quiet", arguments.quiet, "Print only errors");
}

}  // namespace

Command add_render_options(Command& program, RenderArguments& arguments) {
  Command command = program.add_command(
      "render", "Render a scene file (Mitsuba, Nori or pbrt-v4) or a model (.obj, .ply, .serialized) to images.");
  add_image_options(command, arguments);
  add_layer_options(command, arguments);
  add_transport_options(command, arguments);
  add_run_options(command, arguments);
  add_checkpoint_options(command, arguments.checkpoint);
  add_preview_options(command, arguments.preview);
  return command;
}

}  // namespace sheaf
