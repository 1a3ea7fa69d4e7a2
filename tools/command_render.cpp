// sheaf render: reads a scene, renders it with a progress bar and writes all outputs.
#include "core/error.h"
#include "core/exr.h"
#include "core/large_pages.h"
#include "core/output_file.h"
#include "core/progress.h"
#include "core/saturate.h"
#include "kernels/denoise/denoise.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/passes/render.h"
#include "scene/compile/compile.h"
#include "scene/dialects/common/integrator_name.h"
#include "scene/dialects/common/light_selector_name.h"
#include "scene/dialects/common/medium_estimator_name.h"
#include "scene/dialects/common/sampler_name.h"
#include "scene/dialects/native_color.h"
#include "scene/dialects/read_scene.h"
#include "scene/xml/xml.h"
#include "tools/commands.h"
#include "tools/interrupt.h"
#include "tools/interrupted_image.h"
#include "tools/parts.h"
#include "tools/picture_files.h"
#include "tools/preview.h"
#include "tools/render_arguments.h"
#include "tools/render_plan.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <memory>
#include <tuple>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// Maximum pixels along a side of the frame, as in scene files.
constexpr int kMaxFrameSide = 1'000'000'000;

/// With a denoiser, renders with at least this many samples per pixel use four sets of samples, others two.
constexpr std::uint32_t kDenoisedSamples = 16;

/// Returns all files that the render writes, the images first. Checks that the formats are known, the names are
/// distinct and the locations are writable. Throws Error.
std::vector<NamedFile> check_outputs(const RenderArguments& arguments) {
  std::vector<std::string> pictures = arguments.outputs;
  if (pictures.empty()) pictures.push_back(fs::path(arguments.scene).stem().string() + ".exr");
  std::vector<NamedFile> outputs = named_pictures(pictures);
  if (!arguments.stats.empty()) outputs.push_back({"--stats", arguments.stats});
  if (!arguments.checkpoint.file.empty()) outputs.push_back({"--checkpoint", arguments.checkpoint.file});
  const NamedFile scene{"the scene", arguments.scene};
  check_overwriting(outputs, {&scene, 1});
  check_checkpoint(arguments.checkpoint);
  check_all_writable(outputs);
  return outputs;
}

/// Throws Error (exit code 2) if an output would overwrite a file of the scene.
void check_sources(const std::vector<NamedFile>& outputs, const std::vector<fs::path>& files) {
  std::vector<NamedFile> sources;
  for (const fs::path& file : files) sources.push_back({"what the scene is made of,", file});
  check_overwriting(outputs, sources);
}

void apply_integrator(const RenderArguments& arguments, Description& scene) {
  if (!arguments.integrator.empty()) apply_integrator_name(arguments.integrator, scene);
  IntegratorSettings& integrator = scene.integrator;
  if (arguments.spp) integrator.photons.max_passes = 0;
  if (arguments.max_depth) integrator.max_depth = *arguments.max_depth;
  if (arguments.rr_depth) integrator.rr_depth = *arguments.rr_depth;
  if (arguments.candidates) integrator.candidates = *arguments.candidates;
  if (!arguments.light_sampler.empty())
    integrator.light_selector = kLightSelectors.option("light sampler", arguments.light_sampler);
  if (!arguments.medium_estimator.empty())
    integrator.medium_estimator = kMediumEstimators.option("medium estimator", arguments.medium_estimator);
  if (arguments.step_size) integrator.step_size = *arguments.step_size;
}

/// Default maximum samples per pixel if a noise target or a time limit decides.
constexpr std::uint32_t kAdaptiveSamples = 1 << 16;

bool is_adaptive(const RenderArguments& arguments) { return arguments.noise_target || arguments.time_limit; }

