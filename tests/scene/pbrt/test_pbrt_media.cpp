// Media of pbrt on grids, evaluated at positions where voxels and formulas are known.
#include "core/color/color.h"
#include "scene/compile/compile.h"
#include "scene/dialects/pbrt/noise.h"
#include "scene/formats/nanovdb.h"
#include "scene/tables/majorant_grid.h"
#include "scene/tables/medium_lookup.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_pbrt_media {

using namespace test;

namespace {

/// A scene whose box is filled with a medium.
struct Filled {
  std::unique_ptr<const Scene> scene;
  MediumSpectra spectra;
  Vec3f sigma_a, sigma_s, emission;

  explicit Filled(const std::string& medium, const std::string& transform = "") {
    const TemporaryFolder folder;
    VoxelBlocks density(1), temperature(1);
    std::ranges::fill(density.add({0, 0, 0}), 2.0f);
    std::ranges::fill(temperature.add({0, 0, 0}), 1500.0f);
    const NanoVdbGrid grids[] = {{"density", &density, Transform(), NanoVdbGrid::Values::kFloat, false},
                                 {"temperature", &temperature, Transform(), NanoVdbGrid::Values::kFloat, false}};
    write_nanovdb(folder / "fire.nvdb", grids);
    const std::string text = "WorldBegin\nAttributeBegin " + transform + " MakeNamedMedium \"m\" \"string type\" " +
                             medium + "\nAttributeEnd\nMediumInterface \"m\" \"\" Material \"interface\"\n" +
                             "Shape \"sphere\" \"float radius\" 9\n";
    const Description d = read_scene(write_below(folder, "scene.pbrt", text));
    scene = compile_scene(d, {});
    spectra = medium_spectra(scene->view(), scene->view().media.rows[0], {});
  }

  void look(Vec3f p) {
    const SceneView view = scene->view();
    const MediumCoefficients found = medium_coefficients(view, view.media.rows[0], spectra, p, {});
    const Float4 glow = medium_emission(view, view.media.rows[0], spectra, p, {});
    sigma_a = {found.sigma_a[0], found.sigma_a[1], found.sigma_a[2]};
    sigma_s = {found.sigma_s[0], found.sigma_s[1], found.sigma_s[2]};
    emission = {glow[0], glow[1], glow[2]};
  }
};

/// Luminance of a black body of maximum 1, as pbrt's film records it without a scale.
double unit_blackbody_luminance(double temperature) {
  double sum = 0, largest = 0;
  for (double nm = 360; nm < 830; nm += 1)
    sum += double{cie_1931_xyz(static_cast<float>(nm)).y} * blackbody_radiance(nm, temperature);
  for (double nm = 200; nm < 20000; nm += 1) largest = std::max(largest, blackbody_radiance(nm, temperature));
  return sum / largest;
}

}  // namespace

TEST_CASE("pbrt media: a uniform grid is interpolated between voxel centers and fades to zero at its box") {
  Filled fog(
      "\"uniformgrid\" \"integer nx\" 2 \"float density\" [ 1 3 ] \"point3 p0\" [ 0 0 0 ] \"point3 p1\" [ 4 1 1 ] "
      "\"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 0.5 0.5 0.5 ] \"float scale\" 2 \"rgb Le\" [ 1 1 1 ] "
      "\"float Lescale\" [ 0 4 ]",
      "Translate 1 0 0");
  const auto at = [&](float x, float y) { return fog.look({1 + x, y, 0.5f}), fog.sigma_a.x / 2; };
  CHECK(at(1, 0.5f) == near(1));
  CHECK(at(3, 0.5f) == near(3));
  CHECK(at(2, 0.5f) == near(2));
  CHECK(at(3.5f, 0.5f) == near(2.25));
  CHECK(at(3, 0.25f) == near(2.25));
  CHECK(at(4.01f, 0.5f) == 0);
  CHECK(at(-0.01f, 0.5f) == 0);
  fog.look({3, 0.5f, 0.5f});
  CHECK(fog.sigma_a.z == near(2 * 3 * 2));
  CHECK(fog.sigma_s.y == near(2 * 0.5 * 2));
  CHECK(fog.emission.x == near(2));
}

