// Environment map images for tests.
#pragma once

#include "core/image/exr.h"
#include "scene/lights/make_envmap.h"

#include <cstdint>
#include <filesystem>
#include <functional>

namespace sheaf::test {

/// An image with the value f(x, y) at each pixel.
inline EnvmapImage envmap_image(std::uint32_t width, std::uint32_t height,
                                const std::function<Vec3f(std::uint32_t, std::uint32_t)>& f) {
  EnvmapImage p{width, height, std::vector<float>(3 * std::size_t{width} * height)};
  for (std::uint32_t i = 0; i < width * height; ++i) {
    const Vec3f v = f(i % width, i / width);
    p.rgb[3 * i] = v.x;
    p.rgb[3 * i + 1] = v.y;
    p.rgb[3 * i + 2] = v.z;
  }
  return p;
}

/// A non-uniform image with a black region and one bright pixel.
inline EnvmapImage uneven_image() {
  return envmap_image(11, 7, [](std::uint32_t x, std::uint32_t y) {
    if (x >= 3 && x <= 6 && y >= 2 && y <= 4) return Vec3f{0, 0, 0};
    if (x == 9 && y == 4) return Vec3f{40, 35, 20};
    return Vec3f{0.1f + 0.2f * static_cast<float>(x % 3), 0.5f, 0.05f * static_cast<float>(y * y)};
  });
}

/// Writes the image as an OpenEXR file.
inline void write_map(const std::filesystem::path& file, const EnvmapImage& map) {
  Image image(static_cast<int>(map.width), static_cast<int>(map.height), {"R", "G", "B"});
  image.data = map.rgb;
  write_exr(file, image, {});
}

}  // namespace sheaf::test
