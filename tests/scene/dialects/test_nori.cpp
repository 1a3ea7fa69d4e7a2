// The Nori dialect: descriptions of each element, defaults, errors.
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/scene_errors.h"

#include <doctest/doctest.h>

#include <numbers>

namespace sheaf::test_nori {

using namespace test;

namespace {

const std::string kCamera = "<camera type=\"perspective\"/>";
const std::string kIntegrator = "<integrator type=\"path_mis\"/>";

/// The camera is in line 2, the integrator in line 3, and `inside` begins in line 4.
std::string scene_with(const std::string& inside, const std::string& camera = kCamera,
                       const std::string& integrator = kIntegrator) {
  return "<scene>\n" + camera + "\n" + integrator + "\n" + inside + "\n</scene>\n";
}

}  // namespace

TEST_CASE("Nori: a minimal scene has the documented defaults") {
  const Description d = read_text(scene_with("<mesh type='obj'><string name='filename' value='mesh.obj'/></mesh>"));
  CHECK(d.film.width == 1280);
  CHECK(d.film.height == 720);
  CHECK(d.camera.fov == 30);
  CHECK(d.camera.fov_axis == CameraDescription::FovAxis::kX);
  CHECK(d.film.filter.kind == PixelFilter::Kind::kGaussian);
  CHECK(d.film.filter.radius == 2);
  CHECK(d.film.filter.stddev == 0.5f);
  CHECK(d.sampler.sample_count == 1);
  REQUIRE(d.shapes.size() == 1);
  CHECK_FALSE(d.shapes[0].material.has_value());
  CHECK_FALSE(d.shapes[0].radiance.has_value());
  const auto& mesh = std::get<MeshFileShape>(d.shapes[0].geometry);
  CHECK(mesh.file.filename() == "mesh.obj");
  CHECK_FALSE(mesh.flip_tex_coords);
  CHECK(d.notes.empty());
}

TEST_CASE("Nori: integers may be written as floats of integral value") {
  const Description d = read_text(
      scene_with("<sampler type='independent'><float name='sampleCount' value='16'/></sampler>",
                 "<camera type='perspective'><float name='width' value='40.0'/><integer name='height' value='3e1'/>"
                 "</camera>",
                 "<integrator type='photonmapper'><float name='photonCount' value='2e5'/>"
                 "<float name='maxDepth' value='7'/><float name='rrDepth' value='3'/></integrator>"));
  CHECK(d.sampler.sample_count == 16);
  CHECK(d.film.width == 40);
  CHECK(d.film.height == 30);
  CHECK(d.integrator.photons.global.count == 200'000);
  CHECK(d.integrator.max_depth == 7);
  CHECK(d.integrator.rr_depth == 3);
}

TEST_CASE("Nori: cameras and filters and samplers have the documented parameters") {
  auto camera = [](const std::string& inside) {
    return read_text(scene_with("", "<camera type='perspective'>" + inside + "</camera>"));
  };
  const Description d = camera(
      "<integer name='width' value='40'/><integer name='height' value='30'/><float name='fov' value='50'/>"
      "<float name='nearClip' value='0.1'/><float name='farClip' value='100'/><transform name='toWorld'>"
      "<scale value='-1,1,1'/><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>"
      "<rfilter type='mitchell'><float name='radius' value='2'/><float name='B' value='0.2'/>"
      "<float name='C' value='0.4'/></rfilter>");
  CHECK(d.film.width == 40);
  CHECK(d.film.height == 30);
  CHECK(d.camera.fov == 50);
  CHECK(d.film.filter.kind == PixelFilter::Kind::kMitchell);
  CHECK(d.notes.empty());
  CHECK(d.film.filter.b == 0.2f);
  CHECK(d.film.filter.c == 0.4f);
  CHECK(d.camera.to_world.point({0, 0, 0}) == Vec3f{0, 0, 5});
  // Nori's x axis points to the right of the image, Sheaf's to the left, which is -x when looking along -z.
  CHECK(d.camera.to_world.vector({1, 0, 0}) == Vec3f{-1, 0, 0});
  CHECK(camera("<rfilter type='box'/>").film.filter.radius == 0.5f);
  CHECK(camera("<rfilter type='tent'/>").film.filter.radius == 1);
  const Description gaussian =
      camera("<rfilter type='gaussian'><float name='stddev' value='1'/><float name='radius' value='3'/></rfilter>");
  CHECK(gaussian.film.filter.stddev == 1);
  CHECK(gaussian.film.filter.radius == 4);
  REQUIRE(gaussian.notes.size() == 1);
  CHECK(contains(gaussian.notes[0], "scene.xml:2: rfilter 'gaussian' has the radius 4"));
  CHECK(d.camera.near_clip == 0.1f);
  CHECK(d.camera.far_clip == 100);
  CHECK(camera("").camera.near_clip == 1e-4f);
  CHECK(camera("").camera.far_clip == 10'000);
  CHECK(camera("").sampler.kind == SamplerKind::kSobol);
  const auto sampler = [](const std::string& type) {
    return read_text(scene_with("<sampler type='" + type + "'><integer name='sampleCount' value='64'/></sampler>"));
  };
  CHECK(sampler("independent").sampler.sample_count == 64);
  CHECK(sampler("independent").sampler.kind == SamplerKind::kIndependent);
  CHECK(sampler("stratified").sampler.kind == SamplerKind::kStratified);
  CHECK(sampler("sobol").sampler.kind == SamplerKind::kSobol);
  CHECK(sampler("zsobol").sampler.kind == SamplerKind::kZSobol);
  REQUIRE(sampler("halton").notes.size() == 1);
  CHECK(contains(sampler("halton").notes[0], "sampler 'halton' is rendered with 'sobol'"));
}

TEST_CASE("Nori: thin-lens and orthographic cameras are read") {
  const auto camera = [](const std::string& type, const std::string& inside) {
    return read_text(scene_with("", "<camera type='" + type + "'>" + inside + "</camera>")).camera;
  };
  for (const char* radius : {"apertureRadius", "lensRadius"})
    for (const char* distance : {"focusDistance", "focalDistance"})
      for (const char* type : {"perspective", "thinlens"}) {
        const CameraDescription c = camera(
            type, std::string("<float name='") + radius + "' value='0.25'/><float name='" + distance + "' value='6'/>");
        CHECK(c.aperture_radius == 0.25f);
        CHECK(c.focus_distance == 6);
        CHECK(c.fov == 30);
      }
  CHECK(camera("perspective", "").aperture_radius == 0);
  CHECK(camera("orthographic", "").projection == CameraDescription::Projection::kOrthographic);
}

TEST_CASE("Nori: integrators are mapped to those of Sheaf") {
  struct Case {
    const char* name;
    IntegratorKind kind;
    LightStrategy strategy;
    int max_depth;
  };
  const Case cases[] = {
      {"ptracer", IntegratorKind::kLightTracer, LightStrategy::kMis, -1},
      {"photonmapper", IntegratorKind::kPhotonMapper, LightStrategy::kMis, -1},
      {"ppm", IntegratorKind::kPhotonMapper, LightStrategy::kMis, -1},
      {"sppm", IntegratorKind::kPhotonMapper, LightStrategy::kMis, -1},
      {"normals", IntegratorKind::kNormals, LightStrategy::kMis, -1},
      {"depth", IntegratorKind::kDepth, LightStrategy::kMis, -1},
      {"path", IntegratorKind::kPath, LightStrategy::kMis, -1},
      {"path_mis", IntegratorKind::kPath, LightStrategy::kMis, -1},
      {"path_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, -1},
      {"path_ems", IntegratorKind::kPath, LightStrategy::kLightOnly, -1},
      {"direct", IntegratorKind::kPath, LightStrategy::kMis, 2},
      {"direct_mis", IntegratorKind::kPath, LightStrategy::kMis, 2},
      {"direct_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, 2},
      {"direct_ems", IntegratorKind::kPath, LightStrategy::kLightOnly, 2},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.name));
    const Description d = read_text(scene_with("", kCamera, std::string("<integrator type='") + c.name + "'/>"));
    CHECK(d.integrator.kind == c.kind);
    CHECK(d.integrator.strategy == c.strategy);
    CHECK(d.integrator.max_depth == c.max_depth);
    CHECK(d.integrator.roulette_depth() == (c.kind == IntegratorKind::kPath ? 2 : 5));
  }
}

TEST_CASE("Nori: photon mapping has the documented parameters") {
  const auto read = [](const std::string& properties) {
    return read_text(scene_with("", kCamera, "<integrator type='photonmapper'>" + properties + "</integrator>"))
        .integrator;
  };
  const IntegratorSettings plain = read("");
  CHECK(plain.kind == IntegratorKind::kPhotonMapper);
  CHECK(plain.photons.global.count == 1'000'000);
  CHECK(plain.photons.global.radius == 0);
  CHECK(plain.photons.gathering == PhotonGathering::kAll);
  CHECK(!plain.photons.progressive);
  CHECK(!plain.photons.uses_beams());
  const PhotonMappingSettings p =
      read(
          "<integer name='photonCount' value='5000'/><float name='photonRadius' value='0.25'/>"
          "<boolean name='finalGather' value='true'/><integer name='numGatherRays' value='16'/>"
          "<integer name='causticPhotonCount' value='700'/><float name='causticRadius' value='0.125'/>"
          "<string name='kernel' value='cone'/><integer name='lookupSize' value='80'/>"
          "<string name='mediumPhotons' value='beams'/>")
          .photons;
  CHECK(p.global.count == 5000);
  CHECK(p.global.radius == 0.25f);
  CHECK(p.gathering == PhotonGathering::kFinal);
  CHECK(p.gather_rays == 16);
  CHECK(p.caustic.count == 700);
  CHECK(p.caustic.radius == 0.125f);
  CHECK(p.kernel == PhotonKernel::kCone);
  CHECK(p.lookup_size == 80);
  CHECK(p.uses_beams());
  CHECK(read("<boolean name='sampleDirect' value='true'/>").photons.gathering == PhotonGathering::kIndirect);
  const auto gathering = [&](const std::string& properties) { return read(properties).photons.gathering; };
  CHECK(gathering("<integer name='numGatherRays' value='16'/>") == PhotonGathering::kFinal);
  CHECK(gathering("<integer name='numGatherRays' value='0'/>") == PhotonGathering::kAll);
  CHECK(gathering("<integer name='numGatherRays' value='4'/><boolean name='finalGather' value='false'/>") ==
        PhotonGathering::kAll);
  CHECK(read("<boolean name='finalGather' value='true'/>").photons.gather_rays == 1);
  CHECK(read("<integer name='causticPhotonCount' value='7'/>").photons.gathering == PhotonGathering::kAll);
  CHECK(read("<integer name='causticPhotonCount' value='7'/>").photons.caustic.count == 7);
  for (const auto& [properties, message] :
       {std::pair{"<string name='kernel' value='cones'/>",
                  "expected disc, constant, cone or epanechnikov, did you mean 'cone'?"},
        std::pair{"<string name='mediumPhotons' value='point'/>",
                  "is 'point', expected auto, points or beams, did you mean 'points'?"},
        std::pair{"<integer name='photonCount' value='-1'/>", "photonCount"},
        std::pair{"<float name='photonRadius' value='-1'/>", "photonRadius"},
        std::pair{"<integer name='lookupSize' value='5000'/>", "lookupSize"},
        std::pair{"<float name='alpha' value='0.5'/>", "alpha"}}) {
    CAPTURE_BINDING(properties);
    try {
      read(properties);
      FAIL("no error");
    } catch (const Error& error) { CHECK(std::string(error.what()).find(message) != std::string::npos); }
  }
}

TEST_CASE("Nori: materials are read and nested") {
  auto material = [](const std::string& bsdf) {
    return dump(read_text(scene_with("<mesh type='sphere'>" + bsdf + "</mesh>")).materials.at(0));
  };
  CHECK(material("<bsdf type='diffuse'><color name='albedo' value='0.25,0.5,1'/></bsdf>") ==
        "diffuse rgb 0x1p-2 0x1p-1 0x1p+0");
  CHECK(material("<bsdf type='diffuse'/>") == "diffuse constant 0x1p-1");
  CHECK(material("<bsdf type='mirror'/>") == "conductor constant 0x1p+0");
  const Description d = read_text(
      scene_with("<mesh type='sphere'><bsdf type='dielectric'/></mesh><mesh type='sphere'><bsdf type='dielectric'>"
                 "<float name='intIOR' value='1.33'/><float name='extIOR' value='1'/></bsdf></mesh>"));
  const auto& glass = std::get<DielectricDescription>(d.materials.at(0).model);
  CHECK(glass.int_ior == 1.5046f);
  CHECK(glass.ext_ior == 1.000277f);
  const auto& water = std::get<DielectricDescription>(d.materials.at(1).model);
  CHECK(water.int_ior == 1.33f);
  CHECK(water.ext_ior == 1.0f);
  CHECK(static_cast<unsigned>(*d.shapes.at(1).material) == 1);
}

TEST_CASE("Nori: emitters have the documented parameters") {
  auto light = [](const std::string& inside, const char* type = "point") {
    return read_text(scene_with(std::string("<emitter type='") + type + "'>" + inside + "</emitter>")).lights.at(0);
  };
  const auto by_power = std::get<PointLightDescription>(
      light("<point name='position' value='1,2,3'/><color name='power' value='100,200,300'/>").model);
  CHECK(by_power.position == Vec3f{1, 2, 3});
  const Vec3f intensity = std::get<SpectrumDescription::Rgb>(by_power.intensity.value).value;
  CHECK(intensity.x == near(100 / (4 * std::numbers::pi)));
  CHECK(intensity.z == near(300 / (4 * std::numbers::pi)));
  const auto by_intensity = std::get<PointLightDescription>(light("<color name='intensity' value='1,2,3'/>").model);
  CHECK(dump(by_intensity.intensity) == "rgb 0x1p+0 0x1p+1 0x1.8p+1");
  CHECK(dump(light("<color name='radiance' value='1,1,2'/>", "constant")) == "constant rgb 0x1p+0 0x1p+0 0x1p+1");
  const Description d = read_text(
      scene_with("<mesh type='sphere'><emitter type='area'><color name='radiance' value='4,5,6'/></emitter></mesh>"));
  CHECK(dump(d.shapes.at(0).radiance.value()) == "rgb 0x1p+2 0x1.4p+2 0x1.8p+2");
  CHECK(d.lights.empty());
}

TEST_CASE("Nori: transforms apply in document order") {
  auto transformed = [](const std::string& steps, Vec3f p) {
    const Description d =
        read_text(scene_with("<mesh type='sphere'><transform name='toWorld'>" + steps + "</transform></mesh>"));
    return d.shapes.at(0).to_world.point(p);
  };
  CHECK(transformed("<translate value='1,0,0'/><scale value='2,2,2'/>", {0, 0, 0}) == Vec3f{2, 0, 0});
  CHECK(transformed("<scale value='2,2,2'/><translate value='1,0,0'/>", {0, 0, 0}) == Vec3f{1, 0, 0});
  CHECK(transformed("<matrix value='0,-1,0,5, 1,0,0,6, 0,0,1,7, 0,0,0,1'/>", {1, 0, 0}) == Vec3f{5, 7, 7});
  const Vec3f rotated = transformed("<rotate axis='0,0,1' angle='90'/>", {1, 0, 0});
  CHECK(rotated.x == within(0, 1e-7));
  CHECK(rotated.y == near(1));
}

TEST_CASE("Nori: spheres have the documented parameters") {
  const Description d = read_text(
      scene_with("<mesh type='sphere'><point name='center' value='1,2,3'/><float name='radius' value='0.5'/></mesh>"));
  const auto& sphere = std::get<SphereShape>(d.shapes.at(0).geometry);
  CHECK(sphere.center == Vec3f{1, 2, 3});
  CHECK(sphere.radius == 0.5f);
}

TEST_CASE("Nori: errors of meshes and materials have line and fault and nearest name") {
  check_errors({
      {scene_with("<mesh type='obi'/>"), "scene.xml:4: unknown mesh plugin 'obi', did you mean 'obj'?"},
      {scene_with("<mesh type='obj'/>"), "scene.xml:4: mesh 'obj' needs the string 'filename'"},
      {scene_with("<mesh type='obj'><string name='filename' value='no.obj'/></mesh>"),
       "scene.xml:4: file 'no.obj' not found in "},
      {scene_with("<mesh type='obj'><string name='filename' value=''/></mesh>"), "scene.xml:4: empty file name"},
      {scene_with("<mesh type='obj'><string name='filename' value='.'/></mesh>"), "is not a regular file"},
      {scene_with("<mesh type='sphere'><bsdf type='diffuse'>\n<color name='albdo' value='1,1,1'/></bsdf></mesh>"),
       "scene.xml:5: unknown property 'albdo' of bsdf 'diffuse', did you mean 'albedo'?"},
      {scene_with("<mesh type='sphere'><bsdf type='dielectric'><float name='intIRO' value='1'/></bsdf></mesh>"),
       "did you mean 'int_ior'?"},
      {scene_with("<mesh type='sphere'><bsdf type='diffuse'><color name='albedo' value='-1,1,1'/></bsdf></mesh>"),
       "property 'albedo' of bsdf 'diffuse' contains -1, expected values within [0, 1]"},
      {scene_with("<mesh type='sphere'><bsdf type='diffuse'><color name='albedo' value='1,1'/></bsdf></mesh>"),
       "color is '1,1', expected three numbers"},
      {scene_with("<mesh type='sphere'><bsdf type='microfacets'/></mesh>"),
       "unknown bsdf plugin 'microfacets', did you mean 'microfacet'?"},
      {scene_with("<mesh type='sphere'><bsdf type='mirror'/><bsdf type='mirror'/></mesh>"),
       "mesh 'sphere' has 2 nested <bsdf>, expected one"},
      {scene_with("<mesh type='sphere'><film type='hdrfilm'/></mesh>"),
       "mesh 'sphere' takes no nested <film> (known: bsdf, medium, emitter)"},
      {scene_with("<mesh type='sphere'><float name='radius' value='-2'/></mesh>"),
       "property 'radius' of mesh 'sphere' is '-2', expected a positive number"},
      {scene_with("<mesh type='sphere'><string name='radius' value='2'/></mesh>"),
       "property 'radius' of mesh 'sphere' is given as <string>, expected float"},
      {scene_with("<mesh type='sphere'><flaot name='radius' value='2'/></mesh>"),
       "unknown element <flaot> in mesh 'sphere', did you mean 'float'?"},
  });
}

TEST_CASE("Nori: errors of emitters and cameras and samplers and integrators have line and fault and nearest name") {
  check_errors({
      {scene_with("<emitter type='area'/>"), "emitter 'area' must be nested in a <mesh>"},
      {scene_with("<emitter type='point'><color name='power' value='1'/><color name='intensity' value='1'/></emitter>"),
       "has both 'power' (W) and 'intensity' (W/sr)"},
      {scene_with("<emiter type='point'/>"), "unknown element <emiter> in a Nori scene, did you mean 'emitter'?"},
      {scene_with("", "<camera type='fisheye'/>"), "scene.xml:2: unknown camera plugin 'fisheye'"},
      {scene_with("", "<camera type='thinlens'/>"), "scene.xml:2: camera 'thinlens' needs the float 'apertureRadius'"},
      {scene_with("", "<camera type='thinlens'><float name='lensRadius' value='1'/></camera>"),
       "camera 'thinlens' has a lens but no 'focusDistance'"},
      {scene_with("",
                  "<camera type='thinlens'><float name='lensRadius' value='1'/><float name='apertureRadius' "
                  "value='1'/></camera>"),
       "has both 'apertureRadius' and 'lensRadius', expected one"},
      {scene_with("", kCamera + kCamera), "scene.xml:2: a second <camera>"},
      {scene_with("", "<mesh type='sphere'/>"), "scene.xml:1: the scene has no <camera>"},
      {scene_with("", kCamera, ""), "scene.xml:1: the scene has no <integrator>"},
      {scene_with("", kCamera, "<integrator type='witted'/>"), "scene.xml:3: unknown integrator plugin 'witted'"},
      {scene_with("", "<camera type='perspective'><integer name='width' value='0'/></camera>"),
       "property 'width' of camera 'perspective' is '0', expected an integer from 1"},
      {scene_with("",
                  "<camera type='perspective'><integer name='width' value='100000'/>"
                  "<integer name='height' value='100000'/></camera>"),
       "100000 x 100000 pixels, expected at most 10^9"},
      {scene_with("<sampler type='independent'><integer name='sampleCount' value='99999999999'/></sampler>"),
       "property 'sampleCount' of sampler 'independent' is '99999999999'"},
      {scene_with("<sampler type='independent'><float name='sampleCount' value='4.5'/></sampler>"),
       "property 'sampleCount' is '4.5', expected an integer"},
      {scene_with("", "<camera type='perspective'><float name='fov' value='nan'/></camera>"),
       "property 'fov' is 'nan', expected a finite number"},
      {scene_with("<test type='chi2test'/>"), "unknown element <test> in a Nori scene"},
  });
}

TEST_CASE("Nori: shapes may be called shape and appear beside a camera without a version") {
  const Description d = read_text(scene_with("<shape type='sphere'><bsdf type='mirror'/></shape><shape type='cube'/>"));
  CHECK(d.shapes.size() == 2);
  CHECK(d.camera.fov == 30);
}

TEST_CASE("Nori: a parallelogram has a corner at its origin") {
  const Description d = read_text(
      scene_with("<mesh type='parallelogram'><point name='origin' value='1 2 3'/><vector name='u' value='2 0 0'/>"
                 "<vector name='v' value='0 0 4'/><emitter type='parallelogram_emitter'>"
                 "<color name='radiance' value='5 5 5'/></emitter></mesh>"));
  REQUIRE(d.shapes.size() == 1);
  const ShapeDescription& shape = d.shapes[0];
  CHECK(std::holds_alternative<RectangleShape>(shape.geometry));
  CHECK(length(shape.to_world.point({-1, -1, 0}) - Vec3f{1, 2, 3}) < 1e-6f);
  CHECK(length(shape.to_world.point({1, 1, 0}) - Vec3f{3, 2, 7}) < 1e-6f);
  // The normal is u x v.
  CHECK(dot(shape.to_world.vector({0, 0, 1}), Vec3f{0, -1, 0}) > 0.999f);
  CHECK(shape.radiance.has_value());
  CHECK(contains(error_of_text(scene_with("<mesh type='parallelogram'><vector name='u' value='0 1 0'/></mesh>")),
                 "'u' and 'v' are parallel"));
}

TEST_CASE("Nori: the upstream camera mirrors that of ETH") {
  const std::string text = scene_with("");
  ReadOptions upstream;
  upstream.nori_camera = NoriCamera::kUpstream;
  const Vec3f eth = read_text(text).camera.to_world.vector({1, 2, 3});
  const Vec3f other = read_text(text, upstream).camera.to_world.vector({1, 2, 3});
  CHECK(eth == Vec3f{-other.x, other.y, other.z});
}

TEST_CASE("Nori: exercise integrators make the scene white and light it by a constant environment") {
  const std::string inside =
      "<mesh type='sphere'><bsdf type='mirror'/><emitter type='area'/></mesh>"
      "<emitter type='point'/>";
  const Description ao = read_text(scene_with(inside, kCamera, "<integrator type='ao'/>"));
  CHECK(ao.materials.size() == 1);
  CHECK_FALSE(ao.shapes.at(0).radiance.has_value());
  REQUIRE(ao.lights.size() == 1);
  CHECK(std::holds_alternative<ConstantLightDescription>(ao.lights[0].model));
  CHECK(ao.integrator.max_depth == 2);
  CHECK(ao.integrator.hide_emitters);
  const Description av =
      read_text(scene_with(inside, kCamera, "<integrator type='av'><float name='length' value='3'/></integrator>"));
  CHECK(av.integrator.kind == IntegratorKind::kVisibility);
  CHECK(av.integrator.visibility_length == 3.0f);
  CHECK(av.lights.empty());
  CHECK(contains(error_of_text(scene_with(inside, kCamera, "<integrator type='av'/>")), "needs the float 'length'"));
  CHECK(contains(
      error_of_text(scene_with(inside, kCamera, "<integrator type='av'><float name='length' value='0'/></integrator>")),
      "'length'"));
  const Description simple = read_text(
      scene_with(inside, kCamera,
                 "<integrator type='simple'><point name='position' value='1 2 3'/><color name='energy' value='4 4 4'/>"
                 "</integrator>"));
  REQUIRE(simple.lights.size() == 1);
  const auto& light = std::get<PointLightDescription>(simple.lights[0].model);
  CHECK(light.position == Vec3f{1, 2, 3});
  const auto& rgb = std::get<SpectrumDescription::Rgb>(light.intensity.value);
  CHECK(rgb.value.x == near(1 / std::numbers::pi));
}

TEST_CASE("Nori: instances refer to groups of type ref by name") {
  const Description d = read_text(
      scene_with("<mesh type='ref' name='ball'><mesh type='sphere'/></mesh><mesh type='instance'>"
                 "<string name='ref' value='ball'/><transform name='toWorld'><scale value='2'/></transform></mesh>"));
  REQUIRE(d.groups.size() == 1);
  CHECK(d.groups[0].shapes.size() == 1);
  REQUIRE(d.instances.size() == 1);
  CHECK(d.instances[0].to_world[0] == 2);
  CHECK(contains(error_of_text(scene_with("<mesh type='instance'><string name='ref' value='bowl'/></mesh>")),
                 "'bowl', expected the name of a shape group"));
}

TEST_CASE("Nori: names used by course projects are read") {
  const Description d = read_text(scene_with(
      "<mesh type='sphere'><bsdf type='diffuse'><boolean name='use_cosine' value='true'/>"
      "<color name='albedo' value='.1 .2 .3'/></bsdf></mesh>"
      "<mesh type='sphere'><bsdf type='microfacet'><color name='albedo' value='.1 .2 .3'/>"
      "<float name='m_alpha' value='.3'/></bsdf></mesh>"
      "<mesh type='sphere'><bsdf type='disney'><color name='albedo' value='.1 .2 .3'/><texture name='normal' "
      "type='normaltexture'><string name='fileName' value='image.png'/></texture></bsdf></mesh>"
      "<mesh type='sphere'><bsdf type='transparent'/></mesh>"
      "<emitter type='envmap'><texture type='constant_color' name='albedo'><color name='value' value='.1 .2 .3'/>"
      "</texture></emitter><emitter type='spot'><color name='power' value='8 8 8'/>"
      "<float name='falloffstart' value='90'/><float name='totalwidth' value='60'/></emitter>"
      "<denoiser type='nl_means'><float name='k' value='1'/></denoiser>"));
  const auto model = [&](std::size_t shape) {
    return d.materials.at(static_cast<std::size_t>(d.shapes.at(shape).material.value())).model;
  };
  CHECK(std::get<float>(std::get<NoriMicrofacetDescription>(model(1)).alpha) == 0.3f);
  CHECK(std::holds_alternative<NormalMapDescription>(model(2)));
  CHECK(std::holds_alternative<NullDescription>(model(3)));
  REQUIRE(d.lights.size() == 2);
  CHECK(std::holds_alternative<ConstantLightDescription>(d.lights[0].model));
  const auto& spot = std::get<SpotLightDescription>(d.lights[1].model);
  CHECK(spot.beam_width == 60);
  // Power of a cone with a sharp edge: intensity times 2 pi (1 - cos 60).
  const auto& intensity = std::get<SpectrumDescription::Rgb>(spot.intensity.value);
  CHECK(intensity.value.x == near(8 / std::numbers::pi));
}

TEST_CASE("Nori: the power of a spot light includes its falloff") {
  const Description d =
      read_text(scene_with("<emitter type='spot'><color name='power' value='8'/><float name='falloffStart' value='20'/>"
                           "<float name='totalWidth' value='70'/></emitter>"));
  const auto& spot = std::get<SpotLightDescription>(d.lights.at(0).model);
  const auto& intensity = std::get<SpectrumDescription::Rgb>(spot.intensity.value);
  // A smooth step in the cosine from 70 to 20 degrees, integrated over directions.
  const double end = std::cos(70 * std::numbers::pi / 180), start = std::cos(20 * std::numbers::pi / 180);
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = std::clamp(((i + 0.5) / kSteps - end) / (start - end), 0.0, 1.0);
    sum += t * t * (3 - 2 * t) / kSteps;
  }
  CHECK(double{intensity.value.x} * 2 * std::numbers::pi * sum == near(8, 1e-3));
}

}  // namespace sheaf::test_nori