/// Sets the sampler and the samples per pixel. Adds a note if they differ from the scene's.
void apply_sampler(const RenderArguments& arguments, Description& scene) {
  SamplerSettings& sampler = scene.sampler;
  const auto note = [&](std::string text) {
    if (!text.empty()) scene.notes.push_back(std::move(text));
  };
  if (arguments.sampler.empty()) {
    note(rendered_sampler_note(sampler.kind));
    sampler.kind = rendered_sampler(sampler.kind);
  } else {
    sampler.kind = kSamplers.option("sampler", arguments.sampler);
    note(stand_in_sampler_note(arguments.sampler));
  }
  const std::uint32_t wanted = arguments.spp.value_or(is_adaptive(arguments) ? kAdaptiveSamples : sampler.sample_count);
  sampler.sample_count = rounded_sample_count(sampler.kind, wanted);
  note(rounding_note(sampler.kind, wanted));
}

/// Sets the size of the frame. The scene's crop window keeps its relative position. Throws Error (exit code 2) if the
/// frame is too large.
void apply_size(const RenderArguments& arguments, FilmSettings& film) {
  if (arguments.size.empty() && !arguments.scale) return;
  const FilmSettings before = film;
  if (!arguments.size.empty()) std::tie(film.width, film.height) = parse_size(arguments.size);
  const double scale = arguments.scale.value_or(1.0);
  if (std::max(film.width, film.height) * scale > kMaxFrameSide)
    throw Error(ExitCode::kUsage,
                fmt::format("--scale {:g} makes a frame of {:g} x {:g} pixels, expected at most {} along each side",
                            scale, film.width * scale, film.height * scale, kMaxFrameSide));
  const auto scaled = [](int pixels, double factor) { return saturate<int>(std::round(pixels * factor)); };
  film.width = std::max(scaled(film.width, scale), 1);
  film.height = std::max(scaled(film.height, scale), 1);
  if (!film.crop) return;
  const double x = static_cast<double>(film.width) / before.width, y = static_cast<double>(film.height) / before.height;
  PixelRect crop{scaled(film.crop->x0, x), scaled(film.crop->y0, y), scaled(film.crop->x1, x),
                 scaled(film.crop->y1, y)};
  crop.x0 = std::min(crop.x0, film.width - 1);
  crop.y0 = std::min(crop.y0, film.height - 1);
  crop.x1 = std::max(crop.x1, crop.x0 + 1);
  crop.y1 = std::max(crop.y1, crop.y0 + 1);
  film.crop = crop;
}

/// The rectangle to render. Throws Error (exit code 2) if the given one does not lie inside the frame.
PixelRect choose_crop(const RenderArguments& arguments, const FilmSettings& film) {
  if (arguments.crop.empty()) return film.crop.value_or(PixelRect{0, 0, film.width, film.height});
  const PixelRect crop{arguments.crop[0], arguments.crop[1], arguments.crop[2], arguments.crop[3]};
  if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > film.width || crop.y1 > film.height || crop.x0 >= crop.x1 ||
      crop.y0 >= crop.y1) {
    throw Error(ExitCode::kUsage,
                fmt::format("--crop {},{},{},{} is empty or reaches beyond the frame of {} x {} pixels", crop.x0,
                            crop.y0, crop.x1, crop.y1, film.width, film.height));
  }
  return crop;
}

/// Number of sets of samples: as requested. By default several if non-local means need variances and the sampler's
/// samples are not independent. Throws Error (exit code 2) if there would be a single set.
int choose_replicates(const RenderArguments& arguments, const SamplerSettings& sampler) {
  if (arguments.denoiser != "nlm") return arguments.replicates;
  if (sampler.sample_count < 2 || arguments.replicates == 1)
    throw Error(ExitCode::kUsage, "--denoise nlm needs at least two samples per pixel, and --replicates above 1");
  if (arguments.replicates != 0 || sampler.kind == SamplerKind::kIndependent) return arguments.replicates;
  return sampler.sample_count < kDenoisedSamples ? 2 : 4;
}

