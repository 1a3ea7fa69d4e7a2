// The Mitsuba dialect: descriptions of each plugin, notations of all versions, errors, and agreement with the Nori
// dialect.
#include "tests/support/capture.h"
#include "tests/support/scene_files.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace sheaf::test_mitsuba {

using namespace test;

namespace {

Description with_sensor(const std::string& inside) {
  return read_text(mitsuba_scene("", "<sensor type='perspective'>" + inside + "</sensor>"));
}

Description with_film(const std::string& inside) { return with_sensor("<film type='hdrfilm'>" + inside + "</film>"); }

Description with_integrator(const std::string& text) {
  return read_text(mitsuba_scene("", "<sensor type='perspective'/>", text));
}

ShapeDescription shape_of(const std::string& text) { return read_text(mitsuba_scene(text)).shapes.at(0); }

std::string reflectance_of(const std::string& property) {
  const Description d = read_text(mitsuba_scene("<bsdf type='diffuse'>" + property + "</bsdf>"));
  return dump(std::get<DiffuseDescription>(d.materials.at(0).model).reflectance);
}

std::string radiance_of(const std::string& property) {
  return dump(*shape_of("<shape type='sphere'><emitter type='area'>" + property + "</emitter></shape>").radiance);
}

}  // namespace

TEST_CASE("Mitsuba: a minimal scene has the documented defaults") {
  const Description d = read_text(mitsuba_scene("<shape type='rectangle'/>"));
  CHECK(d.film.width == 768);
  CHECK(d.film.height == 576);
  CHECK_FALSE(d.film.crop.has_value());
  CHECK(d.film.filter.kind == PixelFilter::Kind::kGaussian);
  CHECK(d.film.filter.radius == 2);
  CHECK(d.sampler.sample_count == 4);
  CHECK(d.sampler.kind == SamplerKind::kSobol);
  CHECK(d.camera.projection == CameraDescription::Projection::kPerspective);
  CHECK(d.camera.near_clip == 0.01f);
  CHECK(d.camera.far_clip == 10'000);
  CHECK(d.camera.aperture_radius == 0);
  CHECK(d.integrator.max_depth == -1);
  CHECK(d.integrator.roulette_depth() == 2);
  // A 50 mm lens, measured along the diagonal of 36 mm x 24 mm film.
  CHECK(d.camera.fov_axis == CameraDescription::FovAxis::kDiagonal);
  CHECK(d.camera.fov == doctest::Approx(46.7930));
  CHECK(d.notes.empty());
}

TEST_CASE("Mitsuba: perspective sensors have the documented parameters") {
  using Axis = CameraDescription::FovAxis;
  const Description d = with_sensor(
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
        with_sensor(std::string("<float name='fov' value='40'/><string name='fov_axis' value='") + name + "'/>");
    CHECK(e.camera.fov_axis == axis);
  }
  for (const char* length : {"<string name='focal_length' value='85mm'/>", "<string name='focalLength' value='85'/>",
                             "<float name='focal_length' value='85'/>"}) {
    const Description e = with_sensor(length);
    CHECK(e.camera.fov == doctest::Approx(2 * std::atan(std::hypot(36.0, 24.0) / 170) * 180 / std::numbers::pi));
    CHECK(e.camera.fov_axis == Axis::kDiagonal);
  }
  const Description two = read_text(mitsuba_scene("<sensor type='perspective'/>",
                                                  "<sensor type='perspective'><film "
                                                  "type='hdrfilm'><integer name='width' value='8'/></film></sensor>"));
  CHECK(two.film.width == 8);
  REQUIRE(two.notes.size() == 1);
  CHECK(contains(two.notes[0], "scene.xml:4: "));
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
    CHECK(with_sensor(std::string("<film type='") + film + "'><float name='gamma' value='2.2'/></film>").film.width ==
          768);
}

TEST_CASE("Mitsuba: samplers are mapped to those of Sheaf") {
  const std::string properties = "<integer name='sampleCount' value='16'/><integer name='seed' value='7'/></sampler>";
  for (const auto& [name, kind] : {std::pair{"independent", SamplerKind::kIndependent},
                                   {"stratified", SamplerKind::kStratified},
                                   {"multijitter", SamplerKind::kMultijitter},
                                   {"sobol", SamplerKind::kSobol},
                                   {"zsobol", SamplerKind::kZSobol}}) {
    const Description d = with_sensor(std::string("<sampler type='") + name + "'>" + properties);
    CHECK(d.sampler.kind == kind);
    CHECK(d.sampler.sample_count == 16);
    CHECK(d.sampler.seed == 7);
    CHECK(d.notes.empty());
  }
  for (const char* name : {"ldsampler", "orthogonal", "halton", "hammersley"}) {
    const Description d =
        with_sensor(std::string("<sampler type='") + name + "'><integer name='dimension' value='8'/>" + properties);
    CHECK(d.sampler.kind == SamplerKind::kSobol);
    CHECK(d.sampler.sample_count == 16);
    REQUIRE(d.notes.size() == 1);
    CHECK(contains(d.notes[0], std::string("sampler '") + name + "' is rendered with 'sobol'"));
  }
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

TEST_CASE("Mitsuba: Russian roulette starts later in scenes with media") {
  const std::string ball = "<shape type='sphere'><medium name='interior' type='homogeneous'/>";
  for (const bool media : {false, true})
    for (const bool said : {false, true}) {
      const std::string integrator = std::string("<integrator type='volpath'>") +
                                     (said ? "<integer name='rr_depth' value='4'/>" : "") + "</integrator>";
      const Description d = read_text(mitsuba_scene(media ? ball + "</shape>" : "<shape type='sphere'/>",
                                                    "<sensor type='perspective'/>", integrator));
      CHECK(d.integrator.roulette_depth() == (said ? 4 : media ? 5 : 2));
    }
}

TEST_CASE("Mitsuba: integrators have the documented parameters") {
  const Description d = with_integrator(
      "<integrator type='moment'><integrator type='aov'><string name='aovs' value='d:depth'/><integrator type='path'>"
      "<integer name='maxDepth' value='7'/><integer name='rr_depth' value='3'/><boolean name='strictNormals' "
      "value='true'/><boolean name='hideEmitters' value='true'/></integrator></integrator></integrator>");
  CHECK(d.integrator.max_depth == 7);
  CHECK(d.integrator.rr_depth == 3);
  CHECK(d.integrator.hide_emitters);
  for (const char* name : {"bdpt", "prb", "prb_basic", "prbvolpath"}) {
    CAPTURE(std::string(name));
    const Description other = with_integrator(std::string("<integrator type='") + name + "'/>");
    REQUIRE(other.notes.size() == 1);
    CHECK(contains(other.notes[0], "has the same expectation"));
    CHECK(other.integrator.max_depth == (std::string(name).starts_with("prb") ? 6 : -1));
  }
  const Description tracer =
      with_integrator("<integrator type='ptracer'><integer name='max_depth' value='5'/></integrator>");
  CHECK(tracer.integrator.kind == IntegratorKind::kLightTracer);
  CHECK(tracer.integrator.max_depth == 5);
  CHECK(tracer.notes.empty());
  const Description mapper = with_integrator(
      "<integrator type='photonmapper'><integer name='globalPhotons' value='1234'/><float name='causticLookupRadius' "
      "value='0.5'/></integrator>");
  CHECK(mapper.integrator.kind == IntegratorKind::kPhotonMapper);
  CHECK(mapper.integrator.photons.global.count == 1234);
  CHECK(mapper.integrator.photons.global.relative_radius == 0.05f);
  CHECK(mapper.integrator.photons.caustic.count == 250'000);
  CHECK(mapper.integrator.photons.caustic.relative_radius == 0.5f);
  CHECK(mapper.integrator.photons.gathering == PhotonGathering::kIndirect);
  CHECK(mapper.integrator.photons.lookup_size == 120);
  CHECK(with_integrator("<integrator type='photonmapper'><boolean name='sampleDirect' value='false'/></integrator>")
            .integrator.photons.caustic.count == 0);
  const PhotonMappingSettings volumetric =
      with_integrator(
          "<integrator type='volumetricphotonmapper'><integer name='photonCount' value='1000'/><float "
          "name='photonRadius' value='0.25'/></integrator>")
          .integrator.photons;
  CHECK(volumetric.volume.count == 1000);
  CHECK(volumetric.volume.radius == 0.25f);
  for (const char* name : {"ppm", "sppm"}) {
    const Description progressive = with_integrator(
        std::string("<integrator type='") + name +
        "'><integer name='photonCount' value='77'/><float name='initialRadius' value='0.25'/><float name='alpha' "
        "value='0.5'/><integer name='maxPasses' value='12'/></integrator>");
    const PhotonMappingSettings& photons = progressive.integrator.photons;
    CHECK(progressive.notes.empty());
    CHECK(photons.progressive);
    CHECK(photons.uses_beams());
    CHECK(!with_integrator(std::string("<integrator type='") + name +
                           "'><string name='mediumPhotons' value='points'/></integrator>")
               .integrator.photons.uses_beams());
    CHECK(photons.gathering == PhotonGathering::kIndirect);
    CHECK(photons.global.count == 77);
    CHECK(photons.global.radius == 0.25f);
    CHECK(photons.alpha == 0.5f);
    CHECK(photons.max_passes == 12);
    CHECK(photons.lookup_size == 0);
    CHECK(with_integrator(std::string("<integrator type='") + name + "'/>").integrator.photons.global.count == 250'000);
  }
  for (const char* name : {"volpath", "volpathmis", "volpath_simple"})
    CHECK(with_integrator(std::string("<integrator type='") + name + "'/>").integrator.max_depth == -1);
  const Description direct = with_integrator("<integrator type='direct'/>");
  CHECK(direct.integrator.max_depth == 2);
  CHECK(direct.integrator.strategy == LightStrategy::kMis);
  CHECK(with_integrator("<integrator type='direct'><integer name='emitter_samples' value='0'/></integrator>")
            .integrator.strategy == LightStrategy::kBsdfOnly);
  const Description lights = with_integrator(
      "<integrator type='direct'><integer name='bsdf_samples' value='0'/><integer "
      "name='emitter_samples' value='4'/></integrator>");
  CHECK(lights.integrator.strategy == LightStrategy::kLightOnly);
  CHECK(lights.notes.size() == 1);
  CHECK(with_integrator("<integrator type='depth'/>").integrator.kind == IntegratorKind::kDepth);
  const Description none = with_integrator("");
  CHECK(none.integrator.kind == IntegratorKind::kPath);
  CHECK(none.notes.size() == 1);
}

TEST_CASE("Mitsuba: shapes have the documented parameters") {
  const ShapeDescription obj = shape_of(
      "<shape type='obj'><string name='filename' value='mesh.obj'/><boolean name='faceNormals' value='true'/>"
      "<boolean name='flip_normals' value='true'/><boolean name='collapse' value='true'/></shape>");
  CHECK(std::get<MeshFileShape>(obj.geometry).format == MeshFileShape::Format::kObj);
  CHECK(std::get<MeshFileShape>(obj.geometry).flip_tex_coords);
  CHECK(obj.face_normals);
  CHECK(obj.flip_normals);
  const ShapeDescription ply = shape_of("<shape type='ply'><string name='filename' value='mesh.ply'/></shape>");
  CHECK(std::get<MeshFileShape>(ply.geometry).format == MeshFileShape::Format::kPly);
  CHECK_FALSE(std::get<MeshFileShape>(ply.geometry).flip_tex_coords);
  const ShapeDescription sphere =
      shape_of("<shape type='sphere'><point name='center' x='1' z='3'/><float name='radius' value='2'/></shape>");
  CHECK(std::get<SphereShape>(sphere.geometry).center == Vec3f{1, 0, 3});
  CHECK(std::get<SphereShape>(sphere.geometry).radius == 2);
  CHECK(std::holds_alternative<RectangleShape>(shape_of("<shape type='rectangle'/>").geometry));
  CHECK(std::holds_alternative<CubeShape>(shape_of("<shape type='cube'/>").geometry));
  CHECK(std::holds_alternative<DiskShape>(shape_of("<shape type='disk'/>").geometry));
  const ShapeDescription cylinder = shape_of(
      "<shape type='cylinder'><point name='p0' value='1 2 3'/><point name='p1' value='4 5 6'/><float name='radius' "
      "value='0.5'/></shape>");
  CHECK(std::get<CylinderShape>(cylinder.geometry).p0 == Vec3f{1, 2, 3});
  CHECK(std::get<CylinderShape>(cylinder.geometry).p1 == Vec3f{4, 5, 6});
  CHECK(std::get<CylinderShape>(cylinder.geometry).radius == 0.5f);
}

TEST_CASE("Mitsuba: materials are read and nested") {
  auto materials = [](const std::string& text) {
    std::string all;
    for (const MaterialDescription& m : read_text(mitsuba_scene(text)).materials) all += dump(m) + "\n";
    return all;
  };
  CHECK(materials("<bsdf type='conductor'><string name='material' value='none'/></bsdf>") ==
        "conductor constant 0x1p+0\n");
  CHECK(materials("<bsdf type='conductor'><spectrum name='eta' value='0.5'/><rgb name='k' value='1,2,4'/></bsdf>") ==
        "conductor constant 0x1p+0 eta constant 0x1p-1 k rgb 0x1p+0 0x1p+1 0x1p+2\n");
  CHECK(materials("<bsdf type='twosided'><bsdf type='diffuse'/></bsdf>") == "diffuse constant 0x1p-1\ntwosided 0 0\n");
  CHECK(materials("<bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='conductor'/></bsdf>") ==
        "diffuse constant 0x1p-1\nconductor constant 0x1p+0\ntwosided 0 1\n");
  CHECK(materials("<bsdf type='twosided'><bsdf type='twosided'><bsdf type='diffuse'/></bsdf></bsdf>") ==
        "diffuse constant 0x1p-1\ntwosided 0 0\ntwosided 0 0\n");
  struct Case {
    const char* name;
    float ior;
  };
  for (const Case& c : {Case{"vacuum", 1},
                        {"air", 1.000277f},
                        {"water", 1.333f},
                        {"bk7", 1.5046f},
                        {"fused quartz", 1.458f},
                        {"diamond", 2.419f}}) {
    const Description d = read_text(mitsuba_scene(std::string("<bsdf type='dielectric'><string name='intIOR' value='") +
                                                  c.name + "'/><float name='ext_ior' value='1.5'/></bsdf>"));
    CHECK(std::get<DielectricDescription>(d.materials.at(0).model).int_ior == c.ior);
    CHECK(std::get<DielectricDescription>(d.materials.at(0).model).ext_ior == 1.5f);
  }
}

TEST_CASE("Mitsuba: references to a material share it") {
  const Description d = read_text(
      mitsuba_scene("<shape type='sphere'><ref id='b'/></shape><bsdf type='diffuse' id='a'/><bsdf type='conductor' "
                    "id='b'/><shape type='cube'><ref name='bsdf' id='b'/></shape>"));
  REQUIRE(d.materials.size() == 2);
  CHECK(d.materials[0].id == "b");
  CHECK(d.shapes.at(0).material == d.shapes.at(1).material);
}

TEST_CASE("Mitsuba: every kind of object can be referred to") {
  const Description d = read_text(mitsuba_scene(
      "<film type='hdrfilm' id='f'><integer name='width' value='9'/><ref id='r'/></film><rfilter type='box' "
      "id='r'/><sampler type='independent' id='s'><integer name='sample_count' value='9'/></sampler>"
      "<emitter type='area' id='e'><ref name='radiance' id='c'/></emitter><rgb id='c' value='1,2,4'/>"
      "<shape type='sphere'><ref id='e'/></shape><integrator type='direct' id='i'/>",
      "<sensor type='perspective'><ref id='f'/><ref id='s'/></sensor>",
      "<integrator type='moment'><ref id='i'/></integrator>"));
  CHECK(d.film.width == 9);
  CHECK(d.film.filter.kind == PixelFilter::Kind::kBox);
  CHECK(d.sampler.sample_count == 9);
  CHECK(d.integrator.max_depth == 2);
  CHECK(dump(d.shapes.at(0).radiance.value()) == "rgb 0x1p+0 0x1p+1 0x1p+2");
}

TEST_CASE("Mitsuba: emitters have the documented parameters") {
  const Description d = read_text(mitsuba_scene(
      "<emitter type='point'><point name='position' x='1' y='2' z='3'/><rgb name='intensity' value='300'/></emitter>"
      "<emitter type='point'><transform name='toWorld'><translate x='4'/></transform><float name='samplingWeight' "
      "value='2'/></emitter><emitter type='constant'><rgb name='radiance' value='0.5'/></emitter>"));
  REQUIRE(d.lights.size() == 3);
  CHECK(dump(d.lights[0]) == "point 0x1p+0 0x1p+1 0x1.8p+1 rgb 0x1.2cp+8 0x1.2cp+8 0x1.2cp+8");
  CHECK(dump(d.lights[1]) == "point 0x1p+2 0x0p+0 0x0p+0 constant 0x1p+0");
  CHECK(dump(d.lights[2]) == "constant rgb 0x1p-1 0x1p-1 0x1p-1");
  CHECK(radiance_of("") == "constant 0x1p+0");
}

TEST_CASE("Mitsuba: spectra are read in every notation") {
  CHECK(reflectance_of("<rgb name='reflectance' value='0.25'/>") == "rgb 0x1p-2 0x1p-2 0x1p-2");
  CHECK(reflectance_of("<rgb name='reflectance' value='0.25 0.5, 1'/>") == "rgb 0x1p-2 0x1p-1 0x1p+0");
  CHECK(reflectance_of("<rgb name='reflectance' value='#ff0000'/>") == "rgb 0x1p+0 0x0p+0 0x0p+0");
  CHECK(reflectance_of("<srgb name='reflectance' value='#00ff00'/>") == "rgb 0x0p+0 0x1p+0 0x0p+0");
  CHECK(reflectance_of("<float name='reflectance' value='0.25'/>") == "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum name='reflectance' value='0.25'/>") == "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum name='reflectance' value='400:0.5, 700:0.25'/>") ==
        "table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  CHECK(reflectance_of(
            "<texture type='rawconstant' name='reflectance'><vector name='value' value='0.1,0.2,0.3'/></texture>") ==
        reflectance_of("<rgb name='reflectance' value='0.1,0.2,0.3'/>"));
  CHECK(
      reflectance_of("<spectrum type='rawconstant' name='reflectance'><float name='value' value='0.25'/></spectrum>") ==
      "constant 0x1p-2");
  CHECK(reflectance_of("<texture type='volume' name='reflectance'><volume name='volume' type='constvolume'>"
                       "<float name='value' value='0.25'/></volume></texture>") == "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum type='uniform' name='reflectance'><float name='value' value='0.25'/></spectrum>") ==
        "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum type='irregular' name='reflectance'><string name='wavelengths' value='400, 700'/>"
                       "<string name='values' value='0.5, 0.25'/></spectrum>") ==
        "table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  CHECK(reflectance_of("<spectrum type='regular' name='reflectance'><float name='wavelength_min' value='400'/><float "
                       "name='wavelength_max' value='700'/><string name='values' value='0.5, 0.25'/></spectrum>") ==
        "table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  const std::string blackbody = "blackbody 0x1.388p+12 0x1p+1";
  CHECK(radiance_of("<blackbody name='radiance' temperature='5000K' scale='2'/>") == blackbody);
  CHECK(radiance_of("<spectrum type='blackbody' name='radiance'><float name='temperature' value='5000'/><float "
                    "name='scale' value='2'/></spectrum>") == blackbody);
  CHECK(radiance_of("<spectrum type='d65' name='radiance'><float name='scale' value='2'/></spectrum>") ==
        "constant 0x1p+1");
  const Description d = read_text(mitsuba_scene("<bsdf type='diffuse'><srgb name='reflectance' value='0.5'/></bsdf>"));
  const auto& reflectance = std::get<DiffuseDescription>(d.materials.at(0).model).reflectance;
  CHECK(std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(reflectance).value).value.x ==
        doctest::Approx(0.21404));
}

