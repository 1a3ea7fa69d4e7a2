// Emission of surfaces with an opacity: what is cut out or faint neither is seen nor lights others. Invisible lamps,
// and black environments as visible backgrounds.
#include "scene/dialects/common/covered_emission.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/light_tracing_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"
#include "tests/support/photon_testing.h"

namespace sheaf::test_covered_emission {

using namespace test;
using nlohmann::json;

namespace {

/// Mean of a channel over pixels [x0, x1) x [y0, y1).
double mean_of(const Image& image, const char* channel, int x0, int x1, int y0, int y1) {
  double sum = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) sum += static_cast<double>(image.at(x, y, image.find_channel(channel)));
  return sum / ((x1 - x0) * (y1 - y0));
}

Image image_of(const Description& d) { return render(*compile_scene(d), {}).film.to_image(); }

// glTF

/// A square of 2 x 2 at height z with texture coordinates, in a node of its own. Returns its primitive.
json& add_square(GltfBuilder& gltf, float z, int material) {
  json& primitive = gltf.add_mesh({{"POSITION", gltf.add<float>({-1, -1, z, 1, -1, z, 1, 1, z, -1, 1, z}, "VEC3")},
                                   {"NORMAL", gltf.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")}});
  primitive["indices"] = gltf.add<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  primitive["material"] = material;
  const std::size_t node = gltf.json["nodes"].size();
  gltf.json["nodes"].push_back({{"mesh", gltf.json["meshes"].size() - 1}});
  gltf.json["scenes"][0]["nodes"] = json::array();
  for (std::size_t i = 0; i <= node; ++i) gltf.json["scenes"][0]["nodes"].push_back(i);
  return primitive;
}

/// Renders a square with the material and alphas of its left and its right edge, before a green wall if `wall`.
Image gltf_image(const json& material, float left, float right, bool wall) {
  GltfBuilder gltf;
  json& primitive = add_square(gltf, 0, 0);
  primitive["attributes"]["COLOR_0"] =
      gltf.add<float>({1, 1, 1, left, 1, 1, 1, right, 1, 1, 1, right, 1, 1, 1, left}, "VEC4");
  gltf.json["materials"] = {material,
                            {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0.25, 0, 1}}}},
                             {"extensions", {{"KHR_materials_unlit", json::object()}}}}};
  if (wall) add_square(gltf, -1, 1);
  gltf.json["extensionsUsed"] = {"KHR_materials_unlit"};
  const TemporaryFolder folder;
  ReadOptions alone;
  alone.surroundings.floor = false;
  Description d = read_scene(write_below(folder, "model.gltf", gltf.text()), alone);
  d.lights.clear();
  d.film = {};
  d.film.width = d.film.height = 8;
  d.camera = {};
  d.camera.to_world = Transform::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
  d.camera.projection = CameraDescription::Projection::kOrthographic;
  d.sampler.sample_count = 64;
  return image_of(d);
}

json unlit(const char* mode, float alpha) {
  return {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, alpha}}}},
          {"extensions", {{"KHR_materials_unlit", json::object()}}},
          {"alphaMode", mode}};
}

json emissive(const char* mode, float alpha) {
  return {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, alpha}}, {"metallicFactor", 1}}},
          {"emissiveFactor", {1, 1, 1}},
          {"alphaMode", mode}};
}

}  // namespace

TEST_CASE("covered emission: gltf blends unlit and emissive surfaces by alpha") {
  const double tolerance = 0.02;
  for (const json& material : {unlit("BLEND", 0.5f), emissive("BLEND", 0.5f)}) {
    CAPTURE(material.dump());
    // 0.5 times the alpha of the vertices, which is 0.5: 1/4 of the radiance
    const Image alone = gltf_image(material, 0.5f, 0.5f, false), before = gltf_image(material, 0.5f, 0.5f, true);
    CHECK(mean_of(alone, "R", 0, 8, 0, 8) == within(0.25, tolerance));
    CHECK(mean_of(alone, "A", 0, 8, 0, 8) == within(0.25, tolerance));
    CHECK(mean_of(before, "R", 0, 8, 0, 8) == within(0.25, tolerance));
    CHECK(mean_of(before, "G", 0, 8, 0, 8) == within(0.25 + 0.75 * 0.25, tolerance));
    CHECK(mean_of(before, "A", 0, 8, 0, 8) == 1.0);
  }
}

