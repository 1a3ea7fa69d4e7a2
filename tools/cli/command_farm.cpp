// sheaf farm: writes and submits the jobs with which a Slurm cluster renders images in parts.
#include "core/io/error.h"
#include "core/io/output_file.h"
#include "scene/dialects/read_model.h"
#include "tools/cli/commands.h"
#include "tools/farm/farm_scripts.h"
#include "tools/farm/frames.h"
#include "tools/farm/render_plan.h"
#include "tools/job/apply_arguments.h"
#include "tools/job/image_files.h"
#include "tools/options/process_command_line.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

struct FarmArguments {
  std::string scene, frames, folder, partition, time, memory;
  std::vector<std::string> outputs, sbatch, options;
  int parts = 0, cpus = 1, grace = 60;
  std::optional<float> fps;
  std::string denoiser;
  bool tiles = false, submit = false;
  VerbosityArguments verbosity;
};

/// Options of `sheaf render` that farm sets itself or that do not apply to parts, with the reason.
constexpr std::pair<const char*, const char*> kUnsupportedOptions[] = {
    {"output", "use the --output of 'sheaf farm'"},
    {"frames", "use the --frames of 'sheaf farm'"},
    {"fps", "use the --fps of 'sheaf farm'"},
    {"denoise", "use the --denoise of 'sheaf farm'"},
    {"skip-existing", "run submit.sh again to continue failed jobs"},
    {"samples", "farm chooses it"},
    {"checkpoint", "farm chooses it"},
    {"resume", "farm chooses it"},
    {"threads", "use the --cpus of 'sheaf farm'"},
    {"stats", "all parts would write the same file"},
    {"noise-target", "parts are rendered independently"},
    {"time-limit", "parts are rendered independently"}};

/// The help on these options.
std::string unsupported_options() {
  std::string text = "Not supported:";
  for (const auto& [name, why] : kUnsupportedOptions) text += fmt::format("\n--{} ({}),", name, why);
  return text + "\n--integrator ptracer (its samples cannot be split: use --parts 1 --tiles)";
}

/// Adds the layers that the denoiser uses to the options of the parts.
void request_layers(const std::string& denoiser, std::vector<std::string>& options) {
  std::string aovs = denoiser == "nlm" ? "albedo,normal,depth,variance,half" : "albedo,normal,depth";
  for (std::size_t i = 0; i < options.size(); ++i) {
    const std::string option = options[i], name = "--aov";
    const bool is_split = option == name && i + 1 < options.size();
    if (!is_split && !option.starts_with(name + "=")) continue;
    aovs = (is_split ? options[i + 1] : option.substr(name.size() + 1)) + "," + aovs;
    const auto at = options.begin() + static_cast<std::ptrdiff_t>(i);
    options.erase(at, at + (is_split ? 2 : 1));
    break;
  }
  options.insert(options.end(), {"--aov", aovs});
  // OIDN expects pixels whose noise is independent
  const auto is_filter_mode = [](const std::string& option) { return option.starts_with("--filter-mode"); };
  if (denoiser == "oidn" && std::none_of(options.begin(), options.end(), is_filter_mode))
    options.insert(options.end(), {"--filter-mode", "importance"});
}

/// Crop windows "x0,y0,x1,y1" of strips of rows. Throws Error (exit code 2) if there are fewer rows than parts.
std::vector<std::string> strips(const PixelRect& crop, int parts) {
  if (crop.height() < parts)
    throw Error(ExitCode::kUsage, fmt::format("{} pixel rows cannot be split into {} parts", crop.height(), parts));
  std::vector<std::string> values;
  const auto row = [&](std::int64_t part) { return crop.y0 + crop.height() * part / parts; };
  for (int part = 0; part < parts; ++part)
    values.push_back(fmt::format("{},{},{},{}", crop.x0, row(part), crop.x1, row(part + 1)));
  return values;
}

