#include "kernels/film/film.h"

#include "core/color/color.h"
#include "kernels/film/more_channels.h"
#include "kernels/film/noise.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace sheaf {

namespace {

/// Width of a bin, nm.
double bin_width(int bins) { return static_cast<double>(kWavelengthMax - kWavelengthMin) / bins; }

/// Name of a bin's channel: its center in nm, with six decimals after a comma.
std::string bin_channel(int bin, int bins) {
  std::string center = fmt::format("{:f}", static_cast<double>(kWavelengthMin) + (bin + 0.5) * bin_width(bins));
  std::replace(center.begin(), center.end(), '.', ',');
  return fmt::format("S0.{}nm", center);
}

/// Rows of pixels per parallel work item of adding borders.
constexpr int kBand = 32;

}  // namespace

Film::Film(int frame_width, int frame_height, PixelRect crop, FilmLayout layout, int spectral_bins, VarianceUnit unit,
           bool has_surface_ids)
    : frame_width_(frame_width),
      frame_height_(frame_height),
      crop_(crop),
      layout_(std::move(layout)),
      unit_(unit),
      row_(layout_, spectral_bins, unit == VarianceUnit::kSample),
      counts_(static_cast<std::size_t>(crop.width()) * static_cast<std::size_t>(crop.height())),
      sums_(counts_.size() * row_.film_size()),
      open_(unit == VarianceUnit::kReplicate && row_.variances > 0 ? counts_.size() * (1 + row_.variances) : 0),
      half_(layout_.half_count() > 0 ? counts_.size() * (1 + static_cast<std::size_t>(layout_.half_count())) : 0),
      coverage_(has_surface_ids ? counts_.size() : 0) {}

void Film::add(int x, int y, const double* sums) {
  const std::size_t pixel = pixel_index(x, y);
  double* row = sums_.data() + pixel * row_.film_size();
  const auto add_group = [&](std::size_t from, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) *row++ += sums[from + k];
  };
  add_group(0, row_.film_squares_at());
  add_group(row_.weight_squared, row_.tile_squares);
  row += row_.squares() - row_.tile_squares;
  add_group(row_.bins_at, row_.bins);
  if (open_.empty()) return;
  double* open = open_.data() + pixel * (1 + row_.variances);
  *open++ += sums[FilmRow::kWeight];
  for (const std::size_t c : row_.with_variance) *open++ += sums[FilmRow::kSums + c];
}

void Film::add(const FilmTile& tile) {
  for (int y = tile.own().y0; y < tile.own().y1; ++y)
    for (int x = tile.own().x0; x < tile.own().x1; ++x) {
      counts_[pixel_index(x, y)] += tile.count(x, y);
      add(x, y, tile.row(x, y));
      if (has_surface_ids()) coverage_[pixel_index(x, y)].add(tile.coverage(x, y));
    }
}

void Film::add(std::span<const FilmBorder> borders) {
  const int bands = (crop_.height() + kBand - 1) / kBand;
  tbb::parallel_for(0, bands, [&](int band) {
    const PixelRect rows{crop_.x0, crop_.y0 + band * kBand, crop_.x1,
                         std::min(crop_.y0 + (band + 1) * kBand, crop_.y1)};
    for (const FilmBorder& border : borders)
      for (const FilmBorder::Strip& strip : border.strips) {
        const PixelRect pixels = strip.pixels.intersection(rows);
        for (int y = pixels.y0; y < pixels.y1; ++y) {
          const auto line = static_cast<std::size_t>(y - strip.pixels.y0) *
                            static_cast<std::size_t>(strip.pixels.width()) * row_.size();
          for (int x = pixels.x0; x < pixels.x1; ++x) {
            const std::size_t at = line + static_cast<std::size_t>(x - strip.pixels.x0) * row_.size();
            add(x, y, strip.sums.data() + at);
            if (has_surface_ids()) coverage_[pixel_index(x, y)].add(strip.coverage[at / row_.size()]);
          }
        }
      }
  });
}

