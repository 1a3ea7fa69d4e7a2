// Sensors, films, pixel filters and samplers of Mitsuba: parameters, defaults, and errors with the nearest name.
#include "tests/support/capture.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

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

Description with_perspective(const std::string& inside) { return with_sensor("perspective", inside); }

Description with_film(const std::string& inside) {
  return with_perspective("<film type='hdrfilm'>" + inside + "</film>");
}

bool is_close(Vec3f a, Vec3f b) { return length(a - b) < 1e-5f; }

}  // namespace

TEST_CASE("Mitsuba: perspective sensors have the documented parameters") {
  using Axis = CameraDescription::FovAxis;
  const Description d = with_perspective(
      "<float name='fov' value='40'/><string name='fovAxis' value='smaller'/><float name='nearClip' value='1'/>"
      "<float name='far_clip' value='5'/><float name='principal_point_offset_x' value='0.1'/>"
      "<transform name='toWorld'><lookat origin='1,2,3' target='1,2,4' up='0,1,0'/></transform>");
  CHECK(d.camera.fov == 40);
  CHECK(d.camera.fov_axis == Axis::kSmaller);
  CHECK(d.camera.to_world.point({0, 0, 1}) == Vec3f{1, 2, 4});
  CHECK(d.camera.near_clip == 1);
  CHECK(d.camera.far_clip == 5);
  CHECK(d.camera.principal_point_x == 0.1f);
  CHECK(d.camera.principal_point_y == 0);
  for (const auto& [name, axis] :
       {std::pair{"x", Axis::kX}, {"y", Axis::kY}, {"diagonal", Axis::kDiagonal}, {"larger", Axis::kLarger}}) {
    const Description e =
        with_perspective(std::string("<float name='fov' value='40'/><string name='fov_axis' value='") + name + "'/>");
    CHECK(e.camera.fov_axis == axis);
  }
  for (const char* length : {"<string name='focal_length' value='85mm'/>", "<string name='focalLength' value='85'/>",
                             "<float name='focal_length' value='85'/>"}) {
    const Description e = with_perspective(length);
    CHECK(e.camera.fov == near(2 * std::atan(std::hypot(36.0, 24.0) / 170) * 180 / std::numbers::pi));
    CHECK(e.camera.fov_axis == Axis::kDiagonal);
  }
  const Description two = read_text(mitsuba_scene("<sensor type='perspective'/>",
                                                  "<sensor type='perspective'><film "
                                                  "type='hdrfilm'><integer name='width' value='8'/></film></sensor>"));
  CHECK(two.film.width == 8);
  REQUIRE(two.notes.size() == 1);
  CHECK(contains(two.notes[0], "scene.xml:4: "));
}

