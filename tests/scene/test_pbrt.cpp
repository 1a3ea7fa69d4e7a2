// Scenes of pbrt-v4: tokens, parameters, directives and the resulting descriptions.
#include <doctest/doctest.h>

#include "core/color.h"
#include "scene/compile/compile.h"
#include "scene/dialects/pbrt/reader.h"
#include "scene/tables/shape.h"
#include "tests/support/capture.h"
#include "tests/support/deflate.h"
#include "tests/support/scene_files.h"

#include <array>
#include <cmath>
#include <numbers>

namespace sheaf::test_pbrt {

using namespace test;
using namespace pbrt;
using doctest::Approx;

namespace {

/// Reads `world` after WorldBegin, which is in line 2 after `options`, in a folder with some files.
Description read_world(const std::string& world, bool lenient = false, const std::string& options = "") {
  const TemporaryFolder folder;
  write_below(folder, "image.png", "");
  write_below(folder, "sky.exr", "");
  write_below(folder, "light.spd", "# a flat light\n300 2\n900 2\n");
  write_below(folder, "part.pbrt", "Translate 1 0 0\n");
  ReadOptions how;
  how.lenient = lenient;
  return read_scene(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"), how);
}

/// The error of a world whose lines start at 3; empty without an error.
std::string error_of_world(const std::string& world, const std::string& options = "") {
  const TemporaryFolder folder;
  write_below(folder, "image.png", "");
  return error_of(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"));
}

std::string error_of_bytes(const std::string& text) {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "scene.pbrt", text));
}

template <class Model> const Model* model_of(const Description& d, MaterialId id) {
  const MaterialDescription* material = &d.materials.at(static_cast<std::size_t>(id));
  if (const auto* sides = std::get_if<TwoSidedDescription>(&material->model))
    material = &d.materials.at(static_cast<std::size_t>(sides->front));
  return std::get_if<Model>(&material->model);
}
template <class Model> const Model* only_material(const Description& d) {
  return model_of<Model>(d, *d.shapes.at(0).material);
}

Vec3f rgb_of(const SpectrumDescription& spectrum) {
  if (const auto* grey = std::get_if<SpectrumDescription::Constant>(&spectrum.value))
    return {grey->value, grey->value, grey->value};
  return std::get<SpectrumDescription::Rgb>(spectrum.value).value;
}

const std::string kDiffuseScene = R"(Film "rgb" "integer xresolution" [ 16 ] # a comment "with a string"
Camera "perspective" "float fov" 40
Sampler "zsobol"
WorldBegin
Attribute "shape" "float radius" 2
AttributeBegin
  Translate 1 2 3
  Texture "t" "spectrum" "checkerboard" "rgb tex1" [ 1 0 0 ]
  Material "diffuse" "texture reflectance" "t"
  AreaLightSource "diffuse" "blackbody L" 5000
  Shape "sphere"
AttributeEnd
ObjectBegin "o"
  Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 ]
ObjectEnd
ObjectInstance "o"
LightSource "point" "rgb I" [ 1 2 3 ]
)";

}  // namespace

