// Animations of COLLADA: the numbers of a transform's elements are interpolated, not the transform.
#include "scene/formats/model_import.h"
#include "tests/support/files/import_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_import_animations {

using namespace test;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// A sampler with its channel.
struct Track {
  std::string target;
  std::vector<double> times, values;
  std::vector<std::string> methods = {};  ///< interpolation of each key; empty: not in the file
  std::vector<double> in = {}, out = {};  ///< tangents
};

std::string animation(const std::string& id, const Track& track) {
  const std::size_t keys = track.times.size();
  std::string text = "<animation id='" + id + "'>" + collada_source(id + "-t", track.times, 1) +
                     collada_source(id + "-v", track.values, track.values.size() / keys);
  std::string inputs =
      "<input semantic='INPUT' source='#" + id + "-t'/><input semantic='OUTPUT' source='#" + id + "-v'/>";
  if (!track.methods.empty()) {
    std::string names;
    for (const std::string& name : track.methods) names += name + " ";
    text += "<source id='" + id + "-i'><Name_array id='" + id + "-ia' count='" + std::to_string(keys) + "'>" + names +
            "</Name_array><technique_common><accessor source='#" + id + "-ia' count='" + std::to_string(keys) +
            "' stride='1'><param name='INTERPOLATION' type='name'/></accessor></technique_common></source>";
    inputs += "<input semantic='INTERPOLATION' source='#" + id + "-i'/>";
  }
  if (!track.in.empty()) {
    text += collada_source(id + "-in", track.in, track.in.size() / keys) +
            collada_source(id + "-out", track.out, track.out.size() / keys);
    inputs += "<input semantic='IN_TANGENT' source='#" + id + "-in'/><input semantic='OUT_TANGENT' source='#" + id +
              "-out'/>";
  }
  return text + "<sampler id='" + id + "-s'>" + inputs + "</sampler><channel source='#" + id + "-s' target='" +
         track.target + "'/></animation>";
}

/// A square in a node 'n' with these elements of its transform.
std::string animated(const std::string& elements, const std::vector<Track>& tracks, const std::string& libraries = {}) {
  std::string animations;
  for (std::size_t i = 0; i < tracks.size(); ++i) animations += animation("a" + std::to_string(i), tracks[i]);
  return collada_file(collada_square(), "<node id='n'>" + elements + "<instance_geometry url='#square'/></node>",
                      "<library_animations>" + animations + "</library_animations>" + libraries);
}

/// The corner (0.5, 0.5, 0) of each square at a time.
std::vector<Vec3f> corners_at(const std::string& bytes, double time, const std::string& clip = {}) {
  ReadOptions options;
  options.moment.time = static_cast<float>(time);
  options.moment.animation = clip;
  options.surroundings.default_studio = Studio::kNone;
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "a.dae", bytes), options);
  std::vector<Vec3f> out;
  for (const ShapeDescription& shape : d.shapes)
    if (const auto* mesh = std::get_if<Mesh>(&shape.geometry); mesh != nullptr)
      for (const Vec3f p : mesh->positions)
        if (p.x > 0 && p.y > 0) out.push_back(shape.to_world.point(p));
  return out;
}
void check_corner(const std::string& bytes, double time, std::array<double, 3> expected) {
  CAPTURE(time);
  const std::vector<Vec3f> corners = corners_at(bytes, time);
  REQUIRE(corners.size() == 1);
  constexpr double kTolerance = 2e-4;  // coordinates are near 1
  CHECK(corners[0].x == within(expected[0], kTolerance));
  CHECK(corners[0].y == within(expected[1], kTolerance));
  CHECK(corners[0].z == within(expected[2], kTolerance));
}

/// The point (x, y) turned about z by an angle in degrees.
std::array<double, 3> rotated(double degrees, double x, double y) {
  const double c = std::cos(degrees * kPi / 180), s = std::sin(degrees * kPi / 180);
  return {c * x - s * y, s * x + c * y, 0};
}

/// The value at `time` of a Bezier curve with these control points, by a search for the parameter.
double bezier_at(std::array<double, 4> times, std::array<double, 4> values, double time) {
  const auto at = [](const std::array<double, 4>& p, double s) {
    return std::pow(1 - s, 3) * p[0] + 3 * std::pow(1 - s, 2) * s * p[1] + 3 * (1 - s) * s * s * p[2] +
           s * s * s * p[3];
  };
  double s = 0;
  while (s < 1 && at(times, s) < time) s += 1e-5;
  return at(values, s);
}

}  // namespace

TEST_CASE("import: an arm turns on an arc, for any angle between its keys") {
  if (!can_import_models()) return;
  for (const double angle : {90.0, 180.0, -270.0, 1080.0}) {
    CAPTURE(angle);
    const std::string file = animated("<rotate sid='r'>0 0 1 0</rotate><translate>2 0 0</translate>",
                                      {{"n/r.ANGLE", {0, 1}, {0, angle}, {"LINEAR", "LINEAR"}}});
    for (const double t : {0.0, 0.25, 0.5, 0.77, 1.0, 2.0})
      check_corner(file, t, rotated(angle * std::min(t, 1.0), 2.5, 0.5));
  }
}

