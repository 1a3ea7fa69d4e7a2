// Lights of pbrt: their power on shapes of all kinds, both sides, images, and colours of other spaces.
#include "core/color.h"
#include "core/image.h"
#include "scene/compile/compile.h"
#include "scene/lights/light_powers.h"
#include "tests/support/light_testing.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_pbrt_lights {

using namespace test;
using doctest::Approx;

namespace {

/// Writes PPM files of 2 x 2 (red, green; blue, white), 4 x 2 grey and 16 x 16 white pixels.
void add_pictures(const TemporaryFolder& folder) {
  write_pnm(folder / "colours.ppm", 2, 2, 3, 255, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255});
  write_pnm(folder / "grey.ppm", 4, 2, 3, 255, std::vector<int>(24, 188));
  write_pnm(folder / "white.ppm", 16, 16, 3, 255, std::vector<int>(768, 255));
}

Description read(const std::string& world) { return read_pbrt_world(world, "", add_pictures); }

/// Luminance of the total power of all lights.
double power_of(const std::string& world) {
  const TemporaryFolder folder;
  add_pictures(folder);
  const auto scene = compile_scene(read_scene(write_below(folder, "scene.pbrt", "WorldBegin\n" + world)), {});
  double sum = 0;
  for (std::uint32_t i = 0; i < scene->view().lights.count; ++i)
    sum += double{luminance(light_power(scene->view(), i))};
  return sum;
}

const std::string kSquare = " \"point3 P\" [ 0 0 0  2 0 0  2 3 0  0 3 0 ] \"integer indices\" [ 0 1 2  0 2 3 ]";

}  // namespace

TEST_CASE("pbrt lights: the power of an area light is the given one for each triangle and patch") {
  const std::string patch = "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  2 0 0  0 3 0  2 3 0.5 ]";
  for (const std::string sides : {"", " \"bool twosided\" true"}) {
    CAPTURE(sides);
    const std::string light = "AreaLightSource \"diffuse\" \"float power\" 60 \"rgb L\" [ 3 3 3 ]" + sides + "\n";
    CHECK(power_of(light + "Shape \"sphere\" \"float radius\" 2") == Approx(60 * 3).epsilon(1e-4));
    CHECK(power_of(light + "Shape \"disk\" \"float innerradius\" 0.5") == Approx(60 * 3).epsilon(2e-3));
    CHECK(power_of(light + "Scale 1 2 3 Shape \"trianglemesh\"" + kSquare) == Approx(2 * 60 * 3).epsilon(1e-4));
    CHECK(power_of(light + patch) == Approx(60 * 3).epsilon(1e-4));
    CHECK(power_of("AreaLightSource \"diffuse\" \"rgb L\" [ 3 3 3 ]" + sides + " Shape \"trianglemesh\"" + kSquare) ==
          Approx(3 * 6 * 3.14159265 * (sides.empty() ? 1 : 2)).epsilon(1e-4));
  }
  const std::string picture = "AreaLightSource \"diffuse\" \"float power\" 60 \"string filename\" \"colours.ppm\"\n";
  const std::string uv = " \"point2 uv\" [ 0 0  1 0  1 1  0 1 ]";
  CHECK(power_of(picture + "Shape \"trianglemesh\"" + kSquare + uv) == Approx(2 * 60).epsilon(5e-3));
  CHECK(power_of(picture + "Shape \"disk\"") == Approx(60).epsilon(0.1));
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
    CHECK(2 * 3.14159265 * sum / kSteps == Approx(50).epsilon(1e-3));
  }
}

TEST_CASE("pbrt lights: a projection is uniform over directions and keeps its power") {
  const Description d = read(
      "LightSource \"projection\" \"string filename\" \"grey.ppm\" \"float fov\" 60 "
      "\"float scale\" 2");
  const auto& projector = std::get<ProjectorDescription>(d.lights.at(0).model);
  CHECK(projector.is_even);
  CHECK(projector.fov_axis == CameraDescription::FovAxis::kSmaller);
  CHECK(projector.scale == 2);
  CHECK(projector.to_world.vector({1, 0, 0}).x == -1);
  CHECK(power_of("LightSource \"projection\" \"string filename\" \"white.ppm\" \"float power\" 25") ==
        Approx(25).epsilon(5e-3));
  CHECK(contains(error_of_pbrt_world("LightSource \"projection\""), "scene.pbrt:3: LightSource 'projection' needs"));
}

