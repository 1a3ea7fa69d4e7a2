// Blends: light sampling evaluates all parts, whichever is chosen, and scattered light has the colors of all parts.
#include "core/image/exr.h"
#include "tests/support/capture.h"
#include "tests/support/measured_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <functional>
#include <string>

namespace sheaf::test_blends {

namespace {

const double kLevel = significance_of_each(100);

MaterialId add_metal(Description& d, float alpha_u, float alpha_v) {
  ConductorDescription metal;
  metal.ior = {SpectrumDescription::rgb(0.2f, 0.4f, 1.4f), SpectrumDescription::rgb(4, 2.5f, 1.9f)};
  metal.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, alpha_u, alpha_v};
  return add_material(d, metal);
}

MaterialId add_coated_metal(Description& d) {
  CoatDescription coat;
  coat.sigma_a = SpectrumDescription::rgb(0.1f, 0.2f, 0.3f);
  coat.nested = add_metal(d, 0.4f, 0.4f);
  return add_material(d, coat);
}

/// A texture of the constant color (r, g, b).
TextureId add_uniform(Description& d, const TemporaryFolder& folder, const char* name, float r, float g, float b) {
  Image image(1, 1, {"R", "G", "B"});
  image.data = {r, g, b};
  write_exr(folder.path() / name, image, {});
  d.textures.push_back({BitmapDescription{.file = folder.path() / name}, {1, 0, 0, 0, 1, 0}, {}, {}});
  return static_cast<TextureId>(d.textures.size() - 1);
}

MaterialId add_tilted(Description& d, const TemporaryFolder& folder, MaterialId nested) {
  return add_material(d, NormalMapDescription{add_uniform(d, folder, "tilt.exr", 0.65f, 0.5f, 0.9f), false, nested});
}

/// The camera sees one point of a floor of one material, made by `add`.
using AddMaterial = std::function<MaterialId(Description&)>;
Description floor_of(const AddMaterial& add, int samples = 1) {
  Description d = one_point_scene(samples);
  add_rectangle(d, Transform::scale({20, 20, 1}), add(d));
  look_at_point(d, {2, 0.5f, 3}, {0, 0, 0});
  return d;
}
PixelMeans under_a_point(const AddMaterial& add, float side = 1) {
  Description d = floor_of(add);
  add_point_light(d, {-2, 1, 4 * side}, 100);
  if (side < 0) look_at_point(d, {2, 0.5f, -3}, {0, 0, 0});
  return pixel_means(d);
}

/// Only light sampling finds a point light. Without the noise of a choice, a blend is exactly the sum of its parts.
void check_sum(const AddMaterial& blend, const std::vector<std::pair<double, AddMaterial>>& parts, float side = 1) {
  const PixelMeans found = under_a_point(blend, side);
  double expected[3] = {};
  for (const auto& [blend_weight, part] : parts) {
    const PixelMeans one = under_a_point(part, side);
    for (std::size_t c = 0; c < 3; ++c) expected[c] += blend_weight * one[c].mean();
  }
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(found[c].mean() == near(expected[c], 1e-4));
    CHECK(std::sqrt(found[c].variance()) < 1e-3 * expected[c]);
  }
}

AddMaterial blend_of(const AddMaterial& a, const AddMaterial& b, ScalarInput weight) {
  return [=](Description& d) {
    const MaterialId first = a(d);
    return add_material(d, BlendDescription{weight, {first, b(d)}});
  };
}

const AddMaterial kGray = [](Description& d) { return add_diffuse_rgb(d, 0.2f, 0.5f, 0.7f); };
const AddMaterial kMetal = [](Description& d) { return add_metal(d, 0.5f, 0.2f); };
const AddMaterial kMeasured = [](Description& d) {
  static const TemporaryFolder folder;
  static const std::filesystem::path file = [] {
    write_bytes(folder / "facets.bsdf", tensor_bytes(measured_fields(TabulatedFacets{}.tabulate())));
    return folder / "facets.bsdf";
  }();
  return add_material(d, MeasuredDescription{file});
};
const AddMaterial kMirror = [](Description& d) { return add_mirror(d, 0.9f); };
const AddMaterial kCoated = [](Description& d) { return add_coated_metal(d); };
const AddMaterial kBlack = [](Description& d) { return add_diffuse(d, 0); };
const AddMaterial kGlass = [](Description& d) {
  DielectricDescription glass;
  glass.int_ior = 1.5f, glass.ext_ior = 1;
  glass.int_dispersion = Dispersion{Dispersion::Form::kPowers, 1.5f, {{{0.02f, -2}}}};
  glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.4f, 0.4f};
  return add_material(d, glass);
};

