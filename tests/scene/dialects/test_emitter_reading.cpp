// Emitters in scene files of both dialects: descriptions, defaults, and errors with the nearest name.
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_emitter_reading {

using namespace test;

namespace {

LightDescription mitsuba_light(const std::string& type, const std::string& inside = "") {
  const Description d = read_text(mitsuba_scene("<emitter type='" + type + "'>" + inside + "</emitter>"));
  REQUIRE(d.lights.size() == 1);
  return d.lights[0];
}
std::string mitsuba_error(const std::string& type, const std::string& inside = "") {
  return error_of_text(mitsuba_scene("<emitter type='" + type + "'>" + inside + "</emitter>"));
}

std::string nori_scene(const std::string& inside) {
  return "<scene>\n<camera type='perspective'/>\n<integrator type='path_mis'/>\n" + inside + "\n</scene>\n";
}
LightDescription nori_light(const std::string& type, const std::string& inside = "") {
  const Description d = read_text(nori_scene("<emitter type='" + type + "'>" + inside + "</emitter>"));
  REQUIRE(d.lights.size() == 1);
  return d.lights[0];
}
std::string nori_error(const std::string& type, const std::string& inside = "") {
  return error_of_text(nori_scene("<emitter type='" + type + "'>" + inside + "</emitter>"));
}

const std::string kImageFile = "<string name='filename' value='image.png'/>";

/// The lights of an emitter in a scene of the given version.
std::vector<LightDescription> lights_of(const std::string& type, const std::string& inside,
                                        const std::string& version) {
  return read_text(mitsuba_scene("<emitter type='" + type + "'>" + inside + "</emitter>",
                                 "<sensor type='perspective'/>", "<integrator type='path'/>", version))
      .lights;
}

/// A direction of the sun, and scales.
const std::string kAimedSun =
    "<vector name='sunDirection' value='0,3,4'/><float name='turbidity' value='5'/>"
    "<float name='skyScale' value='2'/><float name='sunScale' value='0.5'/>";

bool is_close(Vec3f a, Vec3f b) { return length(a - b) < 1e-5f; }

}  // namespace

TEST_CASE("emitters: environment maps of Mitsuba 0.6 may have gamma and cache") {
  const auto envmap = [](const std::string& inside) {
    return read_text(mitsuba_scene("<emitter type='envmap'>" + kImageFile + inside + "</emitter>"));
  };
  const auto is_raw = [&](const std::string& gamma) {
    const Description d = envmap("<float name='gamma' value='" + gamma + "'/><boolean name='cache' value='false'/>");
    return std::get<EnvmapDescription>(d.lights.at(0).model).raw;
  };
  CHECK(is_raw("1"));
  CHECK_FALSE(is_raw("-1"));
  CHECK_FALSE(is_raw("0"));
  CHECK_FALSE(is_raw("2.2"));
  CHECK(contains(envmap("<float name='gamma' value='2.2'/>").notes.at(0),
                 "emitter 'envmap' has 'gamma' 2.2, rendered as sRGB"));
  CHECK(contains(mitsuba_error("envmap", kImageFile + "<float name='gamma' value='3'/>"), "expected 1 (linear) or -1"));
}

TEST_CASE("emitters of Mitsuba: spot lights have the documented defaults and parameters") {
  const auto plain = std::get<SpotLightDescription>(mitsuba_light("spot").model);
  CHECK(plain.falloff == SpotLightDescription::Falloff::kLinear);
  CHECK(plain.cutoff_angle == 20);
  CHECK(plain.beam_width == 15);
  CHECK_FALSE(plain.texture);
  const auto full = std::get<SpotLightDescription>(
      mitsuba_light("spot",
                    "<transform name='to_world'><lookat origin='1,2,3' target='1,2,9' up='0,1,0'/></transform>"
                    "<rgb name='intensity' value='1,2,3'/><float name='cutoffAngle' value='40'/>"
                    "<float name='beam_width' value='8'/><texture name='texture' type='bitmap'>" +
                        kImageFile + "</texture><float name='sampling_weight' value='2'/>")
          .model);
  CHECK(full.to_world.point({0, 0, 0}) == Vec3f{1, 2, 3});
  CHECK(is_close(full.to_world.vector({0, 0, 1}), {0, 0, 1}));
  CHECK(dump(full.intensity) == "rgb 0x1p+0 0x1p+1 0x1.8p+1");
  CHECK(full.cutoff_angle == 40);
  CHECK(full.beam_width == 8);
  CHECK(full.texture == TextureId{0});
  const auto usual =
      std::get<SpotLightDescription>(mitsuba_light("spot", "<float name='cutoff_angle' value='60'/>").model);
  CHECK(usual.beam_width == 45);

  CHECK(contains(mitsuba_error("spot", "<float name='cutof_angle' value='60'/>"), "did you mean 'cutoff_angle'"));
  CHECK(contains(mitsuba_error("spot", "<float name='beam_width' value='60'/>"), "scene.xml:4: "));
  CHECK(contains(mitsuba_error("spot", "<float name='cutoff_angle' value='181'/>"), "'cutoff_angle'"));
  CHECK(contains(mitsuba_error("spot", "<float name='cutoff_angle' value='90'/><texture name='texture' type='bitmap'>" +
                                           kImageFile + "</texture>"),
                 "less than 90"));
  CHECK(mitsuba_error("spot", "<rgb name='texture' value='1,1,1'/>").empty());
}

TEST_CASE("emitters of Mitsuba: directional lights have the documented defaults and parameters") {
  const auto by_direction = std::get<DirectionalLightDescription>(
      mitsuba_light("directional", "<vector name='direction' x='1' y='0' z='-1'/><rgb name='irradiance' value='3'/>")
          .model);
  CHECK(by_direction.direction == Vec3f{1, 0, -1});
  CHECK(dump(by_direction.irradiance) == "rgb 0x1.8p+1 0x1.8p+1 0x1.8p+1");
  const auto by_transform = std::get<DirectionalLightDescription>(
      mitsuba_light("directional", "<transform name='to_world'><rotate x='1' angle='90'/></transform>").model);
  CHECK(is_close(by_transform.direction, {0, -1, 0}));
  CHECK(contains(mitsuba_error("directional", "<vector name='direction' x='0' y='0' z='0'/>"), "no length"));
  CHECK(contains(mitsuba_error("directional", "<vector name='direction' x='1'/><transform name='to_world'/>"),
                 "expected one"));
  CHECK(contains(mitsuba_error("directional", "<rgb name='radiance' value='3'/>"), "'irradiance'"));
  CHECK(contains(mitsuba_error("direktional"), "did you mean 'directional'"));
}

TEST_CASE("emitters of Mitsuba: projectors and environment maps have the documented parameters") {
  const auto projector = std::get<ProjectorDescription>(
      mitsuba_light("projector", "<texture name='irradiance' type='bitmap'>" + kImageFile +
                                     "</texture>"
                                     "<float name='fov' value='30'/><string name='fov_axis' value='y'/>"
                                     "<float name='scale' value='4'/>")
          .model);
  CHECK(std::get<TextureId>(projector.irradiance) == TextureId{0});
  CHECK(projector.fov == 30);
  CHECK(projector.fov_axis == CameraDescription::FovAxis::kY);
  CHECK(projector.scale == 4);
  CHECK(contains(mitsuba_error("projector", "<float name='fov' value='180'/>"), "'fov'"));
  CHECK(contains(mitsuba_error("projector", "<float name='scale' value='-1'/>"), "'scale'"));

  const auto map = std::get<EnvmapDescription>(
      mitsuba_light("envmap", kImageFile + "<float name='scale' value='2'/>"
                                           "<boolean name='mis_compensation' value='false'/>"
                                           "<transform name='to_world'><rotate y='1' angle='90'/></transform>")
          .model);
  CHECK(map.file.filename() == "image.png");
  CHECK(map.scale == 2);
  CHECK_FALSE(map.mis_compensation);
  CHECK(std::get<EnvmapDescription>(mitsuba_light("envmap", kImageFile).model).mis_compensation);
  CHECK(is_close(map.to_world.vector({0, 0, 1}), {1, 0, 0}));
  CHECK(contains(mitsuba_error("envmap"), "'filename'"));
  CHECK(contains(mitsuba_error("envmap", "<string name='filename' value='none.exr'/>"), "none.exr"));
  CHECK(contains(mitsuba_error("envmap", kImageFile + "<float name='scal' value='2'/>"), "did you mean 'scale'"));
}

TEST_CASE("emitters of Mitsuba: sun and sky have the documented defaults and parameters") {
  const auto both = lights_of("sunsky", kAimedSun + "<float name='sun_aperture' value='2'/>", "3.0.0");
  REQUIRE(both.size() == 2);
  const auto sky = std::get<SkyDescription>(both[0].model);
  const auto sun = std::get<SunDescription>(both[1].model);
  CHECK(is_close(sky.up, {0, 0, 1}));
  CHECK(is_close(sun.up, {0, 0, 1}));
  REQUIRE(sky.suns.size() == 1);
  CHECK(is_close(sky.suns[0], {0, 0.6f, 0.8f}));
  CHECK(is_close(sun.direction, {0, 0.6f, 0.8f}));
  CHECK(sky.turbidity == 5);
  CHECK(sun.turbidity == 5);
  CHECK(dump(sky.albedo) == dump(SpectrumDescription::constant(0.3f)));
  CHECK(sky.scale == 2);
  CHECK(sky.sun_scale == 0);
  CHECK(sun.scale == 0.5f);
  CHECK(sun.radius == 1);

  const auto rotated = lights_of("sky",
                                 "<transform name='toWorld'><rotate x='1' angle='90'/></transform>"
                                 "<float name='stretch' value='1.5'/><integer name='resolution' value='256'/>",
                                 "0.6.0");
  REQUIRE(rotated.size() == 1);
  const auto old = std::get<SkyDescription>(rotated[0].model);
  CHECK(is_close(old.up, {0, 0, 1}));
  CHECK(old.stretch == 1.5f);
  CHECK(old.resolution == 256);
  CHECK(dump(old.albedo) == dump(SpectrumDescription::constant(0.2f)));
}

TEST_CASE("emitters of Mitsuba: suns are placed by date and time") {
  // +x is south from version 2 on, and east before.
  const auto later = std::get<SunDescription>(lights_of("sunsky", "", "3.0.0")[1].model);
  const auto before = std::get<SunDescription>(lights_of("sun", "<float name='scale' value='3'/>", "0.6.0")[0].model);
  CHECK(length(later.direction - Vec3f{0.0517f, 0.6916f, 0.7204f}) < 2e-3f);
  CHECK(length(before.direction - Vec3f{-0.6916f, 0.7204f, 0.0517f}) < 2e-3f);
  CHECK(is_close(before.up, {0, 1, 0}));
  CHECK(before.scale == 3);
  CHECK(later.radius == SunDescription::kSunRadius);
  CHECK(std::get<SunDescription>(lights_of("sunsky", "<float name='sunRadiusScale' value='0'/>", "0.6.0")[1].model)
            .radius == 0);
}

TEST_CASE("emitters of Mitsuba: timed skies average many positions of the sun") {
  const auto timed = lights_of("timed_sunsky",
                               "<integer name='end_day' value='3'/><integer name='end_year' value='2025'/>"
                               "<float name='window_end_time' value='9'/>",
                               "3.0.0");
  REQUIRE(timed.size() == 1);
  const auto moving = std::get<SkyDescription>(timed[0].model);
  CHECK(moving.suns.size() == 8192);
  CHECK(moving.sun_scale == 1);
  for (const Vec3f& at : moving.suns) CHECK(at.y < 0);  // before sunrise
}

TEST_CASE("emitters of Mitsuba: errors of sun and sky name the property") {
  CHECK(contains(mitsuba_error("sunsky", kAimedSun + "<float name='hour' value='9'/>"),
                 "is set together with 'sun_direction'"));
  CHECK(contains(mitsuba_error("sunsky", "<float name='turbidity' value='11'/>"), "'turbidity'"));
  CHECK(contains(mitsuba_error("sunsky", "<vector name='sun_direction' value='0,0,0'/>"), "no length"));
  CHECK(contains(mitsuba_error("sunsky", "<integer name='month' value='13'/>"), "'month'"));
  CHECK(contains(mitsuba_error("timed_sunsky", "<integer name='end_year' value='2024'/>"), "before the first"));
  CHECK(contains(mitsuba_error("sunski"), "did you mean 'sunsky'"));
  CHECK(contains(mitsuba_error("sunsky", "<float name='turbidty' value='3'/>"), "did you mean 'turbidity'"));
}

TEST_CASE("emitters of Mitsuba: collimated beams and directional area lights are read") {
  const auto beam = std::get<BeamDescription>(mitsuba_light("collimated",
                                                            "<transform name='toWorld'><translate x='3'/></transform>"
                                                            "<rgb name='power' value='1,2,3'/>")
                                                  .model);
  CHECK(beam.to_world.point({0, 0, 0}) == Vec3f{3, 0, 0});
  CHECK(dump(beam.power) == "rgb 0x1p+0 0x1p+1 0x1.8p+1");
  const Description d = read_text(mitsuba_scene(
      "<shape type='disk'><emitter type='directionalarea'><rgb name='radiance' value='3'/></emitter></shape>"
      "<shape type='disk'><emitter type='area'/></shape>"));
  CHECK(d.shapes.at(0).emits_along_normal);
  CHECK(dump(std::get<SpectrumDescription>(d.shapes.at(0).radiance.value())) == "rgb 0x1.8p+1 0x1.8p+1 0x1.8p+1");
  CHECK_FALSE(d.shapes.at(1).emits_along_normal);
  CHECK(contains(mitsuba_error("directionalarea"), "must be nested in a <shape>"));
}

TEST_CASE("emitters on shapes may be textured even in shape groups") {
  const std::string area =
      "<emitter type='area'><texture name='radiance' type='bitmap'>" + kImageFile + "</texture></emitter>";
  const Description d = read_text(mitsuba_scene("<shape type='shapegroup' id='g'><shape type='sphere'>" + area +
                                                "</shape></shape><shape type='instance'><ref id='g'/></shape>"
                                                "<shape type='rectangle'>" +
                                                area + "</shape>"));
  REQUIRE(d.groups.size() == 1);
  CHECK(std::holds_alternative<TextureId>(d.groups[0].shapes.at(0).radiance.value()));
  CHECK(std::holds_alternative<TextureId>(d.shapes.at(0).radiance.value()));
  const Description nori =
      read_text(nori_scene("<mesh type='sphere'><emitter type='area'><texture name='radiance' type='image'>" +
                           kImageFile + "</texture></emitter></mesh>"));
  CHECK(std::holds_alternative<TextureId>(nori.shapes.at(0).radiance.value()));
}

TEST_CASE("emitters of Nori: spot lights have the documented defaults and parameters") {
  const auto plain = std::get<SpotLightDescription>(nori_light("spot").model);
  CHECK(plain.falloff == SpotLightDescription::Falloff::kSmooth);
  CHECK(plain.cutoff_angle == 30);
  CHECK(plain.beam_width == 25);
  const auto directed = std::get<SpotLightDescription>(
      nori_light("spot",
                 "<point name='position' value='1,2,3'/><vector name='direction' value='0,-2,0'/>"
                 "<color name='intensity' value='1,2,3'/><float name='totalWidth' value='50'/>"
                 "<float name='falloffStart' value='40'/>")
          .model);
  CHECK(directed.to_world.point({0, 0, 0}) == Vec3f{1, 2, 3});
  CHECK(is_close(directed.to_world.vector({0, 0, 1}), {0, -1, 0}));
  CHECK(directed.cutoff_angle == 50);
  CHECK(directed.beam_width == 40);
  const auto looking = std::get<SpotLightDescription>(
      nori_light("spot", "<point name='position' value='1,2,3'/><point name='lookAt' value='1,2,-1'/>").model);
  CHECK(is_close(looking.to_world.vector({0, 0, 1}), {0, 0, -1}));
  const auto placed = std::get<SpotLightDescription>(
      nori_light("spot", "<transform name='toWorld'><translate value='4,5,6'/></transform>").model);
  CHECK(placed.to_world.point({0, 0, 0}) == Vec3f{4, 5, 6});
  CHECK(contains(nori_error("spot", "<point name='position' value='1,2,3'/><point name='lookAt' value='1,2,3'/>"),
                 "no length"));
  CHECK(contains(nori_error("spot", "<vector name='direction' value='0,0,1'/><transform name='toWorld'/>"),
                 "expected one"));
  CHECK(contains(nori_error("spot", "<float name='falloffStart' value='-1'/>"), "'falloffStart'"));
  CHECK(contains(nori_error("spot", "<float name='totalWidt' value='31'/>"), "did you mean 'totalWidth'"));
}

TEST_CASE("emitters of Nori: directional lights and environment maps have the documented parameters") {
  const auto by_irradiance = std::get<DirectionalLightDescription>(
      nori_light("directional", "<vector name='direction' value='0,-1,1'/><color name='irradiance' value='1,2,3'/>")
          .model);
  CHECK(by_irradiance.direction == Vec3f{0, -1, 1});
  CHECK(dump(by_irradiance.irradiance) == "rgb 0x1p+0 0x1p+1 0x1.8p+1");
  const auto by_intensity =
      std::get<DirectionalLightDescription>(nori_light("directional", "<color name='intensity' value='1,2,3'/>").model);
  CHECK(dump(by_intensity.irradiance) == "rgb 0x1p+0 0x1p+1 0x1.8p+1");
  CHECK(contains(
      nori_error("directional", "<color name='intensity' value='1,2,3'/><color name='irradiance' value='1,2,3'/>"),
      "expected one"));
  const auto map = std::get<EnvmapDescription>(
      nori_light("envmap", kImageFile + "<transform name='toWorld'><rotate axis='0,1,0' angle='90'/></transform>")
          .model);
  CHECK(map.scale == 1);
  CHECK(map.mis_compensation);
  CHECK(is_close(map.to_world.vector({0, 0, 1}), {1, 0, 0}));
  CHECK(contains(nori_error("envmapp", kImageFile), "did you mean 'envmap'"));
}

}  // namespace sheaf::test_emitter_reading
