// Color conversions and the CIE tables that they use.
#include "core/color/color.h"

#include "core/io/error.h"

#include <fmt/format.h>

#include <cstddef>
#include <vector>

namespace sheaf {

namespace {

constexpr double kTableStep = 5.0;
constexpr std::size_t kCurveSize = 95;
using Curve = std::array<float, kCurveSize>;

constexpr Curve kCieX{
    0.0001299f,    0.0002321f,    0.0004149f,    0.0007416f,    0.001368f,    0.002236f,     0.004243f,
    0.00765f,      0.01431f,      0.02319f,      0.04351f,      0.07763f,     0.13438f,      0.21477f,
    0.2839f,       0.3285f,       0.34828f,      0.34806f,      0.3362f,      0.3187f,       0.2908f,
    0.2511f,       0.19536f,      0.1421f,       0.09564f,      0.05795001f,  0.03201f,      0.0147f,
    0.0049f,       0.0024f,       0.0093f,       0.0291f,       0.06327f,     0.1096f,       0.1655f,
    0.2257499f,    0.2904f,       0.3597f,       0.4334499f,    0.5120501f,   0.5945f,       0.6784f,
    0.7621f,       0.8425f,       0.9163f,       0.9786f,       1.0263f,      1.0567f,       1.0622f,
    1.0456f,       1.0026f,       0.9384f,       0.8544499f,    0.7514f,      0.6424f,       0.5419f,
    0.4479f,       0.3608f,       0.2835f,       0.2187f,       0.1649f,      0.1212f,       0.0874f,
    0.0636f,       0.04677f,      0.0329f,       0.0227f,       0.01584f,     0.01135916f,   0.008110916f,
    0.005790346f,  0.004109457f,  0.002899327f,  0.00204919f,   0.001439971f, 0.0009999493f, 0.0006900786f,
    0.0004760213f, 0.0003323011f, 0.0002348261f, 0.0001661505f, 0.000117413f, 8.307527e-5f,  5.870652e-5f,
    4.150994e-5f,  2.935326e-5f,  2.067383e-5f,  1.455977e-5f,  1.025398e-5f, 7.221456e-6f,  5.085868e-6f,
    3.581652e-6f,  2.522525e-6f,  1.776509e-6f,  1.251141e-6f};

constexpr Curve kCieY{3.917e-6f,  6.965e-6f,  1.239e-5f,  2.202e-5f,  3.9e-5f,    6.4e-5f,    0.00012f,   0.000217f,
                      0.000396f,  0.00064f,   0.00121f,   0.00218f,   0.004f,     0.0073f,    0.0116f,    0.01684f,
                      0.023f,     0.0298f,    0.038f,     0.048f,     0.06f,      0.0739f,    0.09098f,   0.1126f,
                      0.13902f,   0.1693f,    0.20802f,   0.2586f,    0.323f,     0.4073f,    0.503f,     0.6082f,
                      0.71f,      0.7932f,    0.862f,     0.9148501f, 0.954f,     0.9803f,    0.9949501f, 1.0f,
                      0.995f,     0.9786f,    0.952f,     0.9154f,    0.87f,      0.8163f,    0.757f,     0.6949f,
                      0.631f,     0.5668f,    0.503f,     0.4412f,    0.381f,     0.321f,     0.265f,     0.217f,
                      0.175f,     0.1382f,    0.107f,     0.0816f,    0.061f,     0.04458f,   0.032f,     0.0232f,
                      0.017f,     0.01192f,   0.00821f,   0.005723f,  0.004102f,  0.002929f,  0.002091f,  0.001484f,
                      0.001047f,  0.00074f,   0.00052f,   0.0003611f, 0.0002492f, 0.0001719f, 0.00012f,   8.48e-5f,
                      6e-5f,      4.24e-5f,   3e-5f,      2.12e-5f,   1.499e-5f,  1.06e-5f,   7.4657e-6f, 5.2578e-6f,
                      3.7029e-6f, 2.6078e-6f, 1.8366e-6f, 1.2934e-6f, 9.1093e-7f, 6.4153e-7f, 4.5181e-7f};

constexpr Curve kCieZ{
    0.0006061f,  0.001086f,    0.001946f, 0.003486f, 0.006450001f, 0.01054999f, 0.02005001f,  0.03621f,
    0.06785001f, 0.1102f,      0.2074f,   0.3713f,   0.6456f,      1.03905f,    1.3856f,      1.62296f,
    1.74706f,    1.7826f,      1.77211f,  1.7441f,   1.6692f,      1.5281f,     1.28764f,     1.0419f,
    0.8129501f,  0.6162f,      0.46518f,  0.3533f,   0.272f,       0.2123f,     0.1582f,      0.1117f,
    0.07824999f, 0.05725001f,  0.04216f,  0.02984f,  0.0203f,      0.0134f,     0.008749999f, 0.005749999f,
    0.0039f,     0.002749999f, 0.0021f,   0.0018f,   0.001650001f, 0.0014f,     0.0011f,      0.001f,
    0.0008f,     0.0006f,      0.00034f,  0.00024f,  0.00019f,     0.0001f,     4.999999e-5f, 3e-5f,
    2e-5f,       1e-5f,        0.0f,      0.0f,      0.0f,         0.0f,        0.0f,         0.0f,
    0.0f,        0.0f,         0.0f,      0.0f,      0.0f,         0.0f,        0.0f,         0.0f,
    0.0f,        0.0f,         0.0f,      0.0f,      0.0f,         0.0f,        0.0f,         0.0f,
    0.0f,        0.0f,         0.0f,      0.0f,      0.0f,         0.0f,        0.0f,         0.0f,
    0.0f,        0.0f,         0.0f,      0.0f,      0.0f,         0.0f,        0.0f};

constexpr Curve kD65{46.6383f, 49.3637f, 52.0891f, 51.0323f, 49.9755f, 52.3118f, 54.6482f, 68.7015f, 82.7549f, 87.1204f,
                     91.486f,  92.4589f, 93.4318f, 90.057f,  86.6823f, 95.7736f, 104.865f, 110.936f, 117.008f, 117.41f,
                     117.812f, 116.336f, 114.861f, 115.392f, 115.923f, 112.367f, 108.811f, 109.082f, 109.354f, 108.578f,
                     107.802f, 106.296f, 104.79f,  106.239f, 107.689f, 106.047f, 104.405f, 104.225f, 104.046f, 102.023f,
                     100.0f,   98.1671f, 96.3342f, 96.0611f, 95.788f,  92.2368f, 88.6856f, 89.3459f, 90.0062f, 89.8026f,
                     89.5991f, 88.6489f, 87.6987f, 85.4936f, 83.2886f, 83.4939f, 83.6992f, 81.863f,  80.0268f, 80.1207f,
                     80.2146f, 81.2462f, 82.2778f, 80.281f,  78.2842f, 74.0027f, 69.7213f, 70.6652f, 71.6091f, 72.979f,
                     74.349f,  67.9765f, 61.604f,  65.7448f, 69.8856f, 72.4863f, 75.087f,  69.3398f, 63.5927f, 55.0054f,
                     46.4182f, 56.6118f, 66.8054f, 65.0941f, 63.3828f, 63.8434f, 64.304f,  61.8779f, 59.4519f, 55.7054f,
                     51.959f,  54.6998f, 57.4406f, 58.8765f, 60.3125f};

struct Xyz {
  double x = 0, y = 0, z = 0;
};

/// Linear interpolation in a curve, zero outside.
double evaluate(const Curve& curve, double wavelength) {
  const double position = (wavelength - kWavelengthMin) / kTableStep;
  if (!(position >= 0 && position <= static_cast<double>(kCurveSize - 1))) return 0;
  const std::size_t i = std::min(static_cast<std::size_t>(position), kCurveSize - 2);
  const double t = position - static_cast<double>(i);
  return (1 - t) * static_cast<double>(curve[i]) + t * static_cast<double>(curve[i + 1]);
}

/// A spectrum given by the caller, piecewise linear and zero outside its wavelengths.
struct Table {
  std::span<const float> wavelengths, values;