/// The requested AOVs plus those that the denoiser uses.
AovSet wanted_aovs(const RenderArguments& arguments) {
  AovSet aovs = aovs_from_names(arguments.aovs);
  if (arguments.denoiser.empty()) return aovs;
  for (const Aov aov : {Aov::kAlbedo, Aov::kNormal, Aov::kDepth}) aovs.insert(aov);
  if (arguments.denoiser == "nlm")
    for (const Aov aov : {Aov::kVariance, Aov::kHalf}) aovs.insert(aov);
  return aovs;
}

/// Throws Error (exit code 2) if layers are requested but no output can store them.
void check_layers(const RenderArguments& arguments, const std::vector<fs::path>& outputs) {
  const auto is_exr = [](const fs::path& file) { return extension_of(file) == ".exr"; };
  if (std::any_of(outputs.begin(), outputs.end(), is_exr)) return;
  const char* const option = !arguments.aovs.empty()        ? "--aov"
                             : arguments.light_groups       ? "--light-groups"
                             : arguments.spectral_bins != 0 ? "--spectral-bins"
                                                            : nullptr;
  if (option != nullptr)
    throw Error(ExitCode::kUsage, std::string(option) + " asks for layers, which .exr files alone hold: add -o " +
                                      fs::path(outputs.front()).replace_extension(".exr").string());
}

/// World to OpenEXR's camera space, which looks along -z with x to the right. Sheaf's looks along +z with x to the
/// left.
std::optional<Matrix4> world_to_camera(const CameraDescription& camera) {
  Matrix4 half_turn;
  half_turn.m[0][0] = half_turn.m[2][2] = -1;
  return half_turn * camera.to_world.inverse_matrix();
}

/// Samples per pixel taken so far, rounded.
int taken_samples(const RenderReport& report) {
  return report.interrupted ? saturate<int>(std::round(report.mean_samples)) : saturate<int>(report.spp);
}

ExrMetadata make_metadata(const RenderArguments& arguments, const RenderReport& report, const Description& scene,
                          const SceneNames& names, const Image& image) {
  ExrMetadata metadata;
  metadata.software = "Sheaf " SHEAF_VERSION;
  metadata.world_to_camera = world_to_camera(scene.camera);
  metadata.attributes = {{"sheaf/version", std::string(SHEAF_VERSION)},
                         {"sheaf/isa", report.isa},
                         {"sheaf/integrator", report.integrator},
                         {"sheaf/color", report.color},
                         {"sheaf/sampler", std::string(kSamplers.name_of(scene.sampler.kind))},
                         {"sheaf/seed", std::to_string(report.seed)},
                         {"sheaf/samplesPerPixel", taken_samples(report)},
                         {"sheaf/noise", report.noise ? fmt::format("{:.6g}", *report.noise) : std::string("unknown")},
                         {"sheaf/droppedRays", std::to_string(report.stats.dropped.rays)},
                         {"sheaf/droppedSamples", std::to_string(report.stats.dropped.samples)}};
  if (report.interrupted) add_interrupted_attributes(metadata, report.mean_samples, report.spp);
  if (arguments.noise_target)
    metadata.attributes.push_back({"sheaf/noiseTarget", fmt::format("{:.6g}", *arguments.noise_target)});
  if (arguments.spectral_bins > 0) {
    metadata.attributes.push_back({"spectralLayoutVersion", std::string("1.0")});
    metadata.attributes.push_back({"emissiveUnits", std::string("W.m^-2.sr^-1")});
  }
  for (auto& [name, value] : cryptomatte_attributes(wanted_aovs(arguments), names))
    metadata.attributes.push_back({name, value});
  if (!arguments.samples.empty())
    for (auto& [name, value] : part_id_attributes(wanted_aovs(arguments), names))
      metadata.attributes.push_back({name, value});
  if (!arguments.full_floats) metadata.half_channels = half_channels(image.channels);
  if (!arguments.no_timestamps) {
    metadata.capture_date = fmt::format("{:%Y:%m:%d %H:%M:%S}", fmt::localtime(std::time(nullptr)));
  }
  return metadata;
}

