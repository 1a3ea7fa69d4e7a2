// Animated transforms in scenes of Mitsuba and pbrt: keys, times, composition with the transforms of parents, the
// shutter, and errors.
#include "core/io/error.h"
#include "tests/support/capture.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/media_testing.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

namespace sheaf::test_motion_reading {

using namespace test;

namespace {

constexpr double kTolerance = 1e-6;

/// From +z to +z moved by 2 along x and turned by 90 degrees about z, from time 1 to time 3.
std::string animation(const std::string& name = "to_world") {
  return "<animation name='" + name +
         "'><transform time='3'><rotate z='1' angle='90'/><translate x='2'/></transform><transform time='1'/>"
         "</animation>";
}

/// Half way through animation().
Transform half_way() { return Transform::translate({1, 0, 0}) * Transform::rotate({0, 0, 1}, 45); }

double difference(const Transform& a, const Transform& b) {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) largest = std::max(largest, std::fabs(a.matrix().m[i][j] - b.matrix().m[i][j]));
  return largest;
}

Transform transform_of(const std::array<double, 12>& rows) {
  Matrix4 m;
  for (std::size_t i = 0; i < 12; ++i) m.m[i / 4][i % 4] = double{rows[i]};
  return Transform(m);
}

/// The motion, whose reference must be the transform of its object.
const AnimatedTransform& motion_of(const Description& d, std::optional<MotionId> id, const Transform& to_world) {
  REQUIRE(id.has_value());
  const AnimatedTransform& motion = d.motions.at(static_cast<std::size_t>(*id));
  CHECK(difference(motion.reference(), to_world) < kTolerance);
  return motion;
}

Description with_shape(const std::string& inside) {
  return read_text(mitsuba_scene("<shape type='cube'>" + inside + "</shape>"));
}
std::string shape_error(const std::string& inside) {
  return error_of_text(mitsuba_scene("<shape type='cube'>\n" + inside + "\n</shape>"));
}

Description with_light(const std::string& type, const std::string& inside) {
  return read_text(mitsuba_scene("<emitter type='" + type + "'>" + inside + "</emitter>"));
}

const std::string kMoving = R"(ActiveTransform EndTime
Translate 2 0 0 Rotate 90 0 0 1
ActiveTransform All
)";

}  // namespace

TEST_CASE("motion: an animation moves a shape of Mitsuba") {
  const Description d = with_shape(animation());
  const ShapeDescription& shape = d.shapes.at(0);
  CHECK(difference(shape.to_world, Transform()) < kTolerance);
  const AnimatedTransform& motion = motion_of(d, shape.motion, shape.to_world);
  CHECK(motion.key_times() == std::vector<double>{1, 3});
  CHECK(difference(motion.at(2), half_way()) < kTolerance);
  CHECK(difference(motion.at(9), Transform::translate({2, 0, 0}) * Transform::rotate({0, 0, 1}, 90)) < kTolerance);
}

TEST_CASE("motion: names of Mitsuba 0.6, references, and single keys") {
  const Description old =
      read_text(mitsuba_scene("<shape type='cube'>" + animation("toWorld") + "</shape>", "<sensor type='perspective'/>",
                              "<integrator type='path'/>", "0.6.0"));
  CHECK(difference(motion_of(old, old.shapes.at(0).motion, Transform()).at(2), half_way()) < kTolerance);
  std::string shared = animation("any");
  shared.replace(0, 10, "<animation id='way'");
  const Description d =
      read_text(mitsuba_scene(shared + "<shape type='cube'><ref id='way' name='to_world'/></shape>"
                                       "<shape type='sphere'><ref id='way' name='to_world'/></shape>"));
  for (const ShapeDescription& shape : d.shapes)
    CHECK(difference(motion_of(d, shape.motion, shape.to_world).at(2), half_way()) < kTolerance);
  const Description still =
      with_shape("<animation name='to_world'><transform time='7'><translate y='4'/></transform></animation>");
  CHECK_FALSE(still.shapes.at(0).motion.has_value());
  CHECK(still.motions.empty());
  CHECK(still.shapes[0].to_world.point({0, 0, 0}) == Vec3f{0, 4, 0});
}

