// Color: integrals of the CIE tables, the sRGB transfer curve, and the interpretation of tabulated spectra.
#include "core/color/color.h"

#include "core/io/error.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <limits>
#include <vector>

namespace sheaf::test_color {

namespace {

const std::vector<float> kList{400, 500, 600, 700};

void check_close(Vec3f found, Vec3f expected, double relative) {
  CHECK(found.x == near(expected.x, relative));
  CHECK(found.y == near(expected.y, relative));
  CHECK(found.z == near(expected.z, relative));
}

Vec3f sum_of_curves(bool under_d65) {
  Vec3f sum;
  for (float wavelength = 360; wavelength <= 830; wavelength += 5) {
    sum = sum + cie_1931_xyz(wavelength) * (under_d65 ? cie_d65(wavelength) : 1.0f);
  }
  return sum;
}

}  // namespace

TEST_CASE("D65 has its published chromaticity for the 2-degree observer") {
  const Vec3f xyz = sum_of_curves(true);
  const float sum = xyz.x + xyz.y + xyz.z;
  CHECK(std::abs(xyz.x / sum - 0.3127f) < 1e-4f);
  CHECK(std::abs(xyz.y / sum - 0.3290f) < 1e-4f);
}

TEST_CASE("the color matching functions have equal areas that match the published 5 nm tables") {
  const Vec3f xyz = sum_of_curves(false);
  CHECK(xyz.x == near(21.3714, 2e-4));
  CHECK(xyz.y == near(21.3711, 2e-4));
  CHECK(xyz.z == near(21.3715, 5e-4));
}

TEST_CASE("tabulated curves interpolate linearly and vanish outside their range") {
  CHECK(cie_1931_xyz(555).y == 1.0f);
  CHECK(cie_1931_xyz(557.5f).y == near(0.9975));
  CHECK(cie_d65(560) == 100.0f);
  CHECK(cie_1931_xyz(359.9f) == Vec3f{0, 0, 0});
  CHECK(cie_1931_xyz(830.1f) == Vec3f{0, 0, 0});
  CHECK(cie_d65(std::numeric_limits<float>::quiet_NaN()) == 0.0f);
}

TEST_CASE("the sRGB transfer function has its known values and is inverted exactly") {
  CHECK(linear_to_srgb(0) == 0.0f);
  CHECK(linear_to_srgb(1) == near(1));
  CHECK(linear_to_srgb(0.0031308f) == near(0.04045, 1e-4));
  CHECK(linear_to_srgb(0.18f) == near(0.46136, 1e-4));
  for (int i = 0; i <= 255; ++i) {
    const float encoded = static_cast<float>(i) / 255.0f;
    CHECK(linear_to_srgb(srgb_to_linear(encoded)) == near(encoded, 1e-5));
  }
}

TEST_CASE("conversions between Rec.709 and XYZ are inverses and agree with the chromaticities") {
  const Vec3f rgb{0.2f, 0.7f, 0.4f};
  check_close(xyz_to_rec709(rec709_to_xyz(rgb)), rgb, 1e-5);
  const std::array<Vec3f, 4> colors{Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}, Vec3f{1, 1, 1}};
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const Vec3f xyz = rec709_to_xyz(colors[i]);
    const float sum = xyz.x + xyz.y + xyz.z;
    CHECK(xyz.x / sum == near(kRec709Chromaticities[i].x, 1e-4));
    CHECK(xyz.y / sum == near(kRec709Chromaticities[i].y, 1e-4));
  }
  CHECK(luminance({1, 1, 1}) == near(1, 1e-6));
}

// The expected numbers below are the results of Mitsuba 3.9.1 (variant scalar_rgb) for the same tables. Mitsuba
// normalizes reflectances such that the perfect reflector has 0.9989, hence the larger tolerance there.
TEST_CASE("an emission spectrum is integrated under equal energy") {
  check_close(emission_table_to_rgb(kList, std::vector<float>{0, 8, 15.6f, 18.4f}), {20.7108f, 10.8546f, 2.77115f},
              5e-4);
  check_close(emission_table_to_rgb(kList, std::vector<float>{0.1f, 0.2f, 0.3f, 0.4f}),
              {0.402061f, 0.231368f, 0.124453f}, 5e-4);
  check_close(emission_table_to_rgb(std::vector<float>{300, 900}, std::vector<float>{3, 3}),
              {3.61438f, 2.84487f, 2.72675f}, 5e-4);
}

