#include "tools/job/parts.h"

#include "core/io/error.h"
#include "core/io/inflate.h"
#include "core/io/version.h"
#include "kernels/film/aovs.h"
#include "tools/job/interrupted_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace sheaf {

namespace {

constexpr const char* kSettings = "sheaf/settings";
constexpr const char* kSamples = "sheaf/samples";
constexpr const char* kSamplesPerPixel = "sheaf/samplesPerPixel";
constexpr const char* kIsa = "sheaf/isa";
constexpr std::uint32_t kMaxSamples = 1u << 24;

/// Attributes that all parts of a render share, besides the version.
constexpr std::array<std::pair<const char*, const char*>, 4> kSame = {{{"sheaf/seed", "the seed"},
                                                                       {"sheaf/integrator", "the integrator"},
                                                                       {"sheaf/sampler", "the sampler"},
                                                                       {"sheaf/color", "the color mode"}}};
/// Attributes that are summed over the parts.
constexpr std::array<const char*, 2> kSums = {"sheaf/droppedRays", "sheaf/droppedSamples"};

std::optional<SampleRange> samples_from_text(std::string_view text) {
  SampleRange samples;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, samples.first);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != ':') return std::nullopt;
  const auto count = std::from_chars(first.ptr + 1, end, samples.count);
  if (count.ec != std::errc() || count.ptr != end || samples.count == 0) return std::nullopt;
  if (samples.first > kMaxSamples || samples.count > kMaxSamples) return std::nullopt;
  return samples;
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// The first line of `a` that is not in `b`; an empty string if all are.
std::string first_only_in(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  for (const std::string& line : a)
    if (std::find(b.begin(), b.end(), line) == b.end()) return line;
  return "";
}

template <class Value> void set(ExrMetadata& metadata, const std::string& name, Value value) {
  for (ExrMetadata::Attribute& attribute : metadata.attributes)
    if (attribute.name == name) {
      attribute.value = std::move(value);
      return;
    }
  metadata.attributes.push_back({name, std::move(value)});
}

/// A counter in the header of a part. Throws SceneError.
double count_in(const PartFile& part, const char* name) {
  constexpr double kMaxCount = 0x1p53;
  const std::optional<double> count = part.number(name);
  if (count && *count >= 0 && *count <= kMaxCount) return *count;
  throw SceneError(SourceLocation{part.part.name, 0},
                   fmt::format("the attribute '{}' in the header is not a number", name));
}

}  // namespace

SampleRange parse_samples(const std::string& text) {
  if (const auto samples = samples_from_text(text)) return *samples;
  throw Error(ExitCode::kUsage, fmt::format("--samples '{}': expected FIRST:COUNT, such as 64:32", text));
}

std::string part_settings(const RecordedSettings& settings) {
  /// Maximum number of files listed individually.
  constexpr std::size_t kMaxFiles = 16;
  std::string options, files;
  std::size_t count = 0;
  for (const auto& [name, value, kind] : settings) {
    if (kind == RecordedSetting::Kind::kOption) options += fmt::format("{} {}\n", name, value);
    if (kind != RecordedSetting::Kind::kFile) continue;
    files += fmt::format("{}: {}\n", name, value);
    ++count;
  }
  if (count > kMaxFiles) {
    const std::uint32_t sum = check_sum({files.data(), files.size()}, 0);
    files = fmt::format("{} files of the scene: {:08x}\n", count, sum);
  }
  return options + files;
}

void add_part_attributes(ExrMetadata& metadata, const std::string& settings,
                         const std::optional<SampleRange>& samples) {
  metadata.attributes.push_back({kSettings, settings});
  if (!samples) return;
  metadata.attributes.push_back({kSamples, fmt::format("{}:{}", samples->first, samples->count)});
  metadata.half_channels.clear();
}

std::string PartFile::text(std::string_view name) const {
  for (const ExrMetadata::Attribute& attribute : metadata.attributes)
    if (attribute.name == name)
      return std::visit([](const auto& value) { return fmt::format("{}", value); }, attribute.value);
  return "";
}