  /// The value at a wavelength within segment `i`, between entries i and i + 1.
  double evaluate(std::size_t i, double wavelength) const {
    const double a = wavelengths[i], b = wavelengths[i + 1];
    const double t = (wavelength - a) / (b - a);
    return (1 - t) * static_cast<double>(values[i]) + t * static_cast<double>(values[i + 1]);
  }
};

void check(const Table& table) {
  if (table.wavelengths.size() != table.values.size()) {
    throw SceneError(
        fmt::format("a spectrum has {} wavelengths but {} values", table.wavelengths.size(), table.values.size()));
  }
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    if (!std::isfinite(table.wavelengths[i]) || !std::isfinite(table.values[i])) {
      throw SceneError(fmt::format("entry {} of a spectrum is not a finite number", i));
    }
    if (i > 0 && !(table.wavelengths[i] > table.wavelengths[i - 1])) {
      throw SceneError(fmt::format("wavelengths of a spectrum must increase, but {} follows {}", table.wavelengths[i],
                                   table.wavelengths[i - 1]));
    }
  }
}

enum class Weight { kEqualEnergy, kDaylight };

/// Adds the integral over [a, b], which must lie within one segment of the table and one of the curves. The integrand
/// is at most a cubic there, so Simpson's rule is exact.
void add_interval(const Table& table, std::size_t segment, double a, double b, Weight weight, Xyz& sum) {
  for (int k = 0; k < 3; ++k) {
    const double wavelength = k == 0 ? a : k == 1 ? 0.5 * (a + b) : b;
    const double power = weight == Weight::kDaylight ? evaluate(kD65, wavelength) : 1.0;
    const double scale = (k == 1 ? 4.0 : 1.0) * (b - a) / 6.0 * power * table.evaluate(segment, wavelength);
    sum.x += scale * evaluate(kCieX, wavelength);
    sum.y += scale * evaluate(kCieY, wavelength);
    sum.z += scale * evaluate(kCieZ, wavelength);
  }
}

/// The integral of the product of table, weight and color matching functions.
Xyz integrate(const Table& table, Weight weight) {
  Xyz sum;
  for (std::size_t i = 0; i + 1 < table.values.size(); ++i) {
    const double end = std::min<double>(table.wavelengths[i + 1], kWavelengthMax);
    double a = std::max<double>(table.wavelengths[i], kWavelengthMin);
    while (a < end) {
      const double next = kWavelengthMin + (std::floor((a - kWavelengthMin) / kTableStep) + 1) * kTableStep;
      const double b = std::min(next, end);
      add_interval(table, i, a, b, weight, sum);
      a = b;
    }
  }
  return sum;
}

Xyz integrate_white(Weight weight) {
  constexpr std::array<float, 2> kRange{kWavelengthMin, kWavelengthMax};
  constexpr std::array<float, 2> kOne{1.0f, 1.0f};
  return integrate({kRange, kOne}, weight);
}

Vec3f to_rec709(const Xyz& c, double scale) {
  return xyz_to_rec709(
      {static_cast<float>(c.x * scale), static_cast<float>(c.y * scale), static_cast<float>(c.z * scale)});
}

Vec3f without_negatives(Vec3f a) { return {std::max(a.x, 0.0f), std::max(a.y, 0.0f), std::max(a.z, 0.0f)}; }

}  // namespace

