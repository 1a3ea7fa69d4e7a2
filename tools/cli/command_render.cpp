// sheaf render: reads a scene, renders it with a progress bar and writes all outputs.
#include "core/image/exr.h"
#include "core/io/error.h"
#include "core/io/memory.h"
#include "core/io/output_file.h"
#include "kernels/render/render.h"
#include "scene/compile/move_camera.h"
#include "scene/dialects/read_model.h"
#include "scene/dialects/read_scene.h"
#include "tools/cli/commands.h"
#include "tools/cli/render_scene.h"
#include "tools/cli/render_summary.h"
#include "tools/cli/similar_messages.h"
#include "tools/console/interrupt.h"
#include "tools/console/progress.h"
#include "tools/console/standard_streams.h"
#include "tools/console/terminal.h"
#include "tools/farm/frames.h"
#include "tools/job/apply_arguments.h"
#include "tools/job/image_files.h"
#include "tools/job/interrupted_image.h"
#include "tools/job/parts.h"
#include "tools/job/render_job.h"
#include "tools/preview/preview.h"
#include "tools/report/report_text.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// Returns all output files, the images first. Throws Error for unknown formats, files given twice and locations that
/// are not writable. `has_default`: an image is written even if none is given.
std::vector<NamedFile> check_outputs(const RenderArguments& arguments, bool has_default) {
  std::vector<std::string> images = arguments.outputs;
  if (images.empty() && has_default) images.push_back(fs::path(arguments.scene).stem().string() + ".exr");
  std::vector<NamedFile> outputs = named_images(images);
  if (!arguments.stats.empty() && arguments.stats != "-") outputs.push_back({"--stats", arguments.stats});
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
  for (const fs::path& file : files) sources.push_back({"the scene's input file", file});
  check_overwriting(outputs, sources);
}

/// Throws Error (exit code 2) if layers are requested but no output can store them.
void check_layers(const RenderArguments& arguments, const std::vector<fs::path>& outputs) {
  if (outputs.empty()) return;
  const auto is_exr = [](const fs::path& file) { return extension_of(file) == ".exr"; };
  if (std::any_of(outputs.begin(), outputs.end(), is_exr)) return;
  const char* const option = !arguments.aovs.empty()        ? "--aov"
                             : arguments.light_groups       ? "--light-groups"
                             : arguments.spectral_bins != 0 ? "--spectral-bins"
                                                            : nullptr;
  if (option != nullptr)
    throw Error(ExitCode::kUsage, fmt::format("{} adds layers, which only .exr files can store: add -o {}", option,
                                              fs::path(outputs.front()).replace_extension(".exr").string()));
}

/// A scene with the options of the command line.
struct RenderJob : LoadedScene {
  explicit RenderJob(const RenderArguments& given) : arguments(given), output(output_settings(given.output)) {}

  const RenderArguments& arguments;
  std::vector<fs::path> outputs;  ///< images
  OutputSettings output;
  std::string part;  ///< see part_settings(); empty: all pixels and samples are rendered
};

Progress::Mode progress_mode() {
  if (verbosity() < Verbosity::kNormal) return Progress::Mode::kQuiet;
  return isatty(STDERR_FILENO) != 0 ? Progress::Mode::kBar : Progress::Mode::kLines;
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
RenderResult render_with_progress(const Scene& scene, const RenderSettings& settings, RenderControl control,
                                  Checkpointer& checkpointer, Preview& preview,
                                  const std::function<void(const RenderState&, const RenderReport&)>& show) {
  RenderReport report;
  const auto write = [](std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); };
  Progress progress(progress_mode(), write, Progress::steady_seconds, [] { return terminal_columns(STDERR_FILENO); });
  control.on_progress = [&progress](const RenderProgress& now) { progress.update(now); };
  control.stop = &InterruptGuard::stop();
  control.wants_pause = [&checkpointer] { return InterruptGuard::wants_preview() || checkpointer.is_due(); };
  control.on_report = [&](const RenderReport& now) { report = now; };
  control.on_pause = [&](const RenderState& state) {
    checkpointer.save(state);
    if (!InterruptGuard::wants_preview()) return;
    InterruptGuard::end_preview();
    show(state, report);
  };
  preview.watch(control);
  preview.show_first_passes(scene, settings, control);
  RenderResult result = render(scene, settings, control);
  progress.finish();
  return result;
}

