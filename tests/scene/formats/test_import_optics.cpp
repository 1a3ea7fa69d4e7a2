// Cameras, lights and visibility of imported models.
#include "scene/formats/model_import.h"
#include "tests/support/files/import_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_import_optics {

using namespace test;

namespace {

constexpr double kPi = 3.14159265358979323846;

Description read_as(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  ReadOptions options;
  options.surroundings.default_studio = Studio::kNone;
  return read_scene(write_below(folder, name, bytes), options);
}
/// The file in its text form and both binary forms.
std::vector<Description> read_all(const FbxFile& file) {
  std::vector<Description> out;
  for (const std::string& bytes : {file.text(), file.binary(7400), file.binary(7500)})
    out.push_back(read_as("a.fbx", bytes));
  return out;
}

FbxBlock number(const char* name, double value) { return fbx_property(name, "Number", value); }
FbxBlock choice(const char* name, int value) { return fbx_property(name, "enum", std::int32_t{value}); }

/// Tangents of half the field of view along x and y.
struct View {
  double x, y;
};
View view_of(const Description& d) {
  REQUIRE(d.camera.fov_axis == CameraDescription::FovAxis::kY);
  const double y = std::tan(double(d.camera.fov) * kPi / 360);
  return {y * d.film.width / d.film.height, y};
}
double tan_half(double degrees) { return std::tan(degrees * kPi / 360); }

/// Whether the model's own camera is used; the automatic one is elsewhere.
bool has_own_camera(const Description& d) {
  const Vec3f at = d.camera.to_world.point({0, 0, 0});
  return std::abs(at.x) < 1e-5f && std::abs(at.y) < 1e-5f && std::abs(at.z - 5) < 1e-4f;
}

FbxFile fbx_with_camera(std::vector<FbxBlock> properties) {
  FbxFile file;
  file.add_square("square", {});
  file.add_attribute("cam", "Camera", std::move(properties),
                     {fbx_property("Lcl Translation", "Lcl Translation", {0, 0, 500}),
                      fbx_property("Lcl Rotation", "Lcl Rotation", {0, 90, 0})});
  return file;
}

std::string dae_with_camera(const std::string& optics, const std::string& attributes = "id='cam'") {
  return collada_file(collada_square(),
                      "<node id='n'><instance_geometry url='#square'/></node><node " + attributes +
                          "><translate>0 0 5</translate><instance_camera url='#c'/></node>",
                      "<library_cameras><camera id='c'><optics><technique_common>" + optics +
                          "</technique_common></optics></camera></library_cameras>");
}
Description read_camera(const std::string& optics) { return read_as("a.dae", dae_with_camera(optics)); }

/// The file with a spot light, and what is read of it.
SpotLightDescription dae_spot(const std::string& spot, const std::string& extra = {}) {
  const Description d =
      read_as("a.dae", collada_file(collada_square(),
                                    "<node id='n'><instance_geometry url='#square'/></node><node><translate>0 0 "
                                    "3</translate><instance_light url='#l'/></node>",
                                    "<library_lights><light id='l'><technique_common><spot><color>1 0.5 0.25</color>" +
                                        spot + "</spot></technique_common>" + extra + "</light></library_lights>"));
  REQUIRE(d.lights.size() == 1);
  CHECK(d.notes.empty());
  return std::get<SpotLightDescription>(d.lights[0].model);
}

/// The integral of f over the cosines in [from, 1].
template <class F> double integral(double from, F f) {
  constexpr int kSteps = 20'000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += f(from + (1 - from) * (i + 0.5) / kSteps);
  return sum * (1 - from) / kSteps;
}

/// The x coordinates (m) of the centers of all shapes, sorted.
std::vector<double> heights(const Description& d) {
  std::vector<double> out;
  for (const ShapeDescription& shape : d.shapes)
    if (const auto* mesh = std::get_if<Mesh>(&shape.geometry); mesh != nullptr) {
      double sum = 0;
      for (const Vec3f p : mesh->positions) sum += shape.to_world.point(p).x;
      out.push_back(std::round(sum / static_cast<double>(mesh->positions.size())));
    }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

TEST_CASE("import: FBX cameras by aperture mode, focal length and film") {
  if (!can_import_models()) return;
  struct Case {
    std::vector<FbxBlock> properties;
    View expected;
  };
  const std::vector<Case> cases = {
      // Focal length and film, as Maya writes them: 35 mm over 2 x 17.5 mm
      {{number("FocalLength", 17.5), number("FilmWidth", 35 / 25.4), number("FilmHeight", 35 / 25.4),
        choice("ApertureMode", 3)},
       {1, 1}},
      {{number("FocalLength", 50), number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4)}, {0.36, 0.24}},
      // The gate: an image of 2 : 1 with a film of 36 x 24
      {{number("FocalLength", 50), number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4),
        choice("ApertureMode", 3), number("AspectWidth", 2000), number("AspectHeight", 1000), choice("GateFit", 1)},
       {0.48, 0.24}},
      {{number("FocalLength", 50), number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4),
        choice("ApertureMode", 3), number("AspectWidth", 2000), number("AspectHeight", 1000), choice("GateFit", 2)},
       {0.36, 0.18}},
      {{number("FocalLength", 50), number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4),
        choice("ApertureMode", 3), number("AspectWidth", 2000), number("AspectHeight", 1000), choice("GateFit", 3)},
       {0.36, 0.18}},
      {{number("FocalLength", 50), number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4),
        choice("ApertureMode", 3), number("AspectWidth", 2000), number("AspectHeight", 1000), choice("GateFit", 4)},
       {0.48, 0.24}},
      // Angles
      {{number("FieldOfView", 90), choice("ApertureMode", 1)}, {1, 1}},
      {{number("FieldOfView", 90), choice("ApertureMode", 1), number("AspectWidth", 3), number("AspectHeight", 2)},
       {1, 2.0 / 3}},
      {{number("FieldOfView", 90), choice("ApertureMode", 2), number("AspectWidth", 3), number("AspectHeight", 2)},
       {1.5, 1}},
      {{number("FieldOfViewX", 60), number("FieldOfViewY", 40), choice("ApertureMode", 0)},
       {tan_half(60), tan_half(40)}},
      {{number("FieldOfViewX", 60), number("FieldOfViewY", 40)}, {tan_half(60), tan_half(40)}},
      // The mode decides where a file has several
      {{number("FieldOfView", 90), number("FieldOfViewX", 60), number("FieldOfViewY", 40), number("FocalLength", 50),
        number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4), choice("ApertureMode", 0)},
       {tan_half(60), tan_half(40)}},
      {{number("FieldOfView", 90), number("FieldOfViewX", 60), number("FieldOfViewY", 40), number("FocalLength", 50),
        number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4), choice("ApertureMode", 3)},
       {0.36, 0.24}},
      // A mode without its data
      {{number("FieldOfViewX", 60), number("FieldOfViewY", 40), choice("ApertureMode", 1)},
       {tan_half(60), tan_half(40)}}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    CAPTURE(i);
    for (const Description& d : i == 0 ? read_all(fbx_with_camera(cases[i].properties))
                                       : std::vector{read_as("a.fbx", fbx_with_camera(cases[i].properties).text())}) {
      CHECK(d.notes.empty());
      CHECK(has_own_camera(d));
      CHECK(d.camera.to_world.vector({0, 0, 1}).z == near(-1));
      CHECK(view_of(d).x == near(cases[i].expected.x, 2e-3));  // pixels are whole
      CHECK(view_of(d).y == near(cases[i].expected.y, 1e-4));
    }
  }
}

