// Tone-mapping curves against published values, and properties that every curve needs.
#include "core/color/tone_map.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace sheaf::test_tone_map {

namespace {

constexpr ToneMap kCurves[] = {ToneMap::kFilmic, ToneMap::kAces, ToneMap::kAgx};

Vec3f gray(float x) { return {x, x, x}; }

float spread(Vec3f c) { return std::max({c.x, c.y, c.z}) - std::min({c.x, c.y, c.z}); }

}  // namespace

TEST_CASE("tone maps: black is black, grays are gray, and brighter grays are brighter") {
  for (const ToneMap curve : kCurves) {
    CAPTURE(static_cast<int>(curve));
    const Vec3f black = tone_mapped(curve, {0, 0, 0});
    CHECK(std::max({black.x, black.y, black.z}) == 0.0f);
    float last = 0;
    for (float stops = -14; stops <= 12; stops += 0.01f) {
      const Vec3f out = tone_mapped(curve, gray(0.18f * std::exp2(stops)));
      CHECK(spread(out) < 0.001f);
      CHECK(out.y >= last);
      if (std::abs(stops) < 3) CHECK(out.y > last);
      last = out.y;
    }
    CHECK(last > 0.95f);
  }
}

TEST_CASE("tone maps: middle gray and white have their published values") {
  // Hable: f(0.36) / f(11.2), with f(x) = (0.15 x^2 + 0.05 x + 0.004) / (0.15 x^2 + 0.5 x + 0.06) - 1 / 15.
  const auto hable = [](double x) {
    return (0.15 * x * x + 0.05 * x + 0.004) / (0.15 * x * x + 0.5 * x + 0.06) - 1.0 / 15;
  };
  CHECK(tone_mapped(ToneMap::kFilmic, gray(0.18f)).y == near(hable(0.36) / hable(11.2), 1e-5));
  CHECK(tone_mapped(ToneMap::kFilmic, gray(5.6f)).y == near(1.0, 1e-5));
  CHECK(tone_mapped(ToneMap::kFilmic, gray(5.0f)).y < 1.0f);
  // ACES shows middle gray at a tenth of the display's white (4.8 of 48 cd/m^2 in cinemas).
  CHECK(tone_mapped(ToneMap::kAces, gray(0.18f)).y == near(0.1056, 0.005));
  CHECK(tone_mapped(ToneMap::kAces, gray(1.0f)).y == near(0.6191, 0.005));
  // AgX shows middle gray at half of the encoded range.
  CHECK(std::pow(tone_mapped(ToneMap::kAgx, gray(0.18f)).y, 1 / 2.2f) == near(0.5, 0.01));
  CHECK(tone_mapped(ToneMap::kAgx, gray(0.18f * std::exp2(6.5f))).y > 0.99f);
}

TEST_CASE("tone maps: bright saturated colors turn towards white where the curve says so") {
  for (const ToneMap curve : {ToneMap::kAces, ToneMap::kAgx}) {
    CAPTURE(static_cast<int>(curve));
    const Vec3f dim = tone_mapped(curve, {0.2f, 0.01f, 0.01f}), bright = tone_mapped(curve, {200, 10, 10});
    CHECK(dim.y / dim.x < 0.4f);
    CHECK(bright.y / bright.x > 0.7f);
  }
}

TEST_CASE("tone maps: any input gives values in [0, 1]") {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const float values[] = {-inf, -1e30f, -1, -0.0f, 0, 1e-30f, 0.5f, 1, 100, 3e38f, inf, nan};
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> any(0, std::size(values) - 1);
  for (const ToneMap curve : {ToneMap::kClamp, ToneMap::kFilmic, ToneMap::kAces, ToneMap::kAgx})
    for (int i = 0; i < 2000; ++i) {
      const Vec3f in{values[any(random)], values[any(random)], values[any(random)]};
      const Vec3f out = tone_mapped(curve, in);
      for (const float x : {out.x, out.y, out.z}) CHECK((x >= 0 && x <= 1));
    }
  // Colors outside of Rec.709 are clipped to it before the curve.
  for (const ToneMap curve : kCurves)
    CHECK(tone_mapped(curve, {0.5f, -0.3f, 0.2f}) == tone_mapped(curve, {0.5f, 0, 0.2f}));
  CHECK(tone_mapped(ToneMap::kClamp, {0.25f, 2, nan}) == Vec3f{0.25f, 1, 0});
}

}  // namespace sheaf::test_tone_map