TEST_CASE("motion: sensors move, and have a shutter") {
  const auto read = [](const std::string& inside, const std::string& type = "perspective") {
    return read_text(mitsuba_scene("", "<sensor type='" + type + "'>" + inside + "</sensor>"));
  };
  const Description d = read(animation() +
                             "<float name='shutterOpen' value='1'/><float name='shutter_close' value='2.5'/>"
                             "<float name='shutter_ramp' value='0.25'/>");
  CHECK(difference(motion_of(d, d.camera.motion, d.camera.to_world).at(2), half_way()) < kTolerance);
  CHECK(d.shutter.open == 1);
  CHECK(d.shutter.close == 2.5);
  CHECK(d.shutter.ramp == 0.25f);
  CHECK(d.notes.empty());
  const Description still = read("");
  CHECK_FALSE(still.camera.motion.has_value());
  CHECK(still.shutter.open == 0);
  CHECK(still.shutter.close == 0);
  // A shutter that opens for no time gives a note
  const Description closed = read(animation() +
                                  "<float name='shutter_open' value='2'/><float name='shutter_close' "
                                  "value='2'/>");
  REQUIRE(closed.notes.size() == 1);
  CHECK(contains(closed.notes[0], "moving objects rendered as at the time 2"));
  // A batch has one shutter
  const std::string child = "<sensor type='perspective'>" + animation() +
                            "<float name='shutter_close' value='3'/></sensor><sensor type='perspective'/>";
  const Description batch = read(child, "batch");
  CHECK(batch.shutter.close == 3);
  CHECK(batch.camera.motion.has_value());
  CHECK_FALSE(batch.more_cameras.at(0).motion.has_value());
  CHECK(contains(batch.notes.at(0), "different shutters"));
  CHECK(read(child + "<float name='shutter_close' value='5'/>", "batch").shutter.close == 5);
}

TEST_CASE("motion: a meter moves with its shape") {
  const Description d = read_text(mitsuba_scene("<shape type='rectangle'><boolean name='flip_normals' value='true'/>" +
                                                    animation() + "<sensor type='irradiancemeter'/></shape>",
                                                ""));
  const Transform rotated = Transform::scale({-1, 1, -1});
  CHECK(difference(motion_of(d, d.camera.motion, d.camera.to_world).at(2), half_way() * rotated) < kTolerance);
}

TEST_CASE("motion: lights of Mitsuba move") {
  const std::string image = "<string name='filename' value='image.png'/>";
  for (const auto& [type, inside] : {std::pair{std::string("point"), std::string()},
                                     {"spot", ""},
                                     {"directional", ""},
                                     {"projector", ""},
                                     {"collimated", ""},
                                     {"envmap", image}}) {
    CAPTURE_BINDING(type);
    const Description d = with_light(type, inside + animation());
    REQUIRE(d.lights.size() == 1);
    CHECK(difference(motion_of(d, d.lights[0].motion, Transform()).at(2), half_way()) < kTolerance);
    CHECK_FALSE(with_light(type, inside).lights.at(0).motion.has_value());
  }
  const Description point = with_light("point",
                                       "<animation name='to_world'><transform time='0'><translate x='3'/>"
                                       "</transform><transform time='1'><translate x='5'/></transform>"
                                       "</animation>");
  CHECK(std::get<PointLightDescription>(point.lights[0].model).position == Vec3f{3, 0, 0});
  CHECK_FALSE(with_light("constant", animation()).lights.at(0).motion.has_value());
}