void Film::end_replicate() {
  if (open_.empty()) return;
  const std::size_t numbers = 1 + row_.variances;
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel) {
    const double* const open = open_.data() + pixel * numbers;
    double* square = sums_.data() + pixel * row_.film_size() + row_.film_squares_at();
    *square++ += open[0] * open[0];
    for (std::size_t k = 1; k < numbers; ++k) {
      *square++ += open[k] * open[k];
      *square++ += open[k] * open[0];
    }
  }
  std::fill(open_.begin(), open_.end(), 0.0);
}

void Film::end_first_half() {
  if (half_.empty()) return;
  double* half = half_.data();
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel) {
    const double* const row = sums_.data() + pixel * row_.film_size();
    *half++ = row[FilmRow::kWeight];
    for (std::size_t c = 0; c < row_.channels; ++c)
      if (layout_.channels()[c].has_half) *half++ = row[FilmRow::kSums + c];
  }
}

/// `out`: the image's channels, in order.
void Film::write_pixel(std::size_t pixel, float* out) const {
  const double* const row = sums_.data() + pixel * row_.film_size();
  const double weight = row[FilmRow::kWeight];
  out[row_.channels + row_.variances] = static_cast<float>(counts_[pixel]);
  // With few samples, the negative lobes of a filter can leave no positive weight.
  if (!(weight > 0.0)) return;
  for (std::size_t c = 0; c < row_.channels; ++c) out[c] = static_cast<float>(row[FilmRow::kSums + c] / weight);
  const double* const squares = row + row_.film_squares_at();
  for (std::size_t k = 0; k < row_.variances; ++k)
    out[row_.channels + k] =
        static_cast<float>(std::min(variance_of_mean(row[FilmRow::kSums + row_.with_variance[k]] / weight, weight,
                                                     squares[0], squares[1 + 2 * k], squares[2 + 2 * k]),
                                    kLargestVariance));
  for (std::size_t bin = 0; bin < row_.bins; ++bin)
    out[row_.channels + row_.variances + 1 + bin] =
        static_cast<float>(row[row_.film_bins_at() + bin] / (weight * bin_width(spectral_bins())));
  if (half_.empty()) return;
  const std::size_t halves = half_.size() / counts_.size() - 1;
  const double* const half = half_.data() + pixel * (1 + halves);
  if (!(half[0] > 0.0)) return;
  for (std::size_t k = 0; k < halves; ++k)
    out[row_.channels + row_.variances + 1 + row_.bins + k] = static_cast<float>(half[1 + k] / half[0]);
}

std::optional<double> Film::noise() const {
  constexpr std::size_t kComponents = 3;
  if (row_.variances < kComponents || row_.with_variance[kComponents - 1] != kBlue) return std::nullopt;
  std::vector<float> channels(row_.channels + row_.variances + 1 + row_.bins +
                              static_cast<std::size_t>(layout_.half_count()));
  ImageNoise noise;
  std::size_t unknown = 0;
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel) {
    std::fill(channels.begin(), channels.end(), 0.0f);
    write_pixel(pixel, channels.data());
    noise.add(channels.data(), channels.data() + row_.channels);
    const double* const row = sums_.data() + pixel * row_.film_size();
    if (counts_[pixel] == 0 || is_single_unit(row[FilmRow::kWeight], row[row_.film_squares_at()])) ++unknown;
  }
  if (is_noise_unknown(unknown, counts_.size())) return std::nullopt;
  return noise.noise();
}

double Film::mean_samples() const {
  double samples = 0;
  for (const std::uint64_t count : counts_) samples += static_cast<double>(count);
  return counts_.empty() ? 0.0 : samples / static_cast<double>(counts_.size());
}

void Film::clear() {
  std::fill(counts_.begin(), counts_.end(), 0);
  for (std::vector<double>* const numbers : {&sums_, &open_, &half_}) std::fill(numbers->begin(), numbers->end(), 0.0);
  std::fill(coverage_.begin(), coverage_.end(), IdCoverage());
}

Image Film::to_image() const {
  std::vector<std::string> names;
  for (const FilmChannel& channel : layout_.channels()) names.push_back(channel.name);
  for (const FilmChannel& channel : layout_.channels())
    if (channel.has_variance) names.push_back("variance." + channel.name);
  names.emplace_back("sampleCount");
  for (int bin = 0; bin < spectral_bins(); ++bin) names.push_back(bin_channel(bin, spectral_bins()));
  for (const FilmChannel& channel : layout_.channels())
    if (channel.has_half) names.push_back("half." + channel.name);
  Image image = empty_image(std::move(names));
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel)
    write_pixel(pixel, image.data.data() + pixel * image.channels.size());
  return image;
}

