// Warps: samples against their pdfs, and SIMD lanes against scalar code.
#include "core/sampling/warp.h"

#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_warp {

namespace {

constexpr double kTwoPi = 6.283185307179586476925;

template <class F> auto direction(F&& warp) {
  return [warp](Random4<Scalar> u) { return std::optional<Vec3f>(warp(u.x, u.y)); };
}

/// Numbers in [0, 1), including those at which warps change branches or reach their ends.
std::vector<float> test_numbers() {
  std::vector<float> values = {0.0f,     kOneMinusEpsilon, 0.5f,   0.25f,       0.75f,
                               0x1p-24f, 0.125f,           0.875f, 0.49999997f, 0.50000006f};
  for (std::uint32_t i = 0; i < 150; ++i) values.push_back(random4<Scalar>(3, i, 0, 0).x);
  return values;
}

/// Calls f for corresponding members of all fields.
template <class A, class B, class F> void zip_fields(const A& a, const B& b, F&& f) {
  const auto ta = A::fields(a);
  const auto tb = B::fields(b);
  [&]<std::size_t... I>(std::index_sequence<I...>) { (f(std::get<I>(ta), std::get<I>(tb)), ...); }
  (std::make_index_sequence<std::tuple_size_v<decltype(ta)>>{});
}

/// Maximum difference between warp(Wide, u, v) and warp(Scalar, u, v) over all fields, lanes and pairs of numbers.
template <class Warp> double worst_lane(Warp&& warp) {
  const auto values = test_numbers();
  double worst = 0;
  for (const float v : values)
    for (std::size_t i = 0; i < values.size(); i += kWidth) {
      const auto u = [&](int lane) { return values[(i + static_cast<std::size_t>(lane)) % values.size()]; };
      const auto out = warp(Wide{}, wide_floats(u), WideFloat(v));
      for (int lane = 0; lane < kWidth; ++lane)
        zip_fields(out, warp(Scalar{}, u(lane), v),
                   [&](WideFloat a, float b) { worst = std::max(worst, difference(a[lane], b)); });
    }
  return worst;
}

constexpr int kTests = 11;  // chi-square tests in this file

}  // namespace

TEST_CASE("warp: sincos_2pi stays within its error bound over a dense sweep") {
  double worst = 0, norm = 0;
  for (std::uint32_t i = 0; i <= 1u << 22; ++i) {
    const float u = static_cast<float>(i) * 0x1p-22f;
    const SinCos<Scalar> sc = sincos_2pi<Scalar>(u);
    const double angle = kTwoPi * static_cast<double>(u);
    worst = std::max({worst, std::fabs(sc.sin - std::sin(angle)), std::fabs(sc.cos - std::cos(angle))});
    norm = std::max(norm, std::fabs(static_cast<double>(sc.sin) * sc.sin + static_cast<double>(sc.cos) * sc.cos - 1.0));
  }
  CHECK(worst < 4e-7);
  CHECK(norm < 4e-7);
  const SinCos<Scalar> last = sincos_2pi<Scalar>(kOneMinusEpsilon);
  CHECK(last.cos == 1.0f);
  CHECK(last.sin <= 0.0f);
}

TEST_CASE("warp: sincos_2pi gives the same bits in registers") {
  double worst = 0;
  for (std::uint32_t i = 0; i + kWidth <= 1u << 18; i += kWidth) {
    const auto u = [i](int lane) { return static_cast<float>(i + static_cast<std::uint32_t>(lane)) * 0x1p-18f; };
    const SinCos<Wide> wide = sincos_2pi<Wide>(wide_floats(u));
    for (int lane = 0; lane < kWidth; ++lane) {
      const SinCos<Scalar> one = sincos_2pi<Scalar>(u(lane));
      worst = std::max({worst, difference(wide.sin[lane], one.sin), difference(wide.cos[lane], one.cos)});
    }
  }
  CHECK(worst < 3e-7);
}

TEST_CASE("warp: SIMD results equal scalar ones") {
  CHECK(worst_lane([]<class L>(L, auto u, auto v) { return square_to_disk<L>(u, v); }) < 1e-6);
  CHECK(worst_lane([]<class L>(L, auto u, auto v) { return square_to_sphere<L>(u, v); }) < 1e-6);
  CHECK(worst_lane([]<class L>(L, auto u, auto v) { return square_to_triangle<L>(u, v); }) < 1e-6);
  const auto bilinear = []<class L>(L, auto u, auto v) {
    return square_to_bilinear<L>({Float<L>(0.1f), Float<L>(2.0f), Float<L>(1.0f), Float<L>(0.3f)}, u, v);
  };
  CHECK(worst_lane(bilinear) < 1e-6);
  // Near the horizon z is the square root of a difference of nearly equal numbers, so the test compares its square.
  CHECK(worst_lane([]<class L>(L, auto u, auto v) {
          Vec3<L> w = square_to_cosine_hemisphere<L>(u, v);
          w.z = w.z * w.z;
          return w;
        }) < 2e-6);
  for (const float width : {1e-8f, 1e-3f, 0.5f, 1.0f, 2.0f})
    CHECK(worst_lane([width]<class L>(L, auto u, auto v) { return square_to_cone<L>(u, v, Float<L>(width)); }) < 2e-6);
  const WideFloat cosines = wide_floats([](int lane) { return static_cast<float>(lane) - 3.0f; });
  for (int lane = 0; lane < kWidth; ++lane)
    CHECK(cosine_hemisphere_pdf_solid_angle(cosines)[lane] == cosine_hemisphere_pdf_solid_angle(cosines[lane]));
}