TEST_CASE("motion: instances move, and shapes within groups") {
  const std::string group = "<shape type='shapegroup' id='g'><shape type='sphere'/><shape type='cube' id='moving'>" +
                            animation() + "</shape></shape>";
  const std::string outer =
      "<animation name='to_world'><transform time='0'/><transform time='4'><translate z='8'/></transform></animation>";
  const Description d = read_text(mitsuba_scene(group + "<shape type='instance'><ref id='g'/>" + outer +
                                                "</shape><shape type='instance'><ref id='g'/><transform "
                                                "name='to_world'><translate y='5'/></transform></shape>"));
  REQUIRE(d.groups.size() == 2);
  REQUIRE(d.groups[0].shapes.size() == 1);
  REQUIRE(d.groups[1].shapes.size() == 1);
  CHECK(d.groups[1].shapes[0].id == "moving");
  CHECK_FALSE(d.groups[1].shapes[0].motion.has_value());
  REQUIRE(d.instances.size() == 4);
  const auto motion = [&](std::size_t i) -> const AnimatedTransform& {
    return motion_of(d, d.instances[i].motion, transform_of(d.instances[i].to_world));
  };
  // The moving instance of the resting shape, and of the moving one
  CHECK(d.instances[0].group == 0);
  CHECK(difference(motion(0).at(2), Transform::translate({0, 0, 4})) < kTolerance);
  CHECK(d.instances[1].group == 1);
  CHECK(difference(motion(1).at(2), Transform::translate({0, 0, 4}) * half_way()) < kTolerance);
  CHECK(motion(1).key_times() == std::vector<double>{0, 1, 3, 4});
  // The resting instance
  CHECK_FALSE(d.instances[2].motion.has_value());
  CHECK(difference(motion(3).at(2), Transform::translate({0, 5, 0}) * half_way()) < kTolerance);
  // A product that is too extreme
  const std::string tiny = "<transform name='to_world'><scale value='1e-8'/></transform>";
  const std::string extreme = mitsuba_scene(
      "<shape type='shapegroup' id='g'><shape type='cube'><animation name='to_world'><transform time='0'/><transform "
      "time='1'><scale value='1e-8'/></transform></animation></shape></shape><shape type='instance'><ref id='g'/>" +
      tiny + "</shape>");
  CHECK(contains(error_of_text(extreme), "scene.xml:4: an instance of a shape that moves has a transform that is"));
  ReadOptions lenient;
  lenient.lenient = true;
  CHECK(read_text(extreme, lenient).instances.empty());
  // A group whose shapes all move has no instances
  const Description all = read_text(mitsuba_scene("<shape type='shapegroup' id='g'><shape type='cube'>" + animation() +
                                                  "</shape></shape><shape type='instance'><ref id='g'/></shape>"));
  REQUIRE(all.instances.size() == 1);
  CHECK(all.groups.at(all.instances[0].group).shapes.size() == 1);
}