TEST_CASE("import: several elements of a node move at once, each by its own keys") {
  if (!can_import_models()) return;
  const std::string file = animated(
      "<translate sid='t'>1 0 0</translate><rotate>0 0 1 90</rotate><rotate sid='r'>0 0 1 0</rotate><scale sid='s'>1 1 "
      "1</scale>",
      {{"n/t.Y", {0, 2}, {0, 4}, {"LINEAR", "LINEAR"}},
       {"n/t.X", {0.5, 1}, {1, 2}},
       {"n/r.ANGLE", {0, 1, 2}, {0, 90, 0}},
       {"n/s", {0, 2}, {1, 1, 1, 3, 2, 1}}});
  for (const double t : {0.0, 0.3, 0.75, 1.0, 1.6, 2.0}) {
    const double x = 1 + std::clamp((t - 0.5) / 0.5, 0.0, 1.0), y = 2 * t, angle = 90 + 90 * (t < 1 ? t : 2 - t);
    const std::array<double, 3> p = rotated(angle, 0.5 * (1 + t), 0.5 * (1 + t / 2));
    check_corner(file, t, {x + p[0], y + p[1], 0});
  }
}

TEST_CASE("import: a rotation about an axis that is not normalized, and one whose axis moves") {
  if (!can_import_models()) return;
  check_corner(animated("<rotate sid='r'>0 0 5 0</rotate><translate>2 0 0</translate>", {{"n/r(3)", {0, 1}, {0, 90}}}),
               0.5, rotated(45, 2.5, 0.5));
  // From z to x: at half of the time the axis is x + z
  const std::string file =
      animated("<rotate sid='r'>0 0 1 180</rotate>", {{"n/r", {0, 1}, {0, 0, 1, 180, 1, 0, 0, 180}}});
  // At a quarter, (1, 0, 3)
  check_corner(file, 0.25, {-0.4, -0.5, 0.3});
  check_corner(file, 0.5, {0, -0.5, 0.5});
}

TEST_CASE("import: interpolation by steps") {
  if (!can_import_models()) return;
  const std::string file = animated("<rotate sid='r'>0 0 1 0</rotate><translate sid='t'>2 0 0</translate>",
                                    {{"n/r.ANGLE", {0, 1, 2}, {0, 90, 120}, {"STEP", "LINEAR", "LINEAR"}},
                                     {"n/t.X", {0, 1}, {2, 3}, {"STEP", "STEP"}}});
  check_corner(file, 0.9, rotated(0, 2.5, 0.5));
  check_corner(file, 1, rotated(90, 3.5, 0.5));
  check_corner(file, 1.5, rotated(105, 3.5, 0.5));
}

TEST_CASE("import: Bezier and Hermite curves") {
  if (!can_import_models()) return;
  const std::string elements = "<rotate sid='r'>0 0 1 0</rotate><translate sid='t'>2 0 0</translate>";
  const std::vector<std::string> bezier = {"BEZIER", "BEZIER"};
  // Control points with times: slow at both ends
  const std::string eased =
      animated(elements, {{"n/r.ANGLE", {0, 1}, {0, 90}, bezier, {-0.5, 0, 0.4, 90}, {0.6, 0, 1.5, 90}}});
  // Control points without times
  const std::string uniform = animated(elements, {{"n/t.X", {0, 2}, {2, 4}, bezier, {0, 7}, {-1, 0}}});
  // Tangents of all components, with a time each
  const std::string vectors = animated(elements, {{"n/t",
                                                   {0, 1},
                                                   {2, 0, 0, 3, 1, 0},
                                                   bezier,
                                                   {0, 0, 0, 0, 0, 0, 0.7, 3, 0.2, 1, 0.6, 0},
                                                   {0.3, 2, 0.8, 0, 0.3, 0, 0, 0, 0, 0, 0, 0}}});
  // Hermite: the tangents of t^2 and of 2 t - t^2
  const std::string hermite =
      animated(elements, {{"n/t.X", {0, 1}, {0, 1}, {"HERMITE", "HERMITE"}, {0, 2}, {0, 0}},
                          {"n/t.Y", {0, 1}, {0, 1}, {"HERMITE", "HERMITE"}, {0, 0, 1, 0}, {1, 2, 0, 0}}});
  for (const double t : {0.1, 0.3, 0.5, 0.8}) {
    check_corner(eased, t, rotated(bezier_at({0, 0.6, 0.4, 1}, {0, 0, 90, 90}, t), 2.5, 0.5));
    check_corner(uniform, t, {0.5 + bezier_at({0, 2.0 / 3, 4.0 / 3, 2}, {2, -1, 7, 4}, t), 0.5, 0});
    check_corner(
        vectors, t,
        {0.5 + bezier_at({0, 0.3, 0.7, 1}, {2, 2, 3, 3}, t), 0.5 + bezier_at({0, 0.8, 0.2, 1}, {0, 0, 1, 1}, t), 0});
    check_corner(hermite, t, {0.5 + t * t, 0.5 + 2 * t - t * t, 0});
  }
}

