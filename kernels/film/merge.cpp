#include "kernels/film/merge.h"

#include "core/io/error.h"
#include "kernels/film/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

namespace sheaf {

namespace {

constexpr std::string_view kVariancePrefix = "variance.", kHalfPrefix = "half.", kCountChannel = "sampleCount";

/// Offsets of the sums in a pixel's row that all channels share.
enum Shared : std::size_t { kWeight, kWeightSquared, kHalfWeight, kShared };

bool have_common(const SampleRange& a, const SampleRange& b) { return a.first < b.end() && b.first < a.end(); }

bool is_id(std::string_view channel) {
  return channel == "objectId" || channel == "materialId" || channel.starts_with("CryptoObject0") ||
         channel.starts_with("CryptoMaterial0");
}

/// First run of samples in [0, samples) that no range contains; nothing if there is no gap.
std::optional<SampleRange> first_gap(std::vector<SampleRange> ranges, std::uint32_t samples) {
  std::sort(ranges.begin(), ranges.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::uint32_t at = 0;
  for (const SampleRange& range : ranges) {
    if (range.first > at) return SampleRange{at, range.first - at};
    at = std::max(at, range.end());
  }
  return at < samples ? std::optional(SampleRange{at, samples - at}) : std::nullopt;
}

}  // namespace

void check_overlaps(std::span<const ImagePart> parts) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const PixelRect both = parts[i].pixels.intersection(parts[k].pixels);
      if (both.is_empty() || !have_common(parts[i].samples, parts[k].samples)) continue;
      const SampleRange& a = parts[i].samples;
      const SampleRange& b = parts[k].samples;
      const std::uint32_t first = std::max(a.first, b.first), end = std::min(a.end(), b.end());
      throw SceneError(SourceLocation{parts[i].name, 0},
                       fmt::format("shares samples with '{}': {}:{} of pixel {},{}", parts[k].name, first, end - first,
                                   both.x0, both.y0));
    }
}

double covered_fraction(std::span<const ImagePart> parts, const PixelRect& whole, std::uint32_t samples) {
  double covered = 0;
  for (const ImagePart& part : parts)
    covered += static_cast<double>(part.pixels.intersection(whole).area()) * part.samples.count;
  return covered / (static_cast<double>(whole.area()) * samples);
}

std::optional<PartGap> find_gap(std::span<const ImagePart> parts, const PixelRect& whole, std::uint32_t samples) {
  std::uint64_t covered = 0;
  for (const ImagePart& part : parts) covered += part.pixels.intersection(whole).area() * part.samples.count;
  if (covered == whole.area() * samples) return std::nullopt;
  // All pixels of a cell between the edges of parts have the same samples.
  std::set<int> across{whole.x0, whole.x1}, down{whole.y0, whole.y1};
  for (const ImagePart& part : parts) {
    const PixelRect pixels = part.pixels.intersection(whole);
    if (pixels.is_empty()) continue;
    across.insert({pixels.x0, pixels.x1});
    down.insert({pixels.y0, pixels.y1});
  }
  for (auto y = down.begin(); std::next(y) != down.end(); ++y)
    for (auto x = across.begin(); std::next(x) != across.end(); ++x) {
      const PixelRect cell{*x, *y, *std::next(x), *std::next(y)};
      std::vector<SampleRange> ranges;
      for (const ImagePart& part : parts)
        if (!part.pixels.intersection(cell).is_empty()) ranges.push_back(part.samples);
      if (const auto gap = first_gap(std::move(ranges), samples)) return PartGap{cell, *gap};
    }
  return std::nullopt;
}

bool is_left_out(std::string_view channel) { return channel.starts_with("part.") || channel.starts_with("denoised."); }

