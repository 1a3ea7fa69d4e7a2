// Lights of pbrt: parameters, power on shapes of all kinds, both sides, images, and colors of other spaces.
#include "core/color/color.h"
#include "core/image/image.h"
#include "scene/compile/compile.h"
#include "scene/lights/light_powers.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_pbrt_lights {

using namespace test;

namespace {

/// Writes PPM files of 2 x 2 (red, green; blue, white), 4 x 2 gray and 16 x 16 white pixels.
void add_images(const TemporaryFolder& folder) {
  write_pnm(folder / "colours.ppm", 2, 2, 3, 255, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255});
  write_pnm(folder / "grey.ppm", 4, 2, 3, 255, std::vector<int>(24, 188));
  write_pnm(folder / "white.ppm", 16, 16, 3, 255, std::vector<int>(768, 255));
}

Description read(const std::string& world) { return read_pbrt_world(world, "", add_images); }

/// Luminance of the total power of all lights.
double power_of(const std::string& world) {
  const TemporaryFolder folder;
  add_images(folder);
  const auto scene = compile_scene(read_scene(write_below(folder, "scene.pbrt", "WorldBegin\n" + world)), {});
  double sum = 0;
  for (std::uint32_t i = 0; i < scene->view().lights.count; ++i)
    sum += double{luminance(light_power(scene->view(), i))};
  return sum;
}

const std::string kSquare = " \"point3 P\" [ 0 0 0  2 0 0  2 3 0  0 3 0 ] \"integer indices\" [ 0 1 2  0 2 3 ]";

}  // namespace

TEST_CASE("pbrt: a light of L 1 has radiance 1 and spectra luminance 1 and the exposure of the film counts") {
  const auto light = [](const std::string& parameters, const std::string& options = "") {
    const Description d = read_pbrt_world(
        "LightSource \"infinite\" " + parameters, options,
        [](const TemporaryFolder& folder) { write_below(folder, "light.spd", "# a flat light\n300 2\n900 2\n"); });
    return std::get<ConstantLightDescription>(d.lights.at(0).model).radiance;
  };
  CHECK(rgb_of(light("")).x == 1);
  CHECK(rgb_of(light("\"rgb L\" [ 1 2 3 ] \"float scale\" 2")).y == 4);
  CHECK(rgb_of(light("\"rgb L\" [ 1 2 3 ] \"float illuminance\" 3.14159265")).z == near(3));
  CHECK(rgb_of(light("\"spectrum L\" \"stdillum-D65\"")).x == 1);
  CHECK(rgb_of(light("", "Film \"rgb\" \"float iso\" 50")).x == 0.5f);
  CHECK(rgb_of(light("", "Camera \"perspective\" \"float shutteropen\" 1 \"float shutterclose\" 4")).x == 3);
  const auto flat = std::get<SpectrumDescription::Table>(light("\"spectrum L\" [ 400 7 600 7 ]").value);
  for (const float value : flat.values) CHECK(value == near(1));
  CHECK(std::get<SpectrumDescription::Table>(light("\"spectrum L\" \"light.spd\"").value).values[0] == near(1));
  const auto body = std::get<SpectrumDescription::Blackbody>(light("\"blackbody L\" 4000").value);
  const Vec3f rgb = blackbody_to_rgb(body.temperature, body.scale);
  CHECK(luminance(rgb) == near(1, 0.002));
  CHECK(rgb.x > rgb.z);
}