TEST_CASE("import: matrices are interpolated as translation, rotation and scale") {
  if (!can_import_models()) return;
  const std::string file =
      animated("<translate>0 0 0</translate><matrix sid='m'>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>",
               {{"n/m", {0, 1}, {1, 0,  0, 2, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,  //
                                 0, -3, 0, 4, 3, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1}}});
  const std::array<double, 3> p = rotated(45, 1, 1);
  check_corner(file, 0.5, {3 + p[0], p[1], 0});
  // One number of a matrix: the column precedes the row
  check_corner(animated("<matrix sid='m'>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>", {{"n/m(3)(1)", {0, 1}, {0, 4}}}),
               0.5, {0.5, 2.5, 0});
}

TEST_CASE("import: divided nodes keep their children, and their instances move") {
  if (!can_import_models()) return;
  const std::string tracks =
      "<library_animations>" + animation("a", {"arm/r.ANGLE", {0, 1}, {0, 90}}) + "</library_animations>";
  const std::string arm =
      "<node id='arm'><rotate sid='r'>0 0 1 0</rotate><translate>2 0 0</translate><node id='hand'>"
      "<translate>1 0 0</translate><instance_geometry url='#square'/></node></node>";
  const std::string child = collada_file(collada_square(), arm, tracks);
  check_corner(child, 0.5, rotated(45, 3.5, 0.5));
  // A lamp in the hand of two instances
  const std::string lamp =
      "<library_lights><light id='l'><technique_common><point><color>1 1 "
      "1</color></point></technique_common></light></library_lights>";
  std::string lit = arm;
  lit.insert(lit.find("<instance_geometry"), "<instance_light url='#l'/>");
  const std::string instances = collada_file(
      collada_square(),
      "<node id='x'><translate>0 0 1</translate><instance_node url='#arm'/></node><node id='y'><translate>0 0 "
      "2</translate><instance_node url='#arm'/></node>",
      tracks + lamp + "<library_nodes>" + lit + "</library_nodes>");
  ReadOptions options;
  options.moment.time = 0.5f;
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "a.dae", instances), options);
  REQUIRE(d.lights.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3d at = std::get<PointLightDescription>(d.lights[i].model).position;
    CHECK(at.x == near(rotated(45, 3, 0)[0]));
    CHECK(at.y == near(rotated(45, 3, 0)[1]));
    CHECK(at.z == near(1.0 + static_cast<double>(i)));
  }
}

TEST_CASE("import: clips choose among the animations of a file") {
  if (!can_import_models()) return;
  const std::string file =
      animated("<translate sid='t'>0 0 0</translate>", {{"n/t.X", {0, 1}, {0, 1}}, {"n/t.Y", {0, 1}, {0, 2}}},
               "<library_animation_clips><animation_clip id='up'><instance_animation url='#a1'/></animation_clip>"
               "<animation_clip id='right'><instance_animation url='#a0'/></animation_clip></library_animation_clips>");
  check_corner(file, 1, {0.5, 2.5, 0});
  CHECK(corners_at(file, 1, "right").at(0).x == near(1.5));
  CHECK(corners_at(file, 1, "right").at(0).y == near(0.5));
}

TEST_CASE("import: damaged and other channels of COLLADA give a note") {
  if (!can_import_models()) return;
  const std::string transform = "<translate sid='t'>0 0 0</translate><lookat sid='l'>0 0 0 0 0 1 0 1 0</lookat>";
  for (const Track& track : {Track{"n/l", {0, 1}, {0, 1}},
                             {"n/t.ANGLE", {0, 1}, {0, 1}},
                             {"n/t(7)", {0, 1}, {0, 1}},
                             {"n/t.", {0, 1}, {0, 1}},
                             {"n/q.X", {0, 1}, {0, 1}},
                             {"q/t.X", {0, 1}, {0, 1}},
                             {"n", {0, 1}, {0, 1}},
                             {"", {0, 1}, {0, 1}},
                             {"n/t.X", {1, 0}, {0, 1}},
                             {"n/t.X", {0, NAN}, {0, 1}},
                             {"n/t.X", {0, 1}, {0, INFINITY}},
                             {"n/t(", {0, 1}, {0, 1}},
                             {"n/t(0)(", {0, 1}, {0, 1}}}) {
    CAPTURE(track.target);
    const TemporaryFolder folder;
    const Description d = read_scene(write_below(folder, "a.dae", animated(transform, {track})));
    REQUIRE(d.notes.size() == 1);
    CHECK(contains(d.notes[0], "1 animation channels do not move a node, or are damaged (ignored)"));
  }
}

}  // namespace sheaf::test_import_animations
