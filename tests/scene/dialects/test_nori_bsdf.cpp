// The Nori dialect: materials and textures.
#include "scene/data/glasses.h"
#include "tests/support/capture.h"
#include "tests/support/scene_errors.h"
#include "tests/support/xml_elements.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace sheaf::test_nori_bsdf {

using namespace test;

namespace {

std::string scene_with(const std::string& bsdf) {
  return "<scene>\n<camera type='perspective'/>\n<integrator type='path_mis'/>\n<mesh type='sphere'>" + bsdf +
         "</mesh>\n</scene>\n";
}

std::string material(const std::string& type, const std::string& inside = "") {
  return dump(read_text(scene_with(bsdf(type, inside))).materials.back());
}

TextureDescription texture_of(const std::string& type, const std::string& inside = "") {
  const std::string element = "<texture name='albedo' type='" + type + "'>" + inside + "</texture>";
  return read_text(scene_with(bsdf("diffuse", element))).textures.back();
}

/// The square of a checkerboard that contains a point: 0 or 1, for color0 or color1.
int square(const TextureDescription& t, float u, float v) {
  const std::array<float, 6>& m = t.to_uv;
  const float x = m[0] * u + m[1] * v + m[2], y = m[3] * u + m[4] * v + m[5];
  return (static_cast<int>(std::floor(2 * x)) + static_cast<int>(std::floor(2 * y))) & 1;
}

}  // namespace

TEST_CASE("Nori materials: defaults match the documentation") {
  CHECK(material("diffuse") == "diffuse constant 0x1p-1");
  CHECK(material("mirror") == "conductor constant 0x1p+0");
  CHECK(material("dielectric") ==
        dump_all("dielectric", 1.5046f, 1.000277f, "constant 0x1p+0 constant 0x1p+0 0 0x1p+0 constant 0x1p+0"));
  CHECK(material("microfacet") == dump_all("nori_microfacet", 1.5046f, 1.000277f, 0.1f, "constant 0x1p-1"));
  CHECK(material("disney") ==
        dump_all("disney constant 0x1p-1", 0.0f, 0.0f, 0.5f, 0.0f, 0.5f, 0.0f, 0.0f, 0.5f, 0.0f, 1.0f));
}

TEST_CASE("Nori materials: every parameter is read in both naming styles") {
  for (const bool camel : {true, false}) {
    CAPTURE(camel);
    auto name = [&](const char* snake, const char* other) { return camel ? other : snake; };
    const std::string iors = number(name("int_ior", "intIOR"), "1.5") + number(name("ext_ior", "extIOR"), "1.25");
    CHECK(material("dielectric", iors) ==
          "dielectric 0x1.8p+0 0x1.4p+0 constant 0x1p+0 constant 0x1p+0 0 0x1p+0 constant 0x1p+0");
    CHECK(material("microfacet", iors + number("alpha", "0.25") + "<color name='kd' value='0,0.5,1'/>") ==
          "nori_microfacet 0x1.8p+0 0x1.4p+0 0x1p-2 rgb 0x0p+0 0x1p-1 0x1p+0");
    CHECK(material("disney", "<color name='" + std::string(name("base_color", "baseColor")) + "' value='0,0.5,1'/>" +
                                 number("metallic", "0.0625") + number("subsurface", "0.125") +
                                 number("specular", "0.1875") + number(name("specular_tint", "specularTint"), "0.25") +
                                 number("roughness", "0.3125") + number("anisotropic", "0.375") +
                                 number("sheen", "0.4375") + number(name("sheen_tint", "sheenTint"), "0.5") +
                                 number("clearcoat", "0.5625") +
                                 number(name("clearcoat_gloss", "clearcoatGloss"), "0.625")) ==
          dump_all("disney rgb 0x0p+0 0x1p-1 0x1p+0", 0.0625f, 0.125f, 0.1875f, 0.25f, 0.3125f, 0.375f, 0.4375f, 0.5f,
                   0.5625f, 0.625f));
  }
  CHECK(material("diffuse", "<color name='albedo' value='0,0.5,1'/>") == "diffuse rgb 0x0p+0 0x1p-1 0x1p+0");
}

