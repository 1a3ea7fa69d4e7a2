// The options of `sheaf render`: each group declares its variables and adds them to the command line.
#pragma once

#include "core/color/spectrum.h"
#include "core/io/name_table.h"
#include "kernels/denoise/denoise.h"
#include "kernels/film/aovs.h"
#include "kernels/render/caustic_mode.h"
#include "kernels/training/guiding_mode.h"
#include "scene/compile/compile.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/formats/model_formats.h"
#include "scene/tables/render_settings.h"
#include "tools/job/checkpointing.h"
#include "tools/job/image_files.h"
#include "tools/job/read_options.h"
#include "tools/options/option_groups.h"
#include "tools/options/options.h"
#include "tools/options/verbosity_options.h"
#include "tools/preview/preview.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// Values of --color and --filter-mode.
inline constexpr NameTable<ColorMode> kColorModes{{{"rgb", ColorMode::kRgb}, {"spectral", ColorMode::kSpectral}}};
inline constexpr NameTable<FilterMode> kFilterModes{
    {{"weighted", FilterMode::kWeighted}, {"importance", FilterMode::kImportance}}};

/// Values of --guiding.
inline constexpr NameTable<GuidingMode> kGuidingModes{
    {{"on", GuidingMode::kOn}, {"off", GuidingMode::kOff}, {"auto", GuidingMode::kAuto}}};

/// Values of --caustics.
inline constexpr NameTable<CausticMode> kCausticModes{
    {{"none", CausticMode::kSampled}, {"mnee", CausticMode::kManifold}}};

/// Inputs, outputs and image quality.
struct ImageArguments {
  std::string scene;
  std::vector<std::string> outputs;
  std::string output_format = "png";
  OutputArguments output;
  std::string denoiser;
  bool watertight = false;
  std::string bvh = "auto";
  std::optional<std::uint32_t> spp;
  std::optional<float> noise_target;
  std::optional<float> time_limit;
  std::optional<std::uint32_t> seed;
  int threads = 0;
  std::string color;
  int spectral_bins = 0;

  void add_to(Command& command) {
    add_files(command);
    add_sampling(command);
    add_resources_and_color(command);
  }

 private:
  void add_files(Command& command) {
    command.add_option("scene", scene, "Scene file; - reads the standard input").required().file().only_for_run();
    command.begin_group(kOutputOptions);
    command
        .add_option("-o,--output", outputs,
                    fmt::format("Output image: {}; may be repeated. Default: the scene's name with .exr, in the "
                                "current folder. - writes to the standard output",
                                kOutputFormats))
        .file()
        .only_for_run();
    command.add_option("--format", output_format, "Format of the image on the standard output (-o -). Default: png")
        .one_of({"png", "jpg", "tif", "exr"})
        .only_for_run();
    add_output_options(command, output);
    command
        .add_option(
            "--denoise", denoiser,
            "Denoise the final image with nlm (non-local means) or oidn (Open Image Denoise, if installed). auto, or "
            "no "
            "value: oidn if it is installed, else nlm. Writes the layers denoised.R/G/B to .exr, and the denoised "
            "image "
            "to other formats. nlm implies --replicates 4, or 2 below 16 samples per pixel; oidn implies --filter-mode "
            "importance, because it expects uncorrelated pixel noise")
        .one_of({"auto", "nlm", "oidn"})
        .implies("auto");
    command.begin_group(kAdvancedOptions);
    command.add_flag(
        "--watertight", watertight,
        "Watertight intersection: no ray passes between triangles that share an edge. Up to a third slower "
        "in small scenes");
    command
        .add_option("--bvh", bvh,
                    "Memory layout of the acceleration structure: fast, compact (less memory, slower), or auto: "
                    "compact if fast would exceed the available memory and in short renders. Default: auto")
        .one_of(kBvhChoices.names())
        .only_for_run();
  }