/// Prints notes and warnings before the render; with `frames`, those that earlier frames did not have.
void print_start(const RenderJob& job, FrameRun* frames) {
  const auto print = [&](void (*kind)(std::string_view), const std::string& message) {
    if (frames == nullptr || frames->is_new(message)) kind(message);
  };
  for (const std::string& detail : job.remarks.details) print(print_detail, detail);
  const bool all = verbosity() == Verbosity::kVerbose;
  const auto print_each = [&](void (*kind)(std::string_view), const std::vector<std::string>& messages) {
    for (const std::string& message : all ? messages : without_similar(messages)) print(kind, message);
  };
  print_each(print_note, job.remarks.notes);
  print_each(print_warning, scene_warnings(job));
}

/// Prints warnings, statistics and the written files after the render. `frames`: null for a single image.
void print_end(const RenderResult& result, const WrittenImages& written, std::size_t substitutions, FrameRun* frames) {
  for (const std::string& warning : result.warnings)
    if (frames == nullptr || frames->is_new(warning)) print_warning(warning);
  if (verbosity() == Verbosity::kVerbose) std::fputs(to_table(result.report).c_str(), stderr);
  print_note((frames != nullptr ? frames->label() + ": " : "") + summarize(result.report, written));
  if (substitutions > 0)
    print_warning(fmt::format("{} scene element{} could not be read and {} dropped or replaced; see the warnings above",
                              substitutions, substitutions == 1 ? "" : "s", substitutions == 1 ? "was" : "were"));
}

/// The images that the render writes, with the default name if none are given.
std::vector<fs::path> image_outputs(const RenderArguments& arguments, const std::vector<NamedFile>& outputs,
                                    bool has_default) {
  std::vector<fs::path> images;
  for (std::size_t i = 0; i < std::max<std::size_t>(arguments.outputs.size(), has_default ? 1 : 0); ++i)
    images.push_back(outputs[i].file);
  return images;
}

/// Writes the image so far.
void write_so_far(const RenderJob& job, const RenderState& state, RenderReport report) {
  report.color = job.color_name();
  report.interrupted = true;
  const RenderResult so_far = preview_of(*job.scene, state, job.settings.aovs);
  report.noise = noise_of(so_far.film, so_far.splats, so_far.photons);
  const Image image = so_far.to_image();
  for (const fs::path& file :
       write_images(job.outputs, image, make_metadata(job.arguments, job, report, image), job.output).files)
    print_note("wrote the unfinished image to " + file.string());
}

/// The final image, and the files to which it was written.
struct WrittenImage {
  Image image;
  bool is_denoised;  ///< or no denoiser was requested
  WrittenImages written;
};

/// Denoises the image of `result` and writes it to the files. Frees the film of `result`.
WrittenImage write_result(const RenderJob& job, const std::vector<fs::path>& files, RenderResult& result) {
  WrittenImage out{result.to_image(), true, {}};
  result.film = Film();  // free its memory before writing
  ExrMetadata metadata = make_metadata(job.arguments, job, result.report, out.image);
  if (result.samples) result.report.spp = result.samples->count;  // the header keeps the count of the whole render
  if (!job.part.empty()) add_part_attributes(metadata, job.part, result.samples);
  // If denoising fails, the noisy image can still be written
  out.is_denoised = try_to_write([&] { add_denoised(job.arguments, out.image, metadata); });
  out.written = write_images(files, out.image, metadata, job.output);
  if (out.is_denoised) out.written.denoiser = job.arguments.denoiser;
  return out;
}

