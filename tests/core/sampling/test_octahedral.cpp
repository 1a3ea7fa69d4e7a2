// Octahedral encoding of unit vectors in 32 bits.
#include "core/sampling/octahedral.h"

#include "tests/support/near.h"
#include "tests/support/records_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_octahedral {

TEST_CASE("octahedral: vectors are restored to within 1e-4 and axes exactly and SIMD results equal scalar ones") {
  double worst = 0;
  for (std::uint32_t i = 0; i < 100 * kWidth; i += kWidth) {
    const auto wide =
        wide_record<Vec3>([&](int lane) { return random_direction(3, i + static_cast<std::uint32_t>(lane)); });
    const WideUint bits = encode_octahedral<Wide>(wide);
    const Vec3<Wide> back = decode_octahedral<Wide>(bits);
    for (int lane = 0; lane < kWidth; ++lane) {
      const Vec3f n = lane_record(wide, lane), m = lane_record(back, lane);
      worst = std::max(worst, static_cast<double>(length(m - n)));
      CHECK(std::fabs(length(m) - 1.0f) < 1e-6f);
      CHECK(record_difference<Vec3>(m, decode_octahedral<Scalar>(encode_octahedral<Scalar>(n))) < 1e-4);
    }
  }
  CHECK(worst < 1e-4);
  for (const Vec3f axis :
       {Vec3f{1, 0, 0}, Vec3f{-1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, -1, 0}, Vec3f{0, 0, 1}, Vec3f{0, 0, -1}})
    CHECK(record_difference<Vec3>(decode_octahedral<Scalar>(encode_octahedral<Scalar>(axis)), axis) == 0.0);
}

TEST_CASE("octahedral: any bit pattern decodes to a unit vector") {
  for (const std::uint32_t bits : {0u, 0xffffffffu, 0x80008000u, 0xffff0000u, 0x12345678u})
    CHECK(length(decode_octahedral<Scalar>(bits)) == near(1.0f));
}

}  // namespace sheaf::test_octahedral
