#include "scene/lights/make_envmap.h"

#include "core/color/srgb_bytes.h"
#include "core/color/uplift.h"
#include "core/image/image.h"
#include "core/image/image_channels.h"
#include "core/io/file_cache.h"
#include "core/simd/lanes.h"
#include "core/simd/simd_rows.h"
#include "core/soa/large_pages.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf {

namespace {

constexpr std::size_t kMaxEnvmapPixels = std::size_t{1} << 28;
constexpr double kPiDouble = 3.14159265358979323846;

bool is_usable(float value) { return value >= 0.0f && std::isfinite(value); }

/// Mean of sin theta over the hat function of row `j`, proportional to a node's solid angle. Positive at the poles, so
/// no visible node has density zero.
double mean_sine(std::uint32_t j, std::uint32_t height) {
  const double step = kPiDouble / (height - 1);
  if (j == 0 || j == height - 1) return 2.0 * (1.0 - std::sin(step) / step) / step;
  // 1 - cos(step), without cancellation.
  const double half = std::sin(0.5 * step);
  return std::sin(j * step) * 4.0 * half * half / (step * step);
}

/// The largest power of two not above the image's maximum.
float unit_of(const EnvmapImage& image, float scale) {
  using Range = tbb::blocked_range<std::size_t>;
  const auto largest_of = [&](const Range& range, float largest) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const float value = image.rgb[i] * scale;
      largest = is_usable(value) ? std::max(largest, value) : largest;
    }
    return largest;
  };
  const float largest = tbb::parallel_reduce(Range(0, image.rgb.size(), 1 << 16), 0.0f, largest_of,
                                             [](float a, float b) { return std::max(a, b); });
  return largest > 0 ? std::exp2(static_cast<float>(std::min(std::ilogb(largest), 63))) : 1.0f;
}

/// A node's value in channel `c`: 0 to 2 for red, green and blue.
float value_of(const Envmap& map, std::size_t row, std::size_t column, std::size_t c) {
  const bool last = row + 1 == map.height;
  const EnvmapColumn& at = map.columns[(last ? row - 1 : row) * (map.width + 1) + column];
  return envmap_value<Scalar>(at.radiance[last ? 3 + c : c]);
}

/// Encodes radiance into nodes; an image of one row is duplicated. Works in blocks of rows, allocating the table and
/// freeing the image as it goes.
void fill_radiance(Envmap& map, EnvmapImage& image, float scale) {
  constexpr std::size_t kBlockBytes = std::size_t{32} << 20;
  // Choose the unit of radiance and the size of blocks
  map.unit = unit_of(image, scale);
  const float factor = scale / map.unit;
  const std::size_t rows = map.height - 1, row_length = std::size_t{map.width} + 1;
  const std::size_t block = std::max<std::size_t>(kBlockBytes / (row_length * sizeof(EnvmapColumn)), 16);
  map.columns.reserve(rows * row_length);
  for (std::size_t first = 0; first < rows; first += block) {
    // Encode the rows of a block
    const std::size_t end = std::min(first + block, rows);
    map.columns.resize(end * row_length);
    tbb::parallel_for(first, end, [&](std::size_t j) {
      for (std::size_t i = 0; i <= map.width; ++i)
        for (std::size_t k = 0; k < 6; ++k) {
          const std::size_t row = std::min<std::size_t>(j + k / 3, image.height - 1);
          const std::size_t column = i < map.width ? i : 0;
          const float value = image.rgb[3 * (row * map.width + column) + k % 3] * factor;
          map.columns[j * row_length + i].radiance[k] = is_usable(value) ? envmap_code(value) : std::uint16_t{0};
        }
    });
    // Free the rows of the image above the block's last row, with which the next block starts
    const std::size_t done = std::min<std::size_t>(end, image.height - 1) * map.width * 3;
    release_pages(image.rgb.data(), done * sizeof(float));
  }
  image.rgb = {};
}

/// Mean radiance over all directions from the nodes' values, with the exact integrals of the hat functions.
void set_mean(Envmap& map) {
  std::vector<std::array<double, 3>> rows(map.height);
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t j) {
    const double weight = node_solid_angle(static_cast<std::uint32_t>(j), map.width, map.height);
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (std::size_t i = 0; i < map.width; ++i) sum += static_cast<double>(value_of(map, j, i, c));
      rows[j][c] = sum * weight;
    }
  });
  double sum[3] = {}, weights = 0;
  for (std::uint32_t j = 0; j < map.height; ++j) {
    weights += node_solid_angle(j, map.width, map.height) * map.width;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += rows[j][c];
  }
  const double scale = 0x1p64 * static_cast<double>(map.unit) / weights;
  map.mean = {static_cast<float>(sum[0] * scale), static_cast<float>(sum[1] * scale),
              static_cast<float>(sum[2] * scale)};
}

