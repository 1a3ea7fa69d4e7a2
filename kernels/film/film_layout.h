// The channels of a film: which numbers a sample is made of, and which of them have a variance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// One channel of a film and of the samples that it is made from.
struct FilmChannel {
  std::string name;           ///< as in the picture, e.g. "R" or "albedo.G"; each once
  bool has_variance = false;  ///< the picture has the variance of its mean too, in the channel "variance." + name
  bool has_half = false;      ///< and the mean of the first half of the samples, in the channel "half." + name
  bool operator==(const FilmChannel&) const = default;
};

/// The channels of a sample in their order.
class FilmLayout {
 public:
  /// What every camera pass makes: R, G and B (linear Rec.709, premultiplied), with variances or not, and A (coverage).
  static FilmLayout beauty(bool with_variances = true);

  FilmLayout() = default;
  explicit FilmLayout(std::vector<FilmChannel> channels) : channels_(std::move(channels)) {}

  const std::vector<FilmChannel>& channels() const { return channels_; }
  int size() const { return static_cast<int>(channels_.size()); }
  /// How many channels have a variance.
  int variance_count() const;
  /// How many have the mean of the first half of the samples.
  int half_count() const;
  /// The channel's index, or -1 if there is none of this name.
  int find(std::string_view name) const;
  bool operator==(const FilmLayout&) const = default;

 private:
  std::vector<FilmChannel> channels_;
};

/// Where FilmLayout::beauty() has its channels.
enum BeautyChannel : int { kRed, kGreen, kBlue, kAlpha, kBeautyChannels };

}  // namespace sheaf