/// Adds the denoised image if requested. If that fails, prints the error; the noisy image can still be written.
bool add_denoised(const RenderArguments& arguments, Image& image, ExrMetadata& metadata) {
  if (arguments.denoiser.empty()) return true;
  return try_to_write([&] {
    DenoiseResult result = denoise(image, denoiser_from_name(arguments.denoiser), arguments.threads);
    add_denoise_attribute(metadata, result);
    image = std::move(result.image);
  });
}

Progress::Mode progress_mode(bool quiet) {
  if (quiet) return Progress::Mode::kQuiet;
  return isatty(STDERR_FILENO) != 0 ? Progress::Mode::kBar : Progress::Mode::kLines;
}

/// Width of the terminal in columns; 0 if unknown.
int terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

/// The image so far.
RenderResult preview_of(const Scene& scene, const RenderState& state, AovSet aovs) {
  RenderResult so_far;
  so_far.film = state.film;
  if (!state.adaptive) {
    so_far.film.add(state.borders);
    so_far.film.end_replicate();
  }
  so_far.splats = state.splats;
  so_far.photons = state.photons;
  so_far.aovs = aovs;
  so_far.names = scene.names();
  return so_far;
}

/// Renders with signal handling, progress display and checkpoints. `show` receives the current state whenever the user
/// requests a preview by signal.
RenderResult render_with_progress(const Scene& scene, RenderOptions options, bool quiet, Checkpointer& checkpointer,
                                  Preview& preview,
                                  const std::function<void(const RenderState&, const RenderReport&)>& show) {
  RenderReport report;
  const std::uint64_t pixels =
      static_cast<std::uint64_t>(options.crop->width()) * static_cast<std::uint64_t>(options.crop->height());
  const auto write = [](std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); };
  Progress progress(progress_mode(quiet), pixels * scene.sampler().sample_count, write, Progress::steady_seconds,
                    terminal_columns);
  options.on_progress = [&progress](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
  options.stop = &InterruptGuard::stop();
  options.wants_pause = [&checkpointer] { return InterruptGuard::wants_preview() || checkpointer.is_due(); };
  options.on_report = [&](const RenderReport& now) { report = now; };
  options.on_pause = [&](const RenderState& state) {
    checkpointer.save(state);
    if (!InterruptGuard::wants_preview()) return;
    InterruptGuard::end_preview();
    show(state, report);
  };
  preview.watch(options);
  RenderResult result = render(scene, options);
  progress.finish(!result.interrupted);
  return result;
}

RenderOptions render_options(const RenderArguments& arguments, const SamplerSettings& sampler, AovSet aovs,
                             const PixelRect& crop) {
  RenderOptions options;
  options.seed = arguments.seed;
  options.threads = arguments.threads;
  options.wave_size = arguments.wave_size;
  options.spectral_bins = arguments.spectral_bins;
  options.replicates = choose_replicates(arguments, sampler);
  options.guiding = arguments.guiding;
  options.noise_target = static_cast<double>(arguments.noise_target.value_or(0.0f));
  options.time_limit = static_cast<double>(arguments.time_limit.value_or(0.0f));
  options.aovs = aovs;
  options.light_groups = arguments.light_groups;
  options.crop = crop;
  if (!arguments.samples.empty()) options.samples = parse_samples(arguments.samples);
  return options;
}

/// Prints notes and warnings before the render.
void print_start(const Description& description, const Scene& scene) {
  for (const std::string& note : description.notes) print_message(note);
  for (const std::string& stand_in : description.stand_ins) print_message("warning: " + stand_in);
  for (const std::string& warning : scene.warnings()) print_message("warning: " + warning);
  if (scene.view().light_count == 0 && !scene.names().has_other_light && transports_light(scene.integrator().kind))
    print_message("warning: the scene has no lights: its picture is black");
}

