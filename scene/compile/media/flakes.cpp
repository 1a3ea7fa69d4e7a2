#include "scene/compile/media/flakes.h"

#include "scene/compile/media/build_brick_grid.h"
#include "scene/compile/media/load_volume.h"
#include "scene/formats/vol_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf {

namespace {

constexpr int kChannels = 6;

/// Smallest and largest eigenvalue (Smith, "Eigenvalues of a Symmetric 3 x 3 Matrix", 1961).
std::array<double, 2> extreme_eigenvalues(const std::array<float, 6>& matrix) {
  const auto [xx, yy, zz, xy, xz, yz] =
      std::array<double, 6>{matrix[0], matrix[1], matrix[2], matrix[3], matrix[4], matrix[5]};
  const double mean = (xx + yy + zz) / 3, a = xx - mean, b = yy - mean, c = zz - mean;
  const double spread = std::sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  if (!(spread > 0)) return {mean, mean};
  const double determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const double angle = std::acos(std::clamp(determinant / (2 * spread * spread * spread), -1.0, 1.0)) / 3;
  return {mean + 2 * spread * std::cos(angle + 2 * std::numbers::pi / 3), mean + 2 * spread * std::cos(angle)};
}

/// A grid with three of the channels, starting with `first`.
BrickGrid take_channels(const DenseVolume& volume, std::size_t first, GridVolumeDescription::Wrap wrap) {
  std::vector<float> values;
  for (std::size_t at = first; at < volume.values.size(); at += kChannels)
    values.insert(values.end(), &volume.values[at], &volume.values[at] + 3);
  BrickGrid grid = make_dense_grid(3, volume.size, values, border_of(wrap));
  grid.grid_to_local = volume.grid_to_local;
  return grid;
}

}  // namespace

float largest_flake_area(const std::array<float, 6>& matrix) {
  for (const float entry : matrix)
    if (!std::isfinite(entry)) throw SceneError("a matrix of microflakes holds a number that is not finite");
  constexpr double kRounding = 1e-4;
  const auto [smallest, largest] = extreme_eigenvalues(matrix);
  if (smallest < -kRounding * std::max(largest, 0.0)) {
    throw SceneError(fmt::format(
        "the matrix of microflakes {} (xx yy zz xy xz yz) has the negative eigenvalue {:.6g}, so it describes "
        "no ellipsoid (expected none)",
        fmt::join(matrix, " "), smallest));
  }
  return static_cast<float>(std::sqrt(std::max(largest, 0.0)));
}

FlakeGrids load_flakes(const GridVolumeDescription& description, const SourceLocation& where) {
  const std::string file = description.file.string();
  if (description.format != GridVolumeDescription::Format::kVol)
    throw SceneError(where, file + ": matrices of microflakes have six channels (expected a .vol file)");
  try {
    const DenseVolume volume = read_vol(description.file, description.use_grid_bbox, VolChannels::kMatrices);
    FlakeGrids out;
    for (std::size_t at = 0; at < volume.values.size(); at += kChannels) {
      std::array<float, kChannels> matrix;
      std::copy_n(&volume.values[at], kChannels, matrix.begin());
      try {
        out.largest = std::max(out.largest, largest_flake_area(matrix));
      } catch (const SceneError& error) {
        throw SceneError({file}, fmt::format("voxel {}: {}", at / kChannels, error.what()), error.code());
      }
    }
    out.diagonal = take_channels(volume, 0, description.wrap);
    out.others = take_channels(volume, 3, description.wrap);
    return out;
  } catch (const SceneError& error) { throw SceneError(where, error); }
}

}  // namespace sheaf