TEST_CASE("motion: meshes with materials of their own stay in their space") {
  const TemporaryFolder folder;
  write_below(folder, "a.obj", "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write_below(folder, "a.mtl", "newmtl m\nKd 1 0 0\n");
  const std::string moved =
      "<animation name='to_world'><transform time='0'><translate x='7'/></transform><transform time='1'/></animation>";
  const Description d = read_scene(
      write_below(folder, "scene.xml",
                  mitsuba_scene("<shape type='obj'><string name='filename' value='a.obj'/>" + moved + "</shape>")));
  const ShapeDescription& shape = d.shapes.at(0);
  const Mesh& mesh = std::get<Mesh>(shape.geometry);
  CHECK(mesh.positions.at(0) == Vec3f{0, 0, 0});
  CHECK(difference(motion_of(d, shape.motion, shape.to_world).at(0.5), Transform::translate({3.5f, 0, 0})) <
        kTolerance);
}

TEST_CASE("motion: malformed animations are errors with file and line") {
  const auto check = [](const std::string& inside, const std::string& message) {
    CAPTURE(inside);
    const std::string error = shape_error(inside);
    CAPTURE(error);
    CHECK(contains(error, message));
    CHECK(error.starts_with("scene.xml:"));
  };
  const std::string begin = "<animation name='to_world'>", end = "</animation>";
  check(begin + end, "5: <animation> has no <transform>");
  check(begin + "\n<transform/>" + end, "6: <transform> needs an attribute 'time'");
  check(begin + "<transform time='0'/>\n<transform time='0'/>" + end, "6: a second <transform>");
  check(begin + "<transform time='now'/>" + end, "the time of <transform> is 'now', expected a number");
  check(begin + "<transform time='nan'/>" + end, "the time of <transform>");
  check(begin + "<transform time='1e999'/>" + end, "the time of <transform>");
  check(begin + "<transform time='0'/>\n<transform time='1'><scale x='-1'/></transform>" + end, "6: <transform> at");
  check(begin + "<transform time='0'/>\n<transform time='1'><scale x='0'/></transform>" + end, "scene.xml:6: ");
  check(begin + "<transform time='0' when='1'/>" + end, "<transform> has no attribute 'when'");
  check("<animation name='to_world' loop='1'><transform time='0'/></animation>", "<animation> has no attribute 'loop'");
  check(begin + "<translate x='1'/>" + end, "unexpected <translate> in <animation>");
  check("<transform name='to_world' time='0'/>", "5: <transform> has a 'time'");
  check(begin + "<transform time='0'/>" + end + begin + "<transform time='0'/>" + end, "is set twice");
  check("<animation name='radius'><transform time='0'/></animation>", "unknown property 'radius'");
  // Sensors
  const auto sensor = [](const std::string& inside) {
    return error_of_text(mitsuba_scene("", "<sensor type='perspective'>" + inside + "</sensor>"));
  };
  CHECK(contains(sensor("<float name='shutter_open' value='2'/>"), "'shutter_open' of sensor"));
  CHECK(contains(sensor("<float name='shutter_open' value='2'/><float name='shutter_close' value='1'/>"),
                 "makes the shutter open at 2 and close at 1"));
  CHECK(contains(sensor("<float name='shutter_ramp' value='0.6'/>"), "shutter_ramp"));
  CHECK(contains(error_of_text(mitsuba_scene(animation())), "is not referenced"));
}

TEST_CASE("motion: what cannot move is an error, and stands at its first key if lenient") {
  const std::string texture = "<bsdf type='diffuse'><texture name='reflectance' type='checkerboard'>" +
                              animation("to_uv") + "</texture></bsdf>";
  CHECK(contains(shape_error(texture), "is an <animation>, expected <transform>: it cannot move"));
  CHECK(
      contains(error_of_text(mitsuba_scene("<emitter type='sunsky'>" + animation() + "</emitter>")), "it cannot move"));
  ReadOptions lenient;
  lenient.lenient = true;
  const Description d = read_text(mitsuba_scene("<shape type='cube'>" + texture + "</shape>"), lenient);
  CHECK(d.shapes.size() == 1);
  CHECK(d.textures.size() == 1);
  REQUIRE(d.substitutions.size() >= 1);
  CHECK(contains(d.substitutions[0], "placed as at the first key"));
}

TEST_CASE("motion: an animation moves the grids of Mitsuba's media, about the center of their cube") {
  const TemporaryFolder folder;
  write_vol(folder / "a.vol", 2, 1, [](Vec3f, int) { return 1.0f; });
  const auto read = [&](const std::string& volume, const std::string& type = "heterogeneous") {
    return read_scene(write_below(folder, "scene.xml",
                                  mitsuba_scene("<shape type='cube'><medium name='interior' type='" + type + "'>" +
                                                volume + "</medium></shape>")));
  };
  const Transform about = Transform::translate({1, 0.5f, 0.5f}) * Transform::rotate({0, 0, 1}, 45) *
                          Transform::translate({-0.5f, -0.5f, -0.5f});
  const std::string file = "<string name='filename' value='a.vol'/>";
  const auto grid_of = [](const VolumeInput& input) { return std::get<GridVolumeDescription>(input); };
  Description d = read("<volume name='sigma_t' type='gridvolume'>" + file + animation() + "</volume>");
  const auto& pair = std::get<ExtinctionAlbedoDescription>(d.media.at(0).coefficients);
  CHECK(difference(motion_of(d, grid_of(pair.sigma_t).motion, Transform()).at(2), about) < kTolerance);
  // The box of a file lies relative to its origin
  d = read("<volume name='sigma_t' type='gridvolume'><boolean name='use_grid_bbox' value='true'/>" + file +
           animation() + "</volume>");
  const auto& boxed = std::get<ExtinctionAlbedoDescription>(d.media.at(0).coefficients);
  CHECK(difference(motion_of(d, grid_of(boxed.sigma_t).motion, Transform()).at(2), half_way()) < kTolerance);
  // The bounds of a constant
  d = read("<volume name='sigma_t' type='constvolume'><float name='value' value='1'/>" + animation() + "</volume>");
  REQUIRE(d.media.at(0).density.has_value());
  CHECK(difference(motion_of(d, d.media[0].density->motion, Transform()).at(2), about) < kTolerance);
  // Volume textures stand still
  const std::string texture =
      "<bsdf type='diffuse'><texture name='reflectance' type='volume'><volume name='volume' "
      "type='gridvolume'>" +
      file + animation() + "</volume></texture></bsdf>";
  const auto path = write_below(folder, "texture.xml", mitsuba_scene("<shape type='cube'>" + texture + "</shape>"));
  const std::string error = error_of(path);
  CHECK(contains(error, "it cannot move"));
}

TEST_CASE("motion: ActiveTransform of pbrt moves shapes, instances and cameras") {
  const Description d = read_pbrt_world("Translate 0 0 1\n" + kMoving + R"(Shape "sphere"
ObjectBegin "o" Translate 0 3 0 Shape "cylinder" ObjectEnd
ObjectInstance "o"
Identity Shape "sphere")",
                                        "TransformTimes 1 3\n" + kMoving + "Translate 0 5 0 Camera \"spherical\"");
  CHECK(d.shutter.open == 0);
  CHECK(d.shutter.close == 1);
  const Transform up = Transform::translate({0, 0, 1});
  const AnimatedTransform& shape = motion_of(d, d.shapes.at(0).motion, d.shapes[0].to_world);
  CHECK(shape.key_times() == std::vector<double>{1, 3});
  CHECK(difference(d.shapes[0].to_world, up) < kTolerance);
  CHECK(difference(shape.at(2), up * half_way()) < kTolerance);
  CHECK_FALSE(d.shapes.at(1).motion.has_value());
  // The transform of the instance comes after that of the object's shape, which includes the one at ObjectBegin
  REQUIRE(d.instances.size() == 1);
  const InstanceDescription& instance = d.instances[0];
  CHECK(d.groups.at(instance.group).shapes.size() == 1);
  const AnimatedTransform& both = motion_of(d, instance.motion, transform_of(instance.to_world));
  // Matrices are interpolated after the shift by 3, from (0, 3, 1) to (-1, 0, 1)
  const Transform inner = Transform::translate({-0.5f, 1.5f, 1}) * Transform::rotate({0, 0, 1}, 45);
  CHECK(difference(both.at(2), up * half_way() * inner) < kTolerance);
  // The camera's transform is the inverse of the current one
  const AnimatedTransform& camera = motion_of(d, d.camera.motion, d.camera.to_world);
  const AnimatedTransform inverse(
      {{1, Transform::translate({0, -5, 0})},
       {3, (Transform::translate({2, 0, 0}) * Transform::rotate({0, 0, 1}, 90) * Transform::translate({0, 5, 0}))
               .inverse()}});
  const Transform axes = Transform::translate({0, 5, 0}) * d.camera.to_world;
  for (const double time : {1.0, 1.7, 3.0}) CHECK(difference(camera.at(time), inverse.at(time) * axes) < kTolerance);
}

