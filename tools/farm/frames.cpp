#include "tools/farm/frames.h"

#include "core/io/error.h"
#include "scene/dialects/read_model.h"
#include "scene/formats/model_formats.h"
#include "tools/console/duration.h"
#include "tools/console/interrupt.h"
#include "tools/console/messages.h"
#include "tools/console/progress.h"
#include "tools/job/interrupted_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

constexpr const char* kParameter = "frame";

/// The options of a frame: the outputs have its number, and the scene's parameter or the time is defined.
RenderArguments arguments_of(const RenderArguments& arguments, int frame) {
  RenderArguments one = arguments;
  one.frames.clear();
  if (one.outputs.empty()) one.outputs.push_back(fs::path(one.scene).stem().string() + ".exr");
  for (std::string& output : one.outputs) output = frame_name(output).at(frame);
  for (std::string* file : {&one.stats, &one.checkpoint.file})
    if (!file->empty() && *file != "-") *file = frame_name(*file).at(frame);
  if (reads_as_gltf(one.scene)) {
    one.read.time = static_cast<float>(frame / double(one.fps.value_or(kDefaultFrameRate)));
  } else {
    one.read.definitions.push_back(fmt::format("{}={}", kParameter, frame));
  }
  return one;
}

/// The options that `sheaf render` would be given for a single frame. Checkpoints and parts compare them in order;
/// --frames stands directly before --define in that order.
std::vector<GivenOption> given_for(const std::vector<GivenOption>& given, int frame) {
  const std::string definition = fmt::format("{}={}", kParameter, frame);
  const bool has_others = std::any_of(given.begin(), given.end(), [](auto& option) { return option.name == "define"; });
  std::vector<GivenOption> one;
  for (GivenOption option : given) {
    if (option.name == "frames") {
      if (!has_others) one.push_back({"define", definition, true});
      continue;
    }
    if (option.name == "define") option.values += "," + definition;
    one.push_back(std::move(option));
  }
  return one;
}

/// Whether all images of a frame exist and are not of an interrupted render.
bool is_rendered(const RenderArguments& frame) {
  return std::all_of(frame.outputs.begin(), frame.outputs.end(),
                     [](const std::string& file) { return fs::exists(file) && !is_interrupted(file); });
}

/// "1 frame", "3 frames"
std::string frames_text(std::size_t count) { return fmt::format("{} frame{}", count, count == 1 ? "" : "s"); }

}  // namespace

void FrameRun::begin_frame(int frame) {
  files_.drop_unused();
  frame_ = frame;
  ++position_;
}

std::string FrameRun::label() const { return fmt::format("frame {} ({} of {})", frame_, position_, count_); }

void check_has_frames(const fs::path& scene) {
  if (!reads_as_mesh(scene)) return;
  throw Error(ExitCode::kUsage,
              fmt::format("--frames applies to scenes and animated models ({}), not to models that do not move",
                          scene_model_extensions()));
}

void check_frame_options(const RenderArguments& arguments) {
  if (arguments.frames.empty()) {
    if (arguments.skip_existing) throw Error(ExitCode::kUsage, "--skip-existing needs --frames");
    return;
  }
  for (const std::string& definition : arguments.read.definitions)
    if (definition.starts_with(std::string(kParameter) + "="))
      throw Error(ExitCode::kUsage,
                  fmt::format("-D {} and --frames exclude each other: both set the frame number", definition));
  if (reads_as_gltf(arguments.scene) && arguments.read.time)
    throw Error(ExitCode::kUsage, "--time and --frames exclude each other: both set the time");
  check_has_frames(arguments.scene);
  if (!arguments.preview.serve.empty())
    throw Error(ExitCode::kUsage, "--serve shows a single render and excludes --frames; use --tev instead");
  for (const std::string& output : arguments.outputs)
    if (output == "-") throw Error(ExitCode::kUsage, "-o - writes a single image and excludes --frames");
}

int render_frames(const RenderArguments& arguments, const std::vector<GivenOption>& given, const FrameCalls& calls) {
  // Choose the frames, and check all outputs before any work
  std::vector<int> frames = parse_frames(arguments.frames).frames();
  const std::size_t requested = frames.size();
  if (arguments.skip_existing)
    std::erase_if(frames, [&](int frame) { return is_rendered(arguments_of(arguments, frame)); });
  for (const int frame : frames) calls.check(arguments_of(arguments, frame));
  const std::size_t skipped = requested - frames.size();
  // Render
  const double start = Progress::steady_seconds();
  FrameRun run(frames.size());
  std::size_t finished = 0;
  const auto report = [&] {
    print_note(fmt::format("rendered {}{} in {}{}", frames_text(finished),
                           finished < frames.size() ? fmt::format(" of {}", frames.size()) : "",
                           format_duration(Progress::steady_seconds() - start),
                           skipped > 0 ? fmt::format("; skipped {} with images", frames_text(skipped)) : ""));
  };
  int code = static_cast<int>(ExitCode::kDone);
  try {
    for (const int frame : frames) {
      run.begin_frame(frame);
      code = calls.render(arguments_of(arguments, frame), given_for(given, frame), run);
      if (code != static_cast<int>(ExitCode::kDone)) break;
      ++finished;
      // The render may have been complete when the signal arrived
      if (InterruptGuard::signal() == 0) continue;
      code = 128 + InterruptGuard::signal();
      break;
    }
  } catch (const std::exception&) {
    report();
    throw;
  }
  report();
  return code;
}

}  // namespace sheaf