/// Writes the statistics if requested. Returns false if that fails.
bool write_statistics(const RenderArguments& arguments, RenderReport& report) {
  report.peak_rss_bytes = peak_rss_bytes();
  report.peak_private_bytes = peak_private_bytes();
  if (arguments.stats == "-") return std::fputs(to_json(report).c_str(), stdout) >= 0;
  return arguments.stats.empty() || try_to_write([&] { write_text_file(arguments.stats, to_json(report)); });
}

/// What the renders of a compiled scene share.
struct CompiledRender {
  RenderJob& job;
  Checkpointer& checkpointer;
  Preview& preview;
  RepeatedRender* repeated;  ///< null: rendered once
  FrameRun* frames;          ///< null: a single image
  double load_seconds, build_seconds;
};

/// Renders, writes the outputs, and prints the summary. Returns the exit code; 0 for a render that ends because
/// another one follows.
int render_compiled(const CompiledRender& run, std::optional<RenderState> resumed) {
  RenderJob& job = run.job;
  const RenderArguments& arguments = job.arguments;
  std::string note;
  const RenderSettings settings = continued_settings(job.settings, arguments.checkpoint.file, resumed, note);
  if (!note.empty()) print_note(note);
  RenderControl control = control_of(arguments);
  control.resume = resumed ? &*resumed : nullptr;
  const InterruptGuard guard;
  if (run.repeated != nullptr) control.discards_result = [] { return InterruptGuard::signal() == 0; };
  if (run.repeated != nullptr && run.repeated->camera.has_moved()) InterruptGuard::request_stop();
  const bool writes = run.repeated == nullptr || run.repeated->camera.is_at_home();
  const auto show = [&](const RenderState& state, const RenderReport& report) {
    if (writes) write_so_far(job, state, report);
  };
  RenderResult result =
      render_with_progress(*job.scene, settings, std::move(control), run.checkpointer, run.preview, show);
  if (run.repeated != nullptr && result.interrupted && InterruptGuard::signal() == 0) return 0;
  run.preview.begin_writing();
  result.report.scene = arguments.scene;
  result.report.color = job.color_name();
  add_loading(result.report, job, run.load_seconds, run.build_seconds);

  // Write image and statistics
  const std::vector<fs::path> files = writes ? job.outputs : std::vector<fs::path>{};
  const WrittenImage written = write_result(job, files, result);
  bool complete = written.written.files.size() == files.size() && run.checkpointer.is_saved();
  if (writes) complete &= write_statistics(arguments, result.report);
  print_end(result, written.written, job.description.substitutions.size(), run.frames);
  if (run.frames != nullptr) keep_geometry(std::move(job.scene), run.frames->geometry);

  // Report the outcome
  const bool failed = !complete || !written.is_denoised;
  run.preview.finish(failed ? "failed" : result.interrupted ? "interrupted" : "done", written.image, result.report);
  if (!complete) return static_cast<int>(ExitCode::kOutput);
  if (!written.is_denoised) return static_cast<int>(ExitCode::kRuntime);
  return result.interrupted ? 128 + InterruptGuard::signal() : static_cast<int>(ExitCode::kDone);
}

/// Detaches the camera from a scene before that is destroyed.
class CameraAttachment {
 public:
  CameraAttachment(CameraControl& camera, RenderJob& job) : camera_(camera) {
    if (const auto moved = camera.begin_scene(job.description, job.settings.film)) {
      move_camera(*moved, job.settings.film, job.scene);
      job.description.camera = *moved;
    }
    camera.attach(*job.scene, job.settings.crop);
  }
  ~CameraAttachment() { camera_.detach(); }
  CameraAttachment(const CameraAttachment&) = delete;
  CameraAttachment& operator=(const CameraAttachment&) = delete;

 private:
  CameraControl& camera_;
};