TEST_CASE("covered emission: gltf cuts out unlit and emissive surfaces below the cutoff") {
  for (const json& material : {unlit("MASK", 1), emissive("MASK", 1)}) {
    CAPTURE(material.dump());
    // Alpha runs from 0 to 1: the cutoff of 0.5 lies in the middle.
    const Image alone = gltf_image(material, 0, 1, false), before = gltf_image(material, 0, 1, true);
    CHECK(mean_of(alone, "R", 0, 3, 0, 8) == 0.0);
    CHECK(mean_of(alone, "A", 0, 3, 0, 8) == 0.0);
    CHECK(mean_of(alone, "R", 5, 8, 0, 8) == near(1.0, 1e-4));
    CHECK(mean_of(alone, "A", 5, 8, 0, 8) == 1.0);
    CHECK(mean_of(before, "R", 0, 3, 0, 8) == 0.0);
    CHECK(mean_of(before, "G", 0, 3, 0, 8) == near(0.25, 1e-4));
    CHECK(mean_of(before, "G", 5, 8, 0, 8) == near(1.0, 1e-4));
  }
  // A constant alpha below the cutoff
  const Image none = gltf_image(unlit("MASK", 0.4f), 1, 1, true);
  CHECK(mean_of(none, "R", 0, 8, 0, 8) == 0.0);
  CHECK(mean_of(none, "G", 0, 8, 0, 8) == near(0.25, 1e-4));
  // Opaque materials ignore alpha
  CHECK(mean_of(gltf_image(unlit("OPAQUE", 0.25f), 0, 0, true), "R", 0, 8, 0, 8) == near(1.0, 1e-4));
}

// pbrt

namespace {

/// A square lamp of radiance 1 on both sides, before a gray disk at z = -1 if `wall`.
Image pbrt_image(const std::string& alpha, bool wall) {
  const std::string disk =
      "AttributeBegin Translate 0 0 -1 Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 0.5 ] Shape \"disk\" "
      "\"float radius\" 2 AttributeEnd\n";
  return image_of(read_pbrt_world(
      (wall ? disk : "") +
          "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ] \"bool twosided\" true Material \"diffuse\" \"rgb "
          "reflectance\" [ 0 0 0 ] Texture \"board\" \"float\" \"checkerboard\" \"float uscale\" 2 \"float vscale\" 2 "
          "\"float tex1\" 1 \"float tex2\" 0 Texture \"none\" \"float\" \"constant\" \"float value\" 0\n"
          "Shape \"trianglemesh\" \"point3 P\" [ -1 -1 0  1 -1 0  1 1 0  -1 1 0 ] \"point2 uv\" [ 0 0  1 0  1 1  0 1 ] "
          "\"integer indices\" [ 0 1 2  0 2 3 ] " +
          alpha,
      "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16 \"string filename\" \"x.exr\" PixelFilter "
      "\"box\" Sampler \"independent\" \"integer pixelsamples\" 64 Integrator \"path\" \"integer maxdepth\" 3\n"
      "LookAt 0 0 5  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [ -2 2 -2 2 ]"));
}

}  // namespace

TEST_CASE("covered emission: pbrt's alpha covers area lights") {
  const Image full = pbrt_image("", false), half = pbrt_image("\"float alpha\" 0.5", false),
              board = pbrt_image("\"texture alpha\" \"board\"", false);
  CHECK(mean_of(full, "G", 5, 11, 5, 11) == near(1.0, 1e-4));
  CHECK(mean_of(half, "G", 5, 11, 5, 11) == near(0.5, 1e-4));
  CHECK(mean_of(half, "A", 5, 11, 5, 11) == within(0.5, 0.03));
  // A quarter with alpha 1 and one with alpha 0
  CHECK(mean_of(board, "G", 9, 11, 9, 11) == near(1.0, 1e-4));
  CHECK(mean_of(board, "G", 5, 7, 9, 11) == 0.0);
  CHECK(mean_of(board, "A", 5, 7, 9, 11) == 0.0);
}

TEST_CASE("covered emission: pbrt's lamps light others as far as they are covered") {
  const auto beside = [](const std::string& alpha) {
    const Image image = pbrt_image(alpha, true);
    return mean_of(image, "G", 1, 3, 5, 11) + mean_of(image, "G", 13, 15, 5, 11);
  };
  const double full = beside("");
  CHECK(full > 0.05);
  CHECK(beside("\"float alpha\" 0.5") == near(0.5 * full, 0.03));
  CHECK(beside("\"texture alpha\" \"board\"") == near(0.5 * full, 0.05));
  // An alpha of 0, as a number or as a constant texture, makes the lamp invisible
  for (const std::string alpha : {"\"float alpha\" 0", "\"texture alpha\" \"none\""}) {
    CAPTURE(alpha);
    CHECK(beside(alpha) == near(full, 0.03));
    const Image alone = pbrt_image(alpha, false), before = pbrt_image(alpha, true);
    CHECK(mean_of(alone, "G", 0, 16, 0, 16) == 0.0);
    CHECK(mean_of(alone, "A", 0, 16, 0, 16) == 0.0);
    const double wall = mean_of(before, "G", 7, 9, 7, 9);
    CHECK(wall > 0.1);
    CHECK(wall < 0.5);
  }
}

