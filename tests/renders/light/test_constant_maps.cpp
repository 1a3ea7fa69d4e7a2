// Constants in place of textures render like images of one color.
#include "core/image/exr.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_constant_maps {

using namespace test;

namespace {

/// Renders a square with the material under a light from the side. The folder holds map.exr, an image of one color.
Image render_image(const std::string& material, const std::string& lights, ColorMode color = ColorMode::kRgb) {
  const TemporaryFolder folder;
  Image map(2, 2, {"B", "G", "R"});
  for (std::size_t i = 0; i < map.pixel_count(); ++i)
    map.data[3 * i] = 0.9f, map.data[3 * i + 1] = 0.5f, map.data[3 * i + 2] = 0.8f;
  write_exr(folder / "map.exr", map);
  const std::string sensor =
      "<sensor type='orthographic'><transform name='to_world'><lookat origin='0,0,3' target='0,0,0' up='0,1,0'/>"
      "</transform><film type='hdrfilm'><integer name='width' value='4'/><integer name='height' value='4'/><rfilter "
      "type='box'/></film><sampler type='independent'><integer name='sample_count' value='8'/></sampler></sensor>";
  const Description d = read_scene(write_below(
      folder, "scene.xml", mitsuba_scene("<shape type='rectangle'>" + material + "</shape>" + lights, sensor)));
  CompileOptions options;
  options.color = color;
  return render(*compile_scene(d, options), {}).film.to_image();
}

double largest_difference(const Image& a, const Image& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    largest = std::max(largest, std::fabs(double{a.data[i]} - double{b.data[i]}));
  return largest;
}

double brightest(const Image& image) {
  const int red = image.find_channel("R");
  double brightest = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) brightest = std::max(brightest, double{image.at(x, y, red)});
  return brightest;
}

const std::string kSun = "<emitter type='directional'><vector name='direction' value='-1, 0, -1'/></emitter>";
const std::string kDiffuse = "<bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf>";
const std::string kImage =
    "<texture type='bitmap' name='x'><string name='filename' value='map.exr'/><boolean name='raw' "
    "value='true'/></texture>";

std::string map_of(const std::string& plugin, const std::string& texture) {
  return "<bsdf type='" + plugin + "'>" + texture + kDiffuse + "</bsdf>";
}

}  // namespace

TEST_CASE("constant maps: constant normal maps act like images of one color") {
  const std::string constants[] = {
      "<texture type='rawconstant' name='x'><vector name='value' value='0.8, 0.5, 0.9'/></texture>",
      "<texture type='srgb' name='x'><rgb name='color' value='0.8, 0.5, 0.9'/></texture>",
      "<rgb name='normalmap' value='0.8, 0.5, 0.9'/>", "<spectrum name='normalmap' value='0.8, 0.5, 0.9'/>"};
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    const Image plain = render_image(kDiffuse, kSun, color);
    const Image image = render_image(map_of("normalmap", kImage), kSun, color);
    CHECK(largest_difference(plain, image) > 0.02);
    for (const std::string& constant : constants)
      CHECK(largest_difference(render_image(map_of("normalmap", constant), kSun, color), image) < 1e-5);
    const std::string identity =
        "<texture type='rawconstant' name='x'><vector name='value' value='0.5, 0.5, 1'/></texture>";
    CHECK(largest_difference(render_image(map_of("normalmap", identity), kSun, color), plain) < 1e-5);
  }
}

TEST_CASE("constant maps: constant bump maps change nothing") {
  const Image plain = render_image(kDiffuse, kSun);
  for (const std::string& constant :
       {std::string("<texture type='rawconstant' name='x'><float name='value' value='0.7'/></texture>"),
        std::string("<texture type='scale'><float name='scale' value='3'/><texture type='uniform'><float name='value' "
                    "value='0.3'/></texture></texture>")})
    CHECK(largest_difference(render_image(map_of("bumpmap", constant), kSun), plain) < 1e-5);
}

TEST_CASE("constant maps: spot lights and reflectances and opacities and area lights accept constant textures") {
  const auto spot = [](const std::string& texture) {
    return "<emitter type='spot'><transform name='to_world'><lookat origin='0,0,2' target='0,0,0' up='0,1,0'/>"
           "</transform><float name='cutoff_angle' value='60'/>" +
           texture + "</emitter>";
  };
  const std::string gray = "<texture type='rawconstant' name='texture'><float name='value' value='0.25'/></texture>";
  const double bright = brightest(render_image(kDiffuse, spot("")));
  CHECK(bright > 0.01);
  CHECK(brightest(render_image(kDiffuse, spot(gray))) < 0.3 * bright);
  CHECK(brightest(render_image(kDiffuse, spot(gray))) > 0.1 * bright);
  const std::string albedo =
      "<bsdf type='diffuse'><texture type='rawconstant' name='reflectance'><vector name='value' "
      "value='0.5, 0.5, 0.5'/></texture></bsdf>";
  CHECK(largest_difference(render_image(albedo, kSun), render_image(kDiffuse, kSun)) < 1e-6);
  const std::string mask =
      "<bsdf type='mask'><texture type='rawconstant' name='opacity'><float name='value' value='0'/>"
      "</texture>" +
      kDiffuse + "</bsdf>";
  CHECK(brightest(render_image(mask, kSun)) == 0.0);
}

}  // namespace sheaf::test_constant_maps