TEST_CASE("Mitsuba: thin-lens and orthographic sensors are read") {
  const auto sensor = [](const std::string& type, const std::string& inside) {
    return read_text(mitsuba_scene("", "<sensor type='" + type + "'>" + inside + "</sensor>"));
  };
  const Description lens = sensor("thinlens",
                                  "<float name='aperture_radius' value='0.5'/><float name='fov' value='40'/>"
                                  "<float name='focus_distance' value='7'/>");
  CHECK(lens.camera.projection == CameraDescription::Projection::kPerspective);
  CHECK(lens.camera.fov == 40);
  CHECK(lens.camera.aperture_radius == 0.5f);
  CHECK(lens.camera.focus_distance == 7);
  CHECK(sensor("thinlens", "<float name='aperture_radius' value='0'/>").camera.focus_distance == 10'000);
  const Description parallel = sensor("orthographic", "<float name='near_clip' value='1'/>");
  CHECK(parallel.camera.projection == CameraDescription::Projection::kOrthographic);
  CHECK(parallel.camera.near_clip == 1);
  CHECK(parallel.camera.far_clip == 10'000);
}

TEST_CASE("Mitsuba: films and filters have the documented parameters") {
  const Description d = with_film(
      "<integer name='width' value='100'/><integer name='height' value='50'/><integer name='crop_offset_x' value='10'/>"
      "<integer name='cropOffsetY' value='5'/><integer name='crop_width' value='20'/><integer name='crop_height' "
      "value='45'/><string name='pixel_format' value='rgb'/><string name='componentFormat' value='float32'/><boolean "
      "name='banner' value='false'/><boolean name='sample_border' value='true'/><string name='file_format' "
      "value='openexr'/><boolean name='highQualityEdges' value='true'/>");
  REQUIRE(d.film.crop.has_value());
  CHECK(d.film.crop->x0 == 10);
  CHECK(d.film.crop->y0 == 5);
  CHECK(d.film.crop->width() == 20);
  CHECK(d.film.crop->height() == 45);
  CHECK(d.notes.empty());
  // Each property of the crop window alone. Missing ones extend to the rest of the film.
  const auto check_crop = [](const char* name, PixelRect expected) {
    CAPTURE(std::string(name));
    const Description cropped =
        with_film("<integer name='width' value='100'/><integer name='height' value='50'/><integer name='" +
                  std::string(name) + "' value='10'/>");
    REQUIRE(cropped.film.crop.has_value());
    const PixelRect& crop = *cropped.film.crop;
    CHECK(crop.x0 == expected.x0);
    CHECK(crop.y0 == expected.y0);
    CHECK(crop.x1 == expected.x1);
    CHECK(crop.y1 == expected.y1);
  };
  check_crop("crop_offset_x", {10, 0, 100, 50});
  check_crop("crop_offset_y", {0, 10, 100, 50});
  check_crop("crop_width", {0, 0, 10, 50});
  check_crop("crop_height", {0, 0, 100, 10});
  CHECK_FALSE(with_film("").film.crop.has_value());
  using Kind = PixelFilter::Kind;
  struct Case {
    const char* text;
    Kind kind;
    float radius;
  };
  const Case cases[] = {
      {"<rfilter type='box'/>", Kind::kBox, 0.5f},
      {"<rfilter type='tent'/>", Kind::kTent, 1},
      {"<rfilter type='tent'><float name='radius' value='2'/></rfilter>", Kind::kTent, 2},
      {"<rfilter type='gaussian'/>", Kind::kGaussian, 2},
      {"<rfilter type='gaussian'><float name='stddev' value='1'/></rfilter>", Kind::kGaussian, 4},
      {"<rfilter type='mitchell'><float name='B' value='0.5'/></rfilter>", Kind::kMitchell, 2},
      {"<rfilter type='catmullrom'/>", Kind::kCatmullRom, 2},
      {"<rfilter type='lanczos'/>", Kind::kLanczos, 3},
      {"<rfilter type='lanczos'><integer name='lobes' value='2'/></rfilter>", Kind::kLanczos, 2},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.text));
    const PixelFilter filter = with_film(c.text).film.filter;
    CHECK(filter.kind == c.kind);
    CHECK(filter.radius == c.radius);
  }
  for (const char* film : {"ldrfilm", "mfilm", "tiledhdrfilm"})
    CHECK(with_perspective(std::string("<film type='") + film + "'><float name='gamma' value='2.2'/></film>")
              .film.width == 768);
}

