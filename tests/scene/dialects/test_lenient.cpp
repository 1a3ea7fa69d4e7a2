// Lenient reading: replacements, a warning for each, and strict reading of the same files as errors.
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_lenient {

using namespace test;

namespace {

ReadOptions leniently() {
  ReadOptions options;
  options.lenient = true;
  return options;
}

/// Reads leniently a text that is an error in strict mode.
Description read_broken(const std::string& text) {
  CAPTURE(text);
  CHECK_FALSE(error_of_text(text).empty());
  return read_text(text, leniently());
}

bool says(const Description& d, const char* what) {
  const auto& all = d.substitutions;
  return std::any_of(all.begin(), all.end(), [&](const std::string& text) { return contains(text, what); });
}

const MaterialDescription& material_of(const Description& d, std::size_t shape) {
  return d.materials.at(static_cast<std::size_t>(d.shapes.at(shape).material.value()));
}

std::string sphere_of(const std::string& bsdf) { return mitsuba_scene("<shape type='sphere'>" + bsdf + "</shape>"); }

}  // namespace

TEST_CASE("lenient: a valid scene is read without warnings") {
  const std::string text = mitsuba_scene("<shape type='cube'><bsdf type='diffuse'/></shape><emitter type='constant'/>");
  const Description d = read_text(text, leniently());
  CHECK(d.substitutions.empty());
  CHECK(d.shapes.size() == 1);
  CHECK(d.lights.size() == 1);
}

TEST_CASE("lenient: invalid properties are dropped one by one and the object is kept") {
  const Description d =
      read_broken(sphere_of("<bsdf type='roughplastic'><float name='alpha' value='x'/><float "
                            "name='gloss' value='1'/><float name='int_ior' value='1.7'/></bsdf>"
                            "<float name='radius' value='-1'/><point name='center' value='1 2 3'/>"));
  REQUIRE(d.shapes.size() == 1);
  const auto& sphere = std::get<SphereShape>(d.shapes[0].geometry);
  CHECK(sphere.radius == 1);
  CHECK(sphere.center == Vec3f{1, 2, 3});
  CHECK(std::get<PlasticDescription>(material_of(d, 0).model).int_ior == 1.7f);
  CHECK(says(d, "scene.xml:4: property 'alpha'"));
  CHECK(says(d, "unknown property 'gloss' of bsdf 'roughplastic'"));
  CHECK(says(d, "expected a positive number (ignored)"));
}

TEST_CASE("lenient: the last of duplicate properties counts") {
  const Description d = read_broken(
      mitsuba_scene("<shape type='sphere'><float name='radius' value='2'/><float name='radius' value='3'/></shape>"));
  CHECK(std::get<SphereShape>(d.shapes.at(0).geometry).radius == 3);
  CHECK(says(d, "set twice, expected once (the last one is used)"));
  const Description e =
      read_broken(mitsuba_scene("<shape type='sphere'><float name='radius' value='2' value='5'/>text"
                                "</shape>"));
  CHECK(std::get<SphereShape>(e.shapes.at(0).geometry).radius == 5);
  CHECK(says(e, "unexpected text 'text' inside <shape> (ignored)"));
}

TEST_CASE("lenient: unknown materials are replaced by the most similar ones") {
  const auto model = [](const std::string& bsdf) { return material_of(read_broken(sphere_of(bsdf)), 0).model; };
  CHECK(
      std::get<DielectricDescription>(model("<bsdf type='glass'><float name='int_ior' value='1.7'/></bsdf>")).int_ior ==
      1.7f);
  CHECK(std::get<DielectricDescription>(model("<bsdf type='myglass'><float name='alpha' value='.2'/></bsdf>"))
            .roughness.has_value());
  CHECK(std::holds_alternative<PrincipledDescription>(
      model("<bsdf type='foo'><rgb name='baseColor' value='1 0 0'/><float name='roughness' value='.3'/></bsdf>")));
  CHECK(std::get<ConductorDescription>(model("<bsdf type='brushedmetal'><float name='alpha' value='.2'/></bsdf>"))
            .roughness.has_value());
  CHECK(std::holds_alternative<NullDescription>(model("<bsdf type='transparentfilm'/>")));
  // The first color, or the nested material.
  const auto diffuse = std::get<DiffuseDescription>(
      model("<bsdf type='cloth'><float name='fuzz' value='1'/><rgb name='tint' value='.1 .2 .3'/></bsdf>"));
  const auto& rgb = std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(diffuse.reflectance).value);
  CHECK(rgb.value == Vec3f{0.1f, 0.2f, 0.3f});
  CHECK(std::holds_alternative<PlasticDescription>(
      model("<bsdf type='weathered'><rgb name='dirt' value='1 0 0'/><bsdf type='plastic'/></bsdf>")));
}

