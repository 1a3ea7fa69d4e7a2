// Checks that products and sums are rounded separately, without contraction to fused multiply-adds. Compiled with the
// optimization level at which compilers contract, see cmake/SheafTests.cmake. The test is void on machines without FMA.
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_contraction {

namespace {

template <class F> SHEAF_INLINE F inlined(F a, F b, F c) { return a * b + c; }
template <class F> [[gnu::noinline]] F called(F a, F b, F c) { return a * b + c; }
template <class F> [[gnu::noinline]] F called_difference(F a, F b, F c) { return c - a * b; }

// The square of kRoot is kSquare + 2^-24, which rounds to kSquare.
constexpr float kRoot = 1.0f + 0x1p-12f, kSquare = 1.0f + 0x1p-11f;

/// A value that the compiler cannot know at compile time.
float opaque(float value) {
  volatile float hidden = value;
  return hidden;
}

}  // namespace

TEST_CASE("a product is rounded before an addition in inlined and in called functions") {
  const float a = opaque(kRoot), c = opaque(-kSquare);
  CHECK(inlined(a, a, c) == 0.0f);
  CHECK(called(a, a, c) == 0.0f);
  CHECK(called_difference(a, a, -c) == 0.0f);
}

TEST_CASE("a product is rounded before an addition in SIMD registers") {
  const auto a = wide_floats([](int) { return opaque(kRoot); }), c = wide_floats([](int) { return opaque(-kSquare); });
  const auto in_place = inlined(a, a, c), by_call = called(a, a, c), difference = called_difference(a, a, -c);
  for (int lane = 0; lane < kWidth; ++lane) {
    CHECK(in_place[lane] == 0.0f);
    CHECK(by_call[lane] == 0.0f);
    CHECK(difference[lane] == 0.0f);
  }
}

#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
TEST_CASE("a fused multiply-add rounds once") {
  const float a = opaque(kRoot), c = opaque(-kSquare);
  CHECK(fma(a, a, c) == 0x1p-24f);
  const auto wide = wide_floats([a](int) { return a; });
  CHECK(fma(wide, wide, wide_floats([c](int) { return c; }))[0] == 0x1p-24f);
}
#endif

}  // namespace sheaf::test_contraction