/// Two area lights of unequal size above a floor of blends. With `open`, shadow rays may pass surfaces.
Description lit_floor(const AddMaterial& add, bool open) {
  Description d = floor_of(add, 16);
  add_area_light_rectangle(
      d, Transform::translate({-1, 0, 2}) * Transform::rotate({1, 0, 0}, 180) * Transform::scale({0.8f, 0.8f, 1}), 3);
  add_area_light_sphere(d, {1, -2, 1}, 0.3f, 10);
  if (open) add_sphere(d, {0, 0, 0}, 0.2f, add_material(d, NullDescription{}));
  d.integrator.max_depth = 3;
  return d;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("blends: light sampling evaluates all parts without the noise of a choice") {
  check_sum(blend_of(kGray, kMetal, 0.4f), {{0.6, kGray}, {0.4, kMetal}});
  check_sum(blend_of(kMirror, kGray, 0.4f), {{0.4, kGray}});
  check_sum(blend_of(kGray, kMeasured, 0.4f), {{0.6, kGray}, {0.4, kMeasured}});
  check_sum(blend_of(kGray, blend_of(kCoated, kMetal, 0.3f), 0.5f), {{0.5, kGray}, {0.35, kCoated}, {0.15, kMetal}});
}

TEST_CASE("blends: parts may be textured and have normal maps and be seen from behind") {
  const TemporaryFolder folder;
  const AddMaterial tilted = [&](Description& d) { return add_tilted(d, folder, kMetal(d)); };
  const AddMaterial textured = [&](Description& d) {
    const TextureId blend_weight = add_uniform(d, folder, "share.exr", 0.25f, 0.25f, 0.25f);
    const TextureId color = add_uniform(d, folder, "colour.exr", 0.8f, 0.5f, 0.2f);
    const MaterialId first = add_material(d, DiffuseDescription{color});
    return add_material(d, BlendDescription{blend_weight, {first, tilted(d)}});
  };
  const AddMaterial colored = [](Description& d) { return add_diffuse_rgb(d, 0.8f, 0.5f, 0.2f); };
  check_sum(textured, {{0.75, colored}, {0.25, tilted}});
  const auto both_sides = [](const AddMaterial& add) {
    return [add](Description& d) { return add_two_sided(d, add(d)); };
  };
  check_sum(both_sides(textured), {{0.75, both_sides(colored)}, {0.25, both_sides(tilted)}}, -1);
  // Only one part is visible from behind.
  check_sum(blend_of(both_sides(kGray), kMetal, 0.4f), {{0.6, both_sides(kGray)}}, -1);
}

TEST_CASE("blends: scattered light has the colors of all parts") {
  Description d = floor_of(blend_of(
                               kGray, [](Description& e) { return add_diffuse(e, 0.9f); }, 0.4f),
                           4);
  add_constant_light(d, 1);
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  const PixelMeans found = pixel_means(d);
  CHECK(found[0].mean() == near(0.6 * 0.2 + 0.4 * 0.9, 1e-4));
  CHECK(found[2].mean() == near(0.6 * 0.7 + 0.4 * 0.9, 1e-4));
  CHECK(std::sqrt(found[0].variance()) < 1e-4);
}

TEST_CASE("blends: all strategies agree") {
  const TemporaryFolder folder;
  const AddMaterial tilted = [&](Description& d) { return add_tilted(d, folder, kMetal(d)); };
  const AddMaterial blends[] = {blend_of(kGray, kMetal, 0.4f), blend_of(kGray, blend_of(kMirror, kCoated, 0.5f), 0.6f),
                                blend_of(kGray, tilted, 0.5f), blend_of(kGray, kGlass, 0.5f)};
  int i = 0;
  for (const AddMaterial& blend : blends) {
    CAPTURE(i);
    check_strategies_agree(lit_floor(blend, i % 2 == 0), kLevel);
    ++i;
  }
  check_strategies_agree(lit_floor(blend_of(kGray, kGlass, 0.5f), true), kLevel, ColorMode::kSpectral);
}

TEST_CASE("blends: the light selection is the same for parts with different normals") {
  const TemporaryFolder folder;
  const AddMaterial shiny = [](Description& d) { return add_metal(d, 0.08f, 0.08f); };
  const AddMaterial steep = [&](Description& d) {
    const TextureId map = add_uniform(d, folder, "steep.exr", 0.915f, 0.5f, 0.78f);
    return add_material(d, NormalMapDescription{map, false, shiny(d)});
  };
  Description d = floor_of(blend_of(shiny, steep, 0.5f), 16);
  // The first light is in the mirror direction, at a right angle to the mapped normal, which points at the second
  // light.
  add_area_light_sphere(d, {-2, -0.5f, 3}, 0.4f, 5);
  add_area_light_sphere(d, {3, 0, 0.7f}, 0.4f, 5);
  d.integrator.max_depth = 2;
  check_strategies_agree(d, kLevel);
}

TEST_CASE("blends: photons are stored with their incident power whatever part scatters them") {
  const AddMaterial sides = [](Description& d) { return add_two_sided(d, kGray(d)); };
  const AddMaterial masked = [&](Description& d) {
    const MaterialId nested = sides(d);
    return add_material(d, MaskDescription{0.4f, nested});
  };
  // Power of a point light of 8 pi W / sr at height 2 that falls on the disk of the photon radius.
  const double pi = 3.14159265358979, radius = 0.3, cosine = 2 / std::sqrt(4 + radius * radius);
  const double whole = 0.5 / pi * 8 * pi * 2 * (1 - cosine) / (radius * radius);
  for (const auto& [add, blend_weight] : {std::pair{kGray, 1.0}, std::pair{masked, 0.4},
                                          std::pair{blend_of(kMirror, blend_of(kGray, kGray, 0.5f), 0.7f), 0.7}}) {
    CAPTURE_BINDING(blend_weight);
    Description d = floor_of(add);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {50'000, static_cast<float>(radius), 0};
    add_point_light(d, {0, 0, 2}, static_cast<float>(8 * pi));
    MeanVariance mean;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
      d.sampler.seed = seed;
      mean.add(pixel_means(d)[1].mean());
    }
    check_mean(mean, blend_weight * whole, kLevel, 0.0);
  }
}

TEST_CASE("blends: a mask around a blend transmits the uncovered share") {
  const AddMaterial masked = [](Description& d) {
    const MaterialId blend = blend_of(kGray, kMetal, 0.4f)(d);
    return add_material(d, MaskDescription{0.25f, blend});
  };
  Description d = floor_of(masked, 16);
  add_point_light(d, {-2, 1, 4}, 100);
  const double whole = under_a_point(blend_of(kGray, kMetal, 0.4f))[1].mean();
  check_mean(pixel_means(d)[1], 0.25 * whole, kLevel, 1e-5);
}

TEST_SUITE_END();

}  // namespace sheaf::test_blends