/// Adds the weight of each cell of row `j`: the mean brightness of its nodes times its solid angle.
void add_weights(const Envmap& map, std::size_t j, std::span<double> weights) {
  const double step = kPiDouble / (map.height - 1);
  const double sine = std::sin((static_cast<double>(j) + 0.5) * step) * std::sin(0.5 * step);
  const EnvmapColumn* const columns = &map.columns[j * (map.width + 1)];
  double before = 0;
  for (std::size_t i = 0; i <= map.width; ++i) {
    double here = 0;
    for (std::size_t k = 0; k < 6; k += 3) {
      const auto value = [&](std::size_t c) { return envmap_value<Scalar>(columns[i].radiance[k + c]); };
      here += static_cast<double>(envmap_brightness<Scalar>(value(0), value(1), value(2), map.offset));
    }
    if (i > 0) weights[i - 1] += (before + here) * sine;
    before = here;
  }
}

/// Builds the column table at `table` for the rows [first, first + run) of cells, and the cells' densities. `of_row` is
/// the probability of each row.
void fill_columns(Envmap& map, std::size_t first, std::size_t run, double of_row, Quantile* table) {
  std::vector<double> weights(map.width);
  for (std::size_t j = first; j < first + run; ++j) add_weights(map, j, weights);
  build_quantiles(weights, table);
  const double scale = of_row * map.width * (map.height - 1);
  for (std::size_t j = first; j < first + run; ++j)
    for (std::size_t i = 0; i < map.width; ++i)
      map.columns[j * (map.width + 1) + i].density = static_cast<float>(weights[i] * scale);
}

/// Builds the sampling tables. Returns false if the density is zero everywhere.
bool fill_density(Envmap& map) {
  const std::size_t rows = map.height - 1;
  std::vector<double> weights(rows);
  tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t j) {
    std::vector<double> cells(map.width);
    add_weights(map, j, cells);
    for (const double w : cells) weights[j] += w;
  });
  map.quantiles.resize(kQuantiles);
  map.tables.resize(kQuantiles);
  if (!build_quantiles(weights, map.quantiles.data())) return false;
  map.rows.assign(weights.begin(), weights.end());
  // Quantiles with the same run of rows share a table of columns.
  std::vector<Quantile> runs;
  for (std::size_t i = 0; i < kQuantiles; ++i) {
    const Quantile& q = map.quantiles[i];
    if (runs.empty() || runs.back().first() != q.first()) runs.push_back(q);
    map.tables[i] = static_cast<std::uint32_t>(runs.size()) * kQuantiles;
  }
  map.quantiles.resize((1 + runs.size()) * kQuantiles);
  tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t i) {
    fill_columns(map, runs[i].first(), runs[i].length(), weights[runs[i].first()],
                 &map.quantiles[(1 + i) * kQuantiles]);
  });
  return true;
}

}  // namespace

double node_solid_angle(std::uint32_t row, std::uint32_t width, std::uint32_t height) {
  const double hat = row == 0 || row == height - 1 ? 0.5 : 1.0;  // halved at the poles
  return hat * mean_sine(row, height) * (kPiDouble / (height - 1)) * (2 * kPiDouble / width);
}

namespace {

/// Throws SceneError if an image is too large.
void check_size(const EnvmapImage& image) {
  if (std::size_t{image.width} * image.height > kMaxEnvmapPixels)
    throw SceneError(
        fmt::format("an image of {} x {} pixels is too large for an environment map (expected at most 2^28)",
                    image.width, image.height));
  if (std::max(image.width, image.height) > kMaxQuantileEntries)
    throw SceneError(
        fmt::format("an image of {} x {} pixels is too long for an environment map (expected sides of at most {})",
                    image.width, image.height, kMaxQuantileEntries));
}

/// A map without its density.
Envmap radiance_map(EnvmapImage image, float scale) {
  check_size(image);
  Envmap map;
  map.width = image.width;
  map.height = std::max(image.height, 2u);
  map.to_map[0] = map.to_map[4] = map.to_map[8] = 1.0f;
  fill_radiance(map, image, scale);
  set_mean(map);
  return map;
}

}  // namespace