TEST_CASE("lenient: unreadable optional elements are dropped") {
  const Description d = read_broken(mitsuba_scene(R"(
    <shape type='obj'><string name='filename' value='gone.obj'/></shape>
    <shape type='torus'/>
    <mode type='final'/>
    <emitter type='laser'/>
    <emitter type='envmap'><string name='filename' value='gone.exr'/></emitter>
    <shape type='sphere'><bsdf type='diffuse'>
      <texture name='reflectance' type='bitmap'><string name='filename' value='gone.png'/></texture></bsdf>
      <medium name='interior' type='nonlinear'/><emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>
    <shape type='cube'><ref id='nothing'/><transform name='to_world'><shear value='1'/></transform></shape>
    <include filename='gone.xml'/>)"));
  REQUIRE(d.shapes.size() == 2);
  CHECK(d.lights.empty());
  CHECK(d.shapes[0].radiance.has_value());
  CHECK_FALSE(d.shapes[0].interior.has_value());
  const auto& diffuse = std::get<DiffuseDescription>(material_of(d, 0).model);
  CHECK(std::holds_alternative<SpectrumDescription>(diffuse.reflectance));
  for (const char* what : {"gone.obj", "unknown shape plugin 'torus'", "<mode>", "laser", "gone.exr", "gone.png",
                           "nonlinear", "no object has the id 'nothing'", "shear", "gone.xml"}) {
    CAPTURE(what);
    CHECK(says(d, what));
  }
}

TEST_CASE("lenient: unknown cameras and films and samplers and integrators are replaced") {
  const Description d = read_broken(mitsuba_scene(
      "<shape type='cube'/>",
      "<sensor type='fisheye'><float name='fov' value='70'/><film type='polaroid'><integer name='width' value='32'/>"
      "<rfilter type='blurry'/></film><sampler type='dice'><integer name='sample_count' "
      "value='16'/></sampler></sensor>",
      "<integrator type='magic'><integer name='max_depth' value='7'/><float name='wand' value='1'/></integrator>"));
  CHECK(d.camera.fov == 70);
  CHECK(d.film.width == 32);
  CHECK(d.sampler.sample_count == 16);
  CHECK(d.integrator.kind == IntegratorKind::kPath);
  CHECK(d.integrator.max_depth == 7);
  for (const char* what :
       {"rendered as 'perspective'", "rendered as 'hdrfilm'", "rendered as 'gaussian'", "rendered as 'sobol'",
        "rendered as 'path'", "the scene has no light (rendered with a white sky)"})
    CHECK(says(d, what));
}

TEST_CASE("lenient: a scene without a camera gets one that shows all of it") {
  const Description d = read_broken(
      "<scene version='3.0.0'><shape type='sphere'><point name='center' value='10 20 30'/>"
      "<float name='radius' value='2'/></shape><emitter type='constant'/></scene>");
  CHECK(says(d, "the scene has no <sensor>"));
  const Vec3f eye = d.camera.to_world.point({0, 0, 0}), forward = d.camera.to_world.vector({0, 0, 1});
  const Vec3f to_center = Vec3f{10, 20, 30} - eye;
  CHECK(dot(normalize(forward), normalize(to_center)) == near(1, 1e-5));
  CHECK(length(to_center) > 4);
  CHECK(length(to_center) < 40);
}

TEST_CASE("lenient: cyclic references are cut") {
  const Description d = read_broken(
      mitsuba_scene("<bsdf type='twosided' id='a'><ref id='b'/></bsdf><bsdf type='twosided' id='b'><ref id='a'/></bsdf>"
                    "<shape type='sphere'><ref id='a'/></shape>"));
  CHECK(d.shapes.size() == 1);
}

TEST_CASE("lenient: files that turn out to be malformed are dropped") {
  const TemporaryFolder folder;
  write_below(folder, "bad.obj", "v 0 0 0\nf 1 2 3\n");
  write_below(folder, "bad.png", "no image");
  write_below(folder, "bad.exr", "no image");
  const auto path = write_below(folder, "scene.xml", mitsuba_scene(R"(
    <shape type='obj'><string name='filename' value='bad.obj'/></shape>
    <emitter type='envmap'><string name='filename' value='bad.exr'/></emitter>
    <shape type='sphere'><bsdf type='diffuse'>
      <texture name='reflectance' type='bitmap'><string name='filename' value='bad.png'/></texture></bsdf></shape>
    <emitter type='constant'/>)"));
  Description d = read_scene(path, leniently());
  CHECK_THROWS_AS(compile_scene(d), SceneError);
  ErrorSink errors(true, d.substitutions);
  CompileOptions options;
  options.errors = &errors;
  const std::unique_ptr<Scene> scene = compile_scene(d, options);
  CHECK(scene->info().shapes == 1);
  CHECK(scene->info().lights == 1);
  for (const char* what : {"bad.obj", "bad.exr", "bad.png"}) CHECK(says(d, what));
  CHECK(d.substitutions.size() == 3);
}

TEST_CASE("lenient: Nori scenes are read leniently") {
  const Description d = read_broken(R"(<scene><camera type='fisheye'><float name='fov' value='50'/></camera>
    <integrator type='magic'/><sampler type='dice'/><wizard/>
    <mesh type='sphere'><bsdf type='velvet'><color name='albedo' value='1,0,0'/></bsdf>
      <emitter type='area'><color name='radiance' value='1,1,1'/></emitter></mesh>
    <mesh type='obj'><string name='filename' value='gone.obj'/></mesh></scene>)");
  CHECK(d.camera.fov == 50);
  CHECK(d.shapes.size() == 1);
  CHECK(d.integrator.kind == IntegratorKind::kPath);
  for (const char* what : {"fisheye", "magic", "dice", "<wizard>", "velvet", "gone.obj"}) CHECK(says(d, what));
}

}  // namespace sheaf::test_lenient