// Estimators

namespace {

/// Placement of the lamp below: [-1, 1]^2 at z = 1 facing down, mirrored in y.
Transform above() { return Transform::translate({0, 0, 1}) * Transform::rotate({1, 0, 0}, 180); }

/// A floor under a lamp of which only the half x > 0 exists: the other half is cut out by a texture, or left out.
/// `tint`: a texture of the emission as well.
Description half_lamp(bool cut_out, bool tint, int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, {0, -4, 0.8f}, {0.3f, 0, 0});
  d.integrator.max_depth = 3;
  add_rectangle(d, Transform::scale({3, 3, 1}), add_diffuse(d, 0.5f));
  const MaterialId black = add_diffuse(d, 0);
  SpectrumInput radiance = SpectrumDescription::rgb(2, 1, 0.5f);
  const auto add = [&](TextureModel model) {
    TextureDescription texture;
    texture.model = std::move(model);
    d.textures.push_back(std::move(texture));
    return static_cast<TextureId>(d.textures.size() - 1);
  };
  if (tint) radiance = add(ConstantTextureDescription{SpectrumDescription::rgb(2, 1, 0.5f)});
  if (!cut_out) {
    ShapeDescription& lamp =
        add_rectangle(d, above() * Transform::translate({0.5f, 0, 0}) * Transform::scale({0.5f, 1, 1}), black);
    lamp.radiance = radiance;
    lamp.emits_on_both_sides = true;
    return d;
  }
  CheckerboardDescription board;
  board.color0 = SpectrumDescription::constant(0);
  board.color1 = SpectrumDescription::constant(1);
  const TextureId opacity = add(board);
  d.textures.back().to_uv = {1, 0, 0, 0, 0, 0.25f};
  const MaterialId mask = add_material(d, MaskDescription{opacity, black});
  const CoveredEmission emission = covered_emission(d, radiance, mask);
  ShapeDescription& lamp = add_rectangle(d, above(), mask);
  lamp.radiance = emission.radiance;
  lamp.radiance_scale = emission.scale;
  lamp.emits_on_both_sides = true;
  return d;
}

}  // namespace

TEST_CASE("covered emission: all estimators agree with a lamp of the part that is left") {
  const double level = significance_of_each(40);
  for (const bool tint : {false, true}) {
    CAPTURE(tint);
    for (const NamedStrategy& strategy : kLightStrategies) {
      CAPTURE(strategy.name);
      Description covered = half_lamp(true, tint, 48), left = half_lamp(false, tint, 48);
      covered.integrator.strategy = strategy.strategy;
      left.sampler.seed = 77;
      const PixelMeans a = pixel_means(covered), b = pixel_means(left);
      for (std::size_t c = 0; c < 3; ++c) check_same_mean(a[c], b[c], level);
    }
  }
  // In spectral mode, the spectrum of a covered lamp remains that of the file
  Description covered = half_lamp(true, false, 48), left = half_lamp(false, false, 48);
  left.sampler.seed = 78;
  const PixelMeans a = pixel_means(covered, ColorMode::kSpectral), b = pixel_means(left, ColorMode::kSpectral);
  for (std::size_t c = 0; c < 3; ++c) check_same_mean(a[c], b[c], level);
}

TEST_CASE("covered emission: light tracing and motion and instances agree with path tracing") {
  Description d = half_lamp(true, true, 24);
  d.film.width = d.film.height = 12;
  look_at(d, {0, -4, 2.5f}, {0, 0, 0.3f}, {0, 0, 1}, 45);
  check_light_tracing_agrees(d);
  // The lamp in a moving instance lights as much as the part that is left
  const double level = significance_of_each(6);
  PixelMeans means[2];
  for (const bool cut_out : {false, true}) {
    Description moving = half_lamp(cut_out, false, 48);
    moving.sampler.seed = cut_out ? 3 : 4;
    ShapeGroup group;
    group.shapes.push_back(moving.shapes.back());
    moving.shapes.pop_back();
    moving.groups.push_back(std::move(group));
    InstanceDescription instance;
    instance.motion = add_motion(moving, {{0, Transform::translate({-0.5f, 0, 0.2f})},
                                          {1, Transform::translate({0.5f, 0, 0.6f}) * Transform::rotate({0, 1, 0}, 30) *
                                                  Transform::scale({1, 0.5f, 1})}});
    moving.instances.push_back(instance);
    expose(moving, 0, 1);
    means[cut_out] = pixel_means(moving);
  }
  for (std::size_t c = 0; c < 3; ++c) check_same_mean(means[0][c], means[1][c], level);
}