TEST_CASE("motion: attributes and coordinate systems of pbrt keep both transforms") {
  const Description d = read_pbrt_world("AttributeBegin\n" + kMoving + R"(CoordinateSystem "moving" AttributeEnd
Shape "sphere"
AttributeBegin ActiveTransform StartTime CoordSysTransform "moving" Shape "sphere" Translate 9 0 0 AttributeEnd
TransformBegin ActiveTransform EndTime TransformEnd Translate 1 0 0 Shape "sphere")");
  REQUIRE(d.shapes.size() == 3);
  CHECK_FALSE(d.shapes[0].motion.has_value());
  CHECK(difference(motion_of(d, d.shapes[1].motion, Transform()).at(0.5), half_way()) < kTolerance);
  CHECK_FALSE(d.shapes[2].motion.has_value());
  const Description start = read_pbrt_world("ActiveTransform StartTime Translate 6 0 0 Shape \"sphere\"");
  const AnimatedTransform& arrives = motion_of(start, start.shapes.at(0).motion, Transform::translate({6, 0, 0}));
  CHECK(difference(arrives.at(0.5), Transform::translate({3, 0, 0})) < kTolerance);
  CHECK(difference(arrives.at(1), Transform()) < kTolerance);
}

TEST_CASE("motion: shapes of pbrt with transforms of their own") {
  const Description d = read_pbrt_world(kMoving + R"(Shape "disk" "float radius" 3 "float height" 2
Shape "curve" "point3 P" [ 0 0 0  1 0 0  2 0 0  3 0 0 ] "float width" 2
Shape "curve" "point3 P" [ 0 1 0  1 1 0  2 1 0  3 1 0 ] "float width" 2)");
  REQUIRE(d.shapes.size() == 2);
  const Transform disk = Transform::translate({0, 0, 2}) * Transform::scale({3, 3, 1});
  CHECK(difference(motion_of(d, d.shapes[0].motion, disk).at(0.5), half_way() * disk) < kTolerance);
  CHECK(std::get<Curves>(d.shapes[1].geometry).starts.size() == 2);
  CHECK(difference(motion_of(d, d.shapes[1].motion, Transform()).at(0.5), half_way()) < kTolerance);
  CHECK(d.motions.size() == 2);
}