TEST_CASE("import: FBX cameras take what they lack from the template of the file") {
  if (!can_import_models()) return;
  FbxFile file = fbx_with_camera({choice("ApertureMode", 2)});
  file.add_template("NodeAttribute", "FbxCamera", {number("FieldOfView", 50), choice("ApertureMode", 1)});
  for (const Description& d : read_all(file)) CHECK(view_of(d).y == near(tan_half(50), 1e-4));
  // A focal length of its own counts more than the angle of the template
  FbxFile focal = fbx_with_camera({number("FocalLength", 50)});
  focal.add_template("NodeAttribute", "FbxCamera",
                     {number("FieldOfView", 25), choice("ApertureMode", 2), number("FocalLength", 35),
                      number("FilmWidth", 36 / 25.4), number("FilmHeight", 24 / 25.4)});
  for (const Description& d : read_all(focal)) CHECK(view_of(d).y == near(0.24, 1e-4));
}

TEST_CASE("import: orthographic cameras") {
  if (!can_import_models()) return;
  const auto half_width = [](const Description& d) {
    CHECK(d.camera.projection == CameraDescription::Projection::kOrthographic);
    CHECK(has_own_camera(d));
    return double{length(d.camera.to_world.vector({1, 0, 0}))};
  };
  // 30 units at a zoom of 1
  for (const Description& d : read_all(fbx_with_camera({choice("CameraProjectionType", 1), number("OrthoZoom", 20)})))
    CHECK(half_width(d) == near(3, 1e-4));
  const Description wide = read_as("a.fbx", fbx_with_camera({choice("CameraProjectionType", 1), number("OrthoZoom", 20),
                                                             number("AspectWidth", 2), number("AspectHeight", 1)})
                                                .text());
  CHECK(half_width(wide) == near(3, 1e-4));
  CHECK(wide.film.width == 2 * wide.film.height);

  const auto view = [](const std::string& inside) {
    return read_camera("<orthographic>" + inside + "</orthographic>");
  };
  CHECK(half_width(view("<xmag>3</xmag><ymag>2</ymag>")) == near(3));
  CHECK(view("<xmag>3</xmag><ymag>2</ymag>").film.width == 900);
  CHECK(half_width(view("<ymag>2</ymag><aspect_ratio>1.5</aspect_ratio>")) == near(3));
  CHECK(half_width(view("<xmag>3</xmag><aspect_ratio>1.5</aspect_ratio>")) == near(3));
  CHECK(half_width(view("<ymag>2</ymag>")) == near(2));
  // In the unit of the file
  std::string inches = dae_with_camera("<orthographic><xmag>3</xmag></orthographic>");
  inches.replace(inches.find("meter='1'"), 9, "meter='0.5'");
  CHECK(length(read_as("a.dae", inches).camera.to_world.vector({1, 0, 0})) == near(1.5));
}

