// Majorants of media with colored grids in spectral mode.
#include "scene/compile/compile.h"
#include "scene/tables/medium_lookup.h"
#include "tests/support/media_testing.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_medium_majorants {

namespace {

/// A grid of one voxel of a saturated color.
GridVolumeDescription saturated(const TemporaryFolder& folder, const char* name, Vec3f rgb, float factor = 1) {
  return vol(write_vol(folder / name, 1, 3, [=](Vec3f, int c) {
    return factor * (c == 0 ? rgb.x : c == 1 ? rgb.y : rgb.z);
  }));
}

std::unique_ptr<const Scene> compile_spectral(const MediumDescription& medium) {
  Description d = empty_scene(8, 8);
  fill(d, add_sphere(d, {0, 0, 0}, 2), add_medium(d, medium));
  CompileOptions options;
  options.color = ColorMode::kSpectral;
  return compile_scene(d, options);
}

/// The largest extinction over all wavelengths at the center of the unit cube, and its largest ratio to the majorant.
std::pair<float, float> largest_and_bound(const Scene& scene) {
  const SceneView view = scene.view();
  const MediumRow& medium = view.media.rows[0];
  const MajorantGridRow& majorants = view.media.majorants[medium.majorants];
  const float bound = majorants.bounds[majorants.entries[0] >> kMajorantSideBits].majorant();
  float largest = 0, worst = 0;
  for (float nm = 360; nm <= 826; nm += 4) {
    const Spectrum4 lambda{nm, nm + 1, nm + 2, nm + 3};
    const MediumSpectra spectra = medium_spectra(view, medium, lambda);
    const Float4 found = medium_coefficients(view, medium, spectra, {0.5f, 0.5f, 0.5f}, lambda).sigma_t;
    const bool both = (medium.flags & kMediumAbsorptionScattering) != 0;
    const Float4 most = (both ? spectra.first + spectra.second : spectra.first) * bound;
    for (int lane = 0; lane < 4; ++lane) {
      largest = std::max(largest, found[lane]);
      worst = std::max(worst, found[lane] / most[lane]);
    }
  }
  return {largest, worst};
}

}  // namespace

TEST_CASE("media: majorants hold at every wavelength where spectra exceed their colors") {
  const TemporaryFolder folder;
  for (const Vec3f rgb : {Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}, Vec3f{0.9f, 0.02f, 0.8f}}) {
    CAPTURE(rgb.x);
    CAPTURE(rgb.y);
    CAPTURE(rgb.z);
    const GridVolumeDescription grid = saturated(folder, "a.vol", rgb);
    MediumDescription extinction, sum;
    extinction.coefficients = ExtinctionAlbedoDescription{grid, SpectrumDescription::constant(0.5f)};
    sum.coefficients = AbsorptionScatteringDescription{grid, saturated(folder, "b.vol", rgb)};
    struct Case {
      MediumDescription medium;
      float largest_component;  ///< the largest component
    };
    for (const Case& c : {Case{extinction, 1}, Case{sum, 2}}) {
      const auto scene = compile_spectral(c.medium);
      const auto [largest, fraction] = largest_and_bound(*scene);
      // The test is meaningful only if spectra exceed their colors.
      CHECK(largest > 1.1f * c.largest_component * max_component(rgb));
      CHECK(fraction <= 1);
      CHECK(fraction > 0.5f);
    }
  }
}

TEST_CASE("media: colors whose spectra exceed the float range are errors for extinction and emission") {
  const TemporaryFolder folder;
  const auto large = saturated(folder, "large.vol", {0, 0, 1}, 2.5e38f);
  MediumDescription extinction, emission = fog(1, 0.5f);
  extinction.coefficients = ExtinctionAlbedoDescription{large, SpectrumDescription::constant(0.5f)};
  emission.emission = VolumeInput(large);
  CHECK_THROWS_AS(compile_spectral(extinction), SceneError);
  CHECK_THROWS_AS(compile_spectral(emission), SceneError);
}

}  // namespace sheaf::test_medium_majorants
