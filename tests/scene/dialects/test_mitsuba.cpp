// Scenes of Mitsuba: defaults, shapes, emitters, references, transforms, old names, and agreement with the Nori
// dialect.
#include "tests/support/capture.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <string>
#include <utility>

namespace sheaf::test_mitsuba {

using namespace test;

namespace {

ShapeDescription shape_of(const std::string& text) { return read_text(mitsuba_scene(text)).shapes.at(0); }

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
  CHECK(d.camera.fov == near(46.7930));
  CHECK(d.notes.empty());
}

TEST_CASE("Mitsuba: shapes have the documented parameters") {
  const ShapeDescription obj = shape_of(
      "<shape type='obj'><string name='filename' value='mesh.obj'/><boolean name='faceNormals' value='true'/>"
      "<boolean name='flip_normals' value='true'/><boolean name='collapse' value='true'/></shape>");
  CHECK(std::get<MeshFileShape>(obj.geometry).format == "obj");
  CHECK(std::get<MeshFileShape>(obj.geometry).flip_tex_coords);
  CHECK(obj.face_normals);
  CHECK(obj.flip_normals);
  const ShapeDescription ply = shape_of("<shape type='ply'><string name='filename' value='mesh.ply'/></shape>");
  CHECK(std::get<MeshFileShape>(ply.geometry).format == "ply");
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
        "conductor constant 0x1p+0 constant 0x1p-1 rgb 0x1p+0 0x1p+1 0x1p+2\n");
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
  const ShapeDescription lamp = shape_of("<shape type='sphere'><emitter type='area'/></shape>");
  CHECK(dump(lamp.radiance.value()) == "constant 0x1p+0");
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
  CHECK(rotated.x == near(1));
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