TEST_CASE("motion: lights and media of pbrt stand still, with a note") {
  const Description d = read_pbrt_world(kMoving + R"(LightSource "point" LightSource "point"
MakeNamedMedium "m" "string type" "uniformgrid" "integer nx" 1 "integer ny" 1 "integer nz" 1 "float density" [ 1 ])");
  REQUIRE(d.lights.size() == 2);
  CHECK_FALSE(d.lights[0].motion.has_value());
  CHECK(std::get<PointLightDescription>(d.lights[0].model).position == Vec3f{0, 0, 0});
  REQUIRE(d.notes.size() == 2);
  CHECK(contains(d.notes[0], "lights do not move, as in pbrt"));
  CHECK(contains(d.notes[1], "media do not move, as in pbrt"));
}

TEST_CASE("motion: errors of pbrt's directives") {
  CHECK(contains(error_of_pbrt_world("ActiveTransform Never"), "expected StartTime, EndTime or All"));
  CHECK(contains(error_of_pbrt_world("TransformTimes 0 1"), "TransformTimes after WorldBegin"));
  CHECK(contains(error_of_pbrt_world("", "TransformTimes 1 1"), "scene.pbrt:1: TransformTimes: the motion ends"));
  CHECK(contains(error_of_pbrt_world("", "TransformTimes 0 nan"), "two times"));
  CHECK(contains(error_of_pbrt_world("\nActiveTransform EndTime Scale -1 1 1 Shape \"sphere\""),
                 "scene.pbrt:4: motion between a transform and a mirrored one: not supported"));
  CHECK(contains(error_of_pbrt_world("ActiveTransform EndTime Scale 1e30 1 1 ObjectInstance \"o\" ObjectBegin \"o\" "
                                     "ObjectEnd"),
                 "singular or too extreme"));
}