/// Renders a compiled scene, and again when the camera was moved, until the scene changes. Returns the exit code.
int render_while_camera_moves(const CompiledRender& run) {
  RepeatedRender& repeated = *run.repeated;
  RenderJob& job = run.job;
  int code = 0;
  {
    const CameraAttachment attachment(repeated.camera, job);
    code = render_compiled(run, std::nullopt);
    while (InterruptGuard::signal() == 0 && repeated.wait_for_move()) {
      repeated.frames.follow(job, control_of(job.arguments), repeated.camera, repeated.preview);
      // The motion of the file's camera is compiled anew
      if (repeated.camera.is_at_home() && job.description.camera.motion) {
        repeated.camera.detach();
        keep_geometry(std::move(job.scene), repeated.geometry);
        compile(job.arguments, job, &repeated.geometry);
        repeated.camera.attach(*job.scene, job.settings.crop);
      }
      code = render_compiled(run, std::nullopt);
    }
  }
  keep_geometry(std::move(job.scene), repeated.geometry);
  return code;
}

}  // namespace

int render_scene(const RenderArguments& arguments, const std::vector<GivenOption>& given, RepeatedRender* repeated,
                 FrameRun* frames) {
  // Check the outputs before any work
  RenderJob job(arguments);
  const std::vector<NamedFile> all_outputs = check_outputs(arguments, repeated == nullptr);
  job.outputs = image_outputs(arguments, all_outputs, repeated == nullptr);
  check_layers(arguments, job.outputs);
  if (!arguments.samples.empty() && job.output.is_lossy()) job.output.compression = ExrCompression::kZip;
  std::optional<Preview> own_preview;
  if (repeated == nullptr)
    own_preview.emplace(arguments.preview, arguments.scene, job.outputs.front().string(), job.output.display);
  Preview& preview = repeated != nullptr ? repeated->preview : *own_preview;

  // Read the scene and apply the options
  const double load_start = Progress::steady_seconds();
  job.description = read_scene(arguments.scene, read_options(arguments));
  if (has_studio(job.description)) set_model_defaults(arguments.output, job.output);
  preview.set_display(job.output.display);
  prepare(arguments, job);
  if (repeated != nullptr) repeated->files = job.description.files;
  check_sources(all_outputs, job.description.files);

  // Read the checkpoint
  Checkpointer checkpointer(arguments.checkpoint, arguments.checkpoint.file.empty()
                                                      ? RecordedSettings{}
                                                      : recorded_settings(given, job.description.files));
  if (!arguments.samples.empty() || !arguments.crop.empty())
    job.part = part_settings(recorded_settings(given, job.description.files));
  std::optional<RenderState> resumed = checkpointer.resumed();

  // Compile the scene
  const double build_start = Progress::steady_seconds();
  compile(arguments, job, frames != nullptr ? &frames->geometry : repeated != nullptr ? &repeated->geometry : nullptr);
  const double build_end = Progress::steady_seconds();
  print_start(job, frames);

  // Render
  const CompiledRender run{
      job, checkpointer, preview, repeated, frames, build_start - load_start, build_end - build_start};
  return repeated != nullptr ? render_while_camera_moves(run) : render_compiled(run, std::move(resumed));
}

namespace {

const FrameCalls kFrameCalls{[](const RenderArguments& frame) { check_outputs(frame, true); },
                             [](const RenderArguments& frame, const std::vector<GivenOption>& given, FrameRun& run) {
                               return render_scene(frame, given, nullptr, &run);
                             }};

}  // namespace

void add_render_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<RenderArguments>();
  Command command = add_render_options(program, *arguments);
  command.on_call([arguments, command, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    check_frame_options(*arguments);
    choose_denoiser(arguments->denoiser);
    StandardStreams streams;
    const std::vector<std::string>& outputs = arguments->outputs;
    if (arguments->stats == "-" && std::find(outputs.begin(), outputs.end(), "-") != outputs.end())
      throw Error(ExitCode::kUsage, "-o - and --stats - exclude each other: both write to the standard output");
    streams.open_output(arguments->outputs, arguments->output_format);
    arguments->scene = streams.read_scene(arguments->scene);
    arguments->read.from_working_folder = streams.has_scene();
    exit_code = arguments->frames.empty() ? render_scene(*arguments, command.given())
                                          : render_frames(*arguments, command.given(), kFrameCalls);
    if (!streams.send_output() && exit_code == 0) exit_code = static_cast<int>(ExitCode::kOutput);
  });
}

}  // namespace sheaf
