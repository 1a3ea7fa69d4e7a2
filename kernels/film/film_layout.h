// Film layout: the channels of a sample, and which of them have a variance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// One channel of a film and of its samples.
struct FilmChannel {
  std::string name;           ///< unique; as in the image, e.g. "R" or "albedo.G"
  bool has_variance = false;  ///< the image also has the variance of the mean, as "variance." + name
  bool has_half = false;      ///< the image also has the mean of the first half of the samples, as "half." + name
  bool operator==(const FilmChannel&) const = default;
};

/// The channels of a sample, in order.
class FilmLayout {
 public:
  /// The channels of every camera pass: R, G and B (linear Rec.709, premultiplied), and A (coverage, no variance).
  static FilmLayout beauty(bool with_variances = true);

  FilmLayout() = default;
  explicit FilmLayout(std::vector<FilmChannel> channels) : channels_(std::move(channels)) {}

  const std::vector<FilmChannel>& channels() const { return channels_; }
  int size() const { return static_cast<int>(channels_.size()); }
  /// Number of channels with a variance.
  int variance_count() const;
  /// Number of channels with a mean of the first half of the samples.
  int half_count() const;
  /// Index of the channel, or -1 if it does not exist.
  int find(std::string_view name) const;
  bool operator==(const FilmLayout&) const = default;

 private:
  std::vector<FilmChannel> channels_;
};

/// Channel indices of FilmLayout::beauty().
enum BeautyChannel : int { kRed, kGreen, kBlue, kAlpha, kBeautyChannels };

}  // namespace sheaf