/// Prints warnings, statistics and the written files after the render.
void print_end(const RenderResult& result, const std::vector<fs::path>& written, std::size_t stand_ins) {
  for (const std::string& warning : result.warnings) print_message("warning: " + warning);
  std::fputs(to_table(result.report).c_str(), stderr);
  for (const fs::path& output : written) print_message("wrote " + output.string());
  if (stand_ins > 0)
    print_message(
        fmt::format("warning: {} thing{} of the scene could not be read and {} left out or replaced; see "
                    "the warnings above",
                    stand_ins, stand_ins == 1 ? "" : "s", stand_ins == 1 ? "was" : "were"));
}

/// The requested color mode; otherwise that of the scene's dialect, with a note.
ColorMode choose_color(const RenderArguments& arguments, Description& description) {
  const ColorMode native = native_color(arguments.scene);
  if (arguments.color.empty() && native == ColorMode::kSpectral)
    description.notes.push_back(arguments.scene +
                                ": rendered with --color spectral, as pbrt does; --color rgb is faster");
  const ColorMode color = arguments.color.empty() ? native : kColorModes.option("colour mode", arguments.color);
  if (arguments.spectral_bins > 0 && color != ColorMode::kSpectral)
    throw Error(ExitCode::kUsage, "--spectral-bins needs --color spectral");
  return color;
}

int render_scene(const RenderArguments& arguments, const std::vector<std::pair<std::string, std::string>>& given) {
  // Check the outputs before any work.
  const AovSet aovs = wanted_aovs(arguments);
  const std::vector<NamedFile> all_outputs = check_outputs(arguments);
  std::vector<fs::path> outputs;
  for (std::size_t i = 0; i < std::max<std::size_t>(arguments.outputs.size(), 1); ++i)
    outputs.push_back(all_outputs[i].file);
  check_layers(arguments, outputs);
  if (!arguments.denoiser.empty()) check_denoiser(denoiser_from_name(arguments.denoiser));
  Preview preview(arguments.preview, arguments.scene, outputs.front().string(), arguments.quiet);
  // Read the scene and apply the options.
  const double load_start = Progress::steady_seconds();
  Description description = read_scene(arguments.scene, read_options(arguments.scene, arguments.read));
  check_sources(all_outputs, description.files);
  const ColorMode color = choose_color(arguments, description);
  const char* const color_name = kColorModes.name_of(color);
  apply_integrator(arguments, description);
  apply_sampler(arguments, description);
  apply_size(arguments, description.film);
  if (!arguments.filter_mode.empty())
    description.film.filter_mode = kFilterModes.option("filter mode", arguments.filter_mode);
  else if (arguments.denoiser == "oidn")
    description.film.filter_mode = FilterMode::kImportance;
  const PixelRect crop = choose_crop(arguments, description.film);
  // Read the checkpoint.
  Checkpointer checkpointer(arguments.checkpoint, arguments.checkpoint.file.empty()
                                                      ? RenderSettings{}
                                                      : render_settings(given, description.files));
  const std::string part = arguments.samples.empty() && arguments.crop.empty()
                               ? ""
                               : part_settings(render_settings(given, description.files));
  std::optional<RenderState> resumed = checkpointer.resumed();
  // Compile the scene.
  const double build_start = Progress::steady_seconds();
  const std::unique_ptr<Scene> scene = arguments.read.lenient
                                           ? compile_leniently(description, {arguments.watertight, color})
                                           : compile_scene(description, {arguments.watertight, color});
  move_to_large_pages();
  const double build_end = Progress::steady_seconds();
  if (!arguments.quiet) print_start(description, *scene);

  // Render.
  RenderOptions options = render_options(arguments, description.sampler, aovs, crop);
  options.resume = resumed ? &*resumed : nullptr;
  const InterruptGuard guard;
  const auto show = [&](const RenderState& state, RenderReport report) {
    report.color = color_name;
    report.interrupted = true;
    const RenderResult so_far = preview_of(*scene, state, aovs);
    report.noise = noise_of(so_far.film, so_far.splats, so_far.photons);
    const Image image = so_far.to_image();
    for (const fs::path& file :
         write_pictures(outputs, image, make_metadata(arguments, report, description, scene->names(), image)))
      print_message("wrote what there is to " + file.string());
  };
  RenderResult result = render_with_progress(*scene, std::move(options), arguments.quiet, checkpointer, preview, show);
  // Denoise and write the image.
  preview.begin_writing();
  result.report.scene = arguments.scene;
  result.report.color = color_name;
  result.report.load_seconds = build_start - load_start;
  result.report.build_seconds = build_end - build_start;
  Image image = result.to_image();
  result.film = Film();  // free its memory before writing
  ExrMetadata metadata = make_metadata(arguments, result.report, description, scene->names(), image);
  if (result.samples) result.report.spp = result.samples->count;  // the header keeps the count of the whole render
  if (!part.empty()) add_part_attributes(metadata, part, result.samples);
  const bool denoised = add_denoised(arguments, image, metadata);
  const std::vector<fs::path> written = write_pictures(outputs, image, metadata);
  bool complete = written.size() == outputs.size() && checkpointer.is_saved();
  // Write the statistics and finish.
  result.report.peak_rss_bytes = peak_rss_bytes();
  result.report.peak_private_bytes = peak_private_bytes();
  if (!arguments.stats.empty())
    complete &= try_to_write([&] { write_text_file(arguments.stats, to_json(result.report)); });
  if (!arguments.quiet) print_end(result, written, description.stand_ins.size());
  preview.finish(!complete || !denoised ? "failed" : result.interrupted ? "interrupted" : "done", image, result.report);
  if (!complete) return static_cast<int>(ExitCode::kOutput);
  if (!denoised) return static_cast<int>(ExitCode::kRuntime);
  return result.interrupted ? 128 + InterruptGuard::signal() : static_cast<int>(ExitCode::kDone);
}

}  // namespace

