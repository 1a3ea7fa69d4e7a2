// Sensors of Mitsuba beyond perspective cameras: descriptions, defaults, and errors with the nearest name.
#include "tests/support/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_sensor_reading {

using namespace test;

namespace {

using Projection = CameraDescription::Projection;

const std::string kPixel =
    "<film type='hdrfilm'><integer name='width' value='1'/><integer name='height' value='1'/></film>";

Description with_sensor(const std::string& type, const std::string& inside, const std::string& version = "3.0.0") {
  return read_text(
      mitsuba_scene("", "<sensor type='" + type + "'>" + inside + "</sensor>", "<integrator type='path'/>", version));
}
std::string sensor_error(const std::string& type, const std::string& inside) {
  return error_of_text(mitsuba_scene("", "<sensor type='" + type + "'>" + inside + "</sensor>"));
}

bool near(Vec3f a, Vec3f b) { return length(a - b) < 1e-5f; }

}  // namespace

TEST_CASE("sensors: spherical and distorted and telecentric cameras are read") {
  CHECK(with_sensor("spherical", "").camera.projection == Projection::kSpherical);
  CHECK(contains(sensor_error("spherical", "<float name='fov' value='30'/>"), "'fov'"));
  const CameraDescription distorted =
      with_sensor("perspective_rdist", "<string name='kc' value='-0.1, 0.02'/><float name='fov' value='30'/>").camera;
  CHECK(distorted.projection == Projection::kPerspective);
  CHECK(distorted.distortion == std::array{-0.1f, 0.02f});
  CHECK(distorted.fov == 30);
  CHECK(with_sensor("perspective_rdist", "").camera.distortion == std::array{0.0f, 0.0f});
  CHECK(contains(sensor_error("perspective_rdist", "<string name='kc' value='1, 2, 3'/>"),
                 "has 3 numbers, expected two"));
  CHECK(contains(sensor_error("perspective", "<string name='kc' value='1, 2'/>"), "'kc'"));
  // Lengths are in world space.
  const CameraDescription lens =
      with_sensor("telecentric",
                  "<transform name='toWorld'><scale value='4'/></transform>"
                  "<float name='apertureRadius' value='2'/><float name='focusDistance' value='20'/>",
                  "0.6.0")
          .camera;
  CHECK(lens.projection == Projection::kOrthographic);
  CHECK(lens.aperture_radius == doctest::Approx(0.5));
  CHECK(lens.focus_distance == doctest::Approx(5));
  CHECK(with_sensor("telecentric", "").camera.aperture_radius == 0);
  // Under a non-uniform scale, the lens has its radius along x and the focus its distance along z.
  const CameraDescription uneven =
      with_sensor("telecentric",
                  "<transform name='toWorld'><scale value='4, 2, 5'/><rotate y='1' angle='90'/></transform>"
                  "<float name='apertureRadius' value='2'/><float name='focusDistance' value='20'/>")
          .camera;
  CHECK(uneven.aperture_radius == doctest::Approx(2.0 / 4));
  CHECK(uneven.focus_distance == doctest::Approx(20.0 / 5));
  const CameraDescription far = with_sensor("telecentric",
                                            "<transform name='toWorld'><scale value='4, 2, 5'/></transform>"
                                            "<float name='farClip' value='50'/>")
                                    .camera;
  CHECK(far.focus_distance == doctest::Approx(50.0 / 5));
}

TEST_CASE("sensors: films of Mitsuba 0.6 may have labels and metadata and channel names") {
  const auto film = [](const std::string& inside) {
    return with_sensor("perspective", "<film type='hdrfilm'>" + inside + "</film>", "0.6.0").notes;
  };
  const auto notes_about = [&](const std::string& inside, const char* expected) {
    const std::vector<std::string> notes = film(inside);
    REQUIRE(notes.size() == 1);
    CHECK(contains(notes[0], expected));
  };
  notes_about("<string name='label[10, 10]' value='Hello'/><string name='label[0, 0]' value='x'/>",
              "film labels ignored");
  notes_about("<string name=\"metadata['key']\" value='Hello'/><float name=\"metadata['n']\" value='1'/>",
              "film metadata ignored");
  notes_about("<string name='pixelFormat' value='rgb, rgb'/><string name='channelNames' value='color, position'/>",
              "'channelNames' ignored");
  CHECK(film("<string name='pixelFormat' value='rgba'/>").empty());
  CHECK(contains(sensor_error("perspective", "<film type='hdrfilm'><string name='labels' value='x'/></film>"),
                 "unknown property 'labels'"));
}