/// Defines the parts and the options for merging them.
void split(const FarmArguments& arguments, const RenderPlan& plan, Farm& farm) {
  const RenderSettings& settings = plan.settings;
  const PixelRect& crop = settings.crop;
  const std::string rect = fmt::format("{},{},{},{}", crop.x0, crop.y0, crop.x1, crop.y1);
  farm.merge_options = {"--crop", rect};
  const auto is_given = [&](const char* name) {
    return std::find(plan.given.begin(), plan.given.end(), name) != plan.given.end();
  };
  if (is_given("float")) farm.merge_options.emplace_back("--float");
  std::vector<std::string>& writing = farm.denoiser.empty() ? farm.merge_options : farm.denoise_options;
  for (const auto& [name, value] : plan.output_options) writing.insert(writing.end(), {"--" + name, value});
  // Split the frame into strips of rows
  if (arguments.tiles) {
    if (is_given("crop")) throw Error(ExitCode::kUsage, "--crop and --tiles exclude each other");
    farm.part_option = "--crop";
    farm.part_values = strips(crop, arguments.parts);
    return;
  }
  if (settings.integrator.traits().connects_photons())
    throw Error(ExitCode::kUsage,
                "the samples of ptracer cannot be split, and each of its tiles takes as long as the whole frame: "
                "distribute frames instead, with --parts 1 --tiles");
  // Split the samples into ranges
  const auto parts = static_cast<std::uint32_t>(arguments.parts);
  if (settings.camera_samples() < parts)
    throw Error(
        ExitCode::kUsage,
        fmt::format("{} samples per pixel cannot be split into {} parts; use --tiles to split the frame instead",
                    settings.camera_samples(), parts));
  const std::uint32_t sets = replicates_for_parts(settings, parts);
  constexpr std::uint32_t kMaxSets = 1024;  // limit of --replicates
  if (sets > kMaxSets)
    throw Error(ExitCode::kUsage, fmt::format("{} samples in {} parts require {} sample sets (--replicates), expected "
                                              "at most {}; --replicates 1 disables them, without variance layers",
                                              settings.camera_samples(), parts, sets, kMaxSets));
  farm.part_option = "--samples";
  try {
    for (const SampleRange& range : divide_samples(with_replicates(settings, sets), parts))
      farm.part_values.push_back(fmt::format("{}:{}", range.first, range.count));
  } catch (const Error& error) {
    throw Error(error.exit_code(), fmt::format("{}; use --tiles to split the frame instead", error.what()));
  }
  if (!settings.requests_replicates) {
    farm.options.emplace_back("--replicates");
    farm.options.push_back(std::to_string(sets));
  }
}

std::vector<std::string> sbatch_options(const FarmArguments& arguments) {
  std::vector<std::string> options{"--job-name=sheaf", "--requeue", "--open-mode=append", "--output=/dev/null"};
  if (!arguments.partition.empty()) options.push_back("--partition=" + arguments.partition);
  if (!arguments.memory.empty()) options.push_back("--mem=" + arguments.memory);
  options.insert(options.end(), arguments.sbatch.begin(), arguments.sbatch.end());
  return options;
}

Farm plan_farm(const FarmArguments& arguments) {
  // Parse the frames and the options of the render.
  Farm farm;
  farm.has_frames = !arguments.frames.empty();
  if (farm.has_frames) farm.frames = parse_frames(arguments.frames);
  farm.options = arguments.options;
  farm.denoiser = arguments.denoiser;
  if (!farm.denoiser.empty()) {
    choose_denoiser(farm.denoiser);
    request_layers(farm.denoiser, farm.options);
  }
  std::vector<std::string> words{arguments.scene};
  words.insert(words.end(), farm.options.begin(), farm.options.end());
  if (farm.has_frames) {
    check_has_frames(arguments.scene);
    if (reads_as_gltf(arguments.scene)) {
      farm.frame_rate = arguments.fps.value_or(kDefaultFrameRate);
      words.insert(words.end(), {"--time", std::to_string(farm.frames.first / *farm.frame_rate)});
    } else {
      words.insert(words.end(), {"--define", fmt::format("frame={}", farm.frames.first)});
    }
  }
  const RenderPlan plan = plan_render(words);
  for (const auto& [name, why] : kUnsupportedOptions)
    if (std::find(plan.given.begin(), plan.given.end(), name) != plan.given.end())
      throw Error(ExitCode::kUsage, fmt::format("--{} is not supported by 'sheaf farm': {}", name, why));
  // Fill in paths and parts.
  farm.program = fs::read_symlink("/proc/self/exe").string();
  farm.working_folder = fs::current_path().string();
  farm.scene = fs::absolute(arguments.scene).string();
  const std::string stem = fs::path(arguments.scene).stem().string();
  farm.folder = fs::absolute(arguments.folder.empty() ? fs::path(stem + "_farm") : fs::path(arguments.folder)).string();
  split(arguments, plan, farm);
  // Choose the outputs and the options of sbatch.
  std::vector<fs::path> outputs(arguments.outputs.begin(), arguments.outputs.end());
  if (outputs.empty()) outputs.emplace_back(stem + ".exr");
  for (const fs::path& output : outputs) {
    check_image_name(output);
    check_writable(output);
    FrameName name = farm.has_frames ? frame_name(output.string()) : FrameName{{output.string()}, {}};
    if (output.is_relative()) name.texts.front().insert(0, (fs::current_path() / "").string());
    farm.outputs.push_back(std::move(name));
  }
  farm.sbatch_merge_options = farm.sbatch_options = sbatch_options(arguments);
  farm.sbatch_options.push_back(fmt::format("--cpus-per-task={}", arguments.cpus));
  if (!farm.denoiser.empty()) farm.sbatch_merge_options.push_back(farm.sbatch_options.back());
  farm.sbatch_options.push_back(fmt::format("--signal=B:TERM@{}", arguments.grace));
  if (!arguments.time.empty()) farm.sbatch_options.push_back("--time=" + arguments.time);
  return farm;
}