TEST_CASE("warp: results are finite and normalized and inside their domain up to its ends") {
  double worst_norm = 0;
  int outside = 0;
  for (const float u : test_numbers())
    for (const float v : test_numbers()) {
      const Vec2f disk = square_to_disk<Scalar>(u, v);
      outside += !(disk.x * disk.x + disk.y * disk.y <= 1.0f + 1e-6f);
      const Vec2f b = square_to_triangle<Scalar>(u, v);
      outside += !(b.x >= 0.0f && b.y >= 0.0f && b.x + b.y <= 1.0f);
      const Vec3f hemisphere = square_to_cosine_hemisphere<Scalar>(u, v);
      outside += !(hemisphere.z >= 0.0f);
      const Vec3f directions[] = {hemisphere, square_to_sphere<Scalar>(u, v), square_to_cone<Scalar>(u, v, 1e-6f),
                                  square_to_cone<Scalar>(u, v, 1.0f), square_to_cone<Scalar>(u, v, 2.0f)};
      for (const Vec3f& w : directions) {
        outside += !is_finite(w);
        worst_norm = std::max(worst_norm, std::fabs(static_cast<double>(length(w)) - 1.0));
      }
    }
  CHECK(outside == 0);
  CHECK(worst_norm < 1e-6);
}

TEST_CASE("warp: square_to_disk is uniform over the disk") {
  const auto polar = [](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const Vec2f p = square_to_disk<Scalar>(u.x, u.y);
    const double angle = std::atan2(static_cast<double>(p.y), static_cast<double>(p.x));
    return std::array<double, 2>{angle < 0 ? angle + kTwoPi : angle,
                                 std::min(1.0, static_cast<double>(p.x) * p.x + static_cast<double>(p.y) * p.y)};
  };
  CHECK(chi_square_plane(polar, [](double, double) { return 1.0 / kTwoPi; }, {0, kTwoPi, 0, 1}).p_value >
        significance_of_each(kTests));
}

TEST_CASE("warp: square_to_cosine_hemisphere has a pdf proportional to the cosine") {
  const auto pdf = [](Vec3f w) { return static_cast<double>(cosine_hemisphere_pdf_solid_angle(w.z)); };
  const ChiSquare test = chi_square_sphere(
      direction([](float u, float v) { return square_to_cosine_hemisphere<Scalar>(u, v); }), pdf, -1.0, 1.0);
  CHECK(test.integral == near(1.0, 1e-5));
  CHECK(test.p_value > significance_of_each(kTests));
}

TEST_CASE("warp: square_to_sphere is uniform") {
  const ChiSquare test = chi_square_sphere(direction([](float u, float v) { return square_to_sphere<Scalar>(u, v); }),
                                           [](Vec3f) { return kUniformSpherePdf; });
  CHECK(test.integral == near(1.0, 1e-5));
  CHECK(test.p_value > significance_of_each(kTests));
}

TEST_CASE("warp: square_to_cone is uniform for every opening angle") {
  for (const float width : {1e-3f, 0.3f, 1.0f, 2.0f}) {
    CAPTURE(width);
    const auto warp = [width](float u, float v) { return square_to_cone<Scalar>(u, v, width); };
    const auto pdf = [width](Vec3f) { return 1.0 / (kTwoPi * static_cast<double>(width)); };
    const ChiSquare test = chi_square_sphere(direction(warp), pdf, 1.0 - static_cast<double>(width), 1.0);
    CHECK(test.integral == near(1.0, 1e-5));
    CHECK(test.p_value > significance_of_each(kTests));
  }
}

TEST_CASE("warp: a cone whose 1 - cos is 1e-8 keeps its width") {
  const float width = 1e-8f;
  MeanVariance sin_squared;
  for (std::uint32_t i = 0; i < 10000; ++i) {
    const Random4<Scalar> u = random4<Scalar>(1, i, 0, 0);
    const Vec3f w = square_to_cone<Scalar>(u.x, u.y, width);
    sin_squared.add(static_cast<double>(w.x) * w.x + static_cast<double>(w.y) * w.y);
  }
  CHECK(sin_squared.p_value(static_cast<double>(width)) > kSignificance);
}

TEST_CASE("warp: square_to_triangle is uniform") {
  const auto warp = [](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const Vec2f b = square_to_triangle<Scalar>(u.x, u.y);
    return std::array<double, 2>{b.x, b.y};
  };
  const auto density = [](double x, double y) { return x + y < 1.0 ? 2.0 : 0.0; };
  CHECK(chi_square_plane(warp, density, {0, 1, 0, 1, 20, 20}).p_value > significance_of_each(kTests));
}

TEST_CASE("warp: square_to_bilinear has a pdf proportional to the interpolated weights") {
  for (const CornerWeights<Scalar>& w : {CornerWeights<Scalar>{1, 1, 1, 1}, {0.1f, 2, 1, 0.3f}, {1e-3f, 1, 2, 1e-3f}}) {
    int outside = 0;
    const auto warp = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
      const Vec2f p = square_to_bilinear<Scalar>(w, u.x, u.y);
      outside += !(p.x >= 0.0f && p.x < 1.0f && p.y >= 0.0f && p.y < 1.0f);
      return std::array<double, 2>{p.x, p.y};
    };
    const auto pdf = [&](double x, double y) {
      return double(bilinear_pdf<Scalar>(w, {static_cast<float>(x), static_cast<float>(y)}));
    };
    const ChiSquare test = chi_square_plane(warp, pdf, {0, 1, 0, 1, 20, 20});
    CHECK(outside == 0);
    CHECK(test.integral == near(1.0, 1e-5));
    CHECK(test.p_value > significance_of_each(kTests));
  }
}

}  // namespace sheaf::test_warp
