// Light tracing against path tracing in and around participating media.
#include "tests/renders/light/light_tracing_cases.h"
#include "tests/support/media_testing.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <vector>

namespace sheaf::test_light_tracing_media {

using namespace light_tracing_cases;

namespace {

/// Media in shapes and around the scene, and surfaces that let light pass. `lumps` is the file of a density grid.
std::vector<NamedChange> media(const std::filesystem::path& lumps) {
  const Transform around = Transform::translate({-1.5f, -1.5f, 0.1f}) * Transform::scale({3, 3, 3.2f});
  const auto with_density = [=](MediumDescription m) {
    m.density = vol(lumps, around);
    return m;
  };
  MediumDescription colored = fog(1, 1);
  colored.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.3f, 0.6f, 1.2f),
                                                     SpectrumDescription::rgb(0.9f, 0.5f, 0.7f)};
  return {
      {"fog in a ball, forward scattering",
       [=](Description& d) {
         MediumDescription m = fog(0.8f, 0.9f);
         m.phase = add_phase(d, 0.7f);
         fill(d, add_sphere(d, {0, 0, 1.5f}, 1.4f), add_medium(d, m));
       }},
      {"colored fog in a ball",
       [=](Description& d) {
         fill(d, add_sphere(d, {0, 0, 1.5f}, 1.4f), add_medium(d, colored));
       }},
      {"lumpy fog in a cube",
       [=](Description& d) {
         fill(d, add_shape(d, CubeShape{}, Transform::translate({0, 0, 1.7f}) * Transform::scale({1.5f, 1.5f, 1.6f})),
              add_medium(d, with_density(colored)));
       }},
      {"fog around everything", [](Description& d) { d.camera.medium = add_medium(d, fog(0.1f, 0.8f)); }},
      {"fog in rough glass",
       [=](Description& d) {
         DielectricDescription glass;
         glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.4f, 0.4f};
         const MaterialId material = add_material(d, glass);
         const MediumId inside = add_medium(d, colored);
         add_sphere(d, {0, 0, 0.8f}, 0.75f, material).interior = inside;
       }},
      {"a pane and a mask",
       [=](Description& d) {
         DielectricDescription pane;
         pane.thin = true;
         // Light tracing cannot render specular reflections.
         pane.specular_reflectance = SpectrumDescription::constant(0);
         add_rectangle(d, Transform::translate({0.3f, -0.5f, 1.2f}) * Transform::scale({0.6f, 0.6f, 1}),
                       add_material(d, pane));
         add_rectangle(d, Transform::translate({-0.5f, 0.5f, 0.9f}) * Transform::scale({0.6f, 0.6f, 1}),
                       add_material(d, MaskDescription{0.5f, add_two_sided(d, add_diffuse(d, 0.7f))}));
         d.integrator.thin_dielectrics_are_free = true;
       }},
  };
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("light tracing: every emitter in and around media has the mean of path tracing") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 8, 1, [](Vec3f p, int) {
    return 1 + 0.9f * std::sin(17 * p.x) * std::sin(13 * p.y + 1) * std::cos(11 * p.z);
  });
  const std::vector<NamedChange> changes = media(lumps);
  for (const NamedChange& emitter : emitters())
    for (const NamedChange& medium : changes) {
      CAPTURE(emitter.name);
      CAPTURE(medium.name);
      Description d = room();
      emitter.add(d);
      medium.add(d);
      check_agree(d);
    }
}

TEST_CASE("light tracing: distant light through unbounded fog is unbiased far from the center of the scene") {
  for (const char* const emitter : {"directional", "constant"}) {
    CAPTURE(emitter);
    Description d = room(100);
    add_sphere(d, {16, 0, 0}, 0.5f, add_diffuse(d, 0.5f));
    d.camera.medium = add_medium(d, fog(0.15f, 0.5f));
    add_named(d, emitters(), emitter);
    check_agree(d);
  }
}

TEST_CASE("light tracing: emissive media have the mean of path tracing for every medium estimator") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 8, 1, [](Vec3f p, int) { return 1 + 0.9f * std::sin(17 * p.x); });
  for (const MediumEstimator estimator : {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio})
    for (const bool grid : {false, true})
      for (const float albedo : {0.0f, 0.6f}) {
        CAPTURE(static_cast<int>(estimator));
        CAPTURE(grid);
        CAPTURE(albedo);
        Description d = room();
        d.integrator.medium_estimator = estimator;
        MediumDescription m = fog(0.7f, albedo);
        if (grid) m.density = vol(lumps, Transform::translate({-1, -1, 0.5f}) * Transform::scale({2, 2, 2}));
        m.emission = SpectrumDescription::rgb(2, 3, 1);
        fill(d, add_sphere(d, {0, 0, 1.5f}, 0.8f), add_medium(d, m));
        check_agree(d);
      }
}

TEST_SUITE_END();

}  // namespace sheaf::test_light_tracing_media
