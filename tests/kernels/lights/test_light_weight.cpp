// MIS weights of light sampling and BSDF sampling.
#include "kernels/lights/light_weight.h"

#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_light_weight {

TEST_CASE("light weight: the power heuristic squares the pdfs") {
  CHECK(power_heuristic(1.0f, 0.0f) == 1.0f);
  CHECK(power_heuristic(2.0f, 2.0f) == 0.5f);
  CHECK(power_heuristic(1.0f, 3.0f) == near(0.1));
  for (const float a : {1e-20f, 1.0f, 1e20f, 3e38f})
    for (const float b : {1e-20f, 1.0f, 1e20f, 3e38f}) {
      CHECK(power_heuristic(a, b) + power_heuristic(b, a) == near(1));
      CHECK(power_heuristic(a, b) >= 0.0f);
    }
}

TEST_CASE("light weight: the weights of both techniques add up to 1") {
  for (const int candidates : {1, 4})
    for (const float light : {0.25f, 2.0f})
      for (const float bsdf : {0.5f, 8.0f}) {
        const float ratio = bsdf / (static_cast<float>(candidates) * light);
        CHECK(light_weight(light, bsdf, candidates) == near(1 / (1 + double{ratio} * ratio)));
        CHECK(light_weight(light, bsdf, candidates) + bsdf_weight(light, bsdf, candidates) == near(1));
      }
}

}  // namespace sheaf::test_light_weight