TEST_CASE("covered emission: a lamp that rays miss lights like a visible one from outside") {
  const double level = significance_of_each(6);
  Description visible = half_lamp(false, false, 48), invisible = half_lamp(false, false, 48);
  visible.integrator.max_depth = invisible.integrator.max_depth = 2;
  visible.shapes.back().emits_on_both_sides = invisible.shapes.back().emits_on_both_sides = false;
  invisible.shapes.back().is_visible = false;
  invisible.sampler.seed = 9;
  const PixelMeans a = pixel_means(visible), b = pixel_means(invisible);
  for (std::size_t c = 0; c < 3; ++c) check_same_mean(a[c], b[c], level);
  invisible.film.width = invisible.film.height = 12;
  look_at(invisible, {0, -4, 2.5f}, {0, 0, 0.3f}, {0, 0, 1}, 45);
  check_light_tracing_agrees(invisible);
}

// Mitsuba

namespace {

Image mitsuba_image(const std::string& objects, const std::string& integrator) {
  const std::string sensor =
      "<sensor type='orthographic'><transform name='to_world'><scale value='2'/><lookat origin='0,0,5' target='0,0,0' "
      "up='0,1,0'/></transform><film type='hdrfilm'><integer name='width' value='8'/><integer name='height' "
      "value='8'/><string name='pixel_format' value='rgba'/><rfilter type='box'/></film><sampler type='independent'>"
      "<integer name='sample_count' value='16'/></sampler></sensor>";
  return image_of(read_text(mitsuba_scene(objects, sensor, integrator)));
}

const std::string kPath = "<integrator type='path'/>";
const std::string kHidden = "<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>";

}  // namespace

TEST_CASE("covered emission: in Mitsuba's dialect a mask does not cover the emitter of its shape") {
  // Measured with Mitsuba 3.9.1, before a black wall: 1 for any opacity
  const std::string wall =
      "<shape type='rectangle'><transform name='to_world'><scale value='3'/><translate z='-1'/></transform><bsdf "
      "type='diffuse'><rgb name='reflectance' value='0'/></bsdf></shape>";
  for (const std::string opacity : {"0", "0.5", "1"}) {
    const Image image = mitsuba_image(
        "<shape type='rectangle'><bsdf type='mask'><float name='opacity' value='" + opacity +
            "'/><bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf></bsdf><emitter type='area'><rgb "
            "name='radiance' value='1'/></emitter></shape>" +
            wall,
        kPath);
    CAPTURE(opacity);
    CHECK(mean_of(image, "G", 3, 5, 3, 5) == near(1.0, 1e-4));
  }
}

TEST_CASE("covered emission: the opacity of MTL materials covers Ke") {
  const TemporaryFolder folder;
  write_below(folder, "lamp.mtl", "newmtl lamp\nKd 0 0 0\nKe 1 1 1\nd 0.25\n");
  write_below(folder, "lamp.obj", "mtllib lamp.mtl\nusemtl lamp\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
  Description d = read_scene(write_below(
      folder, "scene.xml", mitsuba_scene("<shape type='obj'><string name='filename' value='lamp.obj'/></shape>")));
  d.film.width = d.film.height = 8;
  d.sampler.sample_count = 256;
  look_at(d, {0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 5);
  const Image image = image_of(d);
  CHECK(mean_of(image, "G", 0, 8, 0, 8) == near(0.25, 1e-4));
  CHECK(mean_of(image, "A", 0, 8, 0, 8) == within(0.25, 0.02));
}

TEST_CASE("black environment: it is a visible background unless emitters are hidden") {
  const std::string ball = "<shape type='sphere'/>", constant = "<emitter type='constant'><rgb name='radiance' value='";
  for (const std::string radiance : {"0", "1e-9"}) {
    CAPTURE(radiance);
    const std::string objects = constant + radiance + "'/></emitter>" + ball;
    CHECK(mean_of(mitsuba_image(objects, kPath), "A", 0, 8, 0, 8) == 1.0);
    CHECK(mean_of(mitsuba_image(objects, kHidden), "A", 0, 2, 0, 2) == 0.0);
  }
  CHECK(mean_of(mitsuba_image(ball, kPath), "A", 0, 2, 0, 2) == 0.0);
  // Black image maps count as well, and neither is a light
  Description d = empty_scene(4, 4);
  add_constant_light(d, 0);
  CHECK(compile_scene(d)->view().lights.count == 0);
  CHECK(mean_of(image_of(d), "A", 0, 4, 0, 4) == 1.0);
}

}  // namespace sheaf::test_covered_emission
