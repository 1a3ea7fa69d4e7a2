// Tessellation of height fields, and heights from images.
#include "scene/formats/height_field.h"

#include "core/color/color.h"
#include "core/image/image.h"
#include "core/image/image_channels.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

Heights read_heights(const std::filesystem::path& file, float scale, bool raw) {
  const SourceLocation where{file.string(), 0};
  const StoredImage image = read_stored_image(file, raw);
  // Check the size and find the channels
  Heights out{static_cast<std::size_t>(image.width), static_cast<std::size_t>(image.height), {}};
  if (out.width < 2 || out.height < 2 || out.width * out.height > kMaxHeights)
    throw SceneError(where, fmt::format("an image of {} x {} pixels (expected at least 2 x 2 and at most {})",
                                        out.width, out.height, kMaxHeights));
  const std::vector<std::size_t> channels = find_color_channels(image.channels, where).channels;
  const bool bytes = !image.bytes.empty(), decode = !raw && (bytes || image.integers);
  // Convert pixels to heights
  out.z.resize(out.width * out.height);
  for (std::size_t i = 0; i < out.z.size(); ++i) {
    float value[3] = {};
    for (std::size_t k = 0; k < channels.size(); ++k) {
      const std::size_t at = i * image.channels.size() + channels[k];
      value[k] = bytes ? static_cast<float>(image.bytes[at]) / 255.0f : image.floats[at];
      if (decode) value[k] = srgb_to_linear(value[k]);
    }
    out.z[i] = scale * (channels.size() == 1 ? value[0] : luminance({value[0], value[1], value[2]}));
    if (!std::isfinite(out.z[i]))
      throw SceneError(where, fmt::format("the pixel in column {}, row {} (from the upper left) is not a finite number",
                                          i % out.width, i / out.width));
  }
  return out;
}

/// Returns vertex normals: means of the normals of the adjacent cells, by the slopes of their edges at the vertex.
std::vector<Vec3f> smooth_normals(const Heights& z) {
  std::vector<Vec3f> normals(z.z.size());
  const float across = 0.5f * static_cast<float>(z.width - 1), along = 0.5f * static_cast<float>(z.height - 1);
  for (std::size_t y = 0; y + 1 < z.height; ++y)
    for (std::size_t x = 0; x + 1 < z.width; ++x)
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const std::size_t cx = x + (corner & 1), cy = y + (corner >> 1);
        const float dx = (z.at(x + 1, cy) - z.at(x, cy)) * across, dy = (z.at(cx, y + 1) - z.at(cx, y)) * along;
        Vec3f& sum = normals[cy * z.width + cx];
        sum = sum + normalize(Vec3f{-dx, -dy, 1});
      }
  for (Vec3f& normal : normals) normal = normalize(normal);
  return normals;
}

}  // namespace

Mesh make_height_field(const Heights& heights, bool smooth) {
  const std::size_t width = heights.width, height = heights.height;
  Mesh mesh;
  mesh.positions.reserve(width * height);
  mesh.uvs.reserve(width * height);
  mesh.triangles.reserve(2 * (width - 1) * (height - 1));
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(width - 1);
      const float v = static_cast<float>(y) / static_cast<float>(height - 1);
      mesh.positions.push_back({2 * u - 1, 2 * v - 1, heights.at(x, y)});
      mesh.uvs.push_back({u, v});
    }
  for (std::uint32_t y = 0; y + 1 < height; ++y)
    for (std::uint32_t x = 0; x + 1 < width; ++x) {
      const auto below = static_cast<std::uint32_t>(width) * y + x, above = below + static_cast<std::uint32_t>(width);
      mesh.triangles.push_back({below, below + 1, above + 1});
      mesh.triangles.push_back({below, above + 1, above});
    }
  if (smooth) mesh.normals = smooth_normals(heights);
  return mesh;
}

Mesh read_height_field(const std::filesystem::path& file, float scale, bool smooth, bool raw) {
  return make_height_field(read_heights(file, scale, raw), smooth);
}

}  // namespace sheaf
