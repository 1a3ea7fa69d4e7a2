// Microflake matrices: valid ellipsoids, grids of them, and invalid media.
#include "scene/compile/compile.h"
#include "scene/compile/media/flakes.h"
#include "scene/tables/medium_lookup.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <limits>

namespace sheaf::test_microflakes {

namespace {

/// A sphere filled with flakes.
Description flakes_in_sphere(SggxDescription flakes) {
  Description d = empty_scene(1, 1);
  d.phases.push_back({std::move(flakes), {}});
  MediumDescription m = fog(1, 0.5f);
  m.phase = PhaseId{0};
  fill(d, add_sphere(d, {0, 0, 5}, 1), add_medium(d, m));
  return d;
}

}  // namespace

TEST_CASE("microflakes: the largest area is the root of the largest eigenvalue and negative ones are clamped") {
  CHECK(largest_flake_area({4, 9, 1, 0, 0, 0}) == near(3));
  CHECK(largest_flake_area({2, 2, 2, 0, 0, 0}) == near(std::sqrt(2.0)));
  // Eigenvalues 3 and 1 in the xz plane, and 0.
  CHECK(largest_flake_area({2, 0, 2, 0, 1, 0}) == near(std::sqrt(3.0)));
  CHECK(largest_flake_area({}) == 0.0f);
  CHECK_THROWS_WITH_AS(largest_flake_area({1, 1, 1, 2, 0, 0}),
                       doctest::Contains("1 1 1 2 0 0 (xx yy zz xy xz yz) has the negative eigenvalue -1,"),
                       SceneError);
  CHECK_THROWS_WITH_AS(largest_flake_area({1, -1, 1, 0, 0, 0}), doctest::Contains("negative"), SceneError);
  CHECK_THROWS_WITH_AS(largest_flake_area({1, 1, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0}),
                       doctest::Contains("not finite"), SceneError);
}

TEST_CASE("microflakes: a grid of six channels is interpolated as matrices") {
  const TemporaryFolder folder;
  const auto file = write_vol(folder / "s.vol", 4, 6, [](Vec3f p, int c) {
    return c == 0 ? 1 + p.x : c < 3 ? 1.0f : c == 3 ? 0.5f * p.y : c == 4 ? -0.25f : 0.125f;
  });
  const auto scene = compile_scene(flakes_in_sphere({vol(file, Transform::translate({-0.5f, -0.5f, 4.5f}))}));
  const SceneView view = scene->view();
  const MediumRow& medium = view.media.rows[0];
  CHECK((medium.flags & kMediumFlakes) != 0);
  CHECK((medium.flags & kMediumHomogeneous) == 0);
  const FlakeMatrix s = flake_matrix(view, medium, {0.1f, -0.2f, 5});
  const float expected[6] = {1.6f, 1, 1, 0.15f, -0.25f, 0.125f};
  for (int k = 0; k < 6; ++k) CHECK(s.entries[k] == near(expected[k]));
  CHECK(medium.max_flakes >= s.projected_area({1, 0, 0}));
  CHECK(flake_projected_area(view, medium, {0.1f, -0.2f, 5}, {1, 0, 0}) == near(std::sqrt(1.6f) / medium.max_flakes));
}

TEST_CASE("microflakes: invalid grids and emissive media are errors") {
  const TemporaryFolder folder;
  const auto gray = write_vol(folder / "grey.vol", 2, 1, [](Vec3f, int) { return 1.0f; });
  const auto bent =
      write_vol(folder / "bent.vol", 2, 6, [](Vec3f p, int c) { return c == 3 && p.y > 0.5f ? 2.0f : 1.0f; });
  CHECK_THROWS_WITH_AS(compile_scene(flakes_in_sphere({vol(gray)})), doctest::Contains("expected 6 channels, found 1"),
                       SceneError);
  CHECK_THROWS_WITH_AS(compile_scene(flakes_in_sphere({vol(bent)})), doctest::Contains("voxel 2: "), SceneError);
  const SggxDescription round{std::array<float, 6>{1, 1, 1, 0, 0, 0}};
  Description glowing = flakes_in_sphere(round);
  glowing.media[0].emission = VolumeInput(SpectrumDescription::constant(1));
  CHECK_THROWS_WITH_AS(compile_scene(glowing), doctest::Contains("cannot emit"), SceneError);
  Description mixed = flakes_in_sphere(round);
  mixed.phases.push_back({BlendPhaseDescription{0.5f, {PhaseId{0}, PhaseId{0}}}, {}});
  mixed.media[0].phase = PhaseId{1};
  CHECK_THROWS_WITH_AS(compile_scene(mixed), doctest::Contains("cannot be mixed"), SceneError);
  Description mapped = flakes_in_sphere(round);
  mapped.integrator.kind = IntegratorKind::kPhotonMapper;
  CHECK_NOTHROW(compile_scene(mapped));
  mapped.integrator.photons.volume.count = 1000;
  CHECK_THROWS_WITH_AS(compile_scene(mapped), doctest::Contains("cannot be gathered"), SceneError);
}

}  // namespace sheaf::test_microflakes
