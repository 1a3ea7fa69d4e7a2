// sheaf merge: merges parts of an image, which are tiles or ranges of samples.
#include "core/error.h"
#include "core/output_file.h"
#include "core/saturate.h"
#include "kernels/film/noise.h"
#include "tools/commands.h"
#include "tools/image_files.h"
#include "tools/interrupted_image.h"
#include "tools/parts.h"
#include "tools/render_summary.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

struct MergeArguments {
  std::vector<std::string> parts, outputs;
  OutputArguments output;
  std::vector<int> crop;  ///< empty or x0, y0, x1, y1
  bool incomplete = false, full_floats = false;
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

/// Pixels of the merged image: the crop window if given, otherwise the frame, or with --incomplete the bounds of all
/// parts.
PixelRect choose_whole(const MergeArguments& arguments, const std::vector<PartFile>& files) {
  const PixelRect frame{0, 0, files.front().frame_width, files.front().frame_height};
  if (arguments.crop.empty()) {
    if (!arguments.incomplete) return frame;
    PixelRect around = files.front().part.pixels;
    for (const PartFile& file : files) {
      const PixelRect& p = file.part.pixels;
      around = {std::min(around.x0, p.x0), std::min(around.y0, p.y0), std::max(around.x1, p.x1),
                std::max(around.y1, p.y1)};
    }
    return around;
  }
  const PixelRect crop{arguments.crop[0], arguments.crop[1], arguments.crop[2], arguments.crop[3]};
  if (crop.is_empty() || !(crop.intersection(frame) == crop))
    throw Error(ExitCode::kUsage, fmt::format("--crop {},{},{},{} is empty or reaches beyond the frame of {} x {} "
                                              "pixels",
                                              crop.x0, crop.y0, crop.x1, crop.y1, frame.x1, frame.y1));
  return crop;
}

/// Throws SceneError if parts or samples are missing.
void check_complete(const MergeArguments& arguments, const std::vector<PartFile>& files,
                    const std::vector<ImagePart>& parts, const PixelRect& whole) {
  if (arguments.incomplete) return;
  for (const PartFile& file : files)
    if (file.interrupted)
      throw SceneError({file.part.name, 0}, "was interrupted before it was complete (--incomplete accepts it)");
  const std::uint32_t samples = files.front().samples_per_pixel;
  if (const auto gap = find_gap(parts, whole, samples))
    throw SceneError(
        fmt::format("the parts are incomplete: pixels {},{},{},{} lack {} (accept this with --incomplete, or merge a "
                    "region with --crop)",
                    gap->pixels.x0, gap->pixels.y0, gap->pixels.x1, gap->pixels.y1,
                    gap->samples == SampleRange{0, samples}
                        ? "all samples"
                        : fmt::format("samples {}:{} of {}", gap->samples.first, gap->samples.count, samples)));
}

/// Cryptomatte ids by index of name, from the first header that has them.
std::array<std::vector<float>, kNameKinds> find_ids(const std::vector<PartFile>& files) {
  std::array<std::vector<float>, kNameKinds> ids;
  for (std::size_t kind = 0; kind < kNameKinds; ++kind)
    for (const PartFile& file : files)
      if (ids[kind].empty()) {
        const auto found = ids_from_attribute(file.text(part_id_attribute(kind)));
        if (!found) throw SceneError({file.part.name, 0}, "the list of ids in the header is malformed");
        ids[kind] = *found;
      }
  return ids;
}

/// Mean number of samples per pixel.
double mean_samples(const Image& image) {
  const int count = image.find_channel("sampleCount");
  double samples = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) samples += static_cast<double>(image.at(x, y, count));
  return samples / static_cast<double>(image.pixel_count());
}

void mark_interrupted(ExrMetadata& metadata, double taken, std::uint32_t planned) {
  for (ExrMetadata::Attribute& attribute : metadata.attributes)
    if (attribute.name == "sheaf/samplesPerPixel") attribute.value = saturate<int>(std::round(taken));
  add_interrupted_attributes(metadata, taken, planned);
}