Vec3f envmap_mean(const EnvmapImage& image) { return radiance_map(image, 1).mean; }

Envmap make_envmap(EnvmapImage image, float scale, bool mis_compensation) {
  Envmap map = radiance_map(std::move(image), scale);
  // Build the sampling density, without compensation if that leaves nothing
  map.offset = mis_compensation ? luminance(map.mean) / map.unit : 0.0f;
  if (!fill_density(map)) {
    map.offset = 0;
    fill_density(map);
  }
  return map;
}

void uplift_nodes(Envmap& map) {
  const UpliftTable& table = UpliftTable::get();
  map.spectra.resize(4 * std::size_t{map.width} * map.height);
  const std::size_t width = map.width;
  const float unit = map.unit * 0x1p64f;
  tbb::parallel_for(std::size_t{0}, std::size_t{map.height}, [&](std::size_t row) {
    for (std::size_t first = 0; first < width; first += kWidth) {
      const int count = static_cast<int>(std::min<std::size_t>(kWidth, width - first));
      // Gather the colors of a register of nodes
      alignas(kSimdAlignment) float colors[3][kWidth];
      float* to[kWidth];
      for (int lane = 0; lane < kWidth; ++lane) {
        const std::size_t column = first + static_cast<std::size_t>(std::min(lane, count - 1));
        for (std::size_t c = 0; c < 3; ++c) colors[c][lane] = value_of(map, row, column, c) * unit;
        to[lane] = &map.spectra[4 * (row * width + column)];
      }
      // Upsample them
      WideFloat rgb[3];
      for (int c = 0; c < 3; ++c) load(colors[c], rgb[c]);
      const ScaledSigmoid<Wide> s = uplift_unbounded<Wide>(table, {rgb[0], rgb[1], rgb[2]});
      const WideFloat spectrum[4] = {s.shape.c0, s.shape.c1, s.shape.c2, s.scale};
      store_rows4(to, spectrum, count);
    }
  });
}

EnvmapImage read_envmap_image(const std::filesystem::path& file, bool raw) {
  const SourceLocation where{file.string(), 0};
  // Read the image and find its colors
  StoredImage stored = cached(file, "stored image", [&] { return read_stored_image(file); });
  const std::vector<std::size_t> channels = find_color_channels(stored.channels, where).channels;
  const std::size_t stride = stored.channels.size();
  const bool bytes = !stored.bytes.empty(), encoded = !raw && (bytes || stored.integers);
  const auto value = [&](std::size_t index) {
    if (bytes && encoded) return linear_of_srgb_bytes()[stored.bytes[index]];
    const float raw_value = bytes ? static_cast<float>(stored.bytes[index]) / 255.0f : stored.floats[index];
    return encoded ? srgb_to_linear(raw_value) : raw_value;
  };
  EnvmapImage out;
  out.width = static_cast<std::uint32_t>(stored.width);
  out.height = static_cast<std::uint32_t>(stored.height);
  const std::size_t pixels = std::size_t{out.width} * out.height;
  // If pixels do not grow, reuse the image's memory: pixels are written only after they are read.
  const bool in_place = !bytes && stride >= 3;
  if (!in_place) out.rgb.resize(3 * pixels);
  std::vector<float>& to = in_place ? stored.floats : out.rgb;
  // Decode the pixels
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    const auto channel = [&](std::size_t c) {
      return value(pixel * stride + channels[std::min(c, channels.size() - 1)]);
    };
    const float rgb[3] = {channel(0), channel(1), channel(2)};
    std::copy(std::begin(rgb), std::end(rgb), &to[3 * pixel]);
  }
  // Free the memory behind the pixels
  if (in_place) {
    release_pages(&to[3 * pixels - 1] + 1, (to.size() - 3 * pixels) * sizeof(float));
    to.resize(3 * pixels);
    out.rgb = std::move(to);
  }
  return out;
}

UnusableValues replace_unusable(EnvmapImage& image) {
  UnusableValues counts;
  for (float& value : image.rgb) {
    if (is_usable(value)) continue;
    const bool infinite = value > 0.0f;
    ++(infinite ? counts.infinite : counts.dark);
    value = infinite ? kInfiniteTexel : 0.0f;
  }
  return counts;
}

}  // namespace sheaf
