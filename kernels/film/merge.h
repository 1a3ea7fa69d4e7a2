// Pictures of parts of a frame, or of some of its samples, joined to the picture of all.
//
// Of a pixel that one part has whole the values are copied. Else means are joined by the sums of their weights, which
// parts tell with all that the variance of the whole depends on (Film::add_part_layers()): with c for the sum of
// (S_u - m W_u) W_u and s for that of (S_u - m W_u)^2, the sums over all units of S_u W_u and S_u^2 are those of
// c + m Q and s + 2 m c + m^2 Q over the parts, m being the part's own mean. Names are joined by weight.
#pragma once

#include "core/image.h"
#include "core/pixel_rect.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/film/sample_range.h"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// What a part is of.
struct PicturePart {
  std::string name;     ///< of its file, for messages
  PixelRect pixels;     ///< inside the frame
  SampleRange samples;  ///< that are taken in these pixels
};

/// Pixels that lack samples.
struct PartGap {
  PixelRect pixels;
  SampleRange samples;
};

/// Throws SceneError, which names both, where two parts have a sample in common.
void check_overlaps(std::span<const PicturePart> parts);

/// The first gap, if there is one: what parts that don't overlap leave of the pixels `whole` and their `samples`.
std::optional<PartGap> find_gap(std::span<const PicturePart> parts, const PixelRect& whole, std::uint32_t samples);

/// The share of the samples of the pixels `whole` that parts have which don't overlap, 0 to 1.
double covered_share(std::span<const PicturePart> parts, const PixelRect& whole, std::uint32_t samples);

/// Whether a channel is for joining alone, or cannot be joined: the whole picture does without it.
bool is_left_out(std::string_view channel);

/// What the pictures of some samples lack to be joined; an empty string if nothing: the layer's name.
std::string missing_part_layer(const Image& part);

/// Joins parts of one render, one after the other.
class PictureMerger {
 public:
  /// `whole`: pixels of the picture, which lies in a frame of frame_width x frame_height. `channels`: its channels.
  /// `samples`: of a pixel. `ids`: for each kind of name, by number, Cryptomatte's ids; empty where they are not
  /// needed.
  PictureMerger(int frame_width, int frame_height, const PixelRect& whole, const std::vector<std::string>& channels,
                std::uint32_t samples, std::array<std::vector<float>, kNameKinds> ids);

  /// Adds a part, which must not overlap others; what lies outside of the picture is left out. `image` has the channels
  /// of the picture at least, and that of some samples all of Film::add_part_layers() and add_part_ids(). Throws
  /// SceneError where it has not, or says what cannot be.
  void add(const PicturePart& part, const Image& image);

  /// The picture: zero where there are no parts. To be called once.
  Image finish();
  /// Pixels of the finished picture whose variances are of a single unit, and say nothing.
  std::size_t pixels_without_variance() const { return single_units_; }

 private:
  /// How a channel of the picture comes about.
  enum class Rule : std::uint8_t { kMean, kVariance, kHalf, kCount, kId };
  struct Channel {
    Rule rule = Rule::kMean;
    std::size_t sum = 0;   ///< where its sums stand in a pixel's row: one, or of kVariance two, of squares and products
    std::size_t mean = 0;  ///< of kVariance: the channel whose variance it is
  };

  void begin_sums();
  void copy(const Image& image, const std::vector<int>& from, const PixelRect& pixels);
  void add_sums(const PicturePart& part, const Image& image, const std::vector<int>& from, const PixelRect& pixels);
  void finish_pixel(const double* row, float* out) const;
  std::size_t pixel_index(int x, int y) const;

  Image image_;
  PixelRect whole_;
  std::uint32_t samples_;
  std::array<std::vector<float>, kNameKinds> ids_;
  std::vector<Channel> channels_;
  std::size_t row_size_ = 0;
  std::vector<double> sums_;  ///< per pixel a row; empty until they are needed
  std::size_t single_units_ = 0;
  std::vector<std::uint8_t> summed_;                          ///< per pixel: it is made of sums
  std::array<std::vector<IdCoverage>, kNameKinds> coverage_;  ///< per pixel, by number of name
};

}  // namespace sheaf
