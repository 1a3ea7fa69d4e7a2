// RGB color spaces from chromaticities, against published matrices and against Mitsuba 3.
#include "core/color/color_space.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <limits>

namespace sheaf::test_color_space {

namespace {

const RgbChromaticities kRec2020{{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}};
const RgbChromaticities kAces{{0.7347, 0.2653}, {0, 1}, {0.0001, -0.0770}, {0.32168, 0.33767}};
const RgbChromaticities kTheaterP3{{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.314, 0.351}};

void check_color(const RgbChromaticities& space, std::array<float, 3> in, std::array<double, 3> expected,
                 double tolerance = 1e-5) {
  REQUIRE(convert_to_rec709(in, space));
  for (std::size_t c = 0; c < 3; ++c) CHECK(double{in[c]} == near(expected[c], tolerance));
}

}  // namespace

TEST_CASE("color space: Rec.2020 to Rec.709 is the matrix of ITU-R BT.2087") {
  const Matrix3 expected{{{1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}}};
  const auto found = rgb_to_rec709(kRec2020);
  REQUIRE(found);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) CHECK((*found)[i][j] == within(expected[i][j], 1e-4));
}

TEST_CASE("color space: white keeps its chromaticity and the figures of Mitsuba 3 are matched") {
  constexpr double kXyz = 1e-3;  // Mitsuba's XYZ matrix has fewer digits
  check_color(kRec2020, {0.2f, 0.5f, 0.3f}, {0.01642274, 0.53903484, 0.28169933});
  check_color(kAces, {0.2f, 0.5f, 0.3f}, {-0.16560157, 0.59936446, 0.24660677});
  check_color(kAces, {1, 1, 1}, {1.0471032, 0.9945427, 0.9153183});
  check_color(kTheaterP3, {0.2f, 0.5f, 0.3f}, {0.10681807, 0.53582126, 0.24176452});
  check_color(kXyzSpace, {0.2f, 0.5f, 0.3f}, {-0.27003974, 0.7566111, 0.22630143}, kXyz);
  check_color(kXyzSpace, {1, 1, 1}, {1.2047939, 0.948291, 0.90891606}, kXyz);
}

TEST_CASE("color space: Rec.709 is unchanged to the bit even with rounded chromaticities") {
  RgbChromaticities rounded = kRec709Space;
  rounded.white = {0.31271, 0.32902};
  for (const RgbChromaticities& space : {kRec709Space, rounded}) {
    std::array<float, 3> color{0.1f, 0.2f, 1e30f};
    REQUIRE(convert_to_rec709(color, space));
    CHECK(color == std::array<float, 3>{0.1f, 0.2f, 1e30f});
  }
}

TEST_CASE("color space: non-finite pixels are unchanged and their neighbors are converted") {
  std::array<float, 6> colors{std::numeric_limits<float>::infinity(), 2, 3, 1, 1, 1};
  REQUIRE(convert_to_rec709(colors, kXyzSpace));
  CHECK(colors[1] == 2.0f);
  CHECK(colors[3] == near(1.2049759));
}

TEST_CASE("color space: collinear primaries and white without luminance and NaN are rejected") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const RgbChromaticities wrong[] = {{{0, 0}, {0, 0}, {0, 0}, {0.3, 0.3}},
                                     {{0.1, 0.1}, {0.2, 0.2}, {0.4, 0.4}, {0.3, 0.3}},
                                     {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3, 0}},
                                     {{nan, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3, 0.3}},
                                     {{0.64, infinity}, {0.30, 0.60}, {0.15, 0.06}, {0.3, 0.3}}};
  for (const RgbChromaticities& space : wrong) {
    std::array<float, 3> color{1, 1, 1};
    CHECK_FALSE(convert_to_rec709(color, space));
  }
}

}  // namespace sheaf::test_color_space
