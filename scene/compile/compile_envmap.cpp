#include "scene/compile/compile_envmap.h"

#include "core/color.h"
#include "core/image.h"
#include "core/lanes.h"
#include "core/uplift.h"
#include "scene/compile/texture_image.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr std::size_t kMaxEnvmapPixels = std::size_t{1} << 28;
constexpr double kPiDouble = 3.14159265358979323846;

bool is_usable(float value) { return value >= 0.0f && std::isfinite(value); }

/// Mean of sin theta over the hat function of row `j`: the share of the sphere that a node stands for. Positive at the
/// poles, so that no node that is seen has a density of zero.
double mean_sine(std::uint32_t j, std::uint32_t height) {
  const double step = kPiDouble / (height - 1);
  if (j == 0 || j == height - 1) return 2.0 * (1.0 - std::sin(step) / step) / step;
  // 1 - cos, without cancellation.
  const double half = std::sin(0.5 * step);
  return std::sin(j * step) * 4.0 * half * half / (step * step);
}

/// Radiance to the nodes; a picture of one row becomes two equal ones.
void fill_radiance(Envmap& map, const EnvmapPicture& picture, float scale) {
  for (std::size_t j = 0; j < map.height; ++j) {
    const std::size_t row = std::min<std::size_t>(j, picture.height - 1) * map.width;
    for (std::size_t i = 0; i < map.width; ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const float value = picture.rgb[3 * (row + i) + c] * scale;
        map.nodes[4 * (j * map.width + i) + c] = is_usable(value) ? value : 0.0f;
      }
  }
}

/// The mean radiance of all directions; of node values, since the integral of hat functions is exact.
void set_mean(Envmap& map) {
  double sum[3] = {}, weights = 0;
  for (std::uint32_t j = 0; j < map.height; ++j) {
    // The hats of the outermost rows are cut in half by the poles.
    const double weight = mean_sine(j, map.height) * (j == 0 || j == map.height - 1 ? 0.5 : 1.0);
    weights += weight * map.width;
    for (std::size_t i = 0; i < map.width; ++i)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * map.nodes[4 * (std::size_t{j} * map.width + i) + c];
  }
  map.mean = {static_cast<float>(sum[0] / weights), static_cast<float>(sum[1] / weights),
              static_cast<float>(sum[2] / weights)};
}

/// Densities at the nodes: brightness, less `offset`, times the sine; in proportion only.
void fill_density(Envmap& map, float offset) {
  for (std::uint32_t j = 0; j < map.height; ++j) {
    const auto sine = static_cast<float>(mean_sine(j, map.height));
    for (std::size_t i = 0; i < map.width; ++i) {
      float* node = &map.nodes[4 * (std::size_t{j} * map.width + i)];
      node[3] = std::max(luminance({node[0], node[1], node[2]}) - offset, 0.0f) * sine;
    }
  }
}

/// Makes the density integrate to 1, and sums it up. False if it is zero everywhere.
bool sum_density(Envmap& map) {
  const std::size_t width = map.width, height = map.height;
  std::vector<double> rows(height);
  for (std::size_t j = 0; j < height; ++j)
    for (std::size_t i = 0; i < width; ++i) rows[j] += map.nodes[4 * (j * width + i) + 3];
  double total = 0;
  for (std::size_t j = 0; j + 1 < height; ++j) total += 0.5 * (rows[j] + rows[j + 1]);
  if (!(total > 0.0)) return false;

  const double normalize = static_cast<double>(width) * static_cast<double>(height - 1) / total;
  map.marginal.assign(height, 0.0f);
  map.conditional.assign(height * (width + 1), 0.0f);
  double before = 0;
  for (std::size_t j = 0; j < height; ++j) {
    float* row = &map.nodes[4 * j * width];
    for (std::size_t i = 0; i < width; ++i) row[4 * i + 3] = static_cast<float>(row[4 * i + 3] * normalize);
    double sum = 0;
    for (std::size_t i = 0; i < width; ++i) {
      sum += 0.5 * (double(row[4 * i + 3]) + row[4 * ((i + 1) % width) + 3]);
      map.conditional[j * (width + 1) + i + 1] = static_cast<float>(sum);
    }
    map.marginal[j] = static_cast<float>(std::min(before / total, 1.0));
    if (j + 1 < height) before += 0.5 * (rows[j] + rows[j + 1]);
  }
  map.marginal[height - 1] = 1.0f;
  return true;
}

}  // namespace

