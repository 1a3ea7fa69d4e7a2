// The transform from a rendered image to a displayed one: exposure, then a tone-mapping curve or a view of an
// OpenColorIO configuration.
#pragma once

#include "core/color/tone_map.h"
#include "core/image/display_view.h"
#include "core/image/image.h"

#include <memory>
#include <optional>

namespace sheaf {

/// Exposure in stops that brings the log-average luminance of an image to middle gray, 0.18. See Reinhard et al.,
/// "Photographic Tone Reproduction for Digital Images" (2002), equation 1, which adds a small number to each luminance:
/// the logarithm would give faint pixels, such as the tails of filters, the weight of many stops. Here, pixels do not
/// count that would be darker than the first level of an 8-bit sRGB image above black if the brighter part of the image
/// were middle gray. Multiplying an image by a factor changes the exposure by its logarithm.
///
/// Colors count by their straight values; light without coverage, alpha below 1/255, counts as it appears over black.
/// Pixels with NaN, infinite or negative luminance do not count. 0 for an image without light.
double auto_exposure(const Image& image);

/// What nearly all pixels of a displayed image show.
enum class Shown { kPicture, kBlack, kWhite };

/// Judges a displayed image; see DisplayTransform::apply(). Transparent pixels do not count.
Shown shown_by(const Image& displayed);

/// Settings of a DisplayTransform. If `display_view` is set, `tone_map` is kNone.
struct DisplaySettings {
  std::optional<double> exposure = 0.0;  ///< stops; nothing: auto_exposure()
  ToneMap tone_map = ToneMap::kClamp;
  std::shared_ptr<const ColorProcessor> display_view;  ///< from linear Rec.709 to values of the display; may be null
};

class DisplayTransform {
 public:
  DisplayTransform() = default;
  explicit DisplayTransform(DisplaySettings settings) : settings_(std::move(settings)) {}

  /// Whether images stay unchanged.
  bool is_identity() const {
    return settings_.exposure == 0.0 && settings_.tone_map == ToneMap::kClamp && !settings_.display_view;
  }
  /// Whether exposure_of() depends on the image.
  bool is_automatic() const { return !settings_.exposure; }
  const DisplaySettings& settings() const { return settings_; }
  /// Exposure of an image, stops.
  double exposure_of(const Image& image) const;
  /// The displayed image: R, G and B, or the channel shown as gray, and A if the image has them. Colors are linear
  /// Rec.709 and premultiplied by A; after encoding with the sRGB curve they are the values of the display. Without
  /// tone map and view, colors may exceed 1.
  Image apply(const Image& image) const;

 private:
  void map_colors(std::vector<Vec3f>& colors) const;

  DisplaySettings settings_;
};

}  // namespace sheaf
