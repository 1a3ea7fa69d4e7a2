// Spherical rectangles: solid angles against double precision, samples against solid angles, and SIMD lanes against
// scalar code. Also inverse square roots, which they are made of.
#include "core/sampling/spherical_rectangle.h"

#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sheaf::test_spherical_rectangle {

namespace {

constexpr double kTwoPi = 6.283185307179586476925;

/// x0, x1, y0, y1 and the height.
struct Box {
  float x0, x1, y0, y1, h;

  SphericalRectangle<Scalar> seen() const { return {x0, x1, y0, y1, h}; }
  /// Solid angle of the part up to the fractions `s` and `t` of the sides.
  double solid_angle(double s, double t) const {
    const double x = x0 + s * (double(x1) - x0), y = y0 + t * (double(y1) - y0);
    return corner(x, y) - corner(x, y0) - corner(x0, y) + corner(x0, y0);
  }

 private:
  double corner(double x, double y) const { return std::atan2(x * y, h * std::sqrt(x * x + y * y + double(h) * h)); }
};

/// Centered, off-axis, near one corner, near the plane, wide and narrow, in millimeters and kilometers.
const std::vector<Box> kBoxes = {{-1, 1, -1, 1, 1},
                                 {-0.7f, 2.1f, 0.3f, 0.9f, 0.8f},
                                 {0.001f, 1, 0.001f, 1, 0.01f},
                                 {-1, 1, -2, 0.5f, 1e-3f},
                                 {0.2f, 3, -0.4f, 0.1f, 0.05f},
                                 {-50, 50, 0.5f, 1, 2},
                                 {-2e-3f, 1e-3f, -1e-3f, 1e-3f, 1.5e-3f},
                                 {-1000, 3000, 1000, 2000, 900},
                                 {-3, -1, -2, -1.5f, 0.5f}};

constexpr int kTests = 9;  // chi-square tests in this file

}  // namespace

TEST_CASE("spherical rectangle: the solid angle equals that of double precision") {
  for (const Box& box : kBoxes) {
    CAPTURE(box.x0);
    CHECK(box.seen().solid_angle() == near(box.solid_angle(1, 1), 1e-5));
  }
  // Underneath a wide rectangle, nearly a hemisphere; in its plane, outside of it, nothing
  CHECK(Box{-1, 1, -1, 1, 1e-6f}.seen().solid_angle() == near(kTwoPi, 1e-5));
  CHECK(Box{1, 2, -1, 1, 0}.seen().solid_angle() == within(0, 1e-6));
}

TEST_CASE("spherical rectangle: samples are uniform over the solid angle") {
  constexpr int kCells = 12, kDraws = 200000;
  for (const Box& box : kBoxes) {
    CAPTURE(box.x0);
    const auto seen = box.seen();
    const float width = box.x1 - box.x0, depth = box.y1 - box.y0;
    int outside = 0;
    std::vector<double> observed(kCells * kCells), expected(kCells * kCells);
    for (std::uint32_t i = 0; i < kDraws; ++i) {
      const auto u = random4<Scalar>(3, i, 0, 0);
      const Vec2f at = seen.sample(u.x, u.y);
      const auto cell = [](float part, float whole) {
        return std::clamp(static_cast<int>(part / whole * kCells), 0, kCells - 1);
      };
      outside += !(at.x >= 0.0f && at.x <= width * 1.00001f && at.y >= 0.0f && at.y <= depth * 1.00001f);
      observed[std::size_t(cell(at.y, depth) * kCells + cell(at.x, width))] += 1;
    }
    for (int row = 0; row < kCells; ++row)
      for (int column = 0; column < kCells; ++column) {
        const auto up_to = [&](int c, int r) { return box.solid_angle(double(c) / kCells, double(r) / kCells); };
        expected[std::size_t(row * kCells + column)] =
            kDraws *
            (up_to(column + 1, row + 1) - up_to(column, row + 1) - up_to(column + 1, row) + up_to(column, row)) /
            box.solid_angle(1, 1);
      }
    CHECK(outside == 0);
    CHECK(chi_square(observed, expected).p_value > significance_of_each(kTests));
  }
}

TEST_CASE("spherical rectangle: a point leads back to its random numbers") {
  double worst = 0;
  for (const Box& box : kBoxes) {
    const auto seen = box.seen();
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const auto u = random4<Scalar>(4, i, 0, 0);
      const Vec2f back = seen.invert(seen.sample(u.x, u.y));
      worst = std::max({worst, std::fabs(double(back.x) - u.x), std::fabs(double(back.y) - u.y)});
    }
  }
  CHECK(worst < 2e-3);
}

TEST_CASE("spherical rectangle: cosines at the corners") {
  const CornerWeights<Scalar> c = Box{-1, 2, -3, 4, 2}.seen().corner_cosines({0.6f, 0, 0.8f});
  const auto expected = [](double x, double y) { return (0.6 * x + 0.8 * 2) / std::sqrt(x * x + y * y + 4); };
  CHECK(c.w00 == near(expected(-1, -3), 1e-4));
  CHECK(c.w10 == near(expected(2, -3), 1e-4));
  CHECK(c.w01 == near(expected(-1, 4), 1e-4));
  CHECK(c.w11 == near(expected(2, 4), 1e-4));
}

TEST_CASE("spherical rectangle: SIMD results equal scalar ones") {
  double worst = 0;
  for (const Box& box : kBoxes) {
    const WideFloat x0(box.x0), x1(box.x1), y0(box.y0), y1(box.y1), h(box.h);
    const SphericalRectangle<Wide> wide(x0, x1, y0, y1, h);
    const auto one = box.seen();
    const auto u = [](int lane) { return random4<Scalar>(5, static_cast<std::uint32_t>(lane), 0, 0); };
    const Vec2<Wide> at =
        wide.sample(wide_floats([&](int lane) { return u(lane).x; }), wide_floats([&](int lane) { return u(lane).y; }));
    for (int lane = 0; lane < kWidth; ++lane) {
      const Vec2f expected = one.sample(u(lane).x, u(lane).y);
      worst = std::max({worst, difference(wide.solid_angle()[lane], one.solid_angle()),
                        std::fabs(double(at.x[lane]) - expected.x) / (double(box.x1) - box.x0),
                        std::fabs(double(at.y[lane]) - expected.y) / (double(box.y1) - box.y0)});
    }
  }
  CHECK(worst < 1e-4);
}

TEST_CASE("inverse square roots stay within their error bounds") {
  double worst = 0, worst_rough = 0;
  for (float x = 1e-30f; x < 1e30f; x *= 1.0007f) {
    const double exact = 1 / std::sqrt(double(x));
    worst = std::max(worst, std::fabs(inverse_sqrt<Scalar>(x) / exact - 1));
    worst_rough = std::max(worst_rough, std::fabs(rough_inverse_sqrt<Scalar>(x) / exact - 1));
  }
  CHECK(worst < 3e-7);
  CHECK(worst_rough < 1.7e-5);
}

}  // namespace sheaf::test_spherical_rectangle
