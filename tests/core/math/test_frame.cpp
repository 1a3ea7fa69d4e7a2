// Frames: orthonormal and right-handed for every normal.
#include "core/math/frame.h"

#include "core/sampling/rng.h"
#include "core/sampling/warp.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_frame {

namespace {
std::vector<Vec3f> normals() {
  std::vector<Vec3f> all = {{0, 0, 1},
                            {0, 0, -1},
                            {1, 0, 0},
                            {-1, 0, 0},
                            {0, 1, 0},
                            {0, -1, 0},
                            {1, 0, -0.0f},
                            normalize(Vec3f{1e-4f, 0, -1}),
                            normalize(Vec3f{1e-7f, -1e-7f, -1}),
                            normalize(Vec3f{1, 1, -1e-20f})};
  for (std::uint32_t i = 0; i < 10000; ++i) {
    const Random4<Scalar> u = random4<Scalar>(4, i, 0, 0);
    all.push_back(square_to_sphere<Scalar>(u.x, u.y));
  }
  return all;
}
}  // namespace

TEST_CASE("frame: orthonormal and right-handed around any normal") {
  double worst = 0;
  for (const Vec3f& n : normals()) {
    const Frame<Scalar> f = Frame<Scalar>::from_normal(n);
    CHECK(f.n == n);
    const Vec3f handed = cross(f.s, f.t) - n;
    for (const float error :
         {length(f.s) - 1.0f, length(f.t) - 1.0f, dot(f.s, f.t), dot(f.s, n), dot(f.t, n), length(handed)})
      worst = std::max(worst, std::fabs(static_cast<double>(error)));
  }
  CHECK(worst < 1e-6);
}

TEST_CASE("frame: to_local and to_world are inverses and z lies along the normal") {
  double worst = 0;
  const Vec3f v{0.3f, -1.2f, 2.0f};
  for (const Vec3f& n : normals()) {
    const Frame<Scalar> f = Frame<Scalar>::from_normal(n);
    worst = std::max(worst, static_cast<double>(length(f.to_world(f.to_local(v)) - v)));
    worst = std::max(worst, static_cast<double>(length(f.to_local(n) - Vec3f{0, 0, 1})));
    worst = std::max(worst, static_cast<double>(length(f.to_world(Vec3f{0, 0, 1}) - n)));
  }
  CHECK(worst < 3e-6);
}

TEST_CASE("frame: SIMD results equal scalar ones") {
  const auto all = normals();
  double worst = 0;
  for (std::size_t i = 0; i + kWidth <= all.size(); i += kWidth) {
    const auto at = [&](int lane) { return all[i + static_cast<std::size_t>(lane)]; };
    const Vec3<Wide> n = {wide_floats([&](int k) { return at(k).x; }), wide_floats([&](int k) { return at(k).y; }),
                          wide_floats([&](int k) { return at(k).z; })};
    const Frame<Wide> wide = Frame<Wide>::from_normal(n);
    const Vec3<Wide> local = wide.to_local(broadcast<Wide>({1, 2, 3})),
                     world = wide.to_world(broadcast<Wide>({1, 2, 3}));
    for (int lane = 0; lane < kWidth; ++lane) {
      const Frame<Scalar> one = Frame<Scalar>::from_normal(at(lane));
      const Vec3f a = one.to_local({1, 2, 3}), b = one.to_world({1, 2, 3});
      worst =
          std::max({worst, difference(wide.s.x[lane], one.s.x), difference(wide.t.y[lane], one.t.y),
                    difference(local.x[lane], a.x), difference(local.y[lane], a.y), difference(local.z[lane], a.z),
                    difference(world.x[lane], b.x), difference(world.y[lane], b.y), difference(world.z[lane], b.z)});
    }
  }
  CHECK(worst < 2e-6);
}

}  // namespace sheaf::test_frame