TEST_CASE("import: COLLADA cameras by any of their numbers") {
  if (!can_import_models()) return;
  const auto view = [](const std::string& inside) {
    const Description d = read_camera("<perspective>" + inside + "</perspective>");
    CHECK(d.notes.empty());
    CHECK(has_own_camera(d));
    return view_of(d);
  };
  const std::string x = "<xfov>60</xfov>", y = "<yfov>40</yfov>", aspect = "<aspect_ratio>1.25</aspect_ratio>";
  CHECK(view(x).x == near(tan_half(60), 1e-4));
  CHECK(view(y).y == near(tan_half(40), 1e-4));
  CHECK(view(x + aspect).x == near(tan_half(60), 1e-4));
  CHECK(view(x + aspect).y == near(tan_half(60) / 1.25, 1e-4));
  CHECK(view(y + aspect).x == near(tan_half(40) * 1.25, 1e-4));
  CHECK(view(y + aspect).y == near(tan_half(40), 1e-4));
  CHECK(view(x + y).x == near(tan_half(60), 2e-3));  // pixels are whole
  CHECK(view(x + y).y == near(tan_half(40), 1e-4));
}

TEST_CASE("import: cameras without a view are replaced with a note, and those without a name are used") {
  if (!can_import_models()) return;
  const auto check_replaced = [](const Description& d) {
    CHECK(!has_own_camera(d));
    CHECK(d.camera.fov > 5);
    REQUIRE(d.notes.size() == 1);
    CHECK(contains(d.notes[0], "camera 'cam' has no field of view (ignored)"));
  };
  for (const char* optics :
       {"<perspective><aspect_ratio>1</aspect_ratio></perspective>", "<perspective/>", "",
        "<perspective><yfov>0</yfov></perspective>", "<perspective><xfov>180</xfov></perspective>",
        "<orthographic><aspect_ratio>1</aspect_ratio></orthographic>", "<orthographic><xmag>nan</xmag></orthographic>"})
    check_replaced(read_camera(optics));
  for (const Description& d : read_all(fbx_with_camera({number("AspectWidth", 1), number("AspectHeight", 1)})))
    check_replaced(d);
  check_replaced(read_as("a.fbx", fbx_with_camera({number("FieldOfView", 0), number("FocalLength", -1)}).text()));

  const std::string perspective = "<perspective><yfov>90</yfov></perspective>";
  for (const char* attributes : {"", "name='cam'", "sid='cam'", "id='' name=''", "name='n'"})
    CHECK(has_own_camera(read_as("a.dae", dae_with_camera(perspective, attributes))));
  FbxFile unnamed;
  unnamed.add_square("", {});
  unnamed.add_attribute("", "Camera", {number("FieldOfView", 90), choice("ApertureMode", 1)},
                        {fbx_property("Lcl Translation", "Lcl Translation", {0, 0, 500}),
                         fbx_property("Lcl Rotation", "Lcl Rotation", {0, 90, 0})});
  for (const Description& d : read_all(unnamed)) {
    CHECK(has_own_camera(d));
    CHECK(view_of(d).y == near(1, 1e-4));
  }
}

