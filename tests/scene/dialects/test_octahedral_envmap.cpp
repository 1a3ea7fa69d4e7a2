// Square equal-area environment maps.
#include "scene/lights/octahedral_envmap.h"

#include "core/sampling/octahedral.h"
#include "core/simd/lanes.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_octahedral_envmap {

namespace {

/// Direction of a position in the square, by the inverse of the map (Clarberg 2008, section 2).
Vec3f direction_at(float x, float y) {
  const float u = 2 * x - 1, v = 2 * y - 1;
  const float distance = 1 - (std::fabs(u) + std::fabs(v)), r = 1 - std::fabs(distance);
  const float phi = (r == 0.0f ? 1.0f : (std::fabs(v) - std::fabs(u)) / r + 1) * kPi / 4;
  const float z = std::copysign(1 - r * r, distance), s = r * std::sqrt(2 - r * r);
  return {std::copysign(std::cos(phi), u) * s, std::copysign(std::sin(phi), v) * s, z};
}

/// A radiance that differs in all directions.
Vec3f radiance(Vec3f d) { return {1 + d.x, 1 + 0.5f * d.y + d.z * d.z, 1.5f - d.z}; }

EnvmapImage square_map(std::uint32_t size) {
  EnvmapImage square{size, size, {}};
  for (std::uint32_t j = 0; j < size; ++j)
    for (std::uint32_t i = 0; i < size; ++i) {
      const auto middle = [&](std::uint32_t k) { return (static_cast<float>(k) + 0.5f) / static_cast<float>(size); };
      const Vec3f rgb = radiance(direction_at(middle(i), middle(j)));
      square.rgb.insert(square.rgb.end(), {rgb.x, rgb.y, rgb.z});
    }
  return square;
}

}  // namespace

TEST_SUITE("square environment maps") {
  TEST_CASE("square maps: directions and positions are inverses") {
    for (float y = 0.01f; y < 1; y += 0.07f)
      for (float x = 0.013f; x < 1; x += 0.06f) {
        const Vec3f direction = direction_at(x, y);
        CHECK(length(direction) == near(1, 1e-4));
        const Vec2f position = equal_area_octahedral<Scalar>(direction);
        CHECK(position.x == near(x, 1e-3));
        CHECK(position.y == near(y, 1e-3));
      }
    CHECK(equal_area_octahedral<Scalar>({0, 0, 1}).x == 0.5f);
    CHECK(equal_area_octahedral<Scalar>({1, 0, 0}).x == 1);
    CHECK(equal_area_octahedral<Scalar>({0, 1, 0}).y == 1);
  }

  TEST_CASE("square maps: a latitude-longitude map has the same radiance in all directions") {
    const EnvmapImage map = lat_long_of_octahedral(square_map(64), "sky.exr");
    REQUIRE(map.height == 64);
    REQUIRE(map.width == 128);
    double worst = 0;
    for (std::uint32_t j = 0; j < map.height; ++j)
      for (std::uint32_t i = 0; i < map.width; ++i) {
        const float phi = 2 * kPi * (static_cast<float>(i) + 0.5f) / 128, theta = kPi * static_cast<float>(j) / 63;
        const Vec3f expected =
            radiance({std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)});
        const float* found = &map.rgb[3 * (std::size_t{j} * map.width + i)];
        worst = std::max({worst, std::fabs(static_cast<double>(found[0] - expected.x)),
                          std::fabs(static_cast<double>(found[1] - expected.y)),
                          std::fabs(static_cast<double>(found[2] - expected.z))});
      }
    CHECK(worst < 0.08);
  }

  TEST_CASE("square maps: a single bright texel keeps its power") {
    EnvmapImage square{32, 32, std::vector<float>(3 * 32 * 32, 0.0f)};
    for (std::size_t c = 0; c < 3; ++c) square.rgb[3 * (5 * 32 + 20) + c] = 1024;
    const Vec3f mean = make_envmap(lat_long_of_octahedral(square, "sun.exr"), 1, false).mean;
    // To the rounding of texels, which have 10 bits
    CHECK(mean.x == near(1, 5e-4));
    CHECK(mean.z == near(1, 5e-4));
  }

  TEST_CASE("square maps: nodes are means of the texels around them, as by scalar arithmetic") {
    constexpr std::uint32_t kSize = 24, kWidth = 2 * kSize;
    EnvmapImage square{kSize, kSize, std::vector<float>(3 * kSize * kSize)};
    for (std::size_t k = 0; k < square.rgb.size(); ++k)
      square.rgb[k] = 0.5f + static_cast<float>((k * 2654435761u >> 8) % 1000) * 1e-3f;
    const EnvmapImage map = lat_long_of_octahedral(square, "sky.exr");
    double scale = 0, worst = 0;
    for (std::uint32_t j = 0; j < kSize; ++j)
      for (std::uint32_t i = 0; i < kWidth; ++i) {
        double sum = 0;
        for (int k = 0; k < 16; ++k) {
          const double phi = 2 * std::acos(-1.0) * (i + (k % 4 + 0.5) / 4) / kWidth;
          const double v = std::clamp((j - 0.5 + (k / 4 + 0.5) / 4) / (kSize - 1), 0.0, 1.0);
          const double theta = std::acos(-1.0) * v, sine = std::sin(theta);
          const Vec2f uv = equal_area_octahedral<Scalar>({static_cast<float>(sine * std::sin(phi)),
                                                          static_cast<float>(std::cos(theta)),
                                                          static_cast<float>(-sine * std::cos(phi))});
          const auto texel = [](float x) { return std::min(static_cast<std::uint32_t>(x * kSize), kSize - 1); };
          sum += static_cast<double>(square.rgb[3 * (std::size_t{texel(uv.y)} * kSize + texel(uv.x))]) / 16;
        }
        const auto found = static_cast<double>(map.rgb[3 * (std::size_t{j} * kWidth + i)]);
        if (scale == 0) scale = found / sum;  // keeps the mean
        worst = std::max(worst, std::abs(found / (sum * scale) - 1));
      }
    CHECK(worst < 1e-5);
  }

  TEST_CASE("square maps: images that are not square are rejected") {
    CHECK_THROWS_AS(lat_long_of_octahedral({4, 2, std::vector<float>(24, 1.0f)}, "sky.exr"), SceneError);
  }
}

}  // namespace sheaf::test_octahedral_envmap
