// sheaf watch: renders a scene, and again whenever one of its files changes or its camera is moved, with previews.
#include "core/io/error.h"
#include "tools/cli/commands.h"
#include "tools/cli/render_scene.h"
#include "tools/console/interrupt.h"
#include "tools/job/apply_arguments.h"
#include "tools/job/image_files.h"
#include "tools/preview/file_watcher.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace sheaf {

namespace {

constexpr const char* kDefaultPort = "8080";

/// A line for each error of the scene.
std::string errors_text(const Error& error) {
  const auto* several = dynamic_cast<const SceneErrors*>(&error);
  if (several == nullptr) return printable(error.what());
  std::string text;
  for (const SceneError& each : several->all()) text += (text.empty() ? "" : "\n") + printable(each.what());
  return text;
}

/// Renders the scene once. Returns the exit code; errors are printed.
int render_once(const RenderArguments& arguments, const std::vector<GivenOption>& given, RepeatedRender& render) {
  try {
    return render_scene(arguments, given, &render);
  } catch (const Error& error) {
    print_error(error);
    render.preview.fail(errors_text(error));
    return static_cast<int>(error.exit_code());
  }
}

/// Renders until a signal stops a render. Returns the exit code.
int watch_scene(RenderArguments& arguments, const std::vector<GivenOption>& given) {
  if (!arguments.checkpoint.file.empty())
    throw Error(ExitCode::kUsage, "--checkpoint is not supported by 'sheaf watch': it belongs to a single render");
  if (!arguments.frames.empty() || arguments.skip_existing)
    throw Error(ExitCode::kUsage,
                "--frames and --skip-existing are not supported by 'sheaf watch': choose a frame by "
                "-D frame=N, or the moment of a model by --time");
  if (arguments.preview.serve.empty() && arguments.preview.tev.empty()) arguments.preview.serve = kDefaultPort;
  arguments.read.turns_camera = true;
  const std::filesystem::path scene = arguments.scene;
  CameraControl camera(InterruptGuard::request_stop);
  Preview preview(arguments.preview, arguments.scene, scene.stem().string() + ".exr",
                  output_settings(arguments.output).display, true, &camera);
  RepeatedRender render{preview, camera, {scene}};
  FileWatcher watcher(InterruptGuard::request_stop);
  const auto announce = [&] {
    watcher.watch(render.files);
    if (!watcher.has_changed() && !camera.has_moved()) print_note("waiting for changes of the scene");
  };
  render.wait_for_move = [&] {
    constexpr double kInterval = 0.05;  // s
    announce();
    while (!watcher.has_changed())
      if (camera.wait(kInterval)) return true;
    return false;
  };
  for (;;) {
    // Render
    watcher.begin();
    watcher.watch(render.files);
    preview.begin_scene();
    const int exit_code = render_once(arguments, given, render);
    // Users can correct the scene, but not the options
    if (exit_code == static_cast<int>(ExitCode::kUsage) || InterruptGuard::signal() != 0) return exit_code;
    // Wait for changes
    if (!watcher.has_changed()) announce();
    watcher.wait();
    print_note("the scene has changed");
  }
}

}  // namespace

void add_watch_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<RenderArguments>();
  Command command = add_render_options(
      program, *arguments, "watch",
      "Render a scene with a preview, and again whenever one of its files changes or the camera is moved on the page. "
      "Serves the preview at port 8080 unless --serve or --tev is given. Writes images only with --output, and none of "
      "a moved camera. On the page, drag to orbit, shift-drag to pan, and turn the wheel to dolly; with fingers: one "
      "orbits, two pan and pinch to dolly. A double click turns to the point under the pointer, with Alt it focuses "
      "there. R returns to the camera of the file. A click shows object, material, position and radiance; Escape "
      "hides them. Exposure, tone map and layer are chosen below the image, and the button 'camera' copies the "
      "look_at. Ctrl-C in the terminal ends the command. See docs/preview.md.");
  command.set_help("scene", "Scene file or model");
  command.set_help(
      "--output", fmt::format("Image to write when a render ends: {}; may be repeated. Default: none", kOutputFormats));
  command.hide({"--format", "--frames", "--fps", "--skip-existing", "--checkpoint", "--checkpoint-every", "--resume"});
  command.on_call([arguments, command, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    choose_denoiser(arguments->denoiser);
    exit_code = watch_scene(*arguments, command.given());
  });
}

}  // namespace sheaf
