// Photon maps on every composite and mapped material against path tracing. A photon is stored with the fraction of the
// parts that store photons, and weighted by the shadow terminator when it is gathered.
#include "core/image/exr.h"
#include "tests/support/photon_testing.h"
#include "tests/support/temporary_folder.h"

#include <functional>
#include <string>

namespace sheaf::test_photon_surfaces {

namespace {

using AddMaterial = std::function<MaterialId(Description&)>;

MaterialId add_metal(Description& d, std::optional<float> alpha) {
  ConductorDescription metal;
  metal.ior = {SpectrumDescription::rgb(0.2f, 0.4f, 1.4f), SpectrumDescription::rgb(4, 2.5f, 1.9f)};
  if (alpha) metal.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, *alpha, *alpha};
  return add_material(d, metal);
}

/// An image of two columns.
TextureId add_image_texture(Description& d, const TemporaryFolder& folder, const std::string& name, Vec3f left,
                            Vec3f right) {
  Image image(2, 1, {"R", "G", "B"});
  image.data = {left.x, left.y, left.z, right.x, right.y, right.z};
  write_exr(folder.path() / name, image, {});
  BitmapDescription bitmap;
  bitmap.file = folder.path() / name;
  d.textures.push_back({bitmap, {1, 0, 0, 0, 1, 0}, {}, {}});
  return static_cast<TextureId>(d.textures.size() - 1);
}

/// A plate of the material, seen and lit from above, a floor below that receives transmitted light, and a ceiling that
/// is visible in reflections.
Description plate(const AddMaterial& add) {
  Description d = empty_scene(4, 4);
  look_at(d, {0.3f, -0.7f, 1.6f}, {0.1f, 0.1f, 0}, {0, 1, 0}, 20);
  d.integrator.max_depth = 3;
  d.integrator.rr_depth = 20;
  add_rectangle(d, Transform::scale({0.8f, 0.8f, 1}), add(d));
  add_rectangle(d, Transform::translate({0, 0, -0.3f}), add_diffuse(d, 0.6f));
  add_rectangle(d, Transform::translate({0, 0, 2.2f}) * Transform::rotate({1, 0, 0}, 180) * Transform::scale({2, 2, 1}),
                add_diffuse(d, 0.8f));
  // A low light, so that many directions lie between the mapped and the geometric normal.
  add_area_light_rectangle(
      d, Transform::translate({-0.9f, 0, 0.5f}) * Transform::rotate({0, 1, 0}, 110) * Transform::scale({0.2f, 0.4f, 1}),
      30);
  return d;
}

void check(const AddMaterial& add) {
  Description d = plate(add);
  const Mean path = path_mean(d, 400);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global = {25'000, 0.06f, 0};
  d.sampler.sample_count = 25;
  check_close(mean_of(d), path, 0.003);
}

const AddMaterial kRed = [](Description& d) { return add_diffuse_rgb(d, 0.7f, 0.2f, 0.1f); };
const AddMaterial kGreen = [](Description& d) { return add_diffuse_rgb(d, 0.1f, 0.8f, 0.2f); };
const AddMaterial kMirror = [](Description& d) { return add_metal(d, {}); };
const AddMaterial kBrushed = [](Description& d) { return add_metal(d, 0.3f); };
const AddMaterial kPlastic = [](Description& d) { return add_material(d, PlasticDescription{}); };

AddMaterial mask_of(const AddMaterial& nested, float opacity) {
  return [=](Description& d) { return add_material(d, MaskDescription{opacity, nested(d)}); };
}
AddMaterial blend_of(const AddMaterial& first, const AddMaterial& second, float weight) {
  return [=](Description& d) {
    const MaterialId a = first(d);
    return add_material(d, BlendDescription{weight, {a, second(d)}});
  };
}

}  // namespace

TEST_CASE("photon mapping: masks and blends have the mean of path tracing with conductors as well") {
  const std::pair<const char*, AddMaterial> cases[] = {
      {"mask", mask_of(kGreen, 0.4f)},
      {"mask that is nearly open", mask_of(kGreen, 0.1f)},
      {"blend", blend_of(kRed, kGreen, 0.3f)},
      {"blend with a mirror", blend_of(kMirror, kGreen, 0.4f)},
      {"blend with a mirror, second", blend_of(kGreen, kMirror, 0.6f)},
      {"blend with a rough conductor", blend_of(kBrushed, kGreen, 0.5f)},
      {"blend with plastic", blend_of(kPlastic, kGreen, 0.5f)},
      {"mask of a blend with a mirror", mask_of(blend_of(kGreen, kMirror, 0.5f), 0.5f)},
      {"blend of a blend with a mirror", blend_of(blend_of(kMirror, kRed, 0.5f), kGreen, 0.4f)},
      {"blend of a mask", blend_of(mask_of(kRed, 0.3f), kGreen, 0.5f)},
      {"two sides of a blend with a mirror",
       [](Description& d) { return add_two_sided(d, blend_of(kMirror, kGreen, 0.5f)(d)); }},
  };
  for (const auto& [name, add] : cases) {
    const std::string what = name;
    CAPTURE(what);
    check(add);
  }
}

TEST_CASE("photon mapping: textured masks and blends have the mean of path tracing") {
  const TemporaryFolder folder;
  check([&](Description& d) {
    const TextureId weight = add_image_texture(d, folder, "mask.exr", {0.2f, 0.2f, 0.2f}, {0.9f, 0.9f, 0.9f});
    return add_material(d, MaskDescription{weight, kGreen(d)});
  });
  check([&](Description& d) {
    const TextureId weight = add_image_texture(d, folder, "blend.exr", {0.2f, 0.2f, 0.2f}, {0.9f, 0.9f, 0.9f});
    const MaterialId a = kMirror(d);
    return add_material(d, BlendDescription{weight, {a, kGreen(d)}});
  });
}

TEST_CASE("photon mapping: normal and bump maps have the mean of path tracing") {
  const TemporaryFolder folder;
  const auto tilted = [&](const AddMaterial& nested, bool soften) {
    return AddMaterial([&folder, nested, soften](Description& d) {
      const TextureId normals = add_image_texture(d, folder, "tilt.exr", {0.2f, 0.5f, 0.9f}, {0.1f, 0.6f, 0.85f});
      return add_material(d, NormalMapDescription{normals, false, nested(d), {.soften_terminator = soften}});
    });
  };
  const auto bumped = [&](const AddMaterial& nested) {
    return AddMaterial([&folder, nested](Description& d) {
      const TextureId heights = add_image_texture(d, folder, "bump.exr", {0, 0, 0}, {1, 1, 1});
      return add_material(d, BumpMapDescription{heights, 0.6f, nested(d)});
    });
  };
  const std::pair<const char*, AddMaterial> cases[] = {
      {"normal map", tilted(kGreen, true)},
      {"normal map with hard shadows", tilted(kGreen, false)},
      {"bump map", bumped(kGreen)},
      {"normal map of a rough conductor", tilted(kBrushed, true)},
      {"normal map of plastic", tilted(kPlastic, true)},
      {"mask of a normal map", mask_of(tilted(kGreen, true), 0.5f)},
      {"blend of a mirror and a bump map", blend_of(kMirror, bumped(kGreen), 0.5f)},
      {"blend of a normal map and none", blend_of(tilted(kGreen, true), kRed, 0.5f)},
  };
  for (const auto& [name, add] : cases) {
    const std::string what = name;
    CAPTURE(what);
    check(add);
  }
}

}  // namespace sheaf::test_photon_surfaces
