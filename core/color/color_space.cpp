// Matrices of RGB color spaces and conversion of pixels to linear Rec.709.
#include "core/color/color_space.h"

#include <cmath>
#include <cstddef>

namespace sheaf {

namespace {

/// Whether two spaces agree within 2e-4 per coordinate, which covers the rounding in image files.
bool same_space(const RgbChromaticities& a, const RgbChromaticities& b) {
  const auto same = [](const Chromaticity& p, const Chromaticity& q) {
    constexpr double kRounding = 2e-4;
    return std::abs(p.x - q.x) < kRounding && std::abs(p.y - q.y) < kRounding;
  };
  return same(a.red, b.red) && same(a.green, b.green) && same(a.blue, b.blue) && same(a.white, b.white);
}

}  // namespace

Matrix3 operator*(const Matrix3& a, const Matrix3& b) {
  Matrix3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * b[k][j];
  return out;
}

std::array<double, 3> operator*(const Matrix3& a, const std::array<double, 3>& v) {
  return {a[0][0] * v[0] + a[0][1] * v[1] + a[0][2] * v[2], a[1][0] * v[0] + a[1][1] * v[1] + a[1][2] * v[2],
          a[2][0] * v[0] + a[2][1] * v[1] + a[2][2] * v[2]};
}

Matrix3 inverse(const Matrix3& m) {
  Matrix3 out;
  double determinant = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      out[j][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
      if (i == 0) determinant += m[0][j] * out[j][0];
    }
  for (auto& row : out)
    for (double& entry : row) entry /= determinant;
  return out;
}

std::array<double, 3> xyz_of(const Chromaticity& c) { return {c.x / c.y, 1, (1 - c.x - c.y) / c.y}; }

Matrix3 rgb_to_xyz(const RgbChromaticities& space) {
  Matrix3 primaries;
  const Chromaticity* const columns[3] = {&space.red, &space.green, &space.blue};
  for (std::size_t j = 0; j < 3; ++j) {
    const Chromaticity& c = *columns[j];
    primaries[0][j] = c.x, primaries[1][j] = c.y, primaries[2][j] = 1 - c.x - c.y;
  }
  const std::array<double, 3> amounts = inverse(primaries) * xyz_of(space.white);
  for (auto& row : primaries)
    for (std::size_t j = 0; j < 3; ++j) row[j] *= amounts[j];
  return primaries;
}

std::optional<Matrix3> rgb_to_rec709(const RgbChromaticities& space) {
  constexpr double kMaxEntry = 1e6;  // beyond it, the primaries lie almost on a line
  const Matrix3 matrix = inverse(rgb_to_xyz(kRec709Space)) * rgb_to_xyz(space);
  for (const auto& row : matrix)
    for (const double entry : row)
      if (!(std::abs(entry) < kMaxEntry)) return std::nullopt;
  return matrix;
}

bool convert_to_rec709(std::span<float> rgb, const RgbChromaticities& space, std::size_t stride) {
  if (same_space(space, kRec709Space)) return true;
  const std::optional<Matrix3> matrix = rgb_to_rec709(space);
  if (!matrix) return false;
  for (std::size_t i = 0; i + 2 < rgb.size(); i += stride) {
    if (!std::isfinite(rgb[i]) || !std::isfinite(rgb[i + 1]) || !std::isfinite(rgb[i + 2])) continue;
    const std::array<double, 3> color =
        *matrix * std::array<double, 3>{double{rgb[i]}, double{rgb[i + 1]}, double{rgb[i + 2]}};
    for (std::size_t c = 0; c < 3; ++c) rgb[i + c] = static_cast<float>(color[c]);
  }
  return true;
}

}  // namespace sheaf
