#include "core/color/tone_map.h"

#include "core/color/color_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sheaf {

namespace {

using Color = std::array<double, 3>;

Color clamped(const Color& color) {
  return {std::clamp(color[0], 0.0, 1.0), std::clamp(color[1], 0.0, 1.0), std::clamp(color[2], 0.0, 1.0)};
}

template <class Curve> Color per_channel(const Color& color, Curve curve) {
  return {curve(color[0]), curve(color[1]), curve(color[2])};
}

/// The constants of Hable's curve: shoulder strength, linear strength, linear angle, toe strength, toe numerator and
/// toe denominator; the value that becomes white, and the exposure before the curve.
double filmic_curve(double x) {
  constexpr double kA = 0.15, kB = 0.50, kC = 0.10, kD = 0.20, kE = 0.02, kF = 0.30;
  return (x * (kA * x + kC * kB) + kD * kE) / (x * (kA * x + kB) + kD * kF) - kE / kF;
}

Color filmic(const Color& color) {
  constexpr double kWhite = 11.2, kExposure = 2.0;
  const double white = filmic_curve(kWhite);
  return per_channel(color, [&](double x) { return filmic_curve(kExposure * x) / white; });
}

/// Rec.709 to AP1 with the saturation of the reference rendering transform, and back with that of the output transform.
constexpr Matrix3 kAcesInput{{{0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}}};
constexpr Matrix3 kAcesOutput{
    {{1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}}};

Color aces(const Color& color) {
  return kAcesOutput * per_channel(kAcesInput * color, [](double x) {
           return (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
         });
}

/// Rec.709 to the inset primaries of AgX.
constexpr Matrix3 kAgxInset{{{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                             {0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                             {0.0423756549057051, 0.0784336, 0.879142973793104}}};

/// Encodes logarithmically from 10 stops below middle gray to 6.5 above, and applies the sigmoid.
double agx_curve(double value) {
  constexpr double kLowest = -12.47393, kHighest = 4.026069;  // log2 of scene values
  const double stops = std::clamp(std::log2(std::max(value, 1e-10)), kLowest, kHighest);
  const double x = (stops - kLowest) / (kHighest - kLowest);
  return std::max(0.0, (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232);
}

/// Decodes the display values with the exponent 2.2.
Color agx(const Color& color) {
  static const Matrix3 outset = inverse(kAgxInset);
  const Color encoded = outset * per_channel(kAgxInset * color, agx_curve);
  return per_channel(clamped(encoded), [](double x) { return std::pow(x, 2.2); });
}

}  // namespace

Vec3f tone_mapped(ToneMap map, Vec3f rgb) {
  const auto finite = [](float x) {
    return x > 0 ? static_cast<double>(std::min(x, std::numeric_limits<float>::max())) : 0.0;
  };
  Color color{finite(rgb.x), finite(rgb.y), finite(rgb.z)};
  switch (map) {
    case ToneMap::kClamp:
      break;
    case ToneMap::kFilmic:
      color = filmic(color);
      break;
    case ToneMap::kAces:
      color = aces(color);
      break;
    case ToneMap::kAgx:
      color = agx(color);
      break;
  }
  color = clamped(color);
  return {static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])};
}

}  // namespace sheaf
