// Images as textures.
#pragma once

#include "scene/textures/texture.h"

#include <compare>
#include <filesystem>
#include <memory>

namespace sheaf {

struct EncodedImage;
struct Image;

/// Data of an image's row.
struct BitmapRow {
  std::uint32_t image;  ///< into TextureView::images
  std::uint32_t tiles_per_row;
  std::uint32_t width, height;  ///< in texels, without padding; from 1 to kMaxImageSide
  TextureWrap wrap_u, wrap_v;
  TextureFilter filter;
  TexelFormat format;
};

/// An image from a file or from memory, repeated over the uv plane.
struct BitmapDescription {
  /// The channels of the image that are used: its colors, or one as a scalar. Red, green and blue of a gray image are
  /// its gray; alpha of an image without alpha is 1.
  enum class Channel { kColor, kRed, kGreen, kBlue, kAlpha };

  std::filesystem::path file;  ///< resolved path
  TextureFilter filter = TextureFilter::kBilinear;
  TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
  bool raw = false;  ///< values are data, not colors: integers are not decoded by the sRGB curve, as alpha never is
  /// Transform of each value of the image after decoding.
  struct ColorTransform {
    float scale = 1;      ///< first: multiply by this
    bool invert = false;  ///< second: replace x by 1 - x and clamp negative values to 0
    float exponent = 1;   ///< last: raise to this power
    friend constexpr auto operator<=>(const ColorTransform&, const ColorTransform&) = default;
  } change = {};
  /// Replaces `file`: channels Y, or R, G and B, with linear values.
  std::shared_ptr<const Image> made = {};
  /// Replaces `file`: a PNG, JPEG or WebP file in memory. Textures with the same object share their texels.
  std::shared_ptr<const EncodedImage> encoded = {};
  Channel channel = Channel::kColor;

  static constexpr TextureDomain kDomain = TextureDomain::kImage;
  static constexpr std::array kPlugins = {"bitmap"};
  static BitmapDescription read(Properties& p);
  static constexpr auto fields(auto& s) {
    return std::tie(s.file, s.filter, s.wrap_u, s.wrap_v, s.raw, s.change.scale, s.change.invert, s.change.exponent,
                    s.channel);
  }
  static constexpr auto colors(auto&) { return std::tie(); }
  void scale_by(float by) { change.scale *= by; }
  /// Whether integers are linear values.
  bool is_linear() const { return raw || channel == Channel::kAlpha; }
  void make_row(TextureRowBuilder& row) const;
};

}  // namespace sheaf
