#include "tools/farm/merge_parts.h"

#include "core/io/error.h"
#include "core/simd/saturate.h"
#include "kernels/film/noise.h"
#include "kernels/render/render_settings.h"
#include "tools/job/interrupted_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf {

namespace {

/// Pixels of the merged image: the crop window if given, otherwise the frame, or with --incomplete the bounds of all
/// parts.
PixelRect choose_whole(const MergeOptions& options, const std::vector<PartFile>& files) {
  const PixelRect frame{0, 0, files.front().frame_width, files.front().frame_height};
  if (options.crop.empty()) {
    if (!options.incomplete) return frame;
    PixelRect around = files.front().part.pixels;
    for (const PartFile& file : files) {
      const PixelRect& p = file.part.pixels;
      around = {std::min(around.x0, p.x0), std::min(around.y0, p.y0), std::max(around.x1, p.x1),
                std::max(around.y1, p.y1)};
    }
    return around;
  }
  const std::vector<int>& crop = options.crop;
  return checked_crop({crop[0], crop[1], crop[2], crop[3]}, frame.x1, frame.y1);
}

/// Throws SceneError if parts or samples are missing.
void check_complete(const MergeOptions& options, const std::vector<PartFile>& files,
                    const std::vector<ImagePart>& parts, const PixelRect& whole) {
  if (options.incomplete) return;
  for (const PartFile& file : files)
    if (file.interrupted)
      throw SceneError(SourceLocation{file.part.name, 0},
                       "was interrupted before it was complete (--incomplete accepts it)");
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
        if (!found) throw SceneError(SourceLocation{file.part.name, 0}, "the list of ids in the header is malformed");
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

}  // namespace

MergedImage merge_parts(const std::vector<MergeSource>& sources, const MergeOptions& options) {
  // Check the headers of all parts
  if (sources.empty()) throw Error(ExitCode::kUsage, "no parts to merge, expected at least one");
  MergedImage out;
  std::vector<PartFile> files;
  std::vector<ImagePart> parts;
  for (const MergeSource& source : sources) {
    files.push_back(source.header);
    check_same_image(files.front(), files.back());
    parts.push_back(files.back().part);
    out.has_denoised |= files.back().has_denoised;
    out.interrupted |= files.back().interrupted;
  }
  const PixelRect whole = choose_whole(options, files);
  const PartFile& first = files.front();
  check_overlaps(parts);
  check_complete(options, files, parts, whole);
  if (whole.area() * first.channels.size() * sizeof(float) > kMaxImageBytes)
    throw SceneError(SourceLocation{first.part.name, 0}, "is part of an image that is too large");
  // Merge the parts
  ImageMerger merger(first.frame_width, first.frame_height, whole, first.channels, first.samples_per_pixel,
                     find_ids(files));
  for (const MergeSource& source : sources) merger.add(source.header.part, source.read());
  // Make the metadata of the merged image
  out.metadata = whole_metadata(files);
  ExrMetadata& metadata = out.metadata;
  if (options.full_floats) metadata.half_channels.clear();
  out.image = merger.finish();
  const Image& image = out.image;
  const bool is_noise_known = !is_noise_unknown(merger.pixels_without_variance(), image.pixel_count());
  const std::optional<double> noise = is_noise_known ? image_noise(image) : std::nullopt;
  std::erase_if(metadata.attributes, [](const auto& attribute) { return attribute.name == kNoiseAttribute; });
  if (noise) metadata.attributes.push_back({kNoiseAttribute, static_cast<float>(*noise)});
  out.sampled_fraction = covered_fraction(parts, whole, first.samples_per_pixel);
  if (out.interrupted) mark_interrupted(metadata, mean_samples(image), first.samples_per_pixel);
  if (out.interrupted || out.sampled_fraction < 1.0)
    metadata.attributes.push_back({"sheaf/incomplete", fmt::format("{:.6g} of the samples{}", out.sampled_fraction,
                                                                   out.interrupted ? ", some interrupted" : "")});
  return out;
}

}  // namespace sheaf
