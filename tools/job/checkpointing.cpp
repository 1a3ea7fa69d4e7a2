#include "tools/job/checkpointing.h"

#include "core/io/error.h"
#include "core/io/inflate.h"
#include "core/io/output_file.h"
#include "core/io/version.h"
#include "core/simd/simd.h"
#include "kernels/render/continuation.h"
#include "tools/console/messages.h"
#include "tools/console/progress.h"

#include <fmt/format.h>

#include <fstream>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// Size and checksum of a file.
std::string fingerprint(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> piece(std::size_t{1} << 20);
  std::uint32_t sum = 0;
  std::uint64_t size = 0;
  while (stream) {
    stream.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto read = static_cast<std::size_t>(stream.gcount());
    sum = check_sum({piece.data(), read}, sum);
    size += read;
  }
  return fmt::format("{} bytes, {:08x}", size, sum);
}

}  // namespace

void add_checkpoint_options(Command& command, CheckpointArguments& arguments) {
  command
      .add_option("--checkpoint", arguments.file,
                  "Checkpoint file: written periodically, on interruption and at the end; --resume continues from it")
      .file()
      .only_for_run();
  command
      .add_option("--checkpoint-every", arguments.every,
                  "Interval between checkpoints: seconds, or with a unit, such as 10m. Default: 60")
      .seconds()
      .positive()
      .only_for_run();
  command
      .add_flag("--resume", arguments.resume,
                "Continue from the --checkpoint file, or start if it does not exist. The output is byte-identical "
                "to that of an uninterrupted render. A larger --spp continues a finished render; see docs/output.md")
      .only_for_run();
}

void check_checkpoint(const CheckpointArguments& arguments) {
  if (arguments.file.empty()) {
    if (arguments.resume) throw Error(ExitCode::kUsage, "--resume needs --checkpoint FILE");
    return;
  }
  if (!arguments.resume && fs::exists(arguments.file))
    throw Error(ExitCode::kUsage,
                fmt::format("the checkpoint '{}' already exists: continue from it with --resume, or delete it",
                            arguments.file));
}

RecordedSettings recorded_settings(const std::vector<GivenOption>& given, const std::vector<fs::path>& files) {
  using Kind = RecordedSetting::Kind;
  RecordedSettings settings{{kVersionSetting, kSheafVersion, Kind::kProgram},
                            {"the instruction set", kIsaName, Kind::kProgram}};
  for (const GivenOption& option : given) {
    const bool selects_part = option.name == "samples" || option.name == "crop";
    if (option.affects_image)
      settings.push_back({"--" + option.name, option.values, selects_part ? Kind::kPart : Kind::kOption});
  }
  for (const fs::path& file : files) settings.push_back({file.filename().string(), fingerprint(file), Kind::kFile});
  return settings;
}

RenderSettings continued_settings(const RenderSettings& settings, const std::string& file,
                                  std::optional<RenderState>& resumed, std::string& note) {
  /// Below this number of samples per pixel, a checkpoint is not worth an error.
  constexpr std::uint32_t kFewSamples = 32;
  note.clear();
  if (!resumed) return settings;
  const std::uint32_t before = resumed->division.spp;
  const Continuation continuation = continue_from(settings, *resumed);
  if (continuation.problem.empty()) {
    if (continuation.settings.replicates != settings.replicates)
      note = fmt::format(
          "the render continues {} samples per pixel with sample sets of {}: the image is that of --replicates {}",
          before, resumed->division.replicate_samples, continuation.settings.replicates);
    return continuation.settings;
  }
  std::string reason = continuation.problem;
  if (settings.spp != before && settings.adapts == resumed->adaptive.has_value())
    reason = fmt::format("--spp {} in the checkpoint, {} now: {}", before / settings.rays, settings.camera_samples(),
                         reason);
  if (before >= kFewSamples || settings.spp <= before)
    throw Error(ExitCode::kCheckpoint, {file, 0}, "cannot be continued: " + reason);
  resumed.reset();
  note = fmt::format("the render begins again, because '{}' cannot be continued: {}", file, reason);
  return settings;
}

Checkpointer::Checkpointer(const CheckpointArguments& arguments, RecordedSettings settings)
    : arguments_(arguments), settings_(std::move(settings)), last_(Progress::steady_seconds()) {}

std::optional<RenderState> Checkpointer::resumed() const {
  if (!arguments_.resume || !fs::exists(arguments_.file)) return std::nullopt;
  return read_checkpoint(arguments_.file, settings_);
}

bool Checkpointer::is_due() const {
  return !arguments_.file.empty() &&
         Progress::steady_seconds() - last_.load(std::memory_order_relaxed) >= arguments_.every;
}

void Checkpointer::save(const RenderState& state) {
  if (arguments_.file.empty()) return;
  try {
    write_checkpoint(arguments_.file, settings_, state);
    is_saved_ = true;
  } catch (const std::exception& error) {
    print_message(error.what());
    is_saved_ = false;
  }
  last_ = Progress::steady_seconds();
}

}  // namespace sheaf