RenderPlan plan_render(const std::vector<std::string>& words) {
  Program program("sheaf", "");
  RenderArguments arguments;
  Command command = add_render_options(program, arguments);
  RenderPlan plan;
  command.on_call([&] {
    for (const auto& [name, value] : command.given()) plan.given.push_back(name);
  });
  // Parse the options as `sheaf render` does.
  std::vector<std::string> line{"sheaf", "render"};
  line.insert(line.end(), words.begin(), words.end());
  std::vector<char*> pointers;
  for (std::string& word : line) pointers.push_back(word.data());
  if (program.parse(static_cast<int>(pointers.size()), pointers.data()))
    throw Error(ExitCode::kUsage, "these are no options of 'sheaf render'");
  // Read the scene and apply the options.
  const AovSet aovs = wanted_aovs(arguments);
  Description scene = read_scene(arguments.scene, read_options(arguments.scene, arguments.read));
  apply_integrator(arguments, scene);
  apply_sampler(arguments, scene);
  apply_size(arguments, scene.film);
  // Fill in the plan.
  plan.integrator = scene.integrator.kind;
  plan.crop = choose_crop(arguments, scene.film);
  const PhotonMappingSettings& photons = scene.integrator.photons;
  const bool maps = plan.integrator == IntegratorKind::kPhotonMapper;
  plan.samples = maps && photons.progressive && photons.max_passes > 0
                     ? rounded_sample_count(scene.sampler.kind, static_cast<std::uint32_t>(photons.max_passes))
                     : scene.sampler.sample_count;
  if (maps && photons.gathering == PhotonGathering::kFinal)
    plan.gather_rays = static_cast<std::uint32_t>(photons.gather_rays);
  plan.sets_given = arguments.replicates > 0;
  plan.sets = plan.sets_given ? static_cast<std::uint32_t>(arguments.replicates)
                              : default_replicates(scene.sampler.kind, std::uint64_t{plan.samples} * plan.gather_rays);
  if (aovs.contains(Aov::kVariance) || aovs.contains(Aov::kHalf)) plan.sets = std::max(plan.sets, 2u);
  return plan;
}

void add_render_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<RenderArguments>();
  Command command = add_render_options(program, *arguments);
  command.on_call([arguments, command, &exit_code] { exit_code = render_scene(*arguments, command.given()); });
}

}  // namespace sheaf