TEST_CASE("pbrt media: absorption and scattering may vary by voxel and color and their sum is bounded") {
  Filled fog(
      "\"rgbgrid\" \"integer nx\" 2 \"integer ny\" 1 \"rgb sigma_a\" [ 1 2 3  3 0 1 ] "
      "\"rgb sigma_s\" [ 0 4 8  2 6 0 ] \"float scale\" 0.5 \"rgb Le\" [ 0 1 0  0 1 0 ] \"float Lescale\" 0.01");
  fog.look({0.25f, 0.5f, 0.5f});
  CHECK(length(fog.sigma_a - Vec3f{0.5f, 1, 1.5f}) < 1e-5f);
  CHECK(length(fog.sigma_s - Vec3f{0, 2, 4}) < 1e-5f);
  CHECK(fog.emission.y == near(1.06857, 1e-4));
  fog.look({0.5f, 0.5f, 0.5f});
  CHECK(length(fog.sigma_a - Vec3f{1, 0.5f, 1}) < 1e-5f);
  CHECK(length(fog.sigma_s - Vec3f{0.5f, 2.5f, 2}) < 1e-5f);
  const MajorantGridRow& row = fog.scene->view().media.majorants[fog.scene->view().media.rows[0].majorants];
  const Float4 most =
      (fog.spectra.first + fog.spectra.second) * row.bounds[row.entries[0] >> kMajorantSideBits].majorant();
  for (int i = 0; i <= 20; ++i) {
    fog.look({0.05f * static_cast<float>(i), 0.5f, 0.5f});
    const Vec3f all = fog.sigma_a + fog.sigma_s;
    CHECK(max_component(all) <= most[0]);
  }
  Filled absorbing("\"rgbgrid\" \"rgb sigma_a\" [ 1 2 3 ]");
  absorbing.look({0.5f, 0.5f, 0.5f});
  CHECK(length(absorbing.sigma_s - Vec3f{1, 1, 1}) < 1e-5f);
}

TEST_CASE("pbrt media: colored grids fade to zero at their box") {
  Filled grid(
      "\"rgbgrid\" \"integer nx\" 2 \"point3 p0\" [ 1 0 0 ] \"point3 p1\" [ 5 1 1 ] \"rgb sigma_a\" [ 1 2 3  4 4 4 ] "
      "\"rgb sigma_s\" [ 2 0 4  8 8 8 ] \"rgb Le\" [ 1 1 1  2 2 2 ]");
  const auto glow_at = [&](float x, float y) { return grid.look({x, y, 0.5f}), grid.emission.y; };
  const float inside = glow_at(4, 0.5f);
  CHECK(inside > 0);
  CHECK(glow_at(2, 0.5f) == near(inside / 2));
  // Half of the weight is that of the outermost voxel, the other half is outside.
  CHECK(glow_at(5 - 1e-4f, 0.5f) == near(inside / 2, 1e-3));
  CHECK(length(grid.sigma_a - Vec3f{2, 2, 2}) < 1e-2f);
  CHECK(length(grid.sigma_s - Vec3f{4, 4, 4}) < 1e-2f);
  CHECK(glow_at(4, 1e-4f) == near(inside / 2, 1e-3));
  glow_at(1 + 1e-4f, 0.5f);
  CHECK(length(grid.sigma_a - Vec3f{0.5f, 1, 1.5f}) < 1e-2f);
  CHECK(length(grid.sigma_s - Vec3f{1, 0, 2}) < 1e-2f);
  for (const float x : {0.99f, 5.01f}) {
    grid.look({x, 0.5f, 0.5f});  // there is no absorption and hence no emission
    CHECK(max_component(grid.sigma_a + grid.sigma_s) == 0);
  }
}

TEST_CASE("pbrt media: Lescale and the exposure multiply the emission of homogeneous media") {
  const auto emission = [](const std::string& parameters) {
    Filled glow("\"homogeneous\" \"rgb sigma_a\" [ 2 2 2 ] " + parameters);
    glow.look({0, 0, 0});
    return glow.emission;
  };
  CHECK(length(emission("\"rgb Le\" [ 1 2 3 ]") - Vec3f{1, 2, 3}) < 1e-5f);
  CHECK(length(emission("\"rgb Le\" [ 1 2 3 ] \"float Lescale\" 2.5") - Vec3f{2.5f, 5, 7.5f}) < 1e-5f);
  // Other spectra are normalized to a luminance of 1.
  CHECK(double{luminance(emission("\"blackbody Le\" 4000 \"float Lescale\" 3"))} == near(3, 2e-3));
}

TEST_CASE("pbrt media: the emission of fire is a black body with maximum 1 at its temperature") {
  for (const std::string medium :
       {"\"nanovdb\" \"string filename\" \"fire.nvdb\" \"float LeScale\" 0.5 \"float temperaturescale\" 2 "
        "\"float temperatureoffset\" 250",
        "\"uniformgrid\" \"float density\" 2 \"float temperature\" 1500 \"float Lescale\" 0.5 "
        "\"float temperaturescale\" 2 \"float temperaturecutoff\" 250 \"point3 p0\" [ 3.5 3.5 3.5 ] "
        "\"point3 p1\" [ 4.5 4.5 4.5 ]"}) {
    CAPTURE(medium);
    Filled fire(medium);
    fire.look({4, 4, 4});
    CHECK(double{luminance(fire.emission)} == near(0.5 * unit_blackbody_luminance(2500), 2e-3));
    CHECK(fire.emission.x > 2 * fire.emission.z);
    CHECK(fire.sigma_a.x == near(2));
  }
  Filled dark("\"nanovdb\" \"string filename\" \"fire.nvdb\" \"float LeScale\" 0");
  CHECK((dark.scene->view().media.rows[0].flags & kMediumEmits) == 0);
}

