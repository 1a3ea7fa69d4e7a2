// Merging of images that hold parts of a frame, or part of its samples.
//
// If one part holds all samples of a pixel, its values are copied. Otherwise means are averaged with their sums of
// weights, and ids are merged by weight. For the variance, parts with their own mean m store additional layers, see
// Film::add_part_layers():
//   - Q = sum of W_u^2
//   - c = sum of (S_u - m W_u) W_u
//   - s = sum of (S_u - m W_u)^2
//
// Over all units, the sum of S_u W_u is the sum of c + m Q over the parts. The sum of S_u^2 is the sum of s + 2 m c +
// m^2 Q.
#pragma once

#include "core/image/image.h"
#include "core/image/pixel_rect.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/film/sample_range.h"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// The pixels and samples that a part holds.
struct ImagePart {
  std::string name;     ///< file name, for messages
  PixelRect pixels;     ///< inside the frame
  SampleRange samples;  ///< taken in each of these pixels
};

/// Pixels with missing samples.
struct PartGap {
  PixelRect pixels;
  SampleRange samples;
};

/// Throws SceneError, naming both parts, if two parts share a sample.
void check_overlaps(std::span<const ImagePart> parts);

/// First gap that non-overlapping parts leave in the pixels `whole` with `samples` samples each; nothing if complete.
std::optional<PartGap> find_gap(std::span<const ImagePart> parts, const PixelRect& whole, std::uint32_t samples);

/// Fraction, 0 to 1, of all samples of the pixels `whole` that non-overlapping parts hold.
double covered_fraction(std::span<const ImagePart> parts, const PixelRect& whole, std::uint32_t samples);

/// Whether the merged image omits a channel, because it only serves merging or cannot be merged.
bool is_left_out(std::string_view channel);

/// Name of the first layer that an image of part of the samples lacks for merging; empty if it lacks none.
std::string missing_part_layer(const Image& part);

/// Merges parts of one render, one after the other.
class ImageMerger {
 public:
  /// `whole`: pixels of the merged image inside a frame of frame_width x frame_height. `channels`: its channels.
  /// `samples`: samples per pixel. `ids`: for each kind of name, the Cryptomatte ids by index; empty if not needed.
  ImageMerger(int frame_width, int frame_height, const PixelRect& whole, const std::vector<std::string>& channels,
              std::uint32_t samples, std::array<std::vector<float>, kNameKinds> ids);

  /// Adds a part, which must not overlap others. Ignores its pixels outside the merged image. `image` needs at least
  /// the channels of the merged image. If it holds part of the samples, it also needs the layers of
  /// Film::add_part_layers() and add_part_ids(). Throws SceneError if layers are missing or values are invalid.
  void add(const ImagePart& part, const Image& image);

  /// Returns the merged image; pixels without parts are zero. Call this once.
  Image finish();
  /// Number of pixels of the finished image whose variance is unknown, because it comes from a single unit.
  std::size_t pixels_without_variance() const { return single_units_; }

 private:
  /// Rule of merging a channel.
  enum class Rule : std::uint8_t { kMean, kVariance, kHalf, kCount, kId };
  struct Channel {
    Rule rule = Rule::kMean;
    std::size_t sum = 0;   ///< offset of its sums in a pixel's row: one, or for kVariance two (squares, products)
    std::size_t mean = 0;  ///< for kVariance: index of the channel with the mean
  };

  void begin_sums();
  void copy(const Image& image, const std::vector<int>& from, const PixelRect& pixels);
  void add_sums(const ImagePart& part, const Image& image, const std::vector<int>& from, const PixelRect& pixels);
  void finish_pixel(const double* row, float* out) const;
  std::size_t pixel_index(int x, int y) const;

  Image image_;
  PixelRect whole_;
  std::uint32_t samples_;
  std::array<std::vector<float>, kNameKinds> ids_;
  std::vector<Channel> channels_;
  std::size_t row_size_ = 0;
  std::vector<double> sums_;  ///< one row per pixel; allocated on first use
  std::size_t single_units_ = 0;
  std::vector<std::uint8_t> summed_;                          ///< per pixel: computed from sums
  std::array<std::vector<IdCoverage>, kNameKinds> coverage_;  ///< per pixel, by index of name
};

}  // namespace sheaf