TEST_CASE("pbrt lights: a goniometric light is a point light times the luminance of its image") {
  const Description d = read("LightSource \"goniometric\" \"string filename\" \"colours.ppm\" \"rgb I\" [ 1 2 3 ]");
  const auto& light = std::get<GoniometricLightDescription>(d.lights.at(0).model);
  const auto& bitmap = std::get<BitmapDescription>(d.textures.at(static_cast<std::size_t>(light.image)).model);
  REQUIRE(bitmap.made);
  CHECK(bitmap.made->data[0] == Approx(1.0 / 3));
  CHECK(bitmap.made->data[3] == 1);
  CHECK(light.to_world.vector({0, 1, 0}).z == 1);
  CHECK(power_of("LightSource \"goniometric\" \"string filename\" \"colours.ppm\" \"float power\" 25") ==
        Approx(25).epsilon(5e-3));
  CHECK(power_of("LightSource \"goniometric\" \"rgb I\" [ 1 1 1 ]") == Approx(4 * 3.14159265).epsilon(1e-4));
  CHECK_THROWS_AS(read("LightSource \"goniometric\" \"string filename\" \"grey.ppm\""), SceneError);
}

TEST_CASE("pbrt lights: the illuminance of an image is the irradiance on a plane towards +z") {
  const Description d = read("LightSource \"infinite\" \"string filename\" \"white.ppm\" \"float illuminance\" 5");
  CHECK(std::get<EnvmapDescription>(d.lights.at(0).model).scale == Approx(5 / 3.14159265).epsilon(0.01));
}

TEST_CASE("pbrt colours: other colour spaces keep white and colours outside Rec.709 are clamped") {
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
  CHECK(mild.x == Approx(0.5 * 1.6605 - 0.4 * 0.5876 - 0.3 * 0.0728).epsilon(1e-3));
  CHECK(mild.y == Approx(-0.5 * 0.1246 + 0.4 * 1.1329 - 0.3 * 0.0083).epsilon(1e-3));
  CHECK(mild.z == Approx(-0.5 * 0.0182 - 0.4 * 0.1006 + 0.3 * 1.1187).epsilon(1e-3));
  std::size_t notes = 0;
  const Vec3f red = reflectance("rec2020", "1 0 0", &notes);
  CHECK(red.x == 1);
  CHECK(red.y == 0);
  CHECK(notes == 1);
  CHECK(contains(error_of_pbrt_world("ColorSpace \"rec709\""), "scene.pbrt:3: unknown colour space 'rec709'"));
  const Description inside = read_pbrt_world(
      "AttributeBegin ColorSpace \"rec2020\" AttributeEnd LightSource \"point\" \"rgb I\" [ 0.1 1 0.1 ]");
  const auto& intensity = std::get<PointLightDescription>(inside.lights.at(0).model).intensity;
  CHECK(std::get<SpectrumDescription::Rgb>(intensity.value).value.x == 0.1f);
}

TEST_CASE("pbrt cameras: spherical cameras face the direction of pbrt with +y upwards") {
  const Description areas = read_pbrt_world("", "Camera \"spherical\"");
  CHECK(areas.camera.equal_area);
  CHECK(areas.camera.to_world.vector({0, 0, 1}).y == 1);
  CHECK(areas.camera.to_world.vector({1, 0, 0}).x == 1);
  const Description turns = read_pbrt_world("", "Camera \"spherical\" \"string mapping\" \"equirectangular\"");
  CHECK(!turns.camera.equal_area);
  CHECK(turns.camera.to_world.vector({0, 0, 1}).x == -1);
  CHECK(turns.camera.to_world.vector({0, 1, 0}).y == 1);
  CHECK(turns.camera.to_world.vector({1, 0, 0}).z == 1);
  const Description lens =
      read_pbrt_world("",
                      "Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" 10\n"
                      "Camera \"orthographic\" \"float lensradius\" 0.5 \"float focaldistance\" 7");
  CHECK(length(lens.camera.to_world.vector({lens.camera.aperture_radius, 0, 0})) == Approx(0.5));
  CHECK(lens.camera.focus_distance == 7);
}

}  // namespace sheaf::test_pbrt_lights
