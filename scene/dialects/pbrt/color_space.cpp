// The pbrt dialect: colors in color spaces other than Rec.709.
#include "core/color/color_space.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <array>

namespace sheaf::pbrt {

namespace {

struct RgbSpace {
  const char* name;
  RgbChromaticities chromaticities;
};
constexpr Chromaticity kD65 = {0.3127, 0.3290};
/// ITU-R BT.709; the primaries of SMPTE RP 431-2 with D65; ITU-R BT.2020; SMPTE ST 2065-1.
constexpr RgbSpace kSpaces[] = {{"srgb", kRec709Space},
                                {"dci-p3", {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, kD65}},
                                {"rec2020", {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, kD65}},
                                {"aces2065-1", {{0.7347, 0.2653}, {0, 1}, {0.0001, -0.0770}, {0.32168, 0.33767}}}};

/// Chromatic adaptation matrix in XYZ from white `from` to white `to` (Lam 1985, the Bradford transform).
Matrix3 adaptation(const Chromaticity& from, const Chromaticity& to) {
  const Matrix3 bradford{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
  const std::array<double, 3> a = bradford * xyz_of(from), b = bradford * xyz_of(to);
  const Matrix3 scale{{{b[0] / a[0], 0, 0}, {0, b[1] / a[1], 0}, {0, 0, b[2] / a[2]}}};
  return inverse(bradford) * (scale * bradford);
}

}  // namespace

const std::vector<std::string>& color_space_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const RgbSpace& space : kSpaces) all.emplace_back(space.name);
    return all;
  }();
  return names;
}

Vec3f to_rec709(Parameters& p, Vec3f rgb, Use use) {
  const std::size_t index = p.reader().attributes.color_space;
  if (index == 0) return rgb;
  const RgbSpace& space = kSpaces[index];
  Matrix3 matrix = rgb_to_xyz(space.chromaticities);
  if (use != Use::kLight) matrix = adaptation(space.chromaticities.white, kRec709Space.white) * matrix;
  const std::array<double, 3> v =
      inverse(rgb_to_xyz(kRec709Space)) * (matrix * std::array<double, 3>{double{rgb.x}, double{rgb.y}, double{rgb.z}});
  // Tolerance, because white may deviate from 1 by rounding.
  constexpr double kRounding = 1e-6;
  const double max_value = use == Use::kReflectance ? 1 : std::numeric_limits<double>::max();
  Vec3f out;
  float* const parts[3] = {&out.x, &out.y, &out.z};
  bool outside = false;
  for (std::size_t c = 0; c < 3; ++c) {
    outside = outside || v[c] < -kRounding || v[c] > max_value + kRounding;
    *parts[c] = static_cast<float>(std::clamp(v[c], 0.0, max_value));
  }
  if (outside && !p.reader().noted_gamut) {
    p.reader().note(p.where(), fmt::format("{}: a color of {} is outside of Rec.709 and clamped (reported once)",
                                           p.title(), space.name));
    p.reader().noted_gamut = true;
  }
  return out;
}

}  // namespace sheaf::pbrt