  void add_sampling(Command& command) {
    command.begin_group(kSamplingOptions);
    command.add_option("--spp", spp, "Samples per pixel. Default: the scene's").in_range(1u, 1u << 24);
    command
        .add_option(
            "--noise-target", noise_target,
            "Adaptive sampling: sample noisy tiles more, until the relative standard error of the image's pixels "
            "reaches this value (0.01 or 1%), or --spp samples are taken (then 65536 by default). For path "
            "tracing with the samplers sobol and independent")
        .fraction()
        .positive();
    command
        .add_option(
            "--time-limit", time_limit,
            "Stop sampling after this time, but not before every pixel has samples. Combines with --noise-target, "
            "or with --spp as the maximum. Seconds, or with units: 90s, 5m, 1h30m")
        .seconds()
        .positive()
        .only_for_run();
    command.add_option("--seed", seed, "Seed of the random numbers. Default: the scene's")
        .in_range(0u, std::numeric_limits<std::uint32_t>::max());
  }

  void add_resources_and_color(Command& command) {
    command.begin_group(kResourceOptions);
    command.add_option("--threads", threads, "Worker threads. Default: 0, one per logical core")
        .in_range(0, 4096)
        .only_for_run();
    command.begin_group(kImageOptions);
    command
        .add_option(
            "--color", color,
            "Color mode: rgb, or spectral with four wavelengths per path. Default: spectral for pbrt scenes, else rgb")
        .one_of(kColorModes.names());
    command.begin_group(kOutputOptions);
    command
        .add_option("--spectral-bins", spectral_bins,
                    "Also write the spectrum of each pixel to .exr, in this many equal bins from 360 to 830 nm, as the "
                    "layers S0.<wavelength>nm. Needs --color spectral")
        .in_range(1, kMaxSpectralBins);
  }
};

/// The words that --aov accepts.
inline std::vector<std::string> aov_words() {
  std::vector<std::string> words{"all"};
  for (const AovEntry& entry : kAovList) words.emplace_back(entry.name);
  return words;
}

/// AOVs and other layers.
struct LayerArguments {
  std::string aovs;
  bool light_groups = false;
  bool full_floats = false;

  void add_to(Command& command) {
    command.begin_group(kOutputOptions);
    command
        .add_option("--aov", aovs,
                    "Additional .exr layers, separated by commas, or all; see docs/layers.md:\n" + aov_descriptions())
        .placeholder("NAMES")
        .suggest(aov_words(), true);
    command.add_flag(
        "--light-groups", light_groups,
        "Write the contribution of each light to its own layer, light_<id of the light>; see docs/layers.md");
    command.add_flag("--float", full_floats,
                     "Store all layers as 32-bit floats. Default: 16 bits for layers with small values");
  }
};

/// Light transport.
struct TransportArguments {
  std::string integrator;
  std::string sampler;
  std::string filter_mode;
  int replicates = 0;
  std::string light_sampler;
  std::string candidates;
  std::string guiding;
  std::string caustics;
  std::optional<float> clamp_indirect;
  std::string medium_estimator;
  std::optional<float> step_size;
  std::optional<int> max_depth;
  std::optional<int> rr_depth;

  void add_to(Command& command) {
    add_integrator(command);
    add_sampling(command);
    add_transport(command);
  }

 private:
  void add_integrator(Command& command) {
    command.begin_group(kTransportOptions);
    command
        .add_option(
            "--integrator", integrator,
            "Integrator, by any name that scene files may use. Default: the scene's\n" + integrator_descriptions())
        .placeholder("NAME")
        .suggest(suggested_integrators());
  }

