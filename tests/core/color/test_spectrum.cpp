// Four-lane spectra and vectors: arithmetic in registers against scalar code.
#include "core/color/spectrum.h"

#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_spectrum {

namespace {
Spectrum4 spectrum(int i) {
  const auto x = static_cast<float>(i);
  return {x + 1.0f, 2.0f * x - 3.0f, 0.5f * x, -x};
}
Vec3f vector(int i) {
  const auto x = static_cast<float>(i);
  return {x - 2.5f, 1.0f + 0.5f * x, 3.0f - x * x};
}
Spectrum<Wide> wide_spectra(int first) {
  return {wide_floats([&](int k) { return spectrum(first + k).c0; }),
          wide_floats([&](int k) { return spectrum(first + k).c1; }),
          wide_floats([&](int k) { return spectrum(first + k).c2; }),
          wide_floats([&](int k) { return spectrum(first + k).c3; })};
}
Vec3<Wide> wide_vectors(int first) {
  return {wide_floats([&](int k) { return vector(first + k).x; }),
          wide_floats([&](int k) { return vector(first + k).y; }),
          wide_floats([&](int k) { return vector(first + k).z; })};
}
double difference_at(const Spectrum<Wide>& a, const Spectrum4& b, int lane) {
  return std::max({difference(a.c0[lane], b.c0), difference(a.c1[lane], b.c1), difference(a.c2[lane], b.c2),
                   difference(a.c3[lane], b.c3)});
}
double difference_at(const Vec3<Wide>& a, const Vec3f& b, int lane) {
  return std::max({difference(a.x[lane], b.x), difference(a.y[lane], b.y), difference(a.z[lane], b.z)});
}
}  // namespace

TEST_CASE("spectrum: arithmetic is componentwise") {
  const Spectrum4 a{1, 2, 3, 4}, b{5, 6, 7, -8};
  const Spectrum4 sum = a + b, product = a * b, scaled = a * 0.5f, chosen = select<Scalar>(true, a, b);
  CHECK((sum.c0 == 6 && sum.c1 == 8 && sum.c2 == 10 && sum.c3 == -4));
  CHECK((product.c0 == 5 && product.c1 == 12 && product.c2 == 21 && product.c3 == -32));
  CHECK((scaled.c0 == 0.5f && scaled.c3 == 2));
  CHECK((chosen.c0 == 1 && chosen.c3 == 4));
  CHECK(select<Scalar>(false, a, b).c3 == -8);
  CHECK(max_component(b) == 7);
  CHECK(max_component(a) == 4);
  CHECK(is_black(Spectrum4{}));
  CHECK(is_black(Spectrum4(-1.0f)));
  CHECK_FALSE(is_black(Spectrum4{0, 0, 0, 1e-30f}));
  CHECK(Spectrum4(3.0f).c2 == 3.0f);
}

TEST_CASE("spectrum: SIMD results equal scalar ones") {
  const Spectrum<Wide> a = wide_spectra(0), b = wide_spectra(5);
  const WideFloat s = wide_floats([](int lane) { return 0.25f * static_cast<float>(lane); });
  const WideMask odd = wide_mask([](int lane) { return lane % 2 == 1; });
  for (int lane = 0; lane < kWidth; ++lane) {
    const Spectrum4 x = spectrum(lane), y = spectrum(lane + 5);
    CHECK(difference_at(a + b, x + y, lane) == 0);
    CHECK(difference_at(a * b, x * y, lane) == 0);
    CHECK(difference_at(a * s, x * s[lane], lane) == 0);
    CHECK(difference_at(select<Wide>(odd, a, b), select<Scalar>(lane % 2 == 1, x, y), lane) == 0);
    CHECK(max_component(a)[lane] == max_component(x));
    CHECK(lane_of(is_black(a * WideFloat(-1.0f)), lane) == is_black(x * -1.0f));
  }
}

TEST_CASE("vec: products and lengths satisfy their identities") {
  const Vec3f a{1, 2, 3}, b{-4, 0.5f, 2};
  CHECK(dot(a, b) == 3);
  CHECK(cross(a, b) == Vec3f{2.5f, -14, 8.5f});
  CHECK(dot(cross(a, b), a) == 0);
  CHECK(cross(Vec3f{1, 0, 0}, Vec3f{0, 1, 0}) == Vec3f{0, 0, 1});
  CHECK(a + b == Vec3f{-3, 2.5f, 5});
  CHECK(a - b == Vec3f{5, 1.5f, 1});
  CHECK(a * b == Vec3f{-4, 1, 6});
  CHECK(-a == Vec3f{-1, -2, -3});
  CHECK(2.0f * a == a * 2.0f);
  CHECK(a / 2.0f == Vec3f{0.5f, 1, 1.5f});
  CHECK(length_squared(a) == 14);
  CHECK(length(Vec3f{3, 4, 12}) == 13);
  CHECK(length(normalize(a)) == near(1.0));
  CHECK(abs(b) == Vec3f{4, 0.5f, 2});
  CHECK(max_component(b) == 2);
  CHECK(is_finite(a));
  CHECK_FALSE(is_finite(Vec3f{1, kInfinity, 0}));
  CHECK_FALSE(is_finite(Vec3f{1, 0, std::numeric_limits<float>::quiet_NaN()}));
}

TEST_CASE("vec: SIMD results equal scalar ones") {
  const Vec3<Wide> a = wide_vectors(0), b = wide_vectors(3), c = broadcast<Wide>({1, -2, 3});
  for (int lane = 0; lane < kWidth; ++lane) {
    const Vec3f x = vector(lane), y = vector(lane + 3);
    CHECK(difference_at(a + b, x + y, lane) == 0);
    CHECK(difference_at(a - b, x - y, lane) == 0);
    CHECK(difference_at(a * b, x * y, lane) == 0);
    CHECK(difference_at(-a, -x, lane) == 0);
    CHECK(difference_at(abs(a), abs(x), lane) == 0);
    CHECK(difference_at(a / WideFloat(3.0f), x / 3.0f, lane) < 1e-6);
    CHECK(difference_at(cross(a, b), cross(x, y), lane) < 1e-6);
    CHECK(difference_at(normalize(a), normalize(x), lane) < 1e-6);
    CHECK(difference(dot(a, b)[lane], dot(x, y)) < 1e-6);
    CHECK(difference(length(a)[lane], length(x)) < 1e-6);
    CHECK(max_component(a)[lane] == max_component(x));
    CHECK(difference_at(select<Wide>(a.x < b.z, a, b), select<Scalar>(x.x < y.z, x, y), lane) == 0);
    CHECK(difference_at(c, Vec3f{1, -2, 3}, lane) == 0);
  }
}

}  // namespace sheaf::test_spectrum