double node_solid_angle(std::uint32_t row, std::uint32_t width, std::uint32_t height) {
  const double hat = row == 0 || row == height - 1 ? 0.5 : 1.0;  // cut in half by the pole
  return hat * mean_sine(row, height) * (kPiDouble / (height - 1)) * (2 * kPiDouble / width);
}

Envmap make_envmap(const EnvmapPicture& picture, float scale, bool mis_compensation) {
  if (std::size_t{picture.width} * picture.height > kMaxEnvmapPixels)
    throw SceneError("a picture of " + std::to_string(picture.width) + " x " + std::to_string(picture.height) +
                     " pixels is too large for an environment map, of 2^28 at most");
  Envmap map;
  map.width = picture.width;
  map.height = std::max(picture.height, 2u);
  map.to_map[0] = map.to_map[4] = map.to_map[8] = 1.0f;
  map.nodes.assign(4 * std::size_t{map.width} * map.height, 0.0f);
  fill_radiance(map, picture, scale);
  set_mean(map);
  fill_density(map, mis_compensation ? luminance(map.mean) : 0.0f);
  if (!sum_density(map)) {
    fill_density(map, 0.0f);
    sum_density(map);
  }
  return map;
}

void uplift_nodes(Envmap& map) {
  const UpliftTable& table = UpliftTable::get();
  map.spectra.resize(map.nodes.size());
  const std::size_t width = map.width;
  tbb::parallel_for(std::size_t{0}, std::size_t{map.height}, [&](std::size_t row) {
    for (std::size_t first = 0; first < width; first += kWidth) {
      const int count = static_cast<int>(std::min<std::size_t>(kWidth, width - first));
      const float* from[kWidth];
      float* to[kWidth];
      for (int lane = 0; lane < kWidth; ++lane) {
        const std::size_t word = 4 * (row * width + first + static_cast<std::size_t>(std::min(lane, count - 1)));
        from[lane] = map.nodes.data() + word;
        to[lane] = map.spectra.data() + word;
      }
      WideFloat node[4];
      load_rows4(from, node);
      const ScaledSigmoid<Wide> s = uplift_unbounded<Wide>(table, {node[0], node[1], node[2]});
      const WideFloat spectrum[4] = {s.shape.c0, s.shape.c1, s.shape.c2, s.scale};
      store_rows4(to, spectrum, count);
    }
  });
}

EnvmapPicture read_envmap_picture(const std::filesystem::path& file) {
  const SourceLocation where{file.string(), 0};
  const Picture picture = read_picture(file);
  const std::vector<std::size_t> channels = texture_channels(picture.channels, where);
  const std::size_t stride = picture.channels.size();
  const bool bytes = !picture.bytes.empty(), encoded = bytes || picture.integers;
  const auto value = [&](std::size_t index) {
    const float stored = bytes ? static_cast<float>(picture.bytes[index]) / 255.0f : picture.floats[index];
    return encoded ? srgb_to_linear(stored) : stored;
  };
  EnvmapPicture out;
  out.width = static_cast<std::uint32_t>(picture.width);
  out.height = static_cast<std::uint32_t>(picture.height);
  out.rgb.resize(3 * std::size_t{out.width} * out.height);
  for (std::size_t pixel = 0; 3 * pixel < out.rgb.size(); ++pixel)
    for (std::size_t c = 0; c < 3; ++c)
      out.rgb[3 * pixel + c] = value(pixel * stride + channels[std::min(c, channels.size() - 1)]);
  return out;
}

std::size_t count_unusable(const EnvmapPicture& picture) {
  return static_cast<std::size_t>(
      std::count_if(picture.rgb.begin(), picture.rgb.end(), [](float value) { return !is_usable(value); }));
}

}  // namespace sheaf
