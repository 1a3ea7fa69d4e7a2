#include "scene/lights/octahedral_envmap.h"

#include "core/sampling/octahedral.h"
#include "core/simd/lanes.h"
#include "core/soa/lane_array.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sheaf {

namespace {

/// Lookups along each side of a node's neighborhood.
constexpr std::uint32_t kLookups = 4;

struct SineCosine {
  double sine, cosine;
};

/// Sines and cosines of the angles of a latitude-longitude map, kLookups per column and per row.
struct LookupAngles {
  std::vector<SineCosine> phi, theta;

  LookupAngles(std::uint32_t width, std::uint32_t height) {
    for (std::uint32_t i = 0; i < width; ++i)
      for (std::uint32_t a = 0; a < kLookups; ++a) {
        const double angle = 2 * std::acos(-1.0) * ((i + (a + 0.5) / kLookups) / width);
        phi.push_back({std::sin(angle), std::cos(angle)});
      }
    for (std::uint32_t j = 0; j < height; ++j)
      for (std::uint32_t b = 0; b < kLookups; ++b) {
        const double v = std::clamp((j - 0.5 + (b + 0.5) / kLookups) / (height - 1), 0.0, 1.0);
        const double angle = std::acos(-1.0) * v;
        theta.push_back({std::sin(angle), std::cos(angle)});
      }
  }
};

/// Direction of a lookup; see scene/tables/envmap.h.
Vec3f direction_of(const SineCosine& phi, const SineCosine& theta) {
  return {static_cast<float>(theta.sine * phi.sine), static_cast<float>(theta.cosine),
          static_cast<float>(-theta.sine * phi.cosine)};
}

bool counts(float value) { return value >= 0.0f && std::isfinite(value); }

/// Indices of the texels at a position in the square map.
std::size_t texel_at(const EnvmapImage& square, Vec2f uv) {
  const auto texel = [&](float coordinate) {
    const auto t = static_cast<std::uint32_t>(std::max(coordinate, 0.0f) * static_cast<float>(square.width));
    return std::min(t, square.width - 1);
  };
  return std::size_t{texel(uv.y)} * square.width + texel(uv.x);
}

/// Computes texel_at() of a register of directions. Positions are approximate in wide registers: those that lie next to
/// another texel are computed again by scalar arithmetic, so that the result does not depend on the instruction set.
void find_texels(const EnvmapImage& square, const LaneRows<Wide, Vec3>& directions, int count, std::size_t* texels) {
  constexpr float kPositionError = 1e-5f;
  const Vec2<Wide> uv = equal_area_octahedral<Wide>(directions.load());
  const LaneArray u(uv.x), v(uv.y);
  const float scale = static_cast<float>(square.width), margin = kPositionError * scale;
  const auto is_near_edge = [&](float coordinate) {
    const float position = coordinate * scale;
    return std::abs(position - std::round(position)) <= margin;
  };
  for (int lane = 0; lane < count; ++lane) {
    const bool exact = is_near_edge(u[lane]) || is_near_edge(v[lane]);
    texels[lane] = texel_at(square, exact ? equal_area_octahedral<Scalar>(directions[lane]) : Vec2f{u[lane], v[lane]});
  }
}

/// Mean of the texels around node (i, j).
Vec3f mean_around(const EnvmapImage& square, std::uint32_t i, std::uint32_t j, const LookupAngles& angles) {
  constexpr int kCount = kLookups * kLookups;
  std::size_t texels[kCount];
  for (int first = 0; first < kCount; first += kWidth) {
    LaneRows<Wide, Vec3> directions;
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto k = static_cast<std::uint32_t>(std::min(first + lane, kCount - 1));
      directions.set(lane,
                     direction_of(angles.phi[kLookups * i + k % kLookups], angles.theta[kLookups * j + k / kLookups]));
    }
    find_texels(square, directions, std::min(kWidth, kCount - first), texels + first);
  }
  Vec3f sum{0, 0, 0};
  for (const std::size_t texel : texels) {
    const float* rgb = &square.rgb[3 * texel];
    sum = sum + Vec3f{counts(rgb[0]) ? rgb[0] : 0, counts(rgb[1]) ? rgb[1] : 0, counts(rgb[2]) ? rgb[2] : 0};
  }
  return sum * (1.0f / kCount);
}

/// Mean of a channel of the square map over all directions.
double mean_of(const EnvmapImage& square, std::size_t channel) {
  double sum = 0;
  for (std::size_t k = channel; k < square.rgb.size(); k += 3)
    sum += counts(square.rgb[k]) ? static_cast<double>(square.rgb[k]) : 0.0;
  return sum * 3 / static_cast<double>(square.rgb.size());
}

/// Scales a map so that envmap_mean() computes the same means as for `square`.
void keep_means(EnvmapImage& map, const EnvmapImage& square) {
  const Vec3f found = envmap_mean(map);
  const std::array<float, 3> means{found.x, found.y, found.z};
  for (std::size_t c = 0; c < 3; ++c) {
    const float scale = means[c] > 0.0f ? static_cast<float>(mean_of(square, c)) / means[c] : 1.0f;
    for (std::size_t k = c; k < map.rgb.size(); k += 3) map.rgb[k] *= scale;
  }
}

}  // namespace

EnvmapImage lat_long_of_octahedral(const EnvmapImage& square, const std::filesystem::path& file) {
  if (square.width != square.height)
    throw SceneError(SourceLocation{file.string(), 0},
                     fmt::format("the environment map has {} x {} pixels (expected a square equal-area map)",
                                 square.width, square.height));
  EnvmapImage map;
  map.height = std::max(square.height, 8u);
  map.width = 2 * map.height;
  map.rgb.resize(3 * std::size_t{map.width} * map.height);
  const LookupAngles angles(map.width, map.height);
  tbb::parallel_for(std::uint32_t{0}, map.height, [&](std::uint32_t j) {
    for (std::uint32_t i = 0; i < map.width; ++i) {
      const Vec3f rgb = mean_around(square, i, j, angles);
      float* out = &map.rgb[3 * (std::size_t{j} * map.width + i)];
      out[0] = rgb.x, out[1] = rgb.y, out[2] = rgb.z;
    }
  });
  keep_means(map, square);
  return map;
}

}  // namespace sheaf