TEST_CASE("Mitsuba: spectra are read from files") {
  const TemporaryFolder folder;
  const auto scene =
      write_below(folder, "scene.xml",
                  mitsuba_scene("<bsdf type='diffuse'><spectrum name='reflectance' filename='data/a.spd'/></bsdf>"));
  auto message = [&](const std::string& spd) {
    write_below(folder, "data/a.spd", spd);
    return error_of(scene);
  };
  CHECK(message("# a comment\n400 0.5\n\n700\t0.25 # the end\n").empty());
  const Description d = read_scene(scene);
  CHECK(dump(d.materials.at(0)) == "diffuse table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  CHECK(contains(message("400 0.5\n300 0.5\n"), "data/a.spd:2: wavelengths must increase"));
  CHECK(contains(message("400 0.5\n500\n"), "data/a.spd:2: expected a wavelength and a value, found '500'"));
  CHECK(contains(message("400 0.5\n500 x\n"), "data/a.spd:2: spectrum value is 'x', expected a number"));
  CHECK(contains(message(""), "data/a.spd: spectrum needs at least two"));
  CHECK(contains(message("400 2\n500 2\n"), "scene.xml:4: property 'reflectance' of bsdf 'diffuse' contains 2"));
}

TEST_CASE("Mitsuba: transforms are composed in document order") {
  auto transformed = [](const std::string& steps, Vec3f p) {
    return shape_of("<shape type='sphere'><transform name='to_world'>" + steps + "</transform></shape>")
        .to_world.point(p);
  };
  CHECK(transformed("<translate x='1'/><scale value='2'/>", {0, 0, 0}) == Vec3f{2, 0, 0});
  CHECK(transformed("<scale x='2'/><translate value='1 0 0'/>", {1, 1, 1}) == Vec3f{3, 1, 1});
  CHECK(transformed("<matrix value='0 -1 0 1 0 0 0 0 1'/>", {1, 2, 3}) == Vec3f{-2, 1, 3});
  CHECK(transformed("<matrix value='1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1'/>", {0, 0, 0}) == Vec3f{4, 5, 6});
  const Vec3f rotated = transformed("<rotate y='1' angle='90'/>", {0, 0, 1});
  CHECK(rotated.x == doctest::Approx(1));
  // Without an up vector, looking along -z, x becomes y and y becomes x.
  CHECK(transformed("<lookat origin='0,0,1' target='0,0,0'/>", {1, 2, 3}) == Vec3f{2, 1, -2});
  const std::string element = "<shape type='sphere'>\n<transform name='to_world'>\n";
  for (const auto& [step, expected] :
       {std::pair{"<scale value='0'/>", "scene.xml:6: transform is not invertible"},
        {"<rotate angle='5'/>", "scene.xml:6: <rotate> needs value="},
        {"<rotate x='0' angle='5'/>", "scene.xml:6: rotation axis must not be zero"},
        {"<rotate x='1'/>", "scene.xml:6: <rotate> needs an attribute 'angle'"},
        {"<matrix value='1 2 3'/>", "scene.xml:6: <matrix> has 3 numbers, expected 16 or 9"},
        {"<matrix value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1'/>", "the last row of <matrix> is invalid, expected 0 0 0 1"},
        {"<lookat origin='0,0,0' target='0,0,0' up='0,1,0'/>", "scene.xml:6: lookat: "},
        {"<lookat origin='0,0,0' target='0,1,0' up='0,1,0'/>", "scene.xml:6: lookat: "},
        {"<translat x='1'/>", "scene.xml:6: unknown transform step <translat>, did you mean 'translate'?"},
        {"<translate value='1,2,3' x='1'/>", "<translate> has no attribute 'x'"},
        {"<translate x='1e60'/>", "expected a number in the range of a float"},
        {"<scale value='1e-300'/>", "scene.xml:6: "}}) {
    CAPTURE_BINDING(step);
    const std::string message = error_of_text(mitsuba_scene(element + step + "</transform></shape>"));
    CHECK_MESSAGE(contains(message, expected), message);
  }
}

TEST_CASE("the same scene in both dialects gives the same description") {
  const std::string nori = R"(<scene>
    <integrator type="path_mis"/>
    <sampler type="independent"><integer name="sampleCount" value="32"/></sampler>
    <camera type="perspective">
      <float name="fov" value="35"/><float name="nearClip" value="0.01"/>
      <integer name="width" value="64"/><integer name="height" value="48"/>
      <transform name="toWorld">
        <scale value="-1,1,1"/><rotate axis="0,1,0" angle="30"/><lookat origin="0,1,6" target="0,1,0" up="0,1,0"/>
      </transform>
      <rfilter type="tent"/>
    </camera>
    <mesh type="sphere"><point name="center" value="1,2,3"/><float name="radius" value="0.5"/>
      <bsdf type="diffuse"><color name="albedo" value="0.1,0.2,0.3"/></bsdf>
    </mesh>
    <mesh type="sphere"><bsdf type="dielectric"><float name="intIOR" value="1.4"/></bsdf></mesh>
    <mesh type="sphere"><bsdf type="mirror"/>
      <emitter type="area"><color name="radiance" value="9,8,7"/></emitter>
    </mesh>
    <emitter type="point"><point name="position" value="0,5,0"/><color name="intensity" value="3,2,1"/></emitter>
    <emitter type="constant"><color name="radiance" value="0.5,0.5,0.5"/></emitter>
  </scene>)";
  const std::string mitsuba = R"(<scene version="3.0.0">
    <shape type="sphere"><point name="center" x="1" y="2" z="3"/><float name="radius" value="0.5"/>
      <bsdf type="diffuse"><rgb name="reflectance" value="0.1 0.2 0.3"/></bsdf>
    </shape>
    <shape type="sphere"><bsdf type="dielectric"><float name="int_ior" value="1.4"/></bsdf></shape>
    <shape type="sphere"><bsdf type="conductor"/><emitter type="area"><rgb name="radiance" value="9,8,7"/></emitter>
    </shape>
    <emitter type="point"><point name="position" value="0,5,0"/><rgb name="intensity" value="3,2,1"/></emitter>
    <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
    <sensor type="perspective">
      <float name="fov" value="35"/>
      <transform name="to_world">
        <rotate y="1" angle="30"/><lookat origin="0,1,6" target="0,1,0" up="0,1,0"/>
      </transform>
      <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/>
        <rfilter type="tent"/></film>
      <sampler type="independent"><integer name="sample_count" value="32"/></sampler>
    </sensor>
    <integrator type="path"/>
  </scene>)";
  CHECK(dump(read_text(nori)) == dump(read_text(mitsuba)));
  CHECK(dump(read_text(nori)) != dump(read_text(mitsuba_scene(""))));
}

TEST_CASE("Mitsuba: names of version 0.6 are read") {
  const Description d = read_text(
      "<scene version='0.2.0'><camera type='perspective'><film type='exrfilm'><integer name='width' value='9'/></film>"
      "</camera><integrator type='path'/><luminaire type='point'/>"
      "<shape type='sphere'><bsdf type='lambertian'/></shape></scene>");
  CHECK(d.film.width == 9);
  CHECK(d.lights.size() == 1);
  CHECK(std::holds_alternative<DiffuseDescription>(
      d.materials.at(static_cast<std::size_t>(d.shapes.at(0).material.value())).model));
}

}  // namespace sheaf::test_mitsuba
