// The options of `sheaf render`: each group declares its variables and adds them to the command line.
#pragma once

#include "core/name_table.h"
#include "core/spectrum.h"
#include "kernels/film/aovs.h"
#include "scene/tables/render_settings.h"
#include "tools/checkpointing.h"
#include "tools/options.h"
#include "tools/preview.h"
#include "tools/read_options.h"

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

/// Inputs, outputs and image quality.
struct ImageArguments {
  std::string scene;
  std::vector<std::string> outputs;
  std::string denoiser;
  bool watertight = false;
  std::optional<std::uint32_t> spp;
  std::optional<float> noise_target;
  std::optional<float> time_limit;
  std::optional<std::uint32_t> seed;
  int threads = 0;
  std::string color;
  int spectral_bins = 0;

  void add_to(Command& command) {
    command.add_option("scene", scene, "Scene file").required().only_for_run();
    command
        .add_option("-o,--output", outputs,
                    "Picture to write, .exr (linear floats, all layers) or .png (8 bits, sRGB); may be repeated. "
                    "Default: the scene's name with .exr, in the current folder")
        .only_for_run();
    command
        .add_option(
            "--denoise", denoiser,
            "Take the noise out of the finished picture, into the layers denoised.R/G/B of .exr and into .png: nlm "
            "(non-local means) or oidn (Open Image Denoise, if it is installed). nlm makes --replicates 4 the default, "
            "2 "
            "below 16 samples per pixel; oidn --filter-mode importance, as it takes what neighbours share for detail")
        .one_of({"nlm", "oidn"});
    command.add_flag("--watertight", watertight,
                     "Let no ray slip between triangles that share an edge; slower by up to a third in small scenes");
    command.add_option("--spp", spp, "Samples per pixel. Default: the scene's").in_range(1u, 1u << 24);
    command
        .add_option("--noise-target", noise_target,
                    "Take samples, tile by tile, until the standard error of a tile's pixels is this share of their "
                    "values (0.01 or 1%), or there are --spp of them (then 65536 by default). For paths from "
                    "the camera, with the samplers sobol and independent")
        .share()
        .positive();
    command
        .add_option(
            "--time-limit", time_limit,
            "Begin no more samples after this time of rendering, once there is a picture: with --noise-target or "
            "up to --spp. Seconds, or with units: 90s, 5m, 1h30m")
        .seconds()
        .positive()
        .only_for_run();
    command.add_option("--seed", seed, "Seed of the random numbers. Default: the scene's")
        .in_range(0u, std::numeric_limits<std::uint32_t>::max());
    command.add_option("--threads", threads, "Worker threads. Default: 0, one for each logical core")
        .in_range(0, 4096)
        .only_for_run();
    command
        .add_option(
            "--color", color,
            "Colour mode: rgb, or spectral: four wavelengths per path. Default: rgb, for scenes of pbrt spectral")
        .one_of(kColorModes.names());
    command
        .add_option("--spectral-bins", spectral_bins,
                    "Also write the spectrum of each pixel to .exr, in this many equal bins from 360 to 830 nm: "
                    "layers S0.<wavelength>nm. Needs --color spectral")
        .in_range(1, kMaxSpectralBins);
  }
};

/// AOVs and other layers.
struct LayerArguments {
  std::string aovs;
  bool light_groups = false;
  bool full_floats = false;

  void add_to(Command& command) {
    std::string names;
    for (const AovEntry& entry : kAovList) names += std::string(entry.name) + ", ";
    command.add_option("--aov", aovs,
                       "Further layers of .exr files, with commas between: " + names + "or all; see docs/layers.md");
    command.add_flag(
        "--light-groups", light_groups,
        "Write the light of each of the scene's lights to a layer of its own, light_<id of the light>; see "
        "docs/layers.md");
    command.add_flag("--float", full_floats,
                     "Store all layers with 32 bits, also those whose values are small enough for 16");
  }
};

/// Light transport.
struct TransportArguments {
  std::string integrator;
  std::string sampler;
  std::string filter_mode;
  int replicates = 0;
  std::string light_sampler;
  std::optional<int> candidates;
  bool guiding = false;
  std::string medium_estimator;
  std::optional<float> step_size;
  std::optional<int> max_depth;
  std::optional<int> rr_depth;