  void add_sampling(Command& command) {
    command.begin_group(kSamplingOptions);
    command
        .add_option("--sampler", sampler,
                    "Sampler: sobol (Owen-scrambled), zsobol (blue noise over pixels; rounds --spp up to a power of "
                    "two), independent, stratified or multijitter (round --spp up to a grid). Default: the scene's, "
                    "but sobol for independent")
        .placeholder("NAME")
        .suggest({"sobol", "zsobol", "independent", "stratified", "multijitter"});
    command
        .add_option(
            "--filter-mode", filter_mode,
            "Application of the pixel filter. weighted (default): a sample contributes to every pixel within the "
            "filter radius. importance: filter importance sampling, where a sample contributes to one pixel; "
            "noisier, but uncorrelated between pixels")
        .one_of(kFilterModes.names());
    command
        .add_option(
            "--replicates", replicates,
            "Number of independent sample sets, from which the layers variance.R/G/B are estimated. 4 to 16 give "
            "good estimates, at a slight loss of stratification. Default: 8 with the sampler independent; "
            "otherwise 1 (no variance layers) below 32 samples per pixel, then one per 32 samples, from 2 to 16")
        .in_range(1, 1024);
  }

  void add_transport(Command& command) {
    command.begin_group(kTransportOptions);
    command
        .add_option("--light-sampler", light_sampler,
                    "Light selection: bvh (light BVH, by estimated contribution), power or uniform. Default: the "
                    "scene's, else bvh")
        .placeholder("NAME")
        .suggest(kLightSelectors.names());
    command
        .add_option("--candidates", candidates,
                    "Light samples per vertex, of which resampled importance sampling (RIS) keeps one for the shadow "
                    "ray: a number, or auto: 1, 2, 4 or 8, as the training passes of guiding recommend, and 1 without "
                    "training. Default: the scene's, else auto; 8 for path_ris")
        .placeholder("N")
        .suggest({"auto"});
    command
        .add_option(
            "--guiding", guiding,
            "Path guiding: learn the incident radiance in training passes and sample directions from it. Helps "
            "with light that is hard to find, e.g. through a small opening. auto: only if the training passes show "
            "that it pays. Training covers the whole frame, regardless of --crop. For path, direct and the other path "
            "tracing integrators. Default: auto; without a value: on")
        .one_of(kGuidingModes.names())
        .implies("on");
    command
        .add_option("--caustics", caustics,
                    "Caustics of mirrors and smooth glass. none: by sampling BSDFs and the guide. mnee: by manifold "
                    "next-event estimation, which connects surfaces to lights through up to 4 specular vertices; also "
                    "from lights at a point or in a direction, whose caustics are missing otherwise. For path and the "
                    "other path tracing integrators, without media and masks. Default: none")
        .one_of(kCausticModes.names());
    command
        .add_option("--clamp-indirect", clamp_indirect,
                    "Scale every contribution of indirect light, which has been scattered at least twice, down to this "
                    "radiance (mean of its channels). Removes fireflies, but the image becomes darker: biased. For "
                    "path, photonmapper and the like. Default: no limit")
        .positive()
        .placeholder("RADIANCE");
    command
        .add_option("--medium-estimator", medium_estimator,
                    "Estimator for media: null_mis (spectral MIS over all wavelengths), delta or ratio (tracking by "
                    "one wavelength), or marching (ray marching; biased). Default: the scene's, else null_mis")
        .placeholder("NAME")
        .suggest(kMediumEstimators.names());
    command
        .add_option("--step-size", step_size,
                    "Step size of ray marching, in meters. Default: the scene's, else 1/100 of the medium's diagonal")
        .positive();
    command
        .add_option(
            "--max-depth", max_depth,
            "Maximum path depth in segments: -1 unlimited, 1 emission only, 2 direct light. Default: the scene's")
        .in_range(-1, 1'000'000);
    command
        .add_option("--rr-depth", rr_depth,
                    "Depth at which Russian roulette starts. Default: the scene's, else 2; 5 in scenes with media, and "
                    "for ptracer and photonmapper")
        .in_range(1, 1'000'000);
  }
};

/// The rendered part of the scene, and the run.
struct RunArguments {
  std::vector<int> crop;  ///< empty or x0, y0, x1, y1
  std::string samples;
  std::string size;
  std::optional<float> scale;
  std::string stats;
  int wave_size = 0;
  bool no_timestamps = false;
  VerbosityArguments verbosity;
  std::string frames;
  std::optional<float> fps;  ///< frames per second of glTF files
  bool skip_existing = false;
  ReadArguments read;