TEST_CASE("import: the cone of a COLLADA spot light ends at half of its falloff angle") {
  if (!can_import_models()) return;
  const SpotLightDescription sharp = dae_spot("<falloff_angle>40</falloff_angle>");
  CHECK(sharp.cutoff_angle == near(20));
  CHECK(sharp.beam_width == near(20, 1e-3));
  CHECK(dae_spot("<falloff_angle>90</falloff_angle><falloff_exponent>0</falloff_exponent>").cutoff_angle == near(45));
  CHECK(dae_spot("").cutoff_angle == near(90));
  CHECK(dae_spot("<falloff_angle>1e9</falloff_angle>").cutoff_angle == near(90));
  // An extension of FCollada: the falloff angle is that of the inner cone
  const SpotLightDescription soft =
      dae_spot("<falloff_angle>40</falloff_angle>",
               "<extra><technique profile='FCOLLADA'><outer_cone>60</outer_cone></technique></extra>");
  CHECK(soft.cutoff_angle == near(30));
  CHECK(soft.beam_width == near(20));
}

TEST_CASE("import: a COLLADA spot light keeps the flux of its falloff exponent inside its cone") {
  if (!can_import_models()) return;
  for (const double angle : {20.0, 60.0, 120.0})
    for (const double exponent : {0.15, 1.0, 4.0, 20.0, 128.0}) {
      CAPTURE(angle);
      CAPTURE(exponent);
      const SpotLightDescription spot =
          dae_spot("<falloff_angle>" + std::to_string(angle) + "</falloff_angle><falloff_exponent>" +
                   std::to_string(exponent) + "</falloff_exponent>");
      CHECK(spot.falloff == SpotLightDescription::Falloff::kSmooth);
      CHECK(spot.cutoff_angle <= angle / 2 * (1 + 1e-5));
      const double outer = std::cos(spot.cutoff_angle * kPi / 180), inner = std::cos(spot.beam_width * kPi / 180);
      const double flux = integral(outer, [&](double cosine) {
        const double t = inner > outer ? std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0) : 1.0;
        return t * t * (3 - 2 * t);
      });
      CHECK(
          flux ==
          near(integral(std::cos(angle * kPi / 360), [&](double cosine) { return std::pow(cosine, exponent); }), 1e-3));
    }
}

TEST_CASE("import: the angles of FBX spot lights are those of whole cones") {
  if (!can_import_models()) return;
  FbxFile file;
  file.add_square("square", {});
  file.add_attribute("lamp", "Light",
                     {choice("LightType", 2), number("InnerAngle", 20), number("OuterAngle", 60),
                      number("Intensity", 200), fbx_property("Color", "Color", {1, 0.5, 0.25})},
                     {fbx_property("Lcl Translation", "Lcl Translation", {0, 300, 0})});
  // An inner angle beyond the outer one, and two lights of one name
  file.add_attribute("lamp", "Light", {choice("LightType", 2), number("InnerAngle", 80), number("OuterAngle", 60)},
                     {fbx_property("Lcl Translation", "Lcl Translation", {0, 100, 0})});
  for (const Description& d : read_all(file)) {
    REQUIRE(d.lights.size() == 2);
    const auto& spot = std::get<SpotLightDescription>(d.lights[0].model);
    CHECK(spot.cutoff_angle == near(30));
    CHECK(spot.beam_width == near(10));
    CHECK(spot.to_world.point({0, 0, 0}).y == near(3));
    CHECK(spot.to_world.vector({0, 0, 1}).y == near(-1));
    // At the center of the scene, at a distance of 3 m, the irradiance is pi times the color
    const Vec3f intensity = std::get<SpectrumDescription::Rgb>(spot.intensity.value).value;
    CHECK(intensity.x == near(2 * 9 * kPi, 1e-4));
    CHECK(intensity.z == near(0.5 * 9 * kPi, 1e-4));
    const auto& other = std::get<SpotLightDescription>(d.lights[1].model);
    CHECK(other.cutoff_angle == near(30));
    CHECK(other.beam_width == near(30));
    CHECK(other.to_world.point({0, 0, 0}).y == near(1));
  }
}

