// sheaf convert: writes a rendered image in other formats, exposed and tone-mapped.
#include "core/image/exr.h"
#include "core/io/error.h"
#include "tools/cli/commands.h"
#include "tools/cli/render_summary.h"
#include "tools/console/messages.h"
#include "tools/job/image_files.h"
#include "tools/job/interrupted_image.h"

#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

struct ConvertArguments {
  std::string input;
  std::vector<std::string> outputs;
  OutputArguments output;
  VerbosityArguments verbosity;
};

int convert_image(const ConvertArguments& arguments) {
  // Check the outputs before any work
  const NamedFile input{"the input image", arguments.input};
  const std::vector<NamedFile> named = named_images(arguments.outputs);
  check_overwriting(named, {&input, 1});
  check_all_writable(named);
  const OutputSettings settings = output_settings(arguments.output);
  // Read the image and write it
  check_is_exr(arguments.input);
  const Image image = read_exr(arguments.input);
  const ExrMetadata metadata = read_exr_metadata(arguments.input);
  const std::vector<fs::path> outputs(arguments.outputs.begin(), arguments.outputs.end());
  const WrittenImages written = write_images(outputs, image, metadata, settings);
  if (const std::string text = interruption(metadata.attributes); !text.empty()) print_warning(text);
  if (!written.files.empty()) print_note(written_files(written));
  return static_cast<int>(written.files.size() == outputs.size() ? ExitCode::kDone : ExitCode::kOutput);
}

}  // namespace

void add_convert_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<ConvertArguments>();
  Command command = program.add_command(
      "convert", "Convert an OpenEXR image to other formats, with exposure and tone map, or to another compression.");
  command.add_option("image", arguments->input, "Input image, .exr").required().file();
  command
      .add_option("-o,--output", arguments->outputs, fmt::format("Output image: {}; may be repeated", kOutputFormats))
      .required()
      .file();
  add_output_options(command, arguments->output);
  add_verbosity_options(command, arguments->verbosity);
  command.on_call([arguments, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    exit_code = convert_image(*arguments);
  });
}

}  // namespace sheaf