int merge_images(const MergeArguments& arguments) {
  const std::vector<fs::path> outputs = check_outputs(arguments);
  const OutputSettings settings = output_settings(arguments.output);
  // Read and check the headers of all parts.
  std::vector<PartFile> files;
  std::vector<ImagePart> parts;
  bool has_denoised = false, interrupted = false;
  for (const std::string& path : arguments.parts) {
    check_is_exr(path);
    files.push_back(read_part_header(path));
    check_same_image(files.front(), files.back());
    parts.push_back(files.back().part);
    has_denoised |= files.back().has_denoised;
    interrupted |= files.back().interrupted;
  }
  const PixelRect whole = choose_whole(arguments, files);
  const PartFile& first = files.front();
  check_overlaps(parts);
  check_complete(arguments, files, parts, whole);
  if (whole.area() * first.channels.size() * sizeof(float) > kMaxImageBytes)
    throw SceneError({first.part.name, 0}, "is part of an image that is too large");
  // Merge the parts.
  ImageMerger merger(first.frame_width, first.frame_height, whole, first.channels, first.samples_per_pixel,
                     find_ids(files));
  for (const ImagePart& part : parts) merger.add(part, read_exr(part.name));
  // Make the metadata of the merged image.
  ExrMetadata metadata = whole_metadata(files);
  if (arguments.full_floats) metadata.half_channels.clear();
  const Image image = merger.finish();
  const bool is_noise_known = !is_noise_unknown(merger.pixels_without_variance(), image.pixel_count());
  const std::optional<double> noise = is_noise_known ? image_noise(image) : std::nullopt;
  std::erase_if(metadata.attributes, [](const auto& attribute) { return attribute.name == kNoiseAttribute; });
  if (noise) metadata.attributes.push_back({kNoiseAttribute, static_cast<float>(*noise)});
  const double share = covered_share(parts, whole, first.samples_per_pixel);
  if (interrupted) mark_interrupted(metadata, mean_samples(image), first.samples_per_pixel);
  if (interrupted || share < 1.0)
    metadata.attributes.push_back(
        {"sheaf/incomplete", fmt::format("{:.6g} of the samples{}", share, interrupted ? ", some interrupted" : "")});
  // Write the outputs and print messages.
  const WrittenImages written = write_images(outputs, image, metadata, settings);
  if (has_denoised)
    print_note("the layers denoised.R/G/B of the parts are omitted; run 'sheaf denoise' on the merged image");
  if (const std::string text = interruption(metadata.attributes); !text.empty()) print_warning(text);
  if (interrupted || share < 1.0)
    print_warning(fmt::format("the image is incomplete: {:.4g} % of the samples{}", share * 100,
                              interrupted ? ", including interrupted parts" : ""));
  print_note(fmt::format("merged {} parts; {}", parts.size(), written_files(written)));
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
      .add_option("-o,--output", arguments->outputs,
                  std::string("Output image: ") + kOutputFormats + "; may be repeated")
      .required()
      .file();
  add_output_options(command, arguments->output);
  command
      .add_option("--crop", arguments->crop,
                  "Region of the merged image, in pixels: x0,y0,x1,y1 (x1, y1 exclusive). Default: the frame")
      .list(',', 4)
      .placeholder("x0,y0,x1,y1");
  command.add_flag("--incomplete", arguments->incomplete,
                   "Merge even if pixels or samples are missing; the header records this");
  command.add_flag("--float", arguments->full_floats,
                   "Store all layers as 32-bit floats. Default: the types of the parts; for sample ranges, 16 bits for "
                   "layers with small values");
  add_verbosity_options(command, arguments->verbosity);
  command.on_call([arguments, &exit_code] {
    set_verbosity(arguments->verbosity.verbosity());
    exit_code = merge_images(*arguments);
  });
}

}  // namespace sheaf
