// Heterogeneous media of Mitsuba end at the axis-aligned box around their extinction volume.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace sheaf::test_medium_bounds {

using namespace test;

namespace {

/// Pixels along each side. The frame shows [-4, 4]^2 along z, the medium's shape is the cube [-3, 3]^3.
constexpr int kSize = 16;

/// Radiance behind the cube [-3, 3]^3, which is filled with a purely absorbing medium.
Image passed_light(const TemporaryFolder& folder, const std::string& sigma_t, ColorMode color = ColorMode::kRgb) {
  const std::string text = mitsuba_scene(
      "<emitter type='constant'><float name='radiance' value='1'/></emitter>"
      "<shape type='cube'><transform name='to_world'><scale value='3'/></transform><bsdf type='null'/>"
      "<medium name='interior' type='heterogeneous'><float name='albedo' value='0'/>" +
          sigma_t + "</medium></shape>",
      "<sensor type='orthographic'><transform name='to_world'><scale value='4, 4, 1'/>"
      "<lookat origin='0, 0, -10' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>"
      "<integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film>"
      "<sampler type='sobol'><integer name='sample_count' value='256'/></sampler></sensor>",
      "<integrator type='volpathmis'/>");
  CompileOptions options;
  options.color = color;
  return render(*compile_scene(read_scene(write_below(folder, "scene.xml", text)), options), {}).film.to_image();
}

/// Position of the center of a pixel, with x to the left and y upwards.
float position_of(int pixel) { return 4 - 8 * (static_cast<float>(pixel) + 0.5f) / kSize; }

/// Checks that pixels with inside(x, y) have transmittance `passed`, up to noise, and all others 1. Pixels with skip(x,
/// y) are ignored.
template <class Inside, class Skip>
void check_passed(const Image& image, double passed, Inside&& inside, Skip&& skip, int channel = 1) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const float value = image.at(x, y, channel);
      if (skip(position_of(x), position_of(y))) continue;
      if (!inside(position_of(x), position_of(y))) {
        CHECK(value == near(1));
        continue;
      }
      CHECK(std::fabs(static_cast<double>(value) - passed) < 0.1);
      sum += static_cast<double>(value);
      ++count;
    }
  REQUIRE(count > 0);
  CHECK(std::fabs(sum / count - passed) < 0.02);
}

std::string placed(const std::string& steps) { return "<transform name='to_world'>" + steps + "</transform>"; }
std::string constant(const std::string& value, const std::string& position = "") {
  return "<volume name='sigma_t' type='constvolume'>" + value + position + "</volume>";
}
std::string grid(const std::string& file, const std::string& position, const std::string& wrap) {
  return "<volume name='sigma_t' type='gridvolume'><string name='filename' value='" + file + "'/>" + position +
         "<string name='wrap_mode' value='" + wrap + "'/></volume>";
}
const std::string kHalf = "<float name='value' value='0.5'/>";
/// A square of side 4, rotated by 45 degrees. Its box has side 4 sqrt(2), of which the cube shows a part.
const std::string kRotated =
    placed("<translate value='-0.5, -0.5, -0.5'/><scale value='3, 3, 2'/><rotate z='1' angle='45'/>");

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("medium bounds: transformed constant volumes fill their unit cube inside the shape") {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& sigma_t, Vec3f low, Vec3f high) {
    CAPTURE(sigma_t);
    check_passed(
        passed_light(folder, sigma_t), std::exp(-0.5 * static_cast<double>(high.z - low.z)),
        [&](float x, float y) {
          return x > low.x && x < high.x && y > low.y && y < high.y && std::fabs(x) < 3 && std::fabs(y) < 3;
        },
        [](float, float) { return false; });
  };
  check("<float name='sigma_t' value='0.5'/>", {0, 0, 0}, {1, 1, 1});
  check(constant(kHalf), {0, 0, 0}, {1, 1, 1});
  check(constant(kHalf, placed("<scale value='3, 2, 0.5'/><translate value='-2, 0.5, 1'/>")), {-2, 0.5f, 1},
        {1, 2.5f, 1.5f});
  // The volume ends at the shape.
  check(constant(kHalf, placed("<scale value='4, 4, 2'/><translate value='1, -6, 0'/>")), {1, -6, 0}, {5, -2, 2});
}

TEST_CASE("medium bounds: rotated volumes extend to their axis-aligned box") {
  const TemporaryFolder folder;
  write_vol(folder / "ones.vol", 2, 1, [](Vec3f, int) { return 0.5f; });
  write_vol(folder / "halves.vol", 64, 1, [](Vec3f p, int) { return p.x < 0.5f ? 0.25f : 1.0f; });
  const float half = 1.5f * std::numbers::sqrt2_v<float>;  // half the side of the box
  for (const std::string& sigma_t : {constant(kHalf, kRotated), grid("ones.vol", kRotated, "clamp"),
                                     grid("ones.vol", kRotated, "repeat"), grid("ones.vol", kRotated, "mirror")}) {
    CAPTURE(sigma_t);
    check_passed(
        passed_light(folder, sigma_t), std::exp(-1.0),
        [&](float x, float y) { return std::fabs(x) < half && std::fabs(y) < half; },
        [&](float x, float y) {
          return std::fabs(std::fabs(x) - half) < 0.3f || std::fabs(std::fabs(y) - half) < 0.3f;
        });
  }
  // Beyond the faces of the grid, the wrap mode applies. The corner of the box at (2.12, 2.12) is half a side beyond
  // the dense face along the x axis of the grid.
  const auto check_beyond = [&](const char* wrap, double sigma) {
    CAPTURE(wrap);
    const auto corner = [](float x, float y) { return x > 1.5f && x < 2 && y > 1.5f && y < 2; };
    check_passed(passed_light(folder, grid("halves.vol", kRotated, wrap)), std::exp(-2 * sigma), corner,
                 [&](float x, float y) { return !corner(x, y); });
  };
  check_beyond("clamp", 1);
  check_beyond("repeat", 0.25);
  check_beyond("mirror", 1);
}

TEST_CASE("medium bounds: a bounded constant absorbs by its spectrum in both color modes") {
  const TemporaryFolder folder;
  const std::string sigma_t =
      constant("<spectrum name='value' value='300:0.5, 900:0.5'/>", placed("<scale value='2'/>"));
  const auto inside = [](float x, float y) { return x > 0 && x < 2 && y > 0 && y < 2; };
  const auto outside = [&](float x, float y) { return !inside(x, y); };
  check_passed(passed_light(folder, sigma_t), std::exp(-1.0), inside, outside);
  check_passed(passed_light(folder, sigma_t, ColorMode::kSpectral), std::exp(-1.0), inside, outside);
  const Image colored =
      passed_light(folder, constant("<rgb name='value' value='0.2, 0.5, 1'/>", placed("<scale value='2'/>")));
  const double sigma[] = {0.2, 0.5, 1};
  for (int c = 0; c < 3; ++c) check_passed(colored, std::exp(-2 * sigma[c]), inside, outside, c);
}

TEST_SUITE_END();

}  // namespace sheaf::test_medium_bounds
