// sheaf convert: writes a rendered image, or one of its layers, in other formats, exposed and tone-mapped.
#include "core/image/exr.h"
#include "core/io/error.h"
#include "kernels/film/aovs.h"
#include "tools/cli/commands.h"
#include "tools/cli/image_layers.h"
#include "tools/cli/render_summary.h"
#include "tools/console/messages.h"
#include "tools/job/image_files.h"
#include "tools/job/interrupted_image.h"

#include <algorithm>
#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

struct ConvertArguments {
  std::string input, layer;
  std::vector<std::string> outputs;
  OutputArguments output;
  VerbosityArguments verbosity;
};

/// Writes a layer: stored values to .exr files, displayed ones to others.
WrittenImages write_layer(const std::vector<fs::path>& files, const Image& image, const std::string& layer,
                          ExrMetadata metadata, const OutputSettings& settings) {
  std::vector<fs::path> exr, others;
  for (const fs::path& file : files) (extension_of(file) == ".exr" ? exr : others).push_back(file);
  metadata.half_channels.clear();
  std::erase_if(metadata.attributes, [](const auto& attribute) { return attribute.name.starts_with("cryptomatte/"); });
  WrittenImages written = write_images(exr, layer_of(image, layer, false), metadata, settings);
  std::vector<fs::path> before = std::move(written.files);
  written = write_images(others, layer_of(image, layer, true), metadata, settings);
  written.files.insert(written.files.begin(), before.begin(), before.end());
  return written;
}

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
  const WrittenImages written = arguments.layer.empty()
                                    ? write_images(outputs, image, metadata, settings)
                                    : write_layer(outputs, image, arguments.layer, metadata, settings);
  if (const std::string text = interruption(metadata.attributes); !text.empty()) print_warning(text);
  if (!written.files.empty()) print_note(written_files(written));
  return static_cast<int>(written.files.size() == outputs.size() ? ExitCode::kDone : ExitCode::kOutput);
}

std::vector<std::string> suggested_layers() {
  std::vector<std::string> names{kImageLayer, "denoised"};
  for (const AovEntry& aov : kAovList) names.emplace_back(aov.name);
  return names;
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
  command
      .add_option("--layer", arguments->layer,
                  "Layer to write: a name of --aov, such as albedo, normal or depth; the part of a channel's name "
                  "before its last dot, such as denoised or light_lamp; or image, the channels R, G, B and A. An "
                  "unknown name lists the layers of the image. Default: to .exr all layers, otherwise denoised if the "
                  "image has it, else image")
      .placeholder("NAME")
      .suggest(suggested_layers());
  add_output_options(command, arguments->output);
  add_verbosity_options(command, arguments->verbosity);
  command.on_call([arguments, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    exit_code = convert_image(*arguments);
  });
}

}  // namespace sheaf