  void add_to(Command& command) {
    command.add_option("--integrator", integrator,
                       "What to compute, by the names that scene files use, e.g. path, direct, path_mats, path_ems, "
                       "path_ris, whitted, ptracer, photonmapper, sppm, ao, av, normals, depth. Default: the scene's");
    command.add_option(
        "--sampler", sampler,
        "How samples are spread: sobol (Owen-scrambled), zsobol (over pixels too; rounds --spp up to a "
        "power of two), independent, stratified, multijitter (these two round it up to a grid). Default: "
        "the scene's, but sobol for independent");
    command
        .add_option("--filter-mode", filter_mode,
                    "How samples come under the reconstruction filter: weighted (default): each counts in every pixel "
                    "that the filter reaches; importance: each is placed by the filter and counts in one pixel, which "
                    "leaves more noise, but noise that differs from pixel to pixel")
        .one_of(kFilterModes.names());
    command
        .add_option(
            "--replicates", replicates,
            "Cut the samples into this many sets that are independent of each other, from whose spread the "
            "layers variance.R/G/B are made: 4 to 16 tell it well, and cost some of the evenness of the samples. "
            "Default: 8 with the sampler independent; else 1 (no such layers) below 32 samples per pixel, 2 below "
            "128, 4 below 512, then 8")
        .in_range(1, 1024);
    command.add_option("--light-sampler", light_sampler,
                       "How the light that a surface looks to is chosen: bvh (by what it may bring there), power, "
                       "uniform. Default: the scene's, else bvh");
    command
        .add_option("--candidates", candidates,
                    "Lights sampled per vertex, of which resampling keeps one for a shadow ray. Default: the "
                    "scene's, else 1; 8 for path_ris")
        .in_range(1, kMaxCandidates);
    command.add_flag(
        "--guiding", guiding,
        "Learn where light comes from in passes before the picture, and send paths there. Helps where light "
        "is hard to find, as through a gap; the whole frame is learned, whatever --crop. For path, direct and "
        "the other integrators of paths from the camera");
    command.add_option(
        "--medium-estimator", medium_estimator,
        "How light in media is tracked: null_mis (by all wavelengths), delta, ratio (by one wavelength), "
        "marching (equal steps; biased). Default: the scene's, else null_mis");
    command
        .add_option("--step-size", step_size,
                    "Metres per step of marching. Default: the scene's, else a hundredth of the medium's diagonal")
        .positive();
    command
        .add_option("--max-depth", max_depth,
                    "Longest path in segments: -1 unlimited, 1 emission only, 2 direct light. Default: the scene's")
        .in_range(-1, 1'000'000);
    command
        .add_option(
            "--rr-depth", rr_depth,
            "Depth from which on Russian roulette ends paths that carry little. Default: the scene's, else 2; 5 "
            "in scenes with media, and for ptracer and photonmapper")
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
  bool quiet = false;
  ReadArguments read;

  void add_to(Command& command) {
    command
        .add_option("--crop", crop,
                    "Part of the frame to render, in pixels: x0,y0,x1,y1 (x1, y1 exclusive). Default: the scene's")
        .list(',', 4);
    command.add_option(
        "--samples", samples,
        "Of the samples per pixel those to render, FIRST:COUNT (counted from 0), for 'sheaf merge' to join "
        "with the others. They begin and end where sets of samples do (--replicates). Default: all");
    command.add_option("--size", size, "Size of the frame in pixels, WxH. Default: the scene's");
    command
        .add_option("--scale", scale,
                    "Factor on the frame's width and height, e.g. 0.25 or 25% for a first look. Default: 1")
        .share()
        .positive();
    add_read_options(command, read);
    command.add_option("--stats", stats, "Write times and counters to this file, as JSON").only_for_run();
    command
        .add_option("--wave-size", wave_size,
                    "Paths in flight per worker; changes speed, not results. Default: 0, from the L2 cache's size")
        .in_range(0, kMaxWaveSize)
        .only_for_run();
    command.add_flag("--no-timestamps", no_timestamps, "Leave the date out of the files: same bytes each time")
        .only_for_run();
    command.add_flag("--quiet", quiet, "Print nothing but errors").only_for_run();
  }
};

/// The options as given.
struct RenderArguments : ImageArguments, LayerArguments, TransportArguments, RunArguments {
  CheckpointArguments checkpoint;
  PreviewArguments preview;
};

/// Adds the subcommand with all of its options, but without an action. `arguments` must live as long as `program`.
inline Command add_render_options(Command& program, RenderArguments& arguments) {
  Command command = program.add_command(
      "render", "Render a scene file (of Mitsuba, Nori or pbrt-v4) or a model (.obj, .ply, .serialized) to pictures.");
  arguments.ImageArguments::add_to(command);
  arguments.LayerArguments::add_to(command);
  arguments.TransportArguments::add_to(command);
  arguments.RunArguments::add_to(command);
  add_checkpoint_options(command, arguments.checkpoint);
  add_preview_options(command, arguments.preview);
  return command;
}

}  // namespace sheaf