TEST_CASE("sensors: meters are read") {
  const CameraDescription aimed = with_sensor("radiancemeter",
                                              "<point name='origin' value='1,2,3'/>"
                                              "<vector name='direction' value='0,4,3'/>" +
                                                  kPixel)
                                      .camera;
  CHECK(aimed.projection == Projection::kRadianceMeter);
  CHECK(near(aimed.to_world.point({0, 0, 0}), {1, 2, 3}));
  CHECK(near(aimed.to_world.vector({0, 0, 1}), {0, 0.8f, 0.6f}));
  CHECK(aimed.near_clip == 0);
  const Description usual = with_sensor("radiancemeter", kPixel);
  CHECK(near(usual.camera.to_world.vector({0, 0, 1}), {0, 0, 1}));
  CHECK(usual.film.filter.kind == PixelFilter::Kind::kBox);
  CHECK(contains(sensor_error("radiancemeter", "<point name='origin' value='1,2,3'/>" + kPixel), "expected both"));
  CHECK(contains(sensor_error("radiancemeter", ""), "768 x 576 pixels, expected one pixel"));

  const std::string down = "<vector name='direction' value='0,0,-2'/>";
  const CameraDescription distant = with_sensor("distant", down + kPixel).camera;
  CHECK(distant.projection == Projection::kDistant);
  CHECK(near(distant.to_world.vector({0, 0, 1}), {0, 0, -1}));
  CHECK(std::holds_alternative<std::monostate>(distant.target));
  const auto point = with_sensor("distant", down + "<point name='target' value='1,2,3'/>" + kPixel).camera.target;
  CHECK(std::get<Vec3f>(point) == Vec3f{1, 2, 3});
  const auto target = [&](const std::string& type) {
    return std::get<CameraDescription::TargetArea>(
        with_sensor("distant", down + "<shape type='" + type +
                                   "' name='target'><transform name='to_world'>"
                                   "<translate x='5'/></transform></shape>" +
                                   kPixel)
            .camera.target);
  };
  CHECK_FALSE(target("rectangle").round);
  CHECK(target("disk").round);
  CHECK(near(target("disk").to_world.point({0, 0, 0}), {5, 0, 0}));
  CHECK(contains(sensor_error("distant", down + "<shape type='sphere'/>" + kPixel), "expected 'rectangle' or 'disk'"));
  CHECK(contains(sensor_error("distant", "<vector name='direction' value='0,0,0'/>" + kPixel), "no length"));

  const std::string meter = "<sensor type='irradiancemeter'>" + kPixel + "</sensor>";
  const auto on = [&](const std::string& shape, const std::string& inside = "") {
    return "<shape type='" + shape + "'><transform name='to_world'><translate z='7'/></transform>" + inside + meter +
           "</shape>";
  };
  const CameraDescription irradiance = read_text(mitsuba_scene(on("rectangle"), "")).camera;
  CHECK(irradiance.projection == Projection::kIrradianceMeter);
  CHECK(near(irradiance.to_world.point({0, 0, 0}), {0, 0, 7}));
  CHECK(near(irradiance.to_world.vector({0, 0, 1}), {0, 0, 1}));
  const std::string flip = "<boolean name='flip_normals' value='true'/>";
  CHECK(near(read_text(mitsuba_scene(on("rectangle", flip), "")).camera.to_world.vector({0, 0, 1}), {0, 0, -1}));
  CHECK(contains(error_of_text(mitsuba_scene(on("sphere"), "")), "expected a 'rectangle'"));
  CHECK(contains(sensor_error("irradiancemeter", ""), "must be nested in a <shape>"));
  const Description both = read_text(mitsuba_scene(on("rectangle")));
  CHECK(both.camera.projection == Projection::kPerspective);
  CHECK(both.notes.size() == 1);
  CHECK(contains(error_of_text(mitsuba_scene("", "")), "no <sensor>"));
}

TEST_CASE("sensors: batches share a film and specfilm is read as a film") {
  const std::string one = "<sensor type='perspective'><float name='fov' value='20'/></sensor>",
                    other = "<sensor type='spherical'><film type='hdrfilm'/></sensor>",
                    film = "<film type='hdrfilm'><integer name='width' value='64'/></film>";
  const Description batch = with_sensor("batch", one + other + film);
  CHECK(batch.camera.fov == 20);
  REQUIRE(batch.more_cameras.size() == 1);
  CHECK(batch.more_cameras[0].projection == Projection::kSpherical);
  CHECK(batch.film.width == 64);
  CHECK(contains(sensor_error("batch", film), "has no <sensor>"));
  CHECK(contains(sensor_error("batch", "<sensor type='distant'/>"), "expected a camera that forms an image"));
  CHECK(contains(sensor_error("bach", ""), "did you mean 'batch'"));

  const Description spectra =
      with_sensor("perspective",
                  "<film type='specfilm'><integer name='width' value='32'/><spectrum name='red' value='600:0, 700:1'/>"
                  "</film>");
  CHECK(spectra.film.width == 32);
  CHECK(spectra.notes.size() == 1);
  CHECK(contains(sensor_error("perspective", "<film type='specfilm'><float name='widht' value='2'/></film>"),
                 "did you mean 'width'"));
}

}  // namespace sheaf::test_sensor_reading
