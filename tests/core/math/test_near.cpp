// The comparison by relative error that tests use.
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <limits>

namespace sheaf::test_near {

TEST_CASE("near: the tolerance is relative at any size") {
  for (const double size : {1e-30, 1e-9, 1.0, 1e9, 1e30}) {
    CAPTURE(size);
    CHECK(1.0009 * size == near(size, 1e-3));
    CHECK(0.9991 * size == near(size, 1e-3));
    CHECK(-1.0009 * size == near(-size, 1e-3));
    CHECK(near(size, 1e-3) == 1.0009 * size);
    CHECK(1.0011 * size != near(size, 1e-3));
    CHECK(0.9989 * size != near(size, 1e-3));
    CHECK(-size != near(size, 1e-3));
    CHECK(0 != near(size, 1e-3));
    CHECK(1.00001 * size == near(size));
    CHECK(1.00002 * size != near(size));
  }
}

TEST_CASE("near: zero, infinity and NaN equal only themselves or nothing") {
  constexpr double kInf = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
  CHECK(0 == near(0));
  CHECK(1e-300 != near(0));
  CHECK(kInf == near(kInf));
  CHECK(-kInf != near(kInf));
  CHECK(1e300 != near(kInf));
  CHECK(kInf != near(1));
  CHECK(kNan != near(kNan));
  CHECK(kNan != near(1));
  CHECK(1 != near(kNan));
}

TEST_CASE("near: distances are absolute") {
  CHECK(0.5 == within(0, 0.5));
  CHECK(-0.5 == within(0, 0.5));
  CHECK(0.51 != within(0, 0.5));
  CHECK(1000.5f == within(1000, 0.5));
  CHECK(1001 != within(1000, 0.5));
}

}  // namespace sheaf::test_near
