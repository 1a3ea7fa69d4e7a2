// Scenes far from the origin: their images are those of the same scenes at the origin.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_far_scenes {

using namespace test;

namespace {

std::string point(Vec3d v) { return std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z); }
std::string move(Vec3d by) { return "<translate value='" + point(by) + "'/>"; }

/// A scene of 32 x 32 pixels around `at`, seen from its +z side.
std::string scene_around(Vec3d at, const std::string& inside, const std::string& integrator,
                         const std::string& sensor = "") {
  return mitsuba_scene(
      inside,
      "<sensor type='perspective'><float name='fov' value='40'/>" + sensor +
          "<transform name='to_world'><lookat origin='" + point(at + Vec3d{0.2, 0.4, 6}) + "' target='" + point(at) +
          "' up='0, 1, 0'/></transform><film type='hdrfilm'><integer name='width' value='32'/><integer name='height' "
          "value='32'/><rfilter type='box'/></film><sampler type='independent'><integer name='sample_count' "
          "value='64'/></sampler></sensor>",
      integrator);
}

/// Means over blocks of 8 x 8 pixels of a channel.
std::vector<double> block_means(const Image& image, int channel) {
  std::vector<double> means(16, 0.0);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      means[static_cast<std::size_t>(y / 8 * 4 + x / 8)] += double{image.at(x, y, channel)} / 64;
  return means;
}

/// Renders the scene at the origin and far away, and compares means of blocks. Paths differ by rounding only.
template <class Inside>
void check_same_image(Inside inside, const std::string& integrator = "<integrator type='path'/>",
                      const std::string& sensor = "") {
  const auto image = [&](Vec3d at) {
    return render(*compile_scene(read_text(scene_around(at, inside(at), integrator, sensor))), {}).film.to_image();
  };
  const Image near_origin = image({0, 0, 0});
  double total = 0;
  for (const Vec3d at : {Vec3d{500000.125, 40, -5400000.375}, Vec3d{-1e7, 3e8, 2e6}}) {
    CAPTURE(at.x);
    const Image far = image(at);
    for (int c = 0; c < 3; ++c) {
      const std::vector<double> a = block_means(near_origin, c), b = block_means(far, c);
      for (std::size_t i = 0; i < a.size(); ++i) {
        CAPTURE(i);
        CHECK(b[i] == within(a[i], 0.02 * a[i] + 1e-4));
        total += a[i];
      }
    }
  }
  CHECK(total > 0);
}

std::string emitter(Vec3d at) {
  return "<emitter type='point'><point name='position' value='" + point(at + Vec3d{1, 2, 3}) +
         "'/><rgb name='intensity' value='20'/></emitter>";
}
std::string placed(const std::string& type, const std::string& steps, const std::string& inside = "") {
  return "<shape type='" + type + "'><transform name='to_world'>" + steps + "</transform>" + inside + "</shape>";
}
std::string wall(Vec3d at) { return placed("rectangle", "<scale value='2'/>" + move(at + Vec3d{0, 0, -1})); }

}  // namespace

TEST_CASE("far scenes: meshes, quadrics, instances and lights of all kinds") {
  check_same_image([](Vec3d at) {
    return wall(at) + placed("cube", "<scale value='0.3'/>" + move(at + Vec3d{-1, 0, 0})) +
           "<shape type='sphere'><point name='center' value='" + point(at + Vec3d{0.4, 0.5, 0}) +
           "'/><float name='radius' value='0.4'/></shape>" + "<shape type='shapegroup' id='g'>" +
           placed("cube", "<scale value='0.2'/>") +
           "</shape><shape type='instance'><ref id='g'/><transform "
           "name='to_world'>" +
           move(at + Vec3d{0.2, -0.7, 0.1}) + "</transform></shape>" +
           placed("rectangle", "<scale value='0.2'/><rotate y='1' angle='160'/>" + move(at + Vec3d{-0.4, 0.9, 1}),
                  "<emitter type='area'><rgb name='radiance' value='3, 8, 3'/></emitter>") +
           "<emitter type='spot'><float name='cutoff_angle' value='30'/><rgb name='intensity' value='30, 3, 3'/>"
           "<transform name='to_world'><lookat origin='" +
           point(at + Vec3d{2, 0, 2}) + "' target='" + point(at) + "' up='0, 1, 0'/></transform></emitter>" +
           emitter(at);
  });
}

TEST_CASE("far scenes: media") {
  check_same_image(
      [](Vec3d at) {
        return wall(at) + emitter(at) +
               placed("cube", "<scale value='0.8'/>" + move(at),
                      "<bsdf type='null'/><medium name='interior' type='homogeneous'><float name='sigma_t' "
                      "value='1'/><rgb name='albedo' value='0.9, 0.5, 0.2'/></medium>");
      },
      "<integrator type='volpath'/>");
}

TEST_CASE("far scenes: motion of shapes, instances and the camera") {
  const auto keys = [](Vec3d from, Vec3d to) {
    return "<animation name='to_world'><transform time='0'><scale value='0.4'/>" + move(from) +
           "</transform><transform time='1'><scale value='0.4'/><rotate z='1' angle='0'/>" + move(to) +
           "</transform></animation>";
  };
  check_same_image(
      [&](Vec3d at) {
        return wall(at) + emitter(at) + "<shape type='cube'>" + keys(at + Vec3d{-1, 0, 0}, at + Vec3d{1, 0.5, 0}) +
               "</shape><shape type='sphere'>" + keys(at + Vec3d{0, -1, 0}, at + Vec3d{0.5, 1, 0}) +
               "<emitter type='area'><rgb name='radiance' value='1, 2, 3'/></emitter></shape>";
      },
      "<integrator type='path'/>", "<float name='shutter_open' value='0'/><float name='shutter_close' value='1'/>");
}

TEST_CASE("far scenes: photon maps") {
  check_same_image([](Vec3d at) { return wall(at) + emitter(at) + placed("cube", "<scale value='0.5'/>" + move(at)); },
                   "<integrator type='photonmapper'/>");
}

TEST_CASE("far scenes: the layer of positions is in the coordinates of the file") {
  const Vec3d at{500000, 40, -5400000};
  RenderOptions options;
  options.aovs = {aov_named("position")};
  const Image image =
      render(*compile_scene(read_text(scene_around(at, wall(at), "<integrator type='path'/>"))), options)
          .film.to_image();
  const int x = image.find_channel("P.X");
  REQUIRE(x >= 0);
  CHECK(double{image.at(16, 16, x)} == within(at.x, 0.25));
  CHECK(double{image.at(16, 16, x + 1)} == within(at.y, 0.25));
  CHECK(double{image.at(16, 16, x + 2)} == within(at.z - 1, 0.5));
}

}  // namespace sheaf::test_far_scenes
