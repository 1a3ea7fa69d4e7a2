// Conversions between floats and numbers of 16 bits.
#include "core/math/half.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_half {

TEST_CASE("half: every finite number survives the conversion to float and back") {
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    if (std::isfinite(half_to_float(half))) CHECK(float_to_half(half_to_float(half)) == half);
  }
}

TEST_CASE("half: floats round to the nearest number, and to the even one in the middle") {
  for (std::uint16_t half = 0; half < 0x7bff; ++half) {
    const float low = half_to_float(half), high = half_to_float(static_cast<std::uint16_t>(half + 1));
    const float middle = 0.5f * (low + high);
    CHECK(float_to_half(middle) == half + (half & 1));
    CHECK(float_to_half(std::nextafter(middle, 0.0f)) == half);
    CHECK(float_to_half(std::nextafter(middle, 1e5f)) == half + 1);
    CHECK(float_to_half(-middle) == (0x8000 | (half + (half & 1))));
  }
  CHECK(float_to_half(65519.0f) == 0x7bff);
  CHECK(float_to_half(65520.0f) == 0x7c00);
  CHECK(float_to_half(1e30f) == 0x7c00);
  CHECK(float_to_half(1e-30f) == 0);
}

}  // namespace sheaf::test_half