TEST_CASE("Nori materials: materials of Mitsuba are read with names in camelCase") {
  CHECK(material("roughconductor", word("material", "Au") + number("alphaU", "0.5") + number("alphaV", "0.25")) !=
        material("roughconductor"));
  CHECK(material("thindielectric", word("intIOR", "water")) ==
        dump_all("dielectric", 1.333f, 1.000277f, *find_dispersion("water"),
                 "constant 0x1p+0 constant 0x1p+0 1 0x1p+0 constant 0x1p+0"));
  CHECK(material("roughplastic", "<color name='diffuseReflectance' value='0.25'/>" + number("alpha", "0.5")) ==
        dump_all("plastic", 1.49f, 1.000277f, "rgb 0x1p-2 0x1p-2 0x1p-2 constant 0x1p+0 0 beckmann 0x1p-1 0x1p-1"));
  CHECK(material("principled", "<color name='baseColor' value='0.25'/>").starts_with("principled rgb 0x1p-2"));
  CHECK(material("twosided", bsdf("diffuse")) == "twosided 0 0");
  CHECK(material("mask", bsdf("mirror") + number("opacity", "0.25")) == "mask 0x1p-2 0");
  CHECK(material("normalmap", "<boolean name='flipGreen' value='true'/>" + bsdf("microfacet") +
                                  "<texture name='normals' type='image'>" + word("filename", "image.png") +
                                  "</texture>") == "normalmap 0 1 0 0x1p+0 0");
}

TEST_CASE("Nori materials: every parameter that may be textured is") {
  for (const auto& [type, parameters] :
       {std::pair{"diffuse", "albedo"},
        {"microfacet", "kd alpha"},
        {"disney",
         "baseColor metallic subsurface specular specularTint roughness anisotropic sheen sheenTint clearcoat "
         "clearcoatGloss"}}) {
    CAPTURE_BINDING(type);
    std::istringstream names(parameters);
    std::string inside;
    int count = 0;
    for (std::string name; names >> name; ++count)
      inside += "<texture name='" + name + "' type='checkerboard_" + (count == 0 ? "color" : "float") + "'/>";
    const std::string text = material(type, inside);
    CAPTURE(text);
    for (int i = 0; i < count; ++i) CHECK(contains(text + " ", " texture " + std::to_string(i) + " "));
  }
}

TEST_CASE("Nori textures: checkerboards have the documented parameters") {
  const TextureDescription plain = texture_of("checkerboard_color");
  CHECK(dump(plain).starts_with("checkerboard constant 0x0p+0 constant 0x1p+0"));
  CHECK(square(plain, 0.5f, 0.5f) == 0);
  CHECK(square(plain, 1.5f, 0.5f) == 1);
  CHECK(square(plain, 1.5f, -0.5f) == 0);
  CHECK(
      dump(texture_of("checkerboard_color", "<color name='value1' value='1,0,0'/><color name='value2' value='0,1,0'/>"))
          .starts_with("checkerboard rgb 0x1p+0 0x0p+0 0x0p+0 rgb 0x0p+0 0x1p+0 0x0p+0"));
  CHECK(dump(texture_of("checkerboard_float", number("value1", "0.25") + number("value2", "0.5")))
            .starts_with("checkerboard constant 0x1p-2 constant 0x1p-1"));
  // A square is `scale` wide, and one begins at `delta`.
  for (const char* placement : {"<vector2 name='scale' value='0.25,0.5'/><point2 name='delta' value='0.1,0.2'/>",
                                "<vector name='scale' value='0.25 0.5'/><point name='delta' value='0.1 0.2'/>"}) {
    const TextureDescription t = texture_of("checkerboard_float", placement);
    CHECK(square(t, 0.11f, 0.21f) == 0);
    CHECK(square(t, 0.34f, 0.69f) == 0);
    CHECK(square(t, 0.36f, 0.69f) == 1);
    CHECK(square(t, 0.34f, 0.71f) == 1);
    CHECK(square(t, 0.36f, 0.71f) == 0);
    CHECK(square(t, 0.09f, 0.21f) == 1);
  }
  CHECK(square(texture_of("checkerboard_float", number("scale", "0.1")), 0.15f, 0.05f) == 1);
}

TEST_CASE("Nori textures: constants are read") {
  CHECK(material("diffuse",
                 "<texture name='albedo' type='constant_color'><color name='value' value='0,0.5,1'/>"
                 "</texture>") == "diffuse rgb 0x0p+0 0x1p-1 0x1p+0");
  CHECK(
      material("microfacet", "<texture name='alpha' type='constant_float'>" + number("value", "0.5") + "</texture>") ==
      dump_all("nori_microfacet", 1.5046f, 1.000277f, 0.5f, "constant 0x1p-1"));
}