std::optional<double> PartFile::number(std::string_view name) const {
  for (const ExrMetadata::Attribute& attribute : metadata.attributes)
    if (attribute.name == name) return number_of(attribute);
  return std::nullopt;
}

namespace {

/// A part with this header. `source`: for messages. `channels`: in alphabetical order, as in files.
PartFile make_part(const std::string& source, const PixelRect& frame, const PixelRect& window,
                   const std::vector<std::string>& channels, ExrMetadata metadata) {
  const SourceLocation where{source, 0};
  PartFile file;
  file.metadata = std::move(metadata);
  if (file.text(kSettings).empty())
    throw SceneError(where, "is not a part of an image, expected a file rendered with --samples or --crop");
  if (const std::string version = file.text(kVersionAttribute); version != kSheafVersion)
    throw SceneError(where, fmt::format("was rendered by Sheaf {0}, but this is Sheaf {1}: merge the parts with Sheaf "
                                        "{0}, or render them again",
                                        version, kSheafVersion));
  // Read the windows.
  const auto beyond = [](const PixelRect& rect) {
    return std::abs(static_cast<long long>(rect.x0)) > kMaxImageSide ||
           std::abs(static_cast<long long>(rect.y0)) > kMaxImageSide || rect.x1 < rect.x0 || rect.y1 < rect.y0 ||
           static_cast<long long>(rect.x1) - rect.x0 > kMaxImageSide ||
           static_cast<long long>(rect.y1) - rect.y0 > kMaxImageSide;
  };
  if (beyond(frame) || beyond(window) || window.is_empty() || !(window.intersection(frame) == window))
    throw SceneError(where, "the data window exceeds the frame or is too large");
  file.frame_width = frame.width();
  file.frame_height = frame.height();
  file.part.name = source;
  file.part.pixels = {window.x0 - frame.x0, window.y0 - frame.y0, window.x1 - frame.x0, window.y1 - frame.y0};
  // For interrupted parts, sheaf/samplesPerPixel is the number taken, so the planned number overrides it.
  for (const char* const name : {kSamplesPerPixel, kSamplesPlannedAttribute})
    for (const ExrMetadata::Attribute& attribute : file.metadata.attributes)
      if (const int* count = std::get_if<int>(&attribute.value); count != nullptr && attribute.name == name)
        if (*count > 0 && *count <= static_cast<int>(kMaxSamples))
          file.samples_per_pixel = static_cast<std::uint32_t>(*count);
  if (file.samples_per_pixel == 0) throw SceneError(where, "the header lacks the number of samples per pixel");
  file.part.samples = {0, file.samples_per_pixel};
  file.interrupted = !interruption(file.metadata.attributes).empty();
  if (const std::string text = file.text(kSamples); !text.empty()) {
    const std::optional<SampleRange> samples = samples_from_text(text);
    if (!samples || samples->end() > file.samples_per_pixel)
      throw SceneError(
          where, fmt::format("the header gives the invalid sample range '{}' of {}", text, file.samples_per_pixel));
    file.part.samples = *samples;
    file.some_samples = true;
  }
  // Collect the channels.
  bool counts = false;
  for (const std::string& channel : channels) {
    counts |= channel == "sampleCount";
    file.has_denoised |= channel.starts_with("denoised.");
    if (!is_left_out(channel)) file.channels.push_back(channel);
  }
  if (!counts) throw SceneError(where, "lacks the layer sampleCount, which merging requires");
  return file;
}

}  // namespace

PartFile read_part_header(const std::filesystem::path& path) {
  const ExrHeader header = read_exr_header(path);
  std::vector<std::string> channels;
  for (const ExrHeader::Channel& channel : header.channels) channels.push_back(channel.name);
  return make_part(path.string(), header.frame, header.window, channels, read_exr_metadata(path));
}

PartFile part_in_memory(const std::string& name, const Image& image, const ExrMetadata& metadata) {
  std::vector<std::string> channels = image.channels;
  std::sort(channels.begin(), channels.end());
  return make_part(name, {0, 0, image.frame_width, image.frame_height},
                   {image.x0, image.y0, image.x0 + image.width, image.y0 + image.height}, channels, metadata);
}