int make_farm(const FarmArguments& arguments) {
  const Farm farm = plan_farm(arguments);
  std::error_code error;
  // Write the scripts
  fs::create_directories(farm.folder, error);
  if (error)
    throw Error(ExitCode::kOutput, fmt::format("cannot create the folder '{}': {}", farm.folder, error.message()));
  const fs::path folder = farm.folder, render = folder / "render.sh", merge = folder / "merge.sh",
                 submit = folder / "submit.sh";
  for (const fs::path& script : {render, merge, submit}) check_writable(script);  // fail before writing any of them
  write_text_file(render, render_script(farm));
  write_text_file(merge, merge_script(farm));
  write_text_file(submit, submit_script(farm, render.string(), merge.string()));
  print_note(fmt::format("wrote render.sh, merge.sh and submit.sh to {}: {} with {} part{}, starting at {} {}",
                         farm.folder, farm.has_frames ? "frames" : "one image", farm.part_values.size(),
                         farm.part_values.size() == 1 ? "" : "s", farm.part_option, farm.part_values.front()));
  // Submit the jobs if requested
  if (!arguments.submit) {
    print_note("to submit the jobs: bash " + shell_quoted(submit.string()));
    return static_cast<int>(ExitCode::kDone);
  }
  const int status = std::system(("bash " + shell_quoted(submit.string())).c_str());
  if (status == -1 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Error(ExitCode::kRuntime,
                fmt::format("some jobs were not submitted; run '{}' to submit them", submit.string()));
  return static_cast<int>(ExitCode::kDone);
}

}  // namespace

void add_farm_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<FarmArguments>();
  Command command =
      program.add_command("farm",
                          "Render images in parts on a Slurm cluster: writes a job array per frame and a job that "
                          "merges its parts. Options of 'sheaf render' follow after --. See docs/farm.md.");
  command.add_option("scene", arguments->scene, "Scene file, on storage shared by all nodes").required().file();
  command.add_arguments("options", arguments->options,
                        "Options of 'sheaf render' for all parts, after --. " + unsupported_options());
  command
      .add_option("--parts", arguments->parts,
                  "Number of parts per image: sample ranges, or strips of rows with --tiles")
      .required()
      .in_range(1, 1000);
  command
      .add_option("--frames", arguments->frames,
                  "Range of frames FIRST:LAST or FIRST:LAST:STEP, inclusive: each frame K is rendered with -D "
                  "frame=K, or a glTF file at its time (--fps). Default: one image without -D")
      .placeholder("FIRST:LAST:STEP");
  command
      .add_option("--fps", arguments->fps,
                  "With --frames for a glTF file: frames per second. Frame K shows the time K / fps. Default: 24")
      .positive();
  command
      .add_option("--denoise", arguments->denoiser,
                  "Denoise each merged image with nlm (non-local means) or oidn (Open Image Denoise, if installed). "
                  "auto, or no value: oidn if it is installed here, else nlm")
      .one_of({"auto", "nlm", "oidn"})
      .implies("auto");
  command
      .add_option(
          "-o,--output", arguments->outputs,
          "Output image, see 'sheaf render'; may be repeated. With --frames, the frame number replaces #### or "
          "$frame4 (4 digits) or $frame, or else precedes the file extension. Default: the scene's name with .exr")
      .file();
  command
      .add_option("--folder", arguments->folder,
                  "Folder for scripts, parts, checkpoints and logs, on storage shared by all nodes. Default: the "
                  "scene's name with _farm, in the current folder")
      .folder();
  command.add_flag("--tiles", arguments->tiles, "Split the frame into strips of rows instead of splitting the samples");
  command.add_flag("--submit", arguments->submit, "Submit the jobs with sbatch");
  command.add_option("--partition", arguments->partition, "Slurm partition").placeholder("NAME");
  command
      .add_option("--time", arguments->time,
                  "Time limit of a part in Slurm's notation, such as 2:00:00. Unfinished parts are requeued and "
                  "continue from their checkpoints")
      .placeholder("TIME");
  command
      .add_option("--grace", arguments->grace,
                  "Seconds before the time limit at which a part writes its checkpoint and exits. Default: 60")
      .in_range(1, 65535);
  command.add_option("--cpus", arguments->cpus, "Cores per part, and its number of threads. Default: 1")
      .in_range(1, 4096);
  command.add_option("--memory", arguments->memory, "Memory per part in Slurm's notation, such as 8G")
      .placeholder("SIZE");
  command
      .add_option("--sbatch", arguments->sbatch,
                  "Additional option for sbatch, such as --sbatch=--constraint=avx512; may be repeated")
      .placeholder("OPTION");
  add_verbosity_options(command, arguments->verbosity);
  command.on_call([arguments, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    exit_code = make_farm(*arguments);
  });
}

}  // namespace sheaf