TEST_CASE("motion: the shutter of the options replaces that of the scene") {
  ReadOptions options;
  options.shutter = ShutterDescription{1, 2, 0.5f};
  const Description d = read_text(mitsuba_scene("<shape type='cube'>" + animation() + "</shape>"), options);
  CHECK(d.shutter.open == 1);
  CHECK(d.shutter.close == 2);
  CHECK(d.shutter.ramp == 0.5f);
  CHECK(d.notes.empty());
}

TEST_CASE("motion: deformable shapes are meshes at several times") {
  const auto shape = [](const std::string& times, const std::string& inside) {
    return mitsuba_scene("<shape type='deformable'>\n<string name='times' value='" + times + "'/>" + inside +
                         "</shape>");
  };
  const std::string first = "<shape type='rectangle'><bsdf type='diffuse' id='paint'/></shape>";
  const std::string second =
      "<shape type='rectangle'><transform name='to_world'><translate z='2'/></transform></shape>";
  const Description d = read_text(shape("0.5, 2", first + second));
  REQUIRE(d.shapes.size() == 1);
  const auto& mesh = std::get<DeformingMesh>(d.shapes[0].geometry);
  REQUIRE(mesh.keys.size() == 2);
  CHECK(mesh.keys[0].time == 0.5);
  CHECK(mesh.keys[1].time == 2);
  CHECK(mesh.keys[1].to_shape.point({0, 0, 0}) == Vec3f{0, 0, 2});
  REQUIRE(d.shapes[0].material.has_value());
  CHECK(d.materials.at(static_cast<std::size_t>(*d.shapes[0].material)).id == "paint");
  CHECK(contains(error_of_text(shape("0 1 2", first + second)), "2 shapes for 3 times"));
  CHECK(contains(error_of_text(shape("0 0", first + second)), "not finite and increasing"));
  CHECK(contains(error_of_text(shape("0 1", first + "<shape type='sphere'/>")), "is not a mesh"));
  // Curves and hairs, which keep all points
  const TemporaryFile straight("straight.txt", "0 0 0\n0 0 1\n0 0 2\n0 0 2\n"),
      bent("bent.txt", "0 0 0\n0 0 1\n1 0 2\n2 0 2\n");
  const auto hair = [](const TemporaryFile& file, const std::string& inside) {
    return "<shape type='hair'><string name='filename' value='" + file.path().string() + "'/>" + inside + "</shape>";
  };
  const Description h =
      read_text(shape("0, 1", hair(straight, "<float name='radius' value='0.1'/>") +
                                  hair(bent, "<transform name='to_world'><scale value='2'/></transform>")));
  const auto& curves = std::get<DeformingCurves>(h.shapes.at(0).geometry);
  REQUIRE(curves.keys.size() == 2);
  CHECK(curves.keys[1].time == 1);
  for (const DeformingCurves::Key& key : curves.keys) CHECK(key.curves.points.size() == 4);
  CHECK(curves.keys[0].curves.points[0].radius == 0.1f);
  CHECK(curves.keys[1].curves.points[0].radius == 0.05f);
  CHECK(curves.keys[1].to_shape.point({1, 0, 0}) == Vec3f{2, 0, 0});
  CHECK(contains(error_of_text(shape("0 1", first + hair(bent, ""))), "expected only meshes or only curves"));
}

}  // namespace sheaf::test_motion_reading
