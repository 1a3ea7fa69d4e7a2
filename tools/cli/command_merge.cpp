// sheaf merge: merges parts of an image, which are tiles or ranges of samples.
#include "core/io/output_file.h"
#include "tools/cli/commands.h"
#include "tools/cli/render_summary.h"
#include "tools/farm/merge_parts.h"
#include "tools/job/image_files.h"
#include "tools/job/interrupted_image.h"
#include "tools/job/parts.h"

#include <fmt/format.h>

#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

struct MergeArguments {
  std::vector<std::string> parts, outputs;
  OutputArguments output;
  MergeOptions options;
  VerbosityArguments verbosity;
};

std::vector<fs::path> check_outputs(const MergeArguments& arguments) {
  std::vector<NamedFile> parts;
  for (const std::string& part : arguments.parts) parts.push_back({"the input part", part});
  const std::vector<NamedFile> outputs = named_images(arguments.outputs);
  check_overwriting(outputs, parts);
  check_all_writable(outputs);
  return {arguments.outputs.begin(), arguments.outputs.end()};
}

int merge_images(const MergeArguments& arguments) {
  const std::vector<fs::path> outputs = check_outputs(arguments);
  const OutputSettings settings = output_settings(arguments.output);
  std::vector<MergeSource> sources;
  for (const std::string& path : arguments.parts) {
    check_is_exr(path);
    sources.push_back({read_part_header(path), [path] { return read_exr(path); }});
  }
  const MergedImage merged = merge_parts(sources, arguments.options);
  // Write the outputs and print messages.
  const WrittenImages written = write_images(outputs, merged.image, merged.metadata, settings);
  if (merged.has_denoised)
    print_note("the layers denoised.R/G/B of the parts are omitted; run 'sheaf denoise' on the merged image");
  if (const std::string text = interruption(merged.metadata.attributes); !text.empty()) print_warning(text);
  if (merged.interrupted || merged.sampled_fraction < 1.0)
    print_warning(fmt::format("the image is incomplete: {:.4g} % of the samples{}", merged.sampled_fraction * 100,
                              merged.interrupted ? ", including interrupted parts" : ""));
  print_note(fmt::format("merged {} parts; {}", sources.size(), written_files(written)));
  return static_cast<int>(written.files.size() == outputs.size() ? ExitCode::kDone : ExitCode::kOutput);
}

}  // namespace

void add_merge_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<MergeArguments>();
  Command command = program.add_command(
      "merge",
      "Merge parts of an image that were rendered with --crop or --samples. Merged tiles are byte-identical to a full "
      "render; merged sample ranges are equal up to rounding. See docs/farm.md.");
  command.add_arguments("parts", arguments->parts, "Part images, .exr, in any order").required().file();
  command
      .add_option("-o,--output", arguments->outputs, fmt::format("Output image: {}; may be repeated", kOutputFormats))
      .required()
      .file();
  add_output_options(command, arguments->output);
  command
      .add_option("--crop", arguments->options.crop,
                  "Region of the merged image, in pixels: x0,y0,x1,y1 (x1, y1 exclusive). Default: the frame")
      .list(',', 4)
      .placeholder("x0,y0,x1,y1");
  command.add_flag("--incomplete", arguments->options.incomplete,
                   "Merge even if pixels or samples are missing; the header records this");
  command.add_flag("--float", arguments->options.full_floats,
                   "Store all layers as 32-bit floats. Default: the types of the parts; for sample ranges, 16 bits for "
                   "layers with small values");
  add_verbosity_options(command, arguments->verbosity);
  command.on_call([arguments, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    exit_code = merge_images(*arguments);
  });
}

}  // namespace sheaf