float linear_to_srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

float srgb_to_linear(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

Vec3f srgb_to_linear(Vec3f encoded) {
  return {srgb_to_linear(encoded.x), srgb_to_linear(encoded.y), srgb_to_linear(encoded.z)};
}

Vec3f rec709_to_xyz(Vec3f rgb) {
  return {0.4123908f * rgb.x + 0.3575843f * rgb.y + 0.1804808f * rgb.z,
          0.2126390f * rgb.x + 0.7151687f * rgb.y + 0.0721923f * rgb.z,
          0.0193308f * rgb.x + 0.1191948f * rgb.y + 0.9505322f * rgb.z};
}

Vec3f xyz_to_rec709(Vec3f xyz) {
  return {3.2409699f * xyz.x - 1.5373832f * xyz.y - 0.4986108f * xyz.z,
          -0.9692436f * xyz.x + 1.8759675f * xyz.y + 0.0415551f * xyz.z,
          0.0556301f * xyz.x - 0.2039770f * xyz.y + 1.0569715f * xyz.z};
}

float luminance(Vec3f rgb) { return rec709_to_xyz(rgb).y; }

Vec3f cie_1931_xyz(float wavelength) {
  return {static_cast<float>(evaluate(kCieX, wavelength)), static_cast<float>(evaluate(kCieY, wavelength)),
          static_cast<float>(evaluate(kCieZ, wavelength))};
}

float cie_d65(float wavelength) { return static_cast<float>(evaluate(kD65, wavelength)); }

double blackbody_radiance(double wavelength, double temperature) {
  constexpr double kPlanck = 6.62607015e-34, kLight = 299792458.0, kBoltzmann = 1.380649e-23;
  if (!(temperature > 0) || !(wavelength > 0)) return 0;
  const double meters = wavelength * 1e-9;
  const double exponent = kPlanck * kLight / (meters * kBoltzmann * temperature);
  const double per_meter = 2 * kPlanck * kLight * kLight / (std::pow(meters, 5) * std::expm1(exponent));
  return per_meter * 1e-9;
}

Vec3f unbounded_table_to_rgb(std::span<const float> wavelengths, std::span<const float> values) {
  const Table table{wavelengths, values};
  check(table);
  static const Xyz white = integrate_white(Weight::kDaylight);
  static const Vec3f white_rgb = to_rec709(white, 1 / white.y);
  const Vec3f rgb = to_rec709(integrate(table, Weight::kDaylight), 1 / white.y);
  return without_negatives({rgb.x / white_rgb.x, rgb.y / white_rgb.y, rgb.z / white_rgb.z});
}

Vec3f reflectance_table_to_rgb(std::span<const float> wavelengths, std::span<const float> values) {
  const Vec3f rgb = unbounded_table_to_rgb(wavelengths, values);
  return {std::min(rgb.x, 1.0f), std::min(rgb.y, 1.0f), std::min(rgb.z, 1.0f)};
}

Vec3f emission_table_to_rgb(std::span<const float> wavelengths, std::span<const float> values) {
  const Table table{wavelengths, values};
  check(table);
  static const double y_integral = integrate_white(Weight::kEqualEnergy).y;
  return without_negatives(to_rec709(integrate(table, Weight::kEqualEnergy), 1 / y_integral));
}

Vec3f blackbody_to_rgb(float temperature, float scale) {
  std::vector<float> wavelengths, values;
  for (float wavelength = kWavelengthMin; wavelength <= kWavelengthMax; wavelength += 1.0f) {
    wavelengths.push_back(wavelength);
    values.push_back(static_cast<float>(blackbody_radiance(wavelength, temperature) * static_cast<double>(scale)));
  }
  return emission_table_to_rgb(wavelengths, values);
}

}  // namespace sheaf
