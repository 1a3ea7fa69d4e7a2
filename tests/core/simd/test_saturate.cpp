// Saturating conversion of external numbers to integers.
#include "core/simd/saturate.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>

namespace sheaf::test_saturate {

TEST_CASE("saturate: values are truncated and clamped to the range and NaN becomes 0") {
  CHECK(saturate<int>(12.9) == 12);
  CHECK(saturate<int>(-12.9) == -12);
  CHECK(saturate<int>(2147483647.0) == 2147483647);
  CHECK(saturate<int>(-2147483648.0) == std::numeric_limits<int>::min());
  for (const double large : {2147483648.0, 1e30, double{std::numeric_limits<double>::infinity()}}) {
    CHECK(saturate<int>(large) == std::numeric_limits<int>::max());
    CHECK(saturate<int>(-large - 1) == std::numeric_limits<int>::min());
  }
  CHECK(saturate<int>(std::nan("")) == 0);
  CHECK(saturate<std::uint32_t>(4294967295.0) == 4294967295u);
  CHECK(saturate<std::uint32_t>(4294967296.0) == 4294967295u);
  CHECK(saturate<std::uint32_t>(-1.0) == 0u);
  CHECK(saturate<std::int64_t>(9.3e18) == std::numeric_limits<std::int64_t>::max());
  CHECK(saturate<std::int64_t>(9007199254740993.0) == 9007199254740992);
  CHECK(saturate<std::uint64_t>(1e20) == std::numeric_limits<std::uint64_t>::max());
  CHECK(saturate<std::uint8_t>(255.5) == 255);
}

}  // namespace sheaf::test_saturate