void check_same_image(const PartFile& first, const PartFile& other) {
  const SourceLocation where{other.part.name, 0};
  const auto fail = [&](const std::string& what, const std::string& here, const std::string& there) {
    throw SceneError(where, fmt::format("is not a part of the same image as '{}': {} is '{}' here and '{}' there",
                                        first.part.name, what, here, there));
  };
  // Compare attributes, sizes and settings
  for (const auto& [name, what] : kSame)
    if (first.text(name) != other.text(name)) fail(what, other.text(name), first.text(name));
  const auto size = [](const PartFile& file) { return fmt::format("{}x{}", file.frame_width, file.frame_height); };
  if (size(first) != size(other)) fail("the size of the frame", size(other), size(first));
  if (first.samples_per_pixel != other.samples_per_pixel)
    fail("the number of samples per pixel", std::to_string(other.samples_per_pixel),
         std::to_string(first.samples_per_pixel));
  const std::vector<std::string> here = lines_of(other.text(kSettings)), there = lines_of(first.text(kSettings));
  if (here != there) {
    const std::string only_here = first_only_in(here, there), only_there = first_only_in(there, here);
    fail("a setting", only_here.empty() ? "not given" : only_here, only_there.empty() ? "not given" : only_there);
  }
  // Compare the layers
  if (first.channels == other.channels) return;
  const std::string more = first_only_in(other.channels, first.channels);
  throw SceneError(where, fmt::format("is not a part of the same image as '{}': the layer '{}' is {}", first.part.name,
                                      more.empty() ? first_only_in(first.channels, other.channels) : more,
                                      more.empty() ? "only there" : "only here"));
}

ExrMetadata whole_metadata(const std::vector<PartFile>& parts) {
  // Parts with all samples have the pixel types of the merged image.
  const auto typed = std::find_if(parts.begin(), parts.end(), [](auto& part) { return !part.some_samples; });
  ExrMetadata whole = typed != parts.end() ? typed->metadata : parts.front().metadata;
  if (typed == parts.end()) whole.half_channels = half_channels(parts.front().channels);
  std::erase_if(whole.half_channels, [](const std::string& channel) { return is_left_out(channel); });
  std::erase_if(whole.attributes, [](const ExrMetadata::Attribute& attribute) {
    const std::string& name = attribute.name;
    return name == kSettings || name == kSamples || name == kInterruptedAttribute || name == kSamplesTakenAttribute ||
           name == kSamplesPlannedAttribute || name == kCommandLineAttribute || name == kRenderSecondsAttribute ||
           name == "sheaf/denoiser" || name.starts_with("sheaf/ids/");
  });
  set(whole, kSamplesPerPixel, static_cast<int>(parts.front().samples_per_pixel));
  // Combine the dates and instruction sets.
  std::vector<std::string> isas;
  for (const PartFile& part : parts) {
    // The date format sorts chronologically.
    if (part.metadata.capture_date && whole.capture_date)
      whole.capture_date = std::max(*whole.capture_date, *part.metadata.capture_date);
    const std::string isa = part.text(kIsa);
    if (std::find(isas.begin(), isas.end(), isa) == isas.end()) isas.push_back(isa);
  }
  std::sort(isas.begin(), isas.end());
  set(whole, kIsa, fmt::format("{}", fmt::join(isas, ", ")));
  // Sum the counters, and the times if all parts have them.
  for (const char* const name : kSums) {
    double sum = 0;
    for (const PartFile& part : parts) sum += count_in(part, name);
    set(whole, name, integer_attribute(name, static_cast<std::uint64_t>(sum)).value);
  }
  const auto seconds_of = [](const PartFile& part) { return part.number(kRenderSecondsAttribute); };
  if (std::all_of(parts.begin(), parts.end(), [&](const PartFile& part) { return seconds_of(part).has_value(); })) {
    double seconds = 0;
    for (const PartFile& part : parts) seconds += *seconds_of(part);
    set(whole, kRenderSecondsAttribute, static_cast<float>(seconds));
  }
  return whole;
}

}  // namespace sheaf