TEST_CASE("Mitsuba: samplers are mapped to those of Sheaf") {
  const std::string properties = "<integer name='sampleCount' value='16'/><integer name='seed' value='7'/></sampler>";
  for (const auto& [name, kind] : {std::pair{"independent", SamplerKind::kIndependent},
                                   {"stratified", SamplerKind::kStratified},
                                   {"multijitter", SamplerKind::kMultijitter},
                                   {"sobol", SamplerKind::kSobol},
                                   {"zsobol", SamplerKind::kZSobol}}) {
    const Description d = with_perspective(std::string("<sampler type='") + name + "'>" + properties);
    CHECK(d.sampler.kind == kind);
    CHECK(d.sampler.sample_count == 16);
    CHECK(d.sampler.seed == 7);
    CHECK(d.notes.empty());
  }
  for (const char* name : {"ldsampler", "orthogonal", "halton", "hammersley"}) {
    const Description d = with_perspective(std::string("<sampler type='") + name +
                                           "'><integer name='dimension' value='8'/>" + properties);
    CHECK(d.sampler.kind == SamplerKind::kSobol);
    CHECK(d.sampler.sample_count == 16);
    REQUIRE(d.notes.size() == 1);
    CHECK(contains(d.notes[0], std::string("sampler '") + name + "' is rendered with 'sobol'"));
  }
}

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
  CHECK(lens.aperture_radius == near(0.5));
  CHECK(lens.focus_distance == near(5));
  CHECK(with_sensor("telecentric", "").camera.aperture_radius == 0);
  // Under a non-uniform scale, the lens has its radius along x and the focus its distance along z.
  const CameraDescription uneven =
      with_sensor("telecentric",
                  "<transform name='toWorld'><scale value='4, 2, 5'/><rotate y='1' angle='90'/></transform>"
                  "<float name='apertureRadius' value='2'/><float name='focusDistance' value='20'/>")
          .camera;
  CHECK(uneven.aperture_radius == near(2.0 / 4));
  CHECK(uneven.focus_distance == near(20.0 / 5));
  const CameraDescription far = with_sensor("telecentric",
                                            "<transform name='toWorld'><scale value='4, 2, 5'/></transform>"
                                            "<float name='farClip' value='50'/>")
                                    .camera;
  CHECK(far.focus_distance == near(50.0 / 5));
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
  CHECK(is_close(aimed.to_world.point({0, 0, 0}), {1, 2, 3}));
  CHECK(is_close(aimed.to_world.vector({0, 0, 1}), {0, 0.8f, 0.6f}));
  CHECK(aimed.near_clip == 0);
  const Description usual = with_sensor("radiancemeter", kPixel);
  CHECK(is_close(usual.camera.to_world.vector({0, 0, 1}), {0, 0, 1}));
  CHECK(usual.film.filter.kind == PixelFilter::Kind::kBox);
  CHECK(contains(sensor_error("radiancemeter", "<point name='origin' value='1,2,3'/>" + kPixel), "expected both"));
  CHECK(contains(sensor_error("radiancemeter", ""), "768 x 576 pixels, expected one pixel"));

  const std::string down = "<vector name='direction' value='0,0,-2'/>";
  const CameraDescription distant = with_sensor("distant", down + kPixel).camera;
  CHECK(distant.projection == Projection::kDistant);
  CHECK(is_close(distant.to_world.vector({0, 0, 1}), {0, 0, -1}));
  CHECK(std::holds_alternative<std::monostate>(distant.target));
  const auto point = with_sensor("distant", down + "<point name='target' value='1,2,3'/>" + kPixel).camera.target;
  CHECK(std::get<Vec3d>(point) == Vec3d{1, 2, 3});
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
  CHECK(is_close(target("disk").to_world.point({0, 0, 0}), {5, 0, 0}));
  CHECK(contains(sensor_error("distant", down + "<shape type='sphere'/>" + kPixel), "expected 'rectangle' or 'disk'"));
  CHECK(contains(sensor_error("distant", "<vector name='direction' value='0,0,0'/>" + kPixel), "no length"));

  const std::string meter = "<sensor type='irradiancemeter'>" + kPixel + "</sensor>";
  const auto on = [&](const std::string& shape, const std::string& inside = "") {
    return "<shape type='" + shape + "'><transform name='to_world'><translate z='7'/></transform>" + inside + meter +
           "</shape>";
  };
  const CameraDescription irradiance = read_text(mitsuba_scene(on("rectangle"), "")).camera;
  CHECK(irradiance.projection == Projection::kIrradianceMeter);
  CHECK(is_close(irradiance.to_world.point({0, 0, 0}), {0, 0, 7}));
  CHECK(is_close(irradiance.to_world.vector({0, 0, 1}), {0, 0, 1}));
  const std::string flip = "<boolean name='flip_normals' value='true'/>";
  CHECK(is_close(read_text(mitsuba_scene(on("rectangle", flip), "")).camera.to_world.vector({0, 0, 1}), {0, 0, -1}));
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