TEST_CASE("import: cameras and lights of instances of COLLADA nodes are placed with each instance") {
  if (!can_import_models()) return;
  const Description d =
      read_as("a.dae",
              collada_file(collada_square(),
                           "<node id='n'><instance_geometry url='#square'/></node><node id='a'><translate>0 0 "
                           "2</translate><instance_node url='#lamp'/></node><node id='b'><translate>0 0 "
                           "7</translate><instance_node url='#lamp'/></node>",
                           "<library_lights><light id='l'><technique_common><point><color>1 1 1</color></point>"
                           "</technique_common></light></library_lights><library_nodes><node id='lamp'><instance_light "
                           "url='#l'/></node></library_nodes>"));
  REQUIRE(d.lights.size() == 2);
  CHECK(std::get<PointLightDescription>(d.lights[0].model).position.z == near(2));
  CHECK(std::get<PointLightDescription>(d.lights[1].model).position.z == near(7));
}

TEST_CASE("import: hidden objects of FBX are left out") {
  if (!can_import_models()) return;
  const auto moved = [](double x, std::vector<FbxBlock> more = {}) {
    more.push_back(fbx_property("Lcl Translation", "Lcl Translation", {x, 0, 0}));
    return more;
  };
  const FbxBlock invisible = fbx_property("Visibility", "Visibility", 0.0),
                 unshown = fbx_property("Show", "bool", std::int32_t{0});
  const FbxBlock alone = fbx_property("Visibility Inheritance", "Visibility Inheritance", std::int32_t{0});
  FbxFile file;
  file.add_square("a", moved(100));
  file.add_square("a", moved(200, {invisible}));  // names need not be unique
  file.add_square("a", moved(300, {unshown}));
  file.add_square("a", moved(400, {fbx_property("Visibility", "Visibility", 0.5)}));
  // Below a hidden group: hidden, unless the child does not inherit
  const std::int64_t group = file.add_model("group", "Null", {invisible});
  const std::int64_t inner = file.add_model("inner", "Null", {}, group);
  file.add_square("b", moved(500), inner);
  file.add_square("c", moved(600, {alone}), inner);
  // Show concerns the object alone; pivots make Assimp divide the node
  const std::int64_t displayed =
      file.add_square("d", moved(700, {unshown, fbx_property("RotationPivot", "Vector3D", {50, 0, 0})}));
  file.add_square("e", moved(100), displayed);
  file.add_square("f", moved(900, {invisible, fbx_property("RotationPivot", "Vector3D", {50, 0, 0})}));
  file.add_attribute("lamp", "Light", {choice("LightType", 0)}, {invisible});
  file.add_attribute("lamp2", "Light", {choice("LightType", 0)});
  for (const Description& d : read_all(file)) {
    CHECK(heights(d) == std::vector<double>{1, 4, 6, 8});
    CHECK(d.lights.size() == 1);
    CHECK(d.notes.empty());
  }
  FbxFile layers;
  layers.add_layer({unshown}, layers.add_square("a", moved(100)));
  layers.add_layer({}, layers.add_square("b", moved(200)));
  for (const Description& d : read_all(layers)) CHECK(heights(d) == std::vector<double>{2});
  // By the template of the file
  FbxFile hidden;
  hidden.add_template("Model", "FbxNode", {unshown});
  hidden.add_square("a", moved(100));
  hidden.add_square("b", moved(200, {fbx_property("Show", "bool", std::int32_t{1})}));
  CHECK(heights(read_as("a.fbx", hidden.text())) == std::vector<double>{2});
}

TEST_CASE("import: animated visibility gives a note") {
  if (!can_import_models()) return;
  FbxFile file;
  const std::int64_t model = file.add_square("blink", {});
  file.connect(file.add_model("curve", "Null", {}), model, "Visibility");
  const Description d = read_as("a.fbx", file.text());
  REQUIRE(d.notes.size() == 1);
  CHECK(contains(d.notes[0], "node 'blink': its visibility is animated"));
}

TEST_CASE("import: damaged FBX files do not crash the reader of properties") {
  if (!can_import_models()) return;
  const FbxFile file = fbx_with_camera({number("FieldOfView", 90)});
  for (const std::string& bytes : {file.text(), file.binary(7400), file.binary(7500)})
    for (std::size_t i = 1; i < 12; ++i) {
      std::string damaged = bytes;
      damaged[27 + (bytes.size() - 28) * i / 12] = static_cast<char>(0xff);
      const TemporaryFolder folder;
      error_of(write_below(folder, "a.fbx", damaged));
      error_of(write_below(folder, "b.fbx", bytes.substr(0, bytes.size() * i / 12)));
    }
}

}  // namespace sheaf::test_import_optics