TEST_CASE("pbrt media: clouds are noise in the space of the medium") {
  Filled cloud(
      "\"cloud\" \"float density\" 2 \"float wispiness\" 0.5 \"float frequency\" 2 \"rgb sigma_a\" [ 0 0 0 ] "
      "\"point3 p0\" [ 0 0.3 0.4 ] \"point3 p1\" [ 1 1 0.5 ]",
      "Translate 3 0 0");
  const pbrt::CloudShape shape{2, 0.5, 2};
  double worst = 0, off = 0, sum = 0;
  for (int i = 0; i < 1000; ++i) {
    const int x = i % 10, y = i / 10 % 10, z = i / 100;
    const Vec3f p{static_cast<float>(x) * 0.1f + 0.05f, static_cast<float>(y) * 0.06f + 0.35f,
                  static_cast<float>(z) * 0.01f + 0.405f};
    cloud.look(p + Vec3f{3, 0, 0});
    const double expected = pbrt::cloud_density(shape, double{p.x}, double{p.y}, double{p.z});
    const double error = std::fabs(double{cloud.sigma_s.x} - expected);
    worst = std::max(worst, error);
    off += error;
    sum += expected;
  }
  CHECK(sum > 20);
  CHECK(off / 1000 < 0.01);
  CHECK(worst < 0.25);
  cloud.look({3.5f, 0.29f, 0.45f});
  CHECK(cloud.sigma_s.x == 0);
}

TEST_CASE("pbrt media: clouds match an independent implementation of the formula of pbrt") {
  struct Case {
    pbrt::CloudShape cloud;
    double x, y, z, density;
  };
  for (const Case& c :
       {Case{{2, 0.5, 2}, 0.81, 0.6, 0.15, 0.07537690329922543},
        Case{{0.7, 2, 4}, 0.37, 0.52, 0.66, 0.23470302532724308}, Case{{1, 1, 7}, 0.1, 0.55, 0.25, 0.5077235665925008},
        Case{{1, 1, 7}, 0.6, 0.55, 0.85, 0.22320655249814503}})
    CHECK(pbrt::cloud_density(c.cloud, c.x, c.y, c.z) == near(c.density, 1e-9));
}

TEST_CASE("pbrt media: noise is 0 at integers and periodic and not constant") {
  double sum = 0, squares = 0;
  for (int i = 0; i < 1000; ++i) {
    CHECK(pbrt::noise(i, 3 * i % 7, -i) == 0);
    const double x = 0.37 * i, y = 0.71 * i, z = 1.13 * i, value = pbrt::noise(x, y, z);
    CHECK(std::fabs(value) <= 1.1);
    CHECK(pbrt::noise(x + 256, y - 256, z) == within(value, 1e-9));
    sum += value, squares += value * value;
  }
  CHECK(std::fabs(sum / 1000) < 0.05);
  CHECK(squares / 1000 > 0.03);
  // Noise rises as steeply as the gradient at the lattice point, (x, y, z) -> +-x +-y and so on.
  const double slope = pbrt::noise(1e-6, 0, 0) / 1e-6;
  CHECK(std::fabs(std::fabs(slope) - std::round(std::fabs(slope))) < 1e-5);
}

TEST_CASE("pbrt media: invalid grids are errors") {
  const auto check = [](const std::string& medium, const std::string& part) {
    const std::string message = error_of_pbrt_world("MakeNamedMedium \"m\" \"string type\" " + medium);
    CAPTURE(message);
    CHECK(contains(message, "scene.pbrt:3: "));
    CHECK(contains(message, part));
  };
  check("\"uniformgrid\"", "needs 'density'");
  check("\"uniformgrid\" \"integer nx\" 2 \"float density\" [ 1 2 3 ]", "has 3 numbers, expected 2");
  check("\"uniformgrid\" \"float density\" -1", "expected a non-negative number");
  check("\"uniformgrid\" \"float density\" 1 \"rgb Le\" [ 1 1 1 ] \"float temperature\" 3", "both 'Le' and");
  check("\"uniformgrid\" \"float density\" 1 \"point3 p1\" [ 1 0 1 ]", "is flat");
  check("\"rgbgrid\"", "needs 'sigma_a' or 'sigma_s'");
  check("\"rgbgrid\" \"float sigma_a\" 1", "is of the type float, expected rgb");
}

}  // namespace sheaf::test_pbrt_media