TEST_CASE("a reflectance spectrum is integrated under D65 and clamped") {
  check_close(reflectance_table_to_rgb(kList, std::vector<float>{0, 0.3f, 0.6f, 0.7f}),
              {0.68179f, 0.431973f, 0.122893f}, 2e-3);
  CHECK(reflectance_table_to_rgb(kList, std::vector<float>{0, 8, 15.6f, 18.4f}) == Vec3f{1, 1, 1});
  check_close(reflectance_table_to_rgb(std::vector<float>{360, 830}, std::vector<float>{0.25f, 0.25f}),
              {0.25f, 0.25f, 0.25f}, 1e-6);
}

TEST_CASE("an unbounded spectrum is integrated under D65 and not clamped") {
  check_close(unbounded_table_to_rgb(kList, std::vector<float>{0, 8, 15.6f, 18.4f}), {17.7147f, 11.3544f, 3.30451f},
              2e-3);
}

TEST_CASE("the integral of a piecewise linear spectrum does not depend on its subdivision") {
  std::vector<float> wavelengths, values;
  for (int i = 0; i <= 997; ++i) {
    wavelengths.push_back(400 + static_cast<float>(i) * 300.0f / 997.0f);
    values.push_back(1 + (wavelengths.back() - 400) / 100);
  }
  check_close(emission_table_to_rgb(wavelengths, values),
              emission_table_to_rgb(std::vector<float>{400, 700}, std::vector<float>{1, 4}), 1e-5);
}

TEST_CASE("colors outside the gamut are clamped to non-negative components") {
  const Vec3f green = emission_table_to_rgb(std::vector<float>{500, 510}, std::vector<float>{1, 1});
  CHECK(green.x == 0.0f);
  CHECK(green.y > 0.0f);
  CHECK(emission_table_to_rgb({}, {}) == Vec3f{0, 0, 0});
}

TEST_CASE("black bodies follow Planck's law and have the published colors") {
  // Wien's displacement law: the peak is at 2897.77 um K / T.
  const double peak = 2.897771955e6 / 5000;
  CHECK(blackbody_radiance(peak, 5000) > blackbody_radiance(peak - 2, 5000));
  CHECK(blackbody_radiance(peak, 5000) > blackbody_radiance(peak + 2, 5000));
  // Stefan-Boltzmann law: sigma T^4 / pi in W / (m^2 sr).
  double total = 0;
  for (int wavelength = 1; wavelength < 100000; ++wavelength) total += blackbody_radiance(wavelength, 5000);
  CHECK(total == near(5.670374e-8 * 5000.0 * 5000 * 5000 * 5000 / 3.14159265, 1e-3));
  CHECK(blackbody_radiance(500, 0) == 0);
  // Mitsuba 3.9.1 in spectral mode; a Monte Carlo mean with an error of about 0.5 %.
  check_close(blackbody_to_rgb(5000, 1), {15290, 12095, 9569}, 1e-2);
  check_close(blackbody_to_rgb(2856, 2), {1000.55f, 447.37f, 126.15f}, 1e-2);
}

TEST_CASE("malformed spectrum tables are rejected") {
  CHECK_THROWS_AS(emission_table_to_rgb(kList, std::vector<float>{1, 2}), SceneError);
  CHECK_THROWS_AS(emission_table_to_rgb(std::vector<float>{500, 500}, std::vector<float>{1, 2}), SceneError);
  CHECK_THROWS_AS(reflectance_table_to_rgb(std::vector<float>{500, std::numeric_limits<float>::quiet_NaN()},
                                           std::vector<float>{1, 2}),
                  SceneError);
  CHECK_THROWS_AS(unbounded_table_to_rgb(std::vector<float>{500, 600},
                                         std::vector<float>{1, std::numeric_limits<float>::infinity()}),
                  SceneError);
}

}  // namespace sheaf::test_color