Image Film::empty_image(std::vector<std::string> channels) const {
  Image image(crop_.width(), crop_.height(), std::move(channels));
  image.x0 = crop_.x0;
  image.y0 = crop_.y0;
  image.frame_width = frame_width_;
  image.frame_height = frame_height_;
  return image;
}

Image Film::beauty_image() const {
  std::vector<std::string> names;
  std::vector<std::size_t> sources;
  for (std::size_t c = 0; c < layout_.channels().size(); ++c) {
    const std::string& name = layout_.channels()[c].name;
    if (name != "R" && name != "G" && name != "B" && name != "A") continue;
    names.push_back(name);
    sources.push_back(c);
  }
  Image image = empty_image(std::move(names));
  tbb::parallel_for(0, crop_.height(), [&](int y) {
    const std::size_t width = static_cast<std::size_t>(crop_.width()), begin = static_cast<std::size_t>(y) * width;
    for (std::size_t pixel = begin; pixel < begin + width; ++pixel) {
      const double* const row = sums_.data() + pixel * row_.film_size();
      const double weight = row[FilmRow::kWeight];
      if (!(weight > 0.0)) continue;
      float* const out = image.data.data() + pixel * sources.size();
      for (std::size_t k = 0; k < sources.size(); ++k)
        out[k] = static_cast<float>(row[FilmRow::kSums + sources[k]] / weight);
    }
  });
  return image;
}

void Film::add_part_layers(Image& image) const {
  std::vector<std::string> names{"part.weight"};
  if (row_.variances > 0) names.emplace_back("part.weightSquared");
  for (const std::size_t c : row_.with_variance)
    for (const char* const kind : {"part.scatter.", "part.cross."}) names.push_back(kind + layout_.channels()[c].name);
  if (!half_.empty()) names.emplace_back("part.halfWeight");
  const std::size_t first = image.channels.size();
  image = with_channels(image, names);
  const std::size_t first_half = row_.channels + row_.variances + 1 + row_.bins;
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel) {
    const double* const row = sums_.data() + pixel * row_.film_size();
    const double weight = row[FilmRow::kWeight];
    float* const means = image.data.data() + pixel * image.channels.size();
    float* out = means + first;
    *out++ = static_cast<float>(weight);
    // to_image() leaves these pixels zero.
    if (weight < 0.0) {
      for (std::size_t c = 0; c < row_.channels; ++c) means[c] = static_cast<float>(row[FilmRow::kSums + c] / weight);
      for (std::size_t bin = 0; bin < row_.bins; ++bin)
        means[row_.channels + row_.variances + 1 + bin] =
            static_cast<float>(row[row_.film_bins_at() + bin] / (weight * bin_width(spectral_bins())));
    }
    const double* square = row + row_.film_squares_at();
    const double weight_squared = row_.variances > 0 ? *square++ : 0.0;
    if (row_.variances > 0) *out++ = static_cast<float>(weight_squared);
    for (const std::size_t c : row_.with_variance) {
      // Use the mean as stored in single precision, so that merging recovers the sums of squares despite the rounding.
      const auto mean = static_cast<double>(means[c]);
      const double scatter = square[0] - 2.0 * mean * square[1] + mean * mean * weight_squared;
      *out++ = static_cast<float>(std::clamp(scatter, 0.0, kLargestVariance));
      *out++ = static_cast<float>(std::clamp(square[1] - mean * weight_squared, -kLargestVariance, kLargestVariance));
      square += 2;
    }
    if (half_.empty()) continue;
    const auto halves = static_cast<std::size_t>(layout_.half_count());
    const double* const half = half_.data() + pixel * (1 + halves);
    *out = static_cast<float>(half[0]);
    for (std::size_t k = 0; k < halves && half[0] != 0.0; ++k)
      means[first_half + k] = static_cast<float>(half[1 + k] / half[0]);
  }
}

}  // namespace sheaf