std::string missing_part_layer(const Image& part) {
  std::vector<std::string> needed{"part.weight"};
  bool variances = false, halves = false, objects = false, materials = false;
  for (const std::string& channel : part.channels) {
    if (channel.starts_with(kVariancePrefix)) {
      variances = true;
      const std::string of = channel.substr(kVariancePrefix.size());
      for (const char* const prefix : {"", "part.scatter.", "part.cross."}) needed.push_back(prefix + of);
    }
    halves |= channel.starts_with(kHalfPrefix);
    objects |= channel == "objectId" || channel.starts_with("CryptoObject0");
    materials |= channel == "materialId" || channel.starts_with("CryptoMaterial0");
  }
  if (variances) needed.emplace_back("part.weightSquared");
  if (halves) needed.emplace_back("part.halfWeight");
  for (const std::string& name : needed)
    if (part.find_channel(name) < 0) return name;
  if (objects && !PartIds(part, 0).any()) return "part.object.number0";
  if (materials && !PartIds(part, 1).any()) return "part.material.number0";
  return "";
}

ImageMerger::ImageMerger(int frame_width, int frame_height, const PixelRect& whole,
                         const std::vector<std::string>& channels, std::uint32_t samples,
                         std::array<std::vector<float>, kNameKinds> ids)
    : image_(whole.width(), whole.height(), channels),
      whole_(whole),
      samples_(samples),
      ids_(std::move(ids)),
      channels_(channels.size()),
      row_size_(kShared) {
  image_.x0 = whole.x0;
  image_.y0 = whole.y0;
  image_.frame_width = frame_width;
  image_.frame_height = frame_height;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::string& name = channels[c];
    Channel& channel = channels_[c];
    channel.sum = row_size_;
    channel.rule = name.starts_with(kVariancePrefix) ? Rule::kVariance
                   : name.starts_with(kHalfPrefix)   ? Rule::kHalf
                   : name == kCountChannel           ? Rule::kCount
                   : is_id(name)                     ? Rule::kId
                                                     : Rule::kMean;
    if (channel.rule == Rule::kVariance) {
      const int mean = image_.find_channel(name.substr(kVariancePrefix.size()));
      if (mean < 0) throw SceneError(fmt::format("the layer '{}' is a variance of a missing layer", name));
      channel.mean = static_cast<std::size_t>(mean);
    }
    row_size_ += channel.rule == Rule::kVariance ? 2 : channel.rule == Rule::kId ? 0 : 1;
  }
}

std::size_t ImageMerger::pixel_index(int x, int y) const {
  return static_cast<std::size_t>(y - whole_.y0) * static_cast<std::size_t>(whole_.width()) +
         static_cast<std::size_t>(x - whole_.x0);
}

void ImageMerger::begin_sums() {
  if (!sums_.empty()) return;
  sums_.resize(image_.pixel_count() * row_size_);
  summed_.resize(image_.pixel_count());
  for (std::size_t kind = 0; kind < kNameKinds; ++kind)
    if (IdChannels(image_, kind).any()) coverage_[kind].resize(image_.pixel_count());
}

void ImageMerger::add(const ImagePart& part, const Image& image) {
  const PixelRect there{image.x0, image.y0, image.x0 + image.width, image.y0 + image.height};
  if (!(there == part.pixels))
    throw SceneError(SourceLocation{part.name, 0}, "the data window does not match the header");
  std::vector<int> from;
  for (const std::string& name : image_.channels) {
    from.push_back(image.find_channel(name));
    if (from.back() < 0) throw SceneError(SourceLocation{part.name, 0}, fmt::format("has no layer '{}'", name));
  }
  const PixelRect pixels = part.pixels.intersection(whole_);
  if (part.samples == SampleRange{0, samples_}) return copy(image, from, pixels);
  const std::string missing = missing_part_layer(image);
  if (!missing.empty())
    throw SceneError(SourceLocation{part.name, 0},
                     fmt::format("has no layer '{}', which merging sample ranges requires", missing));
  begin_sums();
  add_sums(part, image, from, pixels);
}

void ImageMerger::copy(const Image& image, const std::vector<int>& from, const PixelRect& pixels) {
  for (int y = pixels.y0; y < pixels.y1; ++y)
    for (int x = pixels.x0; x < pixels.x1; ++x)
      for (std::size_t c = 0; c < from.size(); ++c)
        image_.at(x - whole_.x0, y - whole_.y0, static_cast<int>(c)) = image.at(x - image.x0, y - image.y0, from[c]);
}