TEST_SUITE("pbrt") {
  TEST_CASE("pbrt: tokens are split as in pbrt") {
    Tokens tokens("Shape \"a b\\\"c\\\\\" # no \"token\" []\n[1 -2.5e1]true\"x\"", "f");
    using Kind = Token::Kind;
    const std::pair<Kind, std::string> expected[] = {
        {Kind::kWord, "Shape"},  {Kind::kString, "a b\"c\\"}, {Kind::kOpen, "["},    {Kind::kWord, "1"},
        {Kind::kWord, "-2.5e1"}, {Kind::kClose, "]"},         {Kind::kWord, "true"}, {Kind::kString, "x"}};
    int index = 0;
    for (const auto& [kind, text] : expected) {
      CAPTURE_BINDING(text);
      CHECK(tokens.current().kind == kind);
      CHECK(tokens.current().text == text);
      CHECK(tokens.where().line == (index++ < 2 ? 1 : 2));
      tokens.advance();
    }
    CHECK(tokens.current().kind == Kind::kEnd);
    tokens.advance();
    CHECK(tokens.current().kind == Kind::kEnd);
    CHECK_THROWS_AS(Tokens("\"no end\n\"", "f"), SceneError);
    CHECK_THROWS_AS(Tokens("\"\\q\"", "f"), SceneError);
    const auto number = [](const char* text) { return number_of(Tokens(text, "f").current(), {"f", 1}, "a number"); };
    CHECK(number("+3") == 3);
    CHECK(number("-.5E-1") == Approx(-0.05));
    CHECK(number("1e-400") == 0);
    for (const char* text : {"1e400", "nan", "inf", "1x", "\"1\"", "", "--1"})
      CHECK_THROWS_AS(number(text), SceneError);
  }

  TEST_CASE("pbrt: values with and without brackets are equal") {
    const Description a = read_world("Shape \"sphere\" \"float radius\" 2 \"float alpha\" 1");
    const Description b = read_world("Shape \"sphere\" \"float radius\" [ 2 ] \"float alpha\" [1]");
    CHECK(dump(a) == dump(b));
    CHECK(std::get<SphereShape>(a.shapes[0].geometry).radius == 2);
  }

  TEST_CASE("pbrt: the x axis of a camera points to the right") {
    const Description d = read_world("", false, "LookAt 0 0 0  0 0 1  0 1 0 Camera \"perspective\" \"float fov\" 50");
    CHECK(d.camera.to_world.vector({1, 0, 0}).x == -1);
    CHECK(d.camera.to_world.vector({0, 0, 1}).z == 1);
    CHECK(d.camera.fov == 50);
    CHECK(d.camera.fov_axis == CameraDescription::FovAxis::kSmaller);
    CHECK(d.film.width == 1280);
    CHECK(d.film.filter.kind == PixelFilter::Kind::kGaussian);
    CHECK(d.sampler.sample_count == 16);
    CHECK(d.sampler.kind == SamplerKind::kZSobol);
    CHECK(d.integrator.max_depth == 6);
  }

  TEST_CASE("pbrt: integers may be written as floats of integral value") {
    const Description d = read_world("Shape \"sphere\"", false,
                                     "Integrator \"path\" \"float maxdepth\" 7\nSampler \"sobol\" "
                                     "\"integer pixelsamples\" 16.0");
    CHECK(d.integrator.max_depth == 8);
    CHECK(d.sampler.sample_count == 16);
    CHECK(contains(error_of_world("Shape \"sphere\"", "Integrator \"path\" \"float maxdepth\" 7.5"),
                   "parameter 'maxdepth' of Integrator 'path' is 7.5, expected an integer"));
  }

  TEST_CASE("pbrt: crop windows between pixels are rounded up at both ends") {
    const auto crop = [](const std::string& parameter) {
      const Description d = read_world(
          "Shape \"sphere\"", false, "Film \"rgb\" \"integer xresolution\" 10 \"integer yresolution\" 7 " + parameter);
      REQUIRE(d.film.crop);
      return std::array{d.film.crop->x0, d.film.crop->x1, d.film.crop->y0, d.film.crop->y1};
    };
    CHECK(crop("\"float cropwindow\" [ 0.21 0.58 0.33 0.9 ]") == std::array{3, 6, 3, 7});
    CHECK(crop("\"float cropwindow\" [ 0.58 0.21 0.9 0.33 ]") == std::array{3, 6, 3, 7});
    CHECK(crop("\"float cropwindow\" [ -1 0.51 0 2 ]") == std::array{0, 6, 0, 7});
    CHECK(crop("\"integer pixelbounds\" [ 2 5 1 99 ]") == std::array{2, 5, 1, 7});
  }

  TEST_CASE("pbrt: textured spheres have v from the lower end up and face outwards") {
    const Description d = read_world(R"(Texture "t" "spectrum" "checkerboard"
Material "diffuse" "texture reflectance" "t" Translate 1 2 3 Shape "sphere" "float radius" 2)");
    const auto scene = compile_scene(d);
    const SceneView& view = scene->view();
    for (const float polar : {0.3f, 1.2f, 2.0f, 2.9f})  // angle from +z
      for (const float turn : {0.4f, 2.0f, 4.0f, 6.0f}) {
        const Vec3f n{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
        const auto y =
            surface_point<Scalar, true>(view, view.geometry.shapes[0], 0, 0, 0, Vec3f{1, 2, 3} + n * 2.0f, kNone);
        CHECK(y.uv.x == Approx(static_cast<double>(turn) / (2 * std::numbers::pi)).epsilon(1e-4));
        CHECK(y.uv.y == Approx(1 - static_cast<double>(polar) / std::numbers::pi).epsilon(1e-4));
        CHECK(length(y.ng - n) < 1e-4f);
      }
  }

  TEST_CASE("pbrt: samplers are read or replaced by similar ones") {
    const auto kind = [](const std::string& name) {
      return read_world("", false, "Sampler \"" + name + "\"").sampler.kind;
    };
    CHECK(kind("independent") == SamplerKind::kIndependent);
    CHECK(kind("stratified") == SamplerKind::kStratified);
    CHECK(kind("zsobol") == SamplerKind::kZSobol);
    for (const char* name : {"halton", "paddedsobol", "pmj02bn", "sobol"}) CHECK(kind(name) == SamplerKind::kSobol);
  }

  TEST_CASE("pbrt: attributes and transforms and objects are saved and restored") {
    const Description d = read_world(R"(
AttributeBegin Translate 1 0 0 Scale 2 2 2 ReverseOrientation Shape "sphere" AttributeEnd
Shape "sphere"
TransformBegin Rotate 90 0 0 1 Material "dielectric" TransformEnd
Shape "sphere"
ObjectBegin "o" Translate 0 5 0 Shape "sphere" ObjectEnd
Translate 7 0 0 ObjectInstance "o" Include "part.pbrt" ObjectInstance "o" Import "part.pbrt" ObjectInstance "o"
ObjectBegin "unused" Shape "sphere" ObjectEnd)");
    REQUIRE(d.shapes.size() == 3);
    CHECK(d.shapes[0].to_world.point({1, 0, 0}).x == 3);
    CHECK(d.shapes[0].flip_normals);
    CHECK(!d.shapes[1].flip_normals);
    CHECK(d.shapes[1].to_world.point({1, 0, 0}).x == 1);
    CHECK(model_of<DiffuseDescription>(d, *d.shapes[1].material) != nullptr);
    CHECK(model_of<DielectricDescription>(d, *d.shapes[2].material) != nullptr);
    REQUIRE(d.groups.size() == 1);
    CHECK(d.groups[0].shapes[0].to_world.point({0, 0, 0}).y == 5);
    REQUIRE(d.instances.size() == 3);
    CHECK(d.instances[0].to_world[3] == 7);
    CHECK(d.instances[1].to_world[3] == 8);
    CHECK(d.instances[2].to_world[3] == 8);
    CHECK(d.files.size() == 2);
  }

  TEST_CASE("pbrt: a light of L 1 has radiance 1 and spectra luminance 1 and the exposure of the film counts") {
    const auto light = [](const std::string& parameters, const std::string& options = "") {
      const Description d = read_world("LightSource \"infinite\" " + parameters, false, options);
      return std::get<ConstantLightDescription>(d.lights.at(0).model).radiance;
    };
    CHECK(rgb_of(light("")).x == 1);
    CHECK(rgb_of(light("\"rgb L\" [ 1 2 3 ] \"float scale\" 2")).y == 4);
    CHECK(rgb_of(light("\"rgb L\" [ 1 2 3 ] \"float illuminance\" 3.14159265")).z == Approx(3));
    CHECK(rgb_of(light("\"spectrum L\" \"stdillum-D65\"")).x == 1);
    CHECK(rgb_of(light("", "Film \"rgb\" \"float iso\" 50")).x == 0.5f);
    CHECK(rgb_of(light("", "Camera \"perspective\" \"float shutteropen\" 1 \"float shutterclose\" 4")).x == 3);
    const auto flat = std::get<SpectrumDescription::Table>(light("\"spectrum L\" [ 400 7 600 7 ]").value);
    for (const float value : flat.values) CHECK(value == Approx(1));
    CHECK(std::get<SpectrumDescription::Table>(light("\"spectrum L\" \"light.spd\"").value).values[0] == Approx(1));
    const auto body = std::get<SpectrumDescription::Blackbody>(light("\"blackbody L\" 4000").value);
    const Vec3f rgb = blackbody_to_rgb(body.temperature, body.scale);
    CHECK(luminance(rgb) == Approx(1).epsilon(0.002));
    CHECK(rgb.x > rgb.z);
  }

  TEST_CASE("pbrt: lights have the documented parameters") {
    const Description d = read_world(R"(Translate 0 0 1
LightSource "point" "point3 from" [ 1 0 0 ] "float power" 12.566370614
LightSource "spot" "point3 to" [ 0 -1 0 ] "float coneangle" 40 "float conedeltaangle" 10 "rgb I" [ 1 1 2 ]
LightSource "distant" "point3 from" [ 0 5 0 ] "point3 to" [ 0 0 0 ] "float illuminance" 3
LightSource "infinite" "string filename" "sky.exr" "float scale" 2)");
    const auto& point = std::get<PointLightDescription>(d.lights.at(0).model);
    CHECK(point.position.x == 1);
    CHECK(point.position.z == 1);
    CHECK(rgb_of(point.intensity).x == Approx(1));
    const auto& spot = std::get<SpotLightDescription>(d.lights.at(1).model);
    CHECK(spot.falloff == SpotLightDescription::Falloff::kSmooth);
    CHECK(spot.cutoff_angle == 40);
    CHECK(spot.beam_width == 30);
    CHECK(spot.to_world.vector({0, 0, 1}).y == Approx(-1));
    const auto& distant = std::get<DirectionalLightDescription>(d.lights.at(2).model);
    CHECK(distant.direction.y < 0);
    CHECK(rgb_of(distant.irradiance).x == 3);
    const auto& sky = std::get<EnvmapDescription>(d.lights.at(3).model);
    CHECK(sky.layout == EnvmapDescription::Layout::kOctahedral);
    CHECK(sky.scale == 2);
    const Description areas = read_world(R"(AreaLightSource "diffuse" "float power" 39.4784176
Shape "sphere" "float radius" 2
AreaLightSource "diffuse" "string filename" "image.png" "float scale" 3
Shape "disk")");
    CHECK(rgb_of(std::get<SpectrumDescription>(*areas.shapes[0].radiance)).x == Approx(0.25));
    const auto texture = std::get<TextureId>(*areas.shapes[1].radiance);
    CHECK(std::get<BitmapDescription>(areas.textures[static_cast<std::size_t>(texture)].model).change.scale == 3);
  }

  TEST_CASE("pbrt: roughness is remapped unless the file disables it") {
    const auto alpha = [](const std::string& parameters) {
      const Description d = read_world("Material \"conductor\" " + parameters + "\nShape \"sphere\"");
      const ConductorDescription* metal = only_material<ConductorDescription>(d);
      REQUIRE(metal != nullptr);
      return metal->roughness;
    };
    CHECK(!alpha(""));
    CHECK(!alpha("\"float roughness\" 1e-8"));
    CHECK(std::get<float>(alpha("\"float roughness\" 0.25")->alpha_u) == 0.5f);
    CHECK(std::get<float>(alpha("\"float roughness\" 0.25 \"bool remaproughness\" false")->alpha_v) == 0.25f);
    const auto two = alpha("\"float roughness\" 0.04 \"float vroughness\" 0.09");
    CHECK(std::get<float>(two->alpha_u) == Approx(0.2));
    CHECK(std::get<float>(two->alpha_v) == Approx(0.3));
  }

  TEST_CASE("pbrt: materials have the documented parameters") {
    const Description glass = read_world("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"\nShape \"sphere\"");
    CHECK(only_material<DielectricDescription>(glass)->int_ior == Approx(1.5168).epsilon(1e-4));
    CHECK(only_material<DielectricDescription>(glass)->int_dispersion);
    // Between the tabulated neighbours of 588 nm in pbrt.
    for (const auto& [name, low, high] : {std::tuple{"BAF10", 1.6686f, 1.6702f},
                                          {"FK51A", 1.4862f, 1.4869f},
                                          {"LASF9", 1.8481f, 1.8509f},
                                          {"F5", 1.6710f, 1.6732f},
                                          {"F10", 1.7277f, 1.7306f},
                                          {"F11", 1.7823f, 1.7855f},
                                          {"SF11", 1.7823f, 1.7855f}}) {
      const Description flint =
          read_world("Material \"dielectric\" \"spectrum eta\" \"glass-" + std::string(name) + "\"\nShape \"sphere\"");
      CHECK(only_material<DielectricDescription>(flint)->int_ior > low);
      CHECK(only_material<DielectricDescription>(flint)->int_ior < high);
    }
    const Description mirror = read_world("Material \"conductor\" \"rgb reflectance\" [ 0.5 0.8 0 ]\nShape \"sphere\"");
    CHECK(rgb_of(std::get<SpectrumDescription>(only_material<ConductorDescription>(mirror)->ior->k)).x == 2);
    CHECK(rgb_of(std::get<SpectrumDescription>(only_material<ConductorDescription>(mirror)->ior->k)).y == Approx(4));
    const Description coat = read_world("Material \"coatedconductor\"\nShape \"sphere\"");
    const auto* sides =
        std::get_if<TwoSidedDescription>(&coat.materials.at(static_cast<std::size_t>(*coat.shapes[0].material)).model);
    REQUIRE(sides != nullptr);
    const auto* blend = std::get_if<BlendDescription>(&coat.materials.at(static_cast<std::size_t>(sides->front)).model);
    REQUIRE(blend != nullptr);
    CHECK(std::get<float>(blend->weight) == Approx(0.04));
    const Description mapped = read_world(R"(Texture "r" "float" "imagemap" "string filename" "image.png"
Material "dielectric" "texture roughness" "r"
Shape "sphere")");
    const auto id = std::get<TextureId>(only_material<DielectricDescription>(mapped)->roughness->alpha_u);
    CHECK(std::get<BitmapDescription>(mapped.textures[static_cast<std::size_t>(id)].model).change.exponent == 0.5f);
  }

  TEST_CASE("pbrt: textures of constants are evaluated") {
    const auto reflectance = [](const std::string& textures) {
      const Description d =
          read_world(textures + "\nMaterial \"diffuse\" \"texture reflectance\" \"x\"\nShape \"sphere\"");
      return rgb_of(std::get<SpectrumDescription>(only_material<DiffuseDescription>(d)->reflectance));
    };
    CHECK(reflectance(
              "Texture \"x\" \"spectrum\" \"mix\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 1 0] \"float amount\" 0.25")
              .x == 0.75f);
    CHECK(reflectance("Texture \"x\" \"spectrum\" \"scale\" \"rgb tex\" [1 0.5 0] \"float scale\" 0.5").y == 0.25f);
    CHECK(reflectance("Texture \"x\" \"spectrum\" \"constant\" \"rgb value\" [0.1 0.2 0.3]").z == 0.3f);
  }

  TEST_CASE("pbrt: media lie inside and outside shapes and equal media need no boundary") {
    const Description d =
        read_world(R"(MakeNamedMedium "fog" "string type" "homogeneous" "string preset" "Skin1" "float g" 0.5
MediumInterface "fog" "" Shape "sphere"
MediumInterface "fog" Shape "sphere"
MediumInterface "" "fog" Material "interface" Shape "sphere")",
                   false,
                   "MakeNamedMedium \"air\" \"string type\" \"homogeneous\"\n"
                   "MediumInterface \"\" \"air\" Camera \"perspective\"");
    CHECK(d.media.size() == 2);
    CHECK(static_cast<int>(*d.camera.medium) == 0);
    CHECK(static_cast<int>(*d.shapes[0].interior) == 1);
    CHECK(!d.shapes[0].exterior);
    CHECK(!d.shapes[1].interior);
    CHECK(static_cast<int>(*d.shapes[2].exterior) == 1);
    CHECK(std::get<HenyeyGreensteinDescription>(d.phases[0].model).g == 0.5f);
  }

  TEST_CASE("pbrt: shapes have the documented parameters") {
    const Description d = read_world(R"(Shape "sphere" "float phimax" 90
Shape "disk" "float innerradius" 0.5
Shape "bilinearmesh" "point3 P" [ 0 0 0  1 0 0  0 1 0  1 1 1 ]
Shape "bilinearmesh" "point3 P" [ 0 0 0  1 0 0  0 1 0  1 1 0 ]
Scale 1 1 -1
Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0 ]
Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0 ] "normal N" [ 0 0 1 0 0 1 0 0 1 ])");
    const auto area = [&](std::size_t shape) {
      double sum = 0;
      const Mesh& mesh = std::get<Mesh>(d.shapes.at(shape).geometry);
      for (const auto& t : mesh.triangles)
        sum += 0.5 * static_cast<double>(length(cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                                      mesh.positions[t[2]] - mesh.positions[t[0]])));
      return sum;
    };
    CHECK(area(0) == Approx(3.14159265).epsilon(0.002));
    CHECK(area(1) == Approx(3.14159265 * 0.75).epsilon(0.002));
    CHECK(std::get<Mesh>(d.shapes[2].geometry).triangles.size() > 100);
    CHECK(std::get<Mesh>(d.shapes[3].geometry).triangles.size() == 2);
    CHECK(area(3) == Approx(1));
    CHECK(d.shapes[4].flip_normals);
    CHECK(!d.shapes[5].flip_normals);
  }

  TEST_CASE("pbrt: curves become B-spline tubes of the same shape") {
    const auto curves = [](const std::string& parameters) {
      return std::get<Curves>(read_world("Shape \"curve\" " + parameters).shapes.at(0).geometry);
    };
    // The point of a segment at t and its radius: a weighted sum of four control points.
    const auto at = [](const Curves& c, std::size_t first, float t) {
      const float s = 1 - t;
      const float w[] = {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * s * s + 3 * s * s * s) / 6,
                         t * t * t / 6};
      Curves::Point out{};
      for (std::size_t k = 0; k < 4; ++k) {
        out.position = out.position + c.points.at(first + k).position * w[k];
        out.radius += c.points[first + k].radius * w[k];
      }
      return out;
    };
    const Curves cubic = curves(R"("point3 P" [ 0 0 0  1 2 0  3 0 1  4 4 4 ] "float width0" 0.4 "float width1" 0)");
    REQUIRE(cubic.points.size() == 4);
    CHECK(cubic.basis == Curves::Basis::kBspline);
    for (const float t : {0.0f, 0.3f, 1.0f}) {
      const float s = 1 - t;
      const Vec3f expected =
          Vec3f{1, 2, 0} * (3 * s * s * t) + Vec3f{3, 0, 1} * (3 * s * t * t) + Vec3f{4, 4, 4} * (t * t * t);
      CHECK(length(at(cubic, 0, t).position - expected) < 1e-5f);
      CHECK(at(cubic, 0, t).radius == Approx(0.2 * (1 - t)).epsilon(1e-5));
    }
    const Curves quadratic =
        curves(R"("point3 P" [ 0 0 0  1 2 0  2 0 0  3 -2 0  4 0 0 ] "integer degree" 2 "float width" 0.5)");
    CHECK(quadratic.starts == std::vector<std::uint32_t>{0, 4});
    CHECK(length(at(quadratic, 0, 0.5f).position - Vec3f{1, 1, 0}) < 1e-5f);
    CHECK(length(at(quadratic, 4, 0.5f).position - Vec3f{3, -1, 0}) < 1e-5f);
    CHECK(at(quadratic, 4, 0.5f).radius == Approx(0.25));
    const std::string points = R"("point3 P" [ 0 0 0  1 2 0  2 0 0  3 -2 0  4 0 0 ] "string basis" "bspline")";
    const Curves spline = curves(points + " \"float width1\" 3");
    CHECK(spline.starts.size() == 1);
    REQUIRE(spline.points.size() == 5);
    CHECK(spline.points[1].position == Vec3f{1, 2, 0});
    CHECK(at(spline, 0, 0).radius == Approx(0.5));
    CHECK(at(spline, 1, 0).radius == Approx(1));
    CHECK(at(spline, 1, 1).radius == Approx(1.5));
    // A quadratic B-spline passes the middle between control points where segments meet.
    const Curves smooth = curves(points + " \"integer degree\" 2");
    CHECK(smooth.starts.size() == 3);
    CHECK(length(at(smooth, 4, 0).position - Vec3f{1.5f, 1, 0}) < 1e-5f);
    CHECK(length(at(smooth, 4, 0.5f).position - Vec3f{2, 0, 0}) < 1e-5f);
  }

  TEST_CASE("pbrt: curves with the same material and attributes become one shape") {
    const std::string curve =
        "Shape \"curve\" \"point3 P\" [ 0 0 0  1 2 0  3 0 1  4 4 4 ] \"string type\" \"cylinder\"\n";
    const Description d =
        read_world(curve + "AttributeBegin Scale 2 2 2\n" + curve + "AttributeEnd\nMaterial \"hair\"\n" + curve);
    REQUIRE(d.shapes.size() == 2);
    const Curves& two = std::get<Curves>(d.shapes[0].geometry);
    CHECK(two.starts == std::vector<std::uint32_t>{0, 4});
    CHECK(two.points[0].radius == 0.5f);
    CHECK(two.points[4].radius == Approx(1));
    CHECK(two.points[5].position.x == Approx(2 * two.points[1].position.x));
    CHECK(d.notes.empty());
    CHECK(model_of<HairDescription>(d, *d.shapes[1].material) != nullptr);
    const std::string board =
        "Texture \"t\" \"spectrum\" \"checkerboard\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n";
    CHECK(read_world(board + curve + curve).shapes.size() == 2);
    const std::string flat = "Shape \"curve\" \"point3 P\" [ 0 0 0  1 2 0  3 0 1  4 4 4 ]\n";
    const std::vector<std::string> notes = read_world(flat + flat).notes;
    REQUIRE(notes.size() == 1);
    CHECK(contains(notes[0], "type 'flat' rendered as a round tube"));
    CHECK(contains(error_of_world("Shape \"curve\""), "has 0 points, expected 4 or more"));
    CHECK(
        contains(error_of_world("Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 ]"), "1 and a multiple"));
    CHECK(contains(error_of_world("Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 2 0 0 3 0 0 ] \"string type\" \"round\""),
                   "expected flat"));
    CHECK(contains(error_of_world("AreaLightSource \"diffuse\"\n" + flat), "light of curves: not supported"));
  }

  TEST_CASE("pbrt: hair is defined by pigments or absorption or colour") {
    const auto hair = [](const std::string& parameters) {
      return *only_material<HairDescription>(read_world("Material \"hair\" " + parameters + " Shape \"sphere\""));
    };
    const HairDescription brown = hair("");
    CHECK(std::get<HairDescription::Melanin>(brown.color).eumelanin == ScalarInput(1.3f));
    CHECK(std::get<HairDescription::Melanin>(brown.color).pheomelanin == ScalarInput(0.0f));
    CHECK(brown.int_ior == 1.55f);
    CHECK(brown.ext_ior == 1.0f);
    const auto red = std::get<HairDescription::Melanin>(hair("\"float pheomelanin\" 0.7").color);
    CHECK(red.eumelanin == ScalarInput(0.0f));
    CHECK(red.pheomelanin == ScalarInput(0.7f));
    const HairDescription dyed =
        hair("\"rgb sigma_a\" [ 1 2 3 ] \"float beta_m\" 0.1 \"float beta_n\" 0.2 \"float alpha\" 4 \"float eta\" 1.4");
    CHECK(rgb_of(std::get<SpectrumDescription>(std::get<HairDescription::Absorption>(dyed.color).sigma_a)) ==
          Vec3f{1, 2, 3});
    CHECK(dyed.longitudinal_roughness == ScalarInput(0.1f));
    CHECK(dyed.azimuthal_roughness == ScalarInput(0.2f));
    CHECK(dyed.scale_tilt == 4.0f);
    CHECK(dyed.int_ior == 1.4f);
    for (const char* name : {"color", "reflectance"}) {
      const HairDescription colored = hair("\"rgb " + std::string(name) + "\" [ 0.1 0.2 0.3 ]");
      CHECK(rgb_of(std::get<SpectrumDescription>(std::get<HairDescription::Reflectance>(colored.color).color)).y ==
            0.2f);
    }
    CHECK(
        contains(error_of_world("Material \"hair\" \"rgb sigma_a\" [ 1 2 3 ] \"float eumelanin\" 1"), "expected one"));
    CHECK(contains(error_of_world("Material \"hair\" \"float beta_m\" 2"), "from 0 to 1"));
  }

  TEST_CASE("pbrt: subsurface scattering becomes a medium behind glass") {
    const auto medium = [](const std::string& parameters) {
      const Description d = read_world("Material \"subsurface\" " + parameters + " Shape \"sphere\"");
      CHECK(only_material<DielectricDescription>(d) != nullptr);
      CHECK(d.notes.size() == 1);
      REQUIRE(d.shapes[0].interior);
      return d.media.at(static_cast<std::size_t>(*d.shapes[0].interior));
    };
    using Scattering = AbsorptionScatteringDescription;
    const auto color = [](const VolumeInput& input) { return rgb_of(std::get<SpectrumDescription>(input)); };
    CHECK(color(std::get<Scattering>(medium("").coefficients).sigma_s).y == 3.21f);
    const MediumDescription given =
        medium(R"("rgb sigma_a" [ 1 2 3 ] "rgb sigma_s" [ 4 5 6 ] "float scale" 10 "float g" 0.5)");
    CHECK(color(std::get<Scattering>(given.coefficients).sigma_a) == Vec3f{1, 2, 3});
    CHECK(given.scale == 10.0f);
    CHECK(given.phase);
    CHECK(color(std::get<Scattering>(medium("\"string name\" \"skin1\"").coefficients).sigma_s).x == Approx(0.74));
    // Without an index-mismatched boundary and with isotropic scattering, Kulla and Conty 2017 give the albedo for a
    // reflectance. Scale lengthens the mean free path.
    const MediumDescription diffuse =
        medium(R"("rgb reflectance" [ 0.2 0.5 0.9 ] "rgb mfp" [ 1 2 4 ] "float scale" 2 "float eta" 1)");
    const auto& c = std::get<ExtinctionAlbedoDescription>(diffuse.coefficients);
    CHECK(rgb_of(std::get<SpectrumDescription>(c.sigma_t)) == Vec3f{1, 0.5f, 0.25f});
    CHECK(diffuse.scale == 0.5f);
    const double s = 4.09712 + 4.20863 * 0.5 - std::sqrt(9.59217 + 41.6808 * 0.5 + 17.7126 * 0.25);
    CHECK(rgb_of(std::get<SpectrumDescription>(c.albedo)).y == Approx(1 - s * s));
    // A reflective boundary needs a higher albedo for the same reflectance.
    const MediumDescription coated = medium(R"("rgb reflectance" [ 0.2 0.5 0.9 ] "float eta" 1.5)");
    CHECK(rgb_of(std::get<SpectrumDescription>(std::get<ExtinctionAlbedoDescription>(coated.coefficients).albedo)).y >
          1 - s * s);
    CHECK(contains(error_of_world("Material \"subsurface\" \"rgb sigma_a\" [ 1 1 1 ]"), "has only 'sigma_a'"));
    CHECK(contains(error_of_world("Material \"subsurface\" \"string name\" \"Skim1\""), "did you mean"));
  }

  TEST_CASE("pbrt: errors have a line number") {
    const auto check = [](const std::string& world, const std::string& message) {
      CAPTURE(world);
      CHECK(error_of_world(world) == message);
    };
    check("\nShap \"sphere\"", "scene.pbrt:4: found 'Shap', expected a directive, did you mean 'Shape'?");
    check("Shape \"spere\"",
          "scene.pbrt:3: unknown shape 'spere', did you mean 'sphere'? (known: bilinearmesh, curve, cylinder, disk, "
          "loopsubdiv, plymesh, sphere, trianglemesh)");
    check("Shape \"sphere\" \"float radios\" 2",
          "scene.pbrt:3: unknown parameter 'radios' of Shape 'sphere', did you mean 'radius'?");
    check("Shape \"sphere\"\n\"float radius\" [ 1 2 ]",
          "scene.pbrt:4: parameter 'radius' of Shape 'sphere' has 2 values, expected 1");
    check("Shape \"sphere\" \"float radius\" -1",
          "scene.pbrt:3: parameter 'radius' of Shape 'sphere' is -1, expected a positive number");
    check("Shape \"sphere\" \"flot radius\" 1",
          "scene.pbrt:3: unknown type 'flot' of a parameter, did you mean 'float'? (known: integer, float, point2, "
          "vector2, point3, vector3, normal3, point, vector, normal, rgb, blackbody, spectrum, bool, string, texture)");
    check("AttributeBegin", "scene.pbrt:3: AttributeBegin is not closed at the end of the file");
    check("AttributeEnd", "scene.pbrt:3: an end without AttributeBegin");
    check("ObjectInstance \"o\"", "scene.pbrt:3: the object 'o' is not defined");
    check("NamedMaterial \"m\"", "scene.pbrt:3: the material 'm' is not defined yet");
    CHECK(contains(error_of_world("Scale 0 1 1"), "scene.pbrt:3: transform is not invertible"));
    check("Film \"rgb\"", "scene.pbrt:3: Film after WorldBegin, expected it before");
    CHECK(contains(error_of_world("Include \"none.pbrt\""), "scene.pbrt:3: file 'none.pbrt' not found in "));
    CHECK(contains(error_of_world("Include \"scene.pbrt\""), "includes itself"));
    CHECK(
        contains(error_of_world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]"),
                 "has 3, expected an index of 3 vertices"));
    CHECK(contains(error_of_world("WorldEnd"), "pbrt-v3"));
    CHECK(contains(error_of_bytes("Film \"rgb\""), "the scene has no WorldBegin"));
    CHECK(contains(error_of_bytes(std::string("\x7f"
                                              "ELF\0\1\2\3",
                                              8)),
                   "expected a directive"));
    ReadOptions defines;
    defines.defines = {{"x", "1"}};
    const TemporaryFolder folder;
    CHECK_THROWS_AS(read_scene(write_below(folder, "scene.pbrt", "WorldBegin\n"), defines), Error);
  }

  TEST_CASE("pbrt: diffuse transmission becomes a blend of two materials that conserves both albedos") {
    const Description d = read_world(
        "Material \"diffusetransmission\" \"rgb reflectance\" [ 0.1 0.2 0.3 ] "
        "\"rgb transmittance\" [ 0.6 0.4 0.2 ] \"float scale\" 0.5 Shape \"sphere\"");
    const auto& blend =
        std::get<BlendDescription>(d.materials.at(static_cast<std::size_t>(*d.shapes.at(0).material)).model);
    const float share = std::get<float>(blend.weight);
    CHECK(share == doctest::Approx(0.6 / 0.9));
    const auto& front = *model_of<DiffuseDescription>(d, blend.nested[0]);
    const auto& through = *model_of<DiffuseTransmitterDescription>(d, blend.nested[1]);
    const Vec3f r = rgb_of(std::get<SpectrumDescription>(front.reflectance)) * (1 - share);
    const Vec3f t = rgb_of(std::get<SpectrumDescription>(through.transmittance)) * share;
    CHECK(length(r - Vec3f{0.05f, 0.1f, 0.15f}) < 1e-6f);
    CHECK(length(t - Vec3f{0.3f, 0.2f, 0.1f}) < 1e-6f);
  }

  TEST_CASE("pbrt: measured materials are two-sided and read from files") {
    CHECK(contains(error_of_world("Material \"measured\""),
                   "scene.pbrt:3: Material 'measured' needs the string 'filename'"));
    CHECK(contains(error_of_world("Material \"measured\" \"string filename\" \"x.bsdf\""), "file 'x.bsdf' not found"));
    const Description d =
        read_world("Material \"measured\" \"string filename\" \"image.png\" Shape \"sphere\" \"float radius\" 1");
    const MaterialId id = *d.shapes.at(0).material;
    const auto& sides = std::get<TwoSidedDescription>(d.materials.at(static_cast<std::size_t>(id)).model);
    CHECK(sides.front == sides.back);
    CHECK(std::get<MeasuredDescription>(d.materials.at(static_cast<std::size_t>(sides.front)).model).file.filename() ==
          "image.png");
  }

  TEST_CASE("pbrt: unsupported features are errors or replacements with a note") {
    for (const std::string world :
         {"Texture \"t\" \"spectrum\" \"marble\"", "Texture \"t\" \"float\" \"fbm\" \"integer octaves\" 3",
          "Texture \"t\" \"float\" \"checkerboard\" \"string mapping\" \"spherical\"",
          "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"string preset\" \"x\""}) {
      CAPTURE(world);
      const std::string message = error_of_world(world);
      CHECK(contains(message, "scene.pbrt:3: "));
      CHECK(contains(message, "not supported"));
      const Description d = read_world(world, true);
      REQUIRE(d.stand_ins.size() == 1);
      CHECK(contains(d.stand_ins[0], "scene.pbrt:3: "));
    }
  }

  TEST_CASE("pbrt: every truncated scene is an error or a scene and never a crash") {
    const TemporaryFolder folder;
    CHECK(error_of(write_below(folder, "scene.pbrt", kDiffuseScene)) == "");
    int errors = 0;
    for (std::size_t size = 0; size < kDiffuseScene.size(); ++size)
      errors += error_of(write_below(folder, "scene.pbrt", kDiffuseScene.substr(0, size))).empty() ? 0 : 1;
    CHECK(errors > static_cast<int>(kDiffuseScene.size()) / 2);
    for (std::size_t i = 0; i < kDiffuseScene.size(); i += 3)  // one damaged character
      for (const char c : {'"', '[', '\0'}) {
        std::string damaged = kDiffuseScene;
        damaged[i] = c;
        error_of(write_below(folder, "scene.pbrt", damaged));
      }
  }

  TEST_CASE("pbrt: files may be compressed") {
    const TemporaryFolder folder;
    write_below(folder, "part.pbrt.gz", gzipped("Shape \"sphere\" \"float radius\" 3\n"));
    const std::string scene = gzipped("WorldBegin\nInclude \"part.pbrt.gz\"\n");
    CHECK(std::get<SphereShape>(read_scene(write_below(folder, "scene.pbrt.gz", scene)).shapes.at(0).geometry).radius ==
          3);
    for (std::size_t size = 0; size < scene.size(); ++size) {
      const std::string message = error_of(write_below(folder, "scene.pbrt.gz", scene.substr(0, size)));
      CHECK(contains(message, "scene.pbrt.gz: scene file is "));
    }
  }

  TEST_CASE("pbrt: the depth of nested attributes and includes is limited") {
    std::string deep;
    for (int i = 0; i < 20'000; ++i) deep += "AttributeBegin\n";
    CHECK(contains(error_of_world(deep), "attributes are saved more than 10000 deep"));
    const TemporaryFolder folder;
    for (int i = 0; i < 40; ++i)
      write_below(folder, "part" + std::to_string(i) + ".pbrt", "Include \"part" + std::to_string(i + 1) + ".pbrt\"\n");
    CHECK(contains(error_of(write_below(folder, "scene.pbrt", "Include \"part0.pbrt\"\n")), "more than 32 deep"));
    // Each file includes the next one twice.
    for (int i = 0; i < 20; ++i)
      write_below(
          folder, "part" + std::to_string(i) + ".pbrt",
          "Include \"part" + std::to_string(i + 1) + ".pbrt\" Include \"part" + std::to_string(i + 1) + ".pbrt\"");
    write_below(folder, "part20.pbrt", "");
    CHECK(contains(error_of(write_below(folder, "scene.pbrt", "Include \"part0.pbrt\"\n")), "more than 10000 files"));
  }
}

}  // namespace sheaf::test_pbrt
