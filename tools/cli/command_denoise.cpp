// sheaf denoise: reads a rendered image, denoises it and writes it to all outputs.
#include "core/image/exr.h"
#include "core/io/error.h"
#include "core/io/output_file.h"
#include "kernels/denoise/denoise.h"
#include "tools/cli/commands.h"
#include "tools/cli/render_summary.h"
#include "tools/console/duration.h"
#include "tools/job/image_files.h"
#include "tools/job/interrupted_image.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

struct DenoiseArguments {
  std::string input, method = "nlm";
  std::vector<std::string> outputs;
  OutputArguments output;
  int threads = 0;
  VerbosityArguments verbosity;
};

std::vector<fs::path> check_outputs(const DenoiseArguments& arguments) {
  const NamedFile input{"the input image", arguments.input};
  const std::vector<NamedFile> outputs = named_images(arguments.outputs);
  check_overwriting(outputs, {&input, 1});
  check_all_writable(outputs);
  return {arguments.outputs.begin(), arguments.outputs.end()};
}

int denoise_image(const DenoiseArguments& arguments) {
  const std::vector<fs::path> outputs = check_outputs(arguments);
  const OutputSettings settings = output_settings(arguments.output);
  const Denoiser denoiser = kDenoisers.option("denoiser", arguments.method);
  check_denoiser(denoiser);
  check_is_exr(arguments.input);
  const Image image = read_exr(arguments.input);
  ExrMetadata metadata = read_exr_metadata(arguments.input);
  const auto start = std::chrono::steady_clock::now();
  const DenoiseResult result = denoise(image, denoiser, arguments.threads);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  add_denoise_attribute(metadata, result);
  const WrittenImages written = write_images(outputs, result.image, metadata, settings);
  if (const std::string text = interruption(metadata.attributes); !text.empty()) print_warning(text);
  print_note(fmt::format("denoised in {} ({}); {}", format_duration(elapsed.count()), result.description,
                         written_files(written)));
  return static_cast<int>(written.files.size() == outputs.size() ? ExitCode::kDone : ExitCode::kOutput);
}

}  // namespace

void add_denoise_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<DenoiseArguments>();
  Command command = program.add_command("denoise",
                                        "Denoise a rendered image. Requires the layers variance.R/G/B. The layers "
                                        "half.R/G/B, albedo.R/G/B, N.X/Y/Z and Z improve the result.");
  command.add_option("image", arguments->input, "Input image, .exr").required().file();
  command
      .add_option("-o,--output", arguments->outputs,
                  fmt::format("Output image: {}; may be repeated. .exr files get the input's layers and "
                              "denoised.R/G/B, others show the denoised image",
                              kOutputFormats))
      .required()
      .file();
  add_output_options(command, arguments->output);
  command
      .add_option("--method", arguments->method,
                  "Denoiser: nlm (non-local means, the default) or oidn (Open Image Denoise, if installed)")
      .one_of(kDenoisers.names());
  command.add_option("--threads", arguments->threads, "Worker threads. Default: 0, one per logical core")
      .in_range(0, 4096);
  add_verbosity_options(command, arguments->verbosity);
  command.on_call([arguments, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    exit_code = denoise_image(*arguments);
  });
}

}  // namespace sheaf
