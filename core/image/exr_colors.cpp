// Reading of the display window of OpenEXR files, and its conversion to linear Rec.709.
#include "core/image/exr_colors.h"

#include "core/color/color_space.h"
#include "core/image/exr.h"
#include "core/image/exr_halves.h"
#include "core/image/image_channels.h"
#include "core/io/error.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

namespace fs = std::filesystem;

/// A display window may be far larger than the data window. Files count as at least this many bytes when their display
/// window is checked by check_image_size().
constexpr std::size_t kMinFileBytes = std::size_t{1} << 15;

/// Copies the data window into the display window. Pixels outside the data window are 0.
std::vector<float> pixels_of_frame(const fs::path& path, Image image) {
  const bool is_frame =
      image.x0 == 0 && image.y0 == 0 && image.width == image.frame_width && image.height == image.frame_height;
  if (is_frame) return std::move(image.data);
  const std::size_t channels = image.channels.size();
  check_image_size(path, image.frame_width, image.frame_height, channels,
                   std::max<std::size_t>(fs::file_size(path), kMinFileBytes));
  check_image_memory(path, image.frame_width, image.frame_height, channels, sizeof(float));
  // Intersect both windows
  const int x_begin = std::max(image.x0, 0), x_end = std::min(image.x0 + image.width, image.frame_width);
  const int y_begin = std::max(image.y0, 0), y_end = std::min(image.y0 + image.height, image.frame_height);
  if (x_begin >= x_end || y_begin >= y_end)
    throw SceneError({path.string(), 0}, "the image's data window lies outside of its display window");
  std::vector<float> pixels(static_cast<std::size_t>(image.frame_width) * static_cast<std::size_t>(image.frame_height) *
                            channels);
  for (int y = y_begin; y < y_end; ++y) {
    const float* const from =
        &image.data[(static_cast<std::size_t>(y - image.y0) * static_cast<std::size_t>(image.width) +
                     static_cast<std::size_t>(x_begin - image.x0)) *
                    channels];
    const std::size_t to =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(image.frame_width) + static_cast<std::size_t>(x_begin);
    std::copy_n(from, static_cast<std::size_t>(x_end - x_begin) * channels,
                pixels.begin() + static_cast<std::ptrdiff_t>(to * channels));
  }
  return pixels;
}

/// The part of a file that holds the color.
struct ColorPart {
  std::size_t index = 0;              ///< among all parts
  std::vector<std::string> names;     ///< of its channels that are read
  std::vector<std::string> channels;  ///< the names that these get
  bool xyz = false;                   ///< the colors are CIE X, Y and Z
  std::optional<RgbChromaticities> chromaticities;

  bool is_gray() const { return channels.front() == "Y"; }
};

ColorPart find_color_part(const fs::path& path) {
  const SourceLocation where{path.string(), 0};
  const std::vector<ExrPart> parts = read_exr_parts(path);
  std::vector<ImageChannels> flat;
  std::vector<std::size_t> part_of;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].deep) continue;
    flat.push_back({parts[i].name, parts[i].channels});
    part_of.push_back(i);
  }
  if (flat.empty()) throw SceneError(where, "deep images are not supported");
  const ColorChannels found = find_color_channels(flat, where);
  const ExrPart& part = parts[part_of[found.part]];
  ColorPart out{part_of[found.part], {}, {}, found.xyz, part.chromaticities};
  for (const std::size_t c : found.channels) out.names.push_back(part.channels[c]);
  if (found.alpha) out.names.push_back(part.channels[*found.alpha]);
  const bool gray = found.channels.size() == 1;
  out.channels = gray ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  if (found.alpha) out.channels.emplace_back("A");
  return out;
}

}  // namespace

StoredImage read_exr_colors(const fs::path& path, bool raw) {
  const ColorPart part = find_color_part(path);
  Image image = read_exr_channels(path, part.index, part.names);
  StoredImage colors;
  colors.width = image.frame_width;
  colors.height = image.frame_height;
  colors.channels = part.channels;
  colors.floats = pixels_of_frame(path, std::move(image));
  // Convert to Rec.709
  if (part.is_gray() || raw) return colors;
  const RgbChromaticities space = part.xyz ? kXyzSpace : part.chromaticities.value_or(kRec709Space);
  if (!convert_to_rec709(colors.floats, space, colors.channels.size()))
    throw SceneError({path.string(), 0},
                     "the image's chromaticities define no color space (expected primaries that span a "
                     "triangle, and finite numbers)");
  return colors;
}

std::optional<HalfImage> read_exr_halves(const fs::path& path, bool raw) {
  const ColorPart part = find_color_part(path);
  if (!raw && !part.is_gray() && (part.xyz || part.chromaticities)) return std::nullopt;
  std::optional<HalfImage> image = read_exr_half_channels(path, part.index, part.names);
  if (image) image->channels = part.channels;
  return image;
}

}  // namespace sheaf