TEST_CASE("pbrt: lights have the documented parameters") {
  const Description d = read_pbrt_world(R"(Translate 0 0 1
LightSource "point" "point3 from" [ 1 0 0 ] "float power" 12.566370614
LightSource "spot" "point3 to" [ 0 -1 0 ] "float coneangle" 40 "float conedeltaangle" 10 "rgb I" [ 1 1 2 ]
LightSource "distant" "point3 from" [ 0 5 0 ] "point3 to" [ 0 0 0 ] "float illuminance" 3
LightSource "infinite" "string filename" "sky.exr" "float scale" 2)");
  const auto& point = std::get<PointLightDescription>(d.lights.at(0).model);
  CHECK(point.position.x == 1);
  CHECK(point.position.z == 1);
  CHECK(rgb_of(point.intensity).x == near(1));
  const auto& spot = std::get<SpotLightDescription>(d.lights.at(1).model);
  CHECK(spot.falloff == SpotLightDescription::Falloff::kSmooth);
  CHECK(spot.cutoff_angle == 40);
  CHECK(spot.beam_width == 30);
  CHECK(spot.to_world.vector({0, 0, 1}).y == near(-1));
  const auto& distant = std::get<DirectionalLightDescription>(d.lights.at(2).model);
  CHECK(distant.direction.y < 0);
  CHECK(rgb_of(distant.irradiance).x == 3);
  const auto& sky = std::get<EnvmapDescription>(d.lights.at(3).model);
  CHECK(sky.layout == EnvmapDescription::Layout::kOctahedral);
  CHECK(sky.scale == 2);
  const Description areas = read_pbrt_world(R"(AreaLightSource "diffuse" "float power" 39.4784176
Shape "sphere" "float radius" 2
AreaLightSource "diffuse" "string filename" "image.png" "float scale" 3
Shape "disk")");
  CHECK(rgb_of(std::get<SpectrumDescription>(*areas.shapes[0].radiance)).x == near(0.25));
  const auto texture = std::get<TextureId>(*areas.shapes[1].radiance);
  CHECK(std::get<BitmapDescription>(areas.textures[static_cast<std::size_t>(texture)].model).change.scale == 3);
}

TEST_CASE("pbrt lights: the power of an area light is the given one for each triangle and patch") {
  const std::string patch = "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  2 0 0  0 3 0  2 3 0.5 ]";
  for (const std::string sides : {"", " \"bool twosided\" true"}) {
    CAPTURE(sides);
    const std::string light = "AreaLightSource \"diffuse\" \"float power\" 60 \"rgb L\" [ 3 3 3 ]" + sides + "\n";
    CHECK(power_of(light + "Shape \"sphere\" \"float radius\" 2") == near(60 * 3, 1e-4));
    CHECK(power_of(light + "Shape \"disk\" \"float innerradius\" 0.5") == near(60 * 3, 2e-3));
    CHECK(power_of(light + "Scale 1 2 3 Shape \"trianglemesh\"" + kSquare) == near(2 * 60 * 3, 1e-4));
    CHECK(power_of(light + patch) == near(60 * 3, 1e-4));
    CHECK(power_of("AreaLightSource \"diffuse\" \"rgb L\" [ 3 3 3 ]" + sides + " Shape \"trianglemesh\"" + kSquare) ==
          near(3 * 6 * 3.14159265 * (sides.empty() ? 1 : 2), 1e-4));
  }
  const std::string image = "AreaLightSource \"diffuse\" \"float power\" 60 \"string filename\" \"colours.ppm\"\n";
  const std::string uv = " \"point2 uv\" [ 0 0  1 0  1 1  0 1 ]";
  CHECK(power_of(image + "Shape \"trianglemesh\"" + kSquare + uv) == near(2 * 60, 5e-3));
  CHECK(power_of(image + "Shape \"disk\"") == near(60, 0.1));
}

TEST_CASE("pbrt lights: the power of a spot light includes its falloff") {
  for (const std::string cone : {"\"float coneangle\" 60 \"float conedeltaangle\" 40", "",
                                 "\"float coneangle\" 90 \"float conedeltaangle\" 90"}) {
    CAPTURE(cone);
    const TemporaryFolder folder;
    const auto scene = compile_scene(
        read_scene(write_below(folder, "scene.pbrt", "WorldBegin\nLightSource \"spot\" \"float power\" 50 " + cone)),
        {});
    // Integral of the intensity over directions: 2 pi times the integral over the cosine.
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const float z = (static_cast<float>(i) + 0.5f) / kSteps;
      const auto s = sample_any_light<Scalar>(scene->view(), {std::sqrt(1 - z * z), 0, z}, {0.5f, 0.5f, 0.5f, 0.5f});
      if (s.valid) sum += double{s.radiance.c1};
    }
    CHECK(2 * 3.14159265 * sum / kSteps == near(50, 1e-3));
  }
}

TEST_CASE("pbrt lights: a projection is uniform over directions and keeps its power") {
  const Description d = read(
      "LightSource \"projection\" \"string filename\" \"grey.ppm\" \"float fov\" 60 "
      "\"float scale\" 2");
  const auto& projector = std::get<ProjectorDescription>(d.lights.at(0).model);
  CHECK(projector.constant_intensity);
  CHECK(projector.fov_axis == CameraDescription::FovAxis::kSmaller);
  CHECK(projector.scale == 2);
  CHECK(projector.to_world.vector({1, 0, 0}).x == -1);
  CHECK(power_of("LightSource \"projection\" \"string filename\" \"white.ppm\" \"float power\" 25") == near(25, 5e-3));
  CHECK(contains(error_of_pbrt_world("LightSource \"projection\""), "scene.pbrt:3: LightSource 'projection' needs"));
}

