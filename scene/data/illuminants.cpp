// Illuminants by the formulas of CIE 15:2018 (ISO/CIE 11664-2), sections 4.1.1 and 4.1.2.
#include "scene/data/illuminants.h"

#include "core/color/color.h"

#include <cmath>
#include <iterator>

namespace sheaf {

namespace {

/// Components of daylight every 10 nm from 360 to 830 nm, linear in between by definition. Source: D. B. Judd, D. L.
/// MacAdam and G. Wyszecki, "Spectral Distribution of Typical Daylight as a Function of Correlated Color Temperature",
/// J. Opt. Soc. Am. 54, 1964, table 3, adopted by the CIE.
constexpr double kDaylight0[] = {61.5,  68.8,  63.4,  65.8,  94.8,  104.8, 105.9, 96.8,  113.9, 125.6, 125.5, 121.3,
                                 121.3, 113.5, 113.1, 110.8, 106.5, 108.8, 105.3, 104.4, 100.0, 96.0,  95.1,  89.1,
                                 90.5,  90.3,  88.4,  84.0,  85.1,  81.9,  82.6,  84.9,  81.3,  71.9,  74.3,  76.4,
                                 63.3,  71.7,  77.0,  65.2,  47.7,  68.6,  65.0,  66.0,  61.0,  53.3,  58.9,  61.9};
constexpr double kDaylight1[] = {38.0,  42.4,  38.5,  35.0,  43.4,  46.3,  43.9,  37.1,  36.7,  35.9,  32.6,  27.9,
                                 24.3,  20.1,  16.2,  13.2,  8.6,   6.1,   4.2,   1.9,   0.0,   -1.6,  -3.5,  -3.5,
                                 -5.8,  -7.2,  -8.6,  -9.5,  -10.9, -10.7, -12.0, -14.0, -13.6, -12.0, -13.3, -12.9,
                                 -10.6, -11.6, -12.2, -10.2, -7.8,  -11.2, -10.4, -10.6, -9.7,  -8.3,  -9.3,  -9.8};
constexpr double kDaylight2[] = {5.3,  6.1,  3.0,  1.2,  -1.1, -0.5, -0.7, -1.2, -2.6, -2.9, -2.8, -2.6,
                                 -2.6, -1.8, -1.5, -1.3, -1.2, -1.0, -0.5, -0.3, 0.0,  0.2,  0.5,  2.1,
                                 3.2,  4.1,  4.7,  5.1,  6.7,  7.3,  8.6,  9.8,  10.2, 8.3,  9.6,  8.5,
                                 7.0,  7.6,  8.0,  6.7,  5.2,  7.4,  6.8,  7.0,  6.4,  5.5,  6.1,  6.5};
constexpr std::size_t kDaylightSize = 48;
static_assert(std::size(kDaylight0) == kDaylightSize && std::size(kDaylight1) == kDaylightSize &&
              std::size(kDaylight2) == kDaylightSize);

double three_decimals(double a) { return std::round(a * 1000) / 1000; }

/// Illuminant D of a nominal temperature from 4000 to 25000 K, at a wavelength in nm. Nominal temperatures refer to c2
/// = 1.4380e-2 m K. The standard requires rounding the factors of the components.
double daylight(double nominal_temperature, double wavelength) {
  const double t = nominal_temperature * 1.4388 / 1.4380;
  const double x = t <= 7000 ? -4.6070e9 / (t * t * t) + 2.9678e6 / (t * t) + 0.09911e3 / t + 0.244063
                             : -2.0064e9 / (t * t * t) + 1.9018e6 / (t * t) + 0.24748e3 / t + 0.237040;
  const double y = -3.000 * x * x + 2.870 * x - 0.275;
  const double m = 0.0241 + 0.2562 * x - 0.7341 * y;
  const double m1 = three_decimals((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
  const double m2 = three_decimals((0.0300 - 31.4424 * x + 30.0717 * y) / m);
  const double position = (wavelength - 360.0) / 10.0;
  const std::size_t i = std::min(static_cast<std::size_t>(position), kDaylightSize - 2);
  const double u = position - static_cast<double>(i);
  const auto at = [&](std::size_t k) { return kDaylight0[k] + m1 * kDaylight1[k] + m2 * kDaylight2[k]; };
  return (1 - u) * at(i) + u * at(i + 1);
}

/// Illuminant A: a blackbody at 2848 K with c2 = 1.435e-2 m K, which is 2856 K with today's constant.
double incandescent(double wavelength) {
  const auto bose = [](double w) { return std::expm1(1.435e7 / (2848.0 * w)); };
  return 100.0 * std::pow(560.0 / wavelength, 5) * bose(560.0) / bose(wavelength);
}

struct Illuminant {
  const char* name;
  double (*power)(double wavelength);
};
constexpr Illuminant kIlluminants[] = {
    {"a", incandescent},
    {"d50", [](double wavelength) { return daylight(5000, wavelength); }},
    {"d55", [](double wavelength) { return daylight(5500, wavelength); }},
    {"d65", [](double wavelength) { return static_cast<double>(cie_d65(static_cast<float>(wavelength))); }},
    {"d75", [](double wavelength) { return daylight(7500, wavelength); }},
    {"e", [](double) { return 1.0; }}};

}  // namespace

std::optional<SpectrumDescription::Table> find_illuminant(std::string_view name) {
  for (const Illuminant& illuminant : kIlluminants) {
    if (name != illuminant.name) continue;
    SpectrumDescription::Table table;
    double y = 0, total = 0;
    for (double wavelength = 360; wavelength <= 830; wavelength += 1) {
      const double curve = static_cast<double>(cie_1931_xyz(static_cast<float>(wavelength)).y);
      y += curve * illuminant.power(wavelength);
      total += curve;
    }
    for (double wavelength = 360; wavelength <= 830; wavelength += 1) {
      table.wavelengths.push_back(static_cast<float>(wavelength));
      table.values.push_back(static_cast<float>(illuminant.power(wavelength) * total / y));
    }
    return table;
  }
  return std::nullopt;
}

std::vector<std::string> illuminant_names() {
  std::vector<std::string> names;
  for (const Illuminant& illuminant : kIlluminants) names.emplace_back(illuminant.name);
  return names;
}

}  // namespace sheaf
