// Normals of normal maps: scale, and the direction of the y axis where uv are mirrored.
#include "kernels/stages/normal_map.h"
#include "scene/compile/textures/compile_textures.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_normal_map {

namespace {

/// A map that is (0.5, 0.2, 0.8) everywhere, unnormalized.
struct UniformMap {
  UniformMap() {
    view.rows = textures.rows.data();
    row.flags = 0;
  }
  TextureTables textures = compile_textures(
      {{ConstantTextureDescription{SpectrumDescription::rgb(0.75f, 0.6f, 0.9f)}, {1, 0, 0, 0, 1, 0}, "", {}}});
  TextureView view;
  NormalMapRow row;

  /// The normal where p = (u, v_sign v, 0). `from_behind`: the base normal is flipped towards the viewer.
  template <class L> Vec3<L> rotated(float v_sign, bool from_behind) const {
    using F = Float<L>;
    const F zero(0.0f), one(1.0f), side(from_behind ? -1.0f : 1.0f);
    Mask<L> usable(false);
    const Vec3<L> n = perturbed_normal<L>(view, row, TextureQuery<L>{}, {zero, zero, side}, side, {one, zero, zero},
                                          {zero, F(v_sign), zero}, Mask<L>(true), usable);
    CHECK(all(usable));
    return n;
  }
  void check(float v_sign, bool from_behind, Vec3f expected) const {
    CAPTURE(v_sign);
    CAPTURE(from_behind);
    expected = normalize(expected);
    const Vec3f n = rotated<Scalar>(v_sign, from_behind);
    CHECK(n.x == near(expected.x));
    CHECK(n.y == near(expected.y));
    CHECK(n.z == near(expected.z));
    const Vec3<Wide> wide = rotated<Wide>(v_sign, from_behind);
    const LaneArray<WideFloat> x(wide.x), y(wide.y), z(wide.z);
    for (int lane = 0; lane < kWidth; ++lane) {
      CHECK(difference(x[lane], n.x) < 1e-6);
      CHECK(difference(y[lane], n.y) < 1e-6);
      CHECK(difference(z[lane], n.z) < 1e-6);
    }
  }
};

}  // namespace

TEST_CASE("normal maps: the y axis is the cross product of normal and tangent, also where uv are mirrored") {
  UniformMap map;
  for (const float v_sign : {1.0f, -1.0f}) {
    map.check(v_sign, false, {0.5f, 0.2f, 0.8f});
    map.check(v_sign, true, {0.5f, 0.2f, -0.8f});
  }
}

TEST_CASE("normal maps: the y axis can follow increasing v") {
  UniformMap map;
  map.row.flags = NormalMapRow::kFollowsUv;
  map.check(1, false, {0.5f, 0.2f, 0.8f});
  map.check(1, true, {0.5f, 0.2f, -0.8f});
  map.check(-1, false, {0.5f, -0.2f, 0.8f});
  map.check(-1, true, {0.5f, -0.2f, -0.8f});
  map.row.flags |= NormalMapRow::kFlipGreen;
  map.check(1, false, {0.5f, -0.2f, 0.8f});
  map.check(-1, false, {0.5f, 0.2f, 0.8f});
}

TEST_CASE("normal maps: the scale multiplies x and y before the normal is normalized") {
  UniformMap map;
  map.row.scale = 2;
  map.check(1, false, {1, 0.4f, 0.8f});
  map.row.flags = NormalMapRow::kFlipGreen;
  map.check(1, false, {1, -0.4f, 0.8f});
  map.row.scale = 0;
  map.check(1, false, {0, 0, 0.8f});
}

}  // namespace sheaf::test_normal_map