void ImageMerger::add_sums(const ImagePart& part, const Image& image, const std::vector<int>& from,
                           const PixelRect& pixels) {
  const int weight_channel = image.find_channel("part.weight");
  const int squared_channel = image.find_channel("part.weightSquared");
  const int half_channel = image.find_channel("part.halfWeight");
  std::vector<std::array<int, 2>> scatter(channels_.size());
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (channels_[c].rule == Rule::kVariance) {
      const std::string& of = image_.channels[channels_[c].mean];
      scatter[c] = {image.find_channel("part.scatter." + of), image.find_channel("part.cross." + of)};
    }
  const PartIds names[kNameKinds] = {{image, 0}, {image, 1}};
  for (int y = pixels.y0; y < pixels.y1; ++y)
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      const float* const in =
          image.data.data() + (static_cast<std::size_t>(y - image.y0) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(x - image.x0)) *
                                  image.channels.size();
      const auto value = [in](int channel) { return channel < 0 ? 0.0 : static_cast<double>(in[channel]); };
      const std::size_t pixel = pixel_index(x, y);
      double* const row = sums_.data() + pixel * row_size_;
      const double weight = value(weight_channel), squared = value(squared_channel), half = value(half_channel);
      // Add the sums of weights and of all channels.
      summed_[pixel] = 1;
      row[kWeight] += weight;
      row[kWeightSquared] += squared;
      row[kHalfWeight] += half;
      for (std::size_t c = 0; c < channels_.size(); ++c) {
        const Channel& channel = channels_[c];
        double* const sum = row + channel.sum;
        switch (channel.rule) {
          case Rule::kMean:
            *sum += weight * value(from[c]);
            break;
          case Rule::kHalf:
            *sum += half * value(from[c]);
            break;
          case Rule::kCount:
            *sum += value(from[c]);
            break;
          case Rule::kId:
            break;
          case Rule::kVariance: {
            const double mean = value(from[channel.mean]), cross = value(scatter[c][1]);
            sum[0] += value(scatter[c][0]) + 2.0 * mean * cross + mean * mean * squared;
            sum[1] += cross + mean * squared;
          }
        }
      }
      // Add the weights of ids.
      for (std::size_t kind = 0; kind < kNameKinds; ++kind)
        if (!coverage_[kind].empty() && !names[kind].add(in, coverage_[kind][pixel]))
          throw SceneError(SourceLocation{part.name, 0}, "contains an invalid object or material number");
    }
}

void ImageMerger::finish_pixel(const double* row, float* out) const {
  const double weight = row[kWeight], half = row[kHalfWeight];
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const double* const sum = row + channels_[c].sum;
    switch (channels_[c].rule) {
      case Rule::kCount:
        out[c] = static_cast<float>(*sum);
        break;
      // As in films, negative filter lobes can leave no positive weight.
      case Rule::kMean:
        out[c] = weight > 0.0 ? static_cast<float>(*sum / weight) : 0.0f;
        break;
      case Rule::kHalf:
        out[c] = weight > 0.0 && half > 0.0 ? static_cast<float>(*sum / half) : 0.0f;
        break;
      case Rule::kVariance: {
        const double mean = row[channels_[channels_[c].mean].sum] / weight;
        out[c] = weight > 0.0
                     ? static_cast<float>(std::min(variance_of_mean(mean, weight, row[kWeightSquared], sum[0], sum[1]),
                                                   kLargestVariance))
                     : 0.0f;
        break;
      }
      case Rule::kId:
        break;
    }
  }
}

Image ImageMerger::finish() {
  const IdChannels id_channels[kNameKinds] = {{image_, 0}, {image_, 1}};
  for (std::size_t pixel = 0; pixel < summed_.size(); ++pixel) {
    if (summed_[pixel] == 0) continue;
    float* const out = image_.data.data() + pixel * image_.channels.size();
    const double* const row = sums_.data() + pixel * row_size_;
    finish_pixel(row, out);
    if (is_single_unit(row[kWeight], row[kWeightSquared])) ++single_units_;
    for (std::size_t kind = 0; kind < kNameKinds; ++kind)
      if (!coverage_[kind].empty() && !put_ids(coverage_[kind][pixel], id_channels[kind], ids_[kind], out))
        throw SceneError("a part contains an object or material number without an id in the headers");
  }
  return std::move(image_);
}

}  // namespace sheaf
