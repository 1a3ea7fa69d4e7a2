// --exposure auto of renders with pixel filter and denoiser, and of finished images.
#include "core/image/image.h"
#include "tests/support/near.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>

namespace sheaf::test_cli_auto_exposure {

namespace {

/// A small bright rectangle in the dark, which covers 8 % of the image: 13.5 of 48 pixels in each direction.
std::string lamp_scene(const std::string& filter) {
  return "<scene version='3.0.0'><integrator type='path'/><sensor type='orthographic'><transform name='to_world'>"
         "<lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/></transform>"
         "<film type='hdrfilm'><integer name='width' value='48'/><integer name='height' value='48'/><rfilter type='" +
         filter +
         "'/></film></sensor><shape type='rectangle'><transform name='to_world'><scale value='0.28125'/></transform>"
         "<emitter type='area'><rgb name='radiance' value='0.02'/></emitter></shape>"
         "<shape type='rectangle'><transform name='to_world'><scale value='3'/><translate z='-1'/></transform>"
         "<bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf></shape></scene>";
}

double printed_stops(const Outcome& outcome) {
  REQUIRE(outcome.code == 0);
  const std::size_t at = outcome.err.find("exposure ");
  REQUIRE(at != std::string::npos);
  return std::strtod(outcome.err.c_str() + at + 9, nullptr);
}

}  // namespace

TEST_CASE("auto exposure: filters and denoisers around a lamp change it little") {
  const TemporaryFolder folder;
  const double expected = std::log2(0.18 / 0.02);
  // A ring of visible tails, whose width is up to two pixels, makes the small lamp less than 2 stops brighter. The
  // middle of the lamp, 0.18 in the box filter, is encoded as 0.46.
  for (const char* const filter : {"box", "tent", "gaussian", "mitchell", "lanczos"}) {
    CAPTURE(std::string(filter));
    write_bytes(folder / "lamp.xml", lamp_scene(filter));
    const std::string render = "render lamp.xml --spp 16 --exposure auto -o a.png -o a.exr";
    const double plain = printed_stops(run(folder, render));
    CHECK(plain > expected - 0.1);
    CHECK(plain < expected + 2);
    const double denoised = printed_stops(run(folder, render + " --denoise nlm"));
    CHECK(denoised == within(plain, 0.1));
    // The lamp is middle gray to light gray in the file, after the denoiser as well, and `convert` chooses the same
    const Image image = read_image(folder / "a.png");
    CHECK(image.at(24, 24, 1) == within(0.63, 0.18));
    CHECK(printed_stops(run(folder, "convert a.exr -o b.png --exposure auto")) == within(denoised, 0.011));
  }
}

TEST_CASE("images that are almost black or white come with the exposure that helps") {
  const TemporaryFolder folder;
  // A wall of one color that fills the image
  const auto wall = [](const std::string& radiance) {
    return "<scene version='3.0.0'><integrator type='path'/><sensor type='orthographic'><transform name='to_world'>"
           "<lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/></transform>"
           "<film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='16'/></film></sensor>"
           "<shape type='rectangle'><transform name='to_world'><scale value='4'/></transform>"
           "<emitter type='area'><rgb name='radiance' value='" +
           radiance + "'/></emitter></shape></scene>";
  };
  write_bytes(folder / "dark.xml", wall("0.001"));
  write_bytes(folder / "bright.xml", wall("50"));
  write_bytes(folder / "gray.xml", wall("0.5"));
  const std::string black = run(folder, "render dark.xml --spp 4 -o a.png -o dark.exr").err;
  CHECK(contains(black, "wrote a.png, dark.exr (almost black: --exposure 7.5 shows a picture)"));
  CHECK(contains(run(folder, "render bright.xml --spp 4 -o a.png").err, "(almost white: --exposure -8.1 "));
  CHECK(contains(run(folder, "convert dark.exr -o a.png").err, "(almost black: --exposure 7.5 "));
  // Not for pictures, with the proposed or an automatic exposure, and for files without one
  for (const char* const command :
       {"render gray.xml --spp 4 -o a.png", "render dark.xml --spp 4 -o a.png --exposure 7.5",
        "render dark.xml --spp 4 -o a.png --exposure auto", "render dark.xml --spp 4 -o a.exr"})
    CHECK(!contains(run(folder, command).err, "almost"));
}

}  // namespace sheaf::test_cli_auto_exposure