TEST_CASE("pbrt lights: a goniometric light is a point light times the luminance of its image") {
  const Description d = read("LightSource \"goniometric\" \"string filename\" \"colours.ppm\" \"rgb I\" [ 1 2 3 ]");
  const auto& light = std::get<GoniometricLightDescription>(d.lights.at(0).model);
  const auto& bitmap = std::get<BitmapDescription>(d.textures.at(static_cast<std::size_t>(light.image)).model);
  REQUIRE(bitmap.made);
  CHECK(bitmap.made->data[0] == near(1.0 / 3));
  CHECK(bitmap.made->data[3] == 1);
  CHECK(light.to_world.vector({0, 1, 0}).z == 1);
  CHECK(power_of("LightSource \"goniometric\" \"string filename\" \"colours.ppm\" \"float power\" 25") ==
        near(25, 5e-3));
  CHECK(power_of("LightSource \"goniometric\" \"rgb I\" [ 1 1 1 ]") == near(4 * 3.14159265, 1e-4));
  CHECK_THROWS_AS(read("LightSource \"goniometric\" \"string filename\" \"grey.ppm\""), SceneError);
}

TEST_CASE("pbrt lights: the illuminance of an image is the irradiance on a plane towards +z") {
  const Description d = read("LightSource \"infinite\" \"string filename\" \"white.ppm\" \"float illuminance\" 5");
  // Texels count by their centers, so that half of those on the horizon are lost: 1.6 % of the cosine
  CHECK(std::get<EnvmapDescription>(d.lights.at(0).model).scale == near(5 / 3.14159265, 0.02));
}

TEST_CASE("pbrt colors: other color spaces keep white and colors outside Rec.709 are clamped") {
  const auto reflectance = [](const std::string& space, const std::string& rgb, std::size_t* notes = nullptr) {
    const Description d = read_pbrt_world("ColorSpace \"" + space + "\" Material \"diffuse\" \"rgb reflectance\" [ " +
                                          rgb + " ]\nShape \"sphere\"");
    for (const MaterialDescription& material : d.materials)
      if (const auto* diffuse = std::get_if<DiffuseDescription>(&material.model)) {
        if (notes != nullptr) *notes = d.notes.size();
        return std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(diffuse->reflectance).value).value;
      }
    return Vec3f{-1, -1, -1};
  };
  for (const std::string space : {"srgb", "dci-p3", "rec2020", "aces2065-1"}) {
    CAPTURE(space);
    std::size_t notes = 1;
    const Vec3f white = reflectance(space, "1 1 1", &notes);
    CHECK(length(white - Vec3f{1, 1, 1}) < 1e-5f);
    CHECK(notes == 0);
  }
  // ITU-R BT.2087: the matrix from BT.2020 has the rows (1.6605, -0.5876, -0.0728), (-0.1246, 1.1329, -0.0083) and
  // (-0.0182, -0.1006, 1.1187).
  const Vec3f mild = reflectance("rec2020", "0.5 0.4 0.3");
  CHECK(mild.x == near(0.5 * 1.6605 - 0.4 * 0.5876 - 0.3 * 0.0728, 1e-3));
  CHECK(mild.y == near(-0.5 * 0.1246 + 0.4 * 1.1329 - 0.3 * 0.0083, 1e-3));
  CHECK(mild.z == near(-0.5 * 0.0182 - 0.4 * 0.1006 + 0.3 * 1.1187, 1e-3));
  std::size_t notes = 0;
  const Vec3f red = reflectance("rec2020", "1 0 0", &notes);
  CHECK(red.x == 1);
  CHECK(red.y == 0);
  CHECK(notes == 1);
  CHECK(contains(error_of_pbrt_world("ColorSpace \"rec709\""), "scene.pbrt:3: unknown color space 'rec709'"));
  const Description inside = read_pbrt_world(
      "AttributeBegin ColorSpace \"rec2020\" AttributeEnd LightSource \"point\" \"rgb I\" [ 0.1 1 0.1 ]");
  const auto& intensity = std::get<PointLightDescription>(inside.lights.at(0).model).intensity;
  CHECK(std::get<SpectrumDescription::Rgb>(intensity.value).value.x == 0.1f);
}

}  // namespace sheaf::test_pbrt_lights