  void add_to(Command& command) {
    command.begin_group(kImageOptions);
    command
        .add_option("--crop", crop,
                    "Crop window to render, in pixels: x0,y0,x1,y1 (x1, y1 exclusive). Default: the scene's")
        .list(',', 4)
        .placeholder("x0,y0,x1,y1");
    command.begin_group(kSamplingOptions);
    command
        .add_option("--samples", samples,
                    "Range of samples per pixel to render, FIRST:COUNT (counted from 0), for 'sheaf merge'. The range "
                    "must consist of whole sample sets (--replicates). Default: all")
        .placeholder("FIRST:COUNT");
    command.begin_group(kImageOptions);
    command.add_option("--size", size, "Frame size in pixels, WxH. Default: the scene's").placeholder("WxH");
    command
        .add_option("--scale", scale,
                    "Scale factor for the frame's width and height, e.g. 0.25 or 25% for a quick look. Default: 1")
        .fraction()
        .positive();
    command.begin_group(kSceneOptions);
    command
        .add_option("--fps", fps,
                    "With --frames for a glTF file: frames per second. Frame K shows the time K / fps. Default: 24")
        .positive()
        .only_for_run();
    // given_for() in tools/farm/frames.cpp expects --frames directly before --define
    command
        .add_option("--frames", frames,
                    "Range of frames FIRST:LAST or FIRST:LAST:STEP, inclusive: renders each frame K with -D frame=K, "
                    "or a glTF file at its time (--fps). In the names of outputs, --stats and --checkpoint, the frame "
                    "number replaces #### or $frame4 (4 "
                    "digits) or $frame, or else precedes the file extension. Existing images are overwritten")
        .placeholder("FIRST:LAST:STEP")
        .only_for_run();
    add_read_options(command, read);
    command.begin_group(kOutputOptions);
    command
        .add_flag("--skip-existing", skip_existing,
                  "With --frames: skip frames whose images all exist, except images of interrupted renders")
        .only_for_run();
    command.add_option("--stats", stats, "Write times and counters to this JSON file; - writes to the standard output")
        .file()
        .only_for_run();
    command.begin_group(kAdvancedOptions);
    command
        .add_option(
            "--wave-size", wave_size,
            "Paths in flight per worker; affects speed, not results. Default: 0, derived from the L2 cache size")
        .in_range(0, kMaxWaveSize)
        .only_for_run();
    command.begin_group(kOutputOptions);
    command
        .add_flag("--no-timestamps", no_timestamps,
                  "Omit the date from the files, so that repeated renders are byte-identical")
        .only_for_run();
    add_verbosity_options(command, verbosity, "Also print times, counters per stage, and the effort for less noise");
  }
};

/// The options as given.
struct RenderArguments : ImageArguments, LayerArguments, TransportArguments, RunArguments {
  CheckpointArguments checkpoint;
  PreviewArguments preview;
};

/// Adds the subcommand `render`, or another one with the same options, but without an action. `arguments` must live as
/// long as `program`.
inline Command add_render_options(
    Command& program, RenderArguments& arguments, const std::string& name = "render",
    const std::string& help = fmt::format("Render a scene file (Mitsuba, Nori or pbrt-v4) or a model ({}) to images.",
                                          model_extensions())) {
  Command command = program.add_command(name, help);
  for (const char* const title : {kSceneOptions, kImageOptions, kSamplingOptions, kTransportOptions, kOutputOptions,
                                  kPreviewOptions, kResourceOptions, kAdvancedOptions})
    command.begin_group(title);
  arguments.ImageArguments::add_to(command);
  arguments.LayerArguments::add_to(command);
  arguments.TransportArguments::add_to(command);
  arguments.RunArguments::add_to(command);
  command.begin_group(kResourceOptions);
  add_checkpoint_options(command, arguments.checkpoint);
  command.begin_group(kPreviewOptions);
  add_preview_options(command, arguments.preview);
  return command;
}

}  // namespace sheaf