TEST_CASE("Nori textures: images are upright") {
  const std::string file = word("filename", "image.png");
  const std::string unchanged = " 0x1p+0 0 0x1p+0 0";  // BitmapDescription::change and channel
  const std::string as_is = unchanged + " to_uv " + dump_all(1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f);
  CHECK(dump(texture_of("bitmap", file)) == "bitmap image.png 0 0 0 0" + as_is);
  CHECK(dump(texture_of("bitmap", file + word("wrapMode", "clamp") + word("filterType", "nearest") +
                                      "<boolean name='raw' value='true'/>")) == "bitmap image.png 1 2 2 1" + as_is);
  CHECK(dump(texture_of("image", file + word("wrap", "mirror") + word("interpolation", "nearest"))) ==
        "bitmap image.png 1 1 1 0" + unchanged + " to_uv " + dump_all(1.0f, 0.0f, -0.0f, 0.0f, 1.0f, -0.0f));
  CHECK(dump(texture_of("image", file + word("filter", "nearest"))).starts_with("bitmap image.png 1 0 0 0"));
  CHECK(texture_of("image", file + "<vector2 name='scale' value='0.5,0.25'/><point2 name='delta' value='0.5,1'/>")
            .to_uv == std::array<float, 6>{2, 0, -1, 0, 4, -4});
  CHECK(texture_of("bitmap", file + number("uscale", "2") + number("voffset", "0.5")).to_uv ==
        std::array<float, 6>{2, 0, 0, 0, 1, 0.5f});
  CHECK(dump(texture_of("checkerboard")).starts_with(dump_all("checkerboard constant", 0.4f, "constant", 0.2f)));
  CHECK(dump(texture_of("mesh_attribute", word("name", "vertex_color"))).starts_with("mesh_attribute vertex_color"));
}

TEST_CASE("Nori materials and textures: errors have line and fault and nearest name") {
  const auto texture = [](const std::string& type, const std::string& inside = "") {
    return bsdf("diffuse", "\n<texture name='albedo' type='" + type + "'>" + inside + "</texture>");
  };
  check_errors(
      {
          {bsdf("disnei"), "scene.xml:4: unknown bsdf plugin 'disnei', did you mean 'disney'?"},
          {bsdf("disney", number("specTint", "0.5")), "unknown property 'specTint' of bsdf 'disney'"},
          {bsdf("disney", number("metalic", "0.5")), "did you mean 'metallic'?"},
          {bsdf("disney", "\n" + number("roughness", "2")),
           "scene.xml:5: property 'roughness' of bsdf 'disney' is '2'"},
          {bsdf("microfacet", number("alpha", "-1")), "expected a non-negative number"},
          {bsdf("microfacet", "<color name='ks' value='1'/>"), "unknown property 'ks' of bsdf 'microfacet'"},
          {bsdf("diffuse", number("reflectivity", "0.5")), "unknown property 'reflectivity' of bsdf 'diffuse'"},
          {texture("checkerbord_color"),
           "scene.xml:5: unknown texture plugin 'checkerbord_color', did you mean 'checkerboard_color'?"},
          {texture("checkerboard_color", number("value3", "1")),
           "unknown property 'value3' of texture 'checkerboard_color', did you mean"},
          {texture("checkerboard_color", "<vector2 name='scale' value='1,0'/>"), "is 0 along an axis"},
          {texture("checkerboard_color", "<vector2 name='scale' value='1,2,3'/>"), "has 3 numbers, expected two"},
          {texture("checkerboard_color", "<color name='scale' value='1'/>"), "is given as <color>, expected vector2"},
          {texture("image"), "texture 'image' needs the string 'filename'"},
          {texture("image", word("filename", "gone.png")), "scene.xml:5: file 'gone.png' not found"},
          {texture("image", word("filename", "image.png") + word("wrap", "fold")),
           "is 'fold', expected repeat, mirror or"},
          {texture("constant_color", "<color name='value' value='2'/>"), "expected values within [0, 1]"},
      },
      [](const std::string& bsdfs) { return error_of_text(scene_with(bsdfs)); });
}

}  // namespace sheaf::test_nori_bsdf
