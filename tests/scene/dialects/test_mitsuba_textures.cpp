// Textures of Mitsuba in the notations of all versions.
#include "tests/support/mitsuba_testing.h"
#include "tests/support/scene_errors.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>

namespace sheaf::test_mitsuba_textures {

using namespace test;

namespace {

/// The last texture of a material, as text.
std::string texture(const std::string& inside, const std::string& type = "bitmap") {
  const std::string file = type == "bitmap" ? "<string name='filename' value='image.png'/>" : "";
  const std::string element = "<texture type='" + type + "' name='reflectance'>" + file + inside + "</texture>";
  return dump(read_text(mitsuba_scene(bsdf("diffuse", element))).textures.back());
}

/// Applies a 2x3 matrix in row order.
std::array<float, 2> apply(const std::array<float, 6>& m, float u, float v) {
  return {m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]};
}

}  // namespace

TEST_CASE("Mitsuba materials: checkerboards of numbers are swapped except in version 0.6") {
  const std::string text = mitsuba_scene(
      "<bsdf type='mask'><texture name='opacity' type='checkerboard' id='squares'>"
      "<float name='color0' value='0.25'/><texture name='color1' type='checkerboard'/></texture>"
      "<bsdf type='diffuse'><ref name='reflectance' id='squares'/></bsdf></bsdf>");
  const auto first = [](const Description& d, TextureId id) {
    const auto& squares = std::get<CheckerboardDescription>(d.textures.at(static_cast<std::size_t>(id)).model);
    const auto* value = std::get_if<SpectrumDescription>(&squares.color0);
    return value != nullptr ? std::get<SpectrumDescription::Constant>(value->value).value : -1.0f;
  };
  for (const bool old : {false, true}) {
    std::string version = text;
    if (old) version.replace(version.find("3.0.0"), 5, "0.6.0");
    const Description d = read_text(version);
    const auto& mask = std::get<MaskDescription>(d.materials.back().model);
    const auto& diffuse = std::get<DiffuseDescription>(d.materials.at(static_cast<std::size_t>(mask.nested)).model);
    CHECK(first(d, std::get<TextureId>(mask.opacity)) == (old ? 0.25f : -1.0f));
    CHECK(first(d, std::get<TextureId>(diffuse.reflectance)) == 0.25f);
    CHECK(d.textures.size() == (old ? 2 : 4));
  }
}

TEST_CASE("Mitsuba textures: bitmaps have the documented parameters") {
  // v of an image points down: (u, v) becomes (u, 1 - v).
  const std::string unchanged = " 0x1p+0 0 0x1p+0 0";  // BitmapDescription::change and channel
  const std::string upright = unchanged + " to_uv " + dump_all(1.0f, 0.0f, 0.0f, -0.0f, -1.0f, 1.0f);
  CHECK(texture("") == "bitmap image.png 0 0 0 0" + upright);
  CHECK(texture("<boolean name='raw' value='true'/>") == "bitmap image.png 0 0 0 1" + upright);
  CHECK(texture(word("filter_type", "nearest") + word("wrap_mode", "mirror")) == "bitmap image.png 1 1 1 0" + upright);
  CHECK(texture(word("filterType", "bilinear") + word("wrapMode", "clamp")) == "bitmap image.png 0 2 2 0" + upright);
  CHECK(texture(word("wrapModeU", "clamp") + word("wrapModeV", "mirror")) == "bitmap image.png 0 2 1 0" + upright);
  CHECK(texture(word("wrapMode", "clamp") + word("wrapModeV", "repeat")) == "bitmap image.png 0 2 0 0" + upright);
  CHECK(texture(number("gamma", "1")) == "bitmap image.png 0 0 0 1" + upright);
  CHECK(texture(number("gamma", "-1")) == "bitmap image.png 0 0 0 0" + upright);
  CHECK(texture(word("format", "variant") +
                "<boolean name='accel' value='false'/><boolean name='cache' value='true'/>" +
                number("maxAnisotropy", "8")) == "bitmap image.png 0 0 0 0" + upright);
  CHECK(contains(texture(word("channel", "all")), unchanged));
  CHECK(contains(texture(word("channel", "g")), " 0x1p+0 0 0x1p+0 2 to_uv"));
  CHECK(contains(texture(word("channel", "a")), " 0x1p+0 0 0x1p+0 4 to_uv"));
  auto notes = [](const std::string& inside) {
    return read_text(mitsuba_scene(bsdf("diffuse", "<texture type='bitmap' name='reflectance'>" +
                                                       word("filename", "image.png") + inside + "</texture>")))
        .notes;
  };
  CHECK(notes("").empty());
  for (const char* filter : {"ewa", "trilinear"}) {
    REQUIRE(notes(word("filterType", filter)).size() == 1);
    CHECK(contains(notes(word("filterType", filter))[0], "scene.xml:4: texture 'bitmap' has the filter"));
  }
  REQUIRE(notes(number("gamma", "2.2")).size() == 1);
  CHECK(contains(notes(number("gamma", "2.2"))[0], "rendered as sRGB"));
}

// Positions of uv points in the image, found with Mitsuba 3.9 and an image of four colors: row 0 is at v = 0, and
// to_uv applies to the original uv.
TEST_CASE("Mitsuba textures: uv transforms are applied") {
  auto to_uv = [](const std::string& inside, const char* type = "bitmap") {
    const std::string file = std::string(type) == "bitmap" ? word("filename", "image.png") : "";
    return read_text(mitsuba_scene(bsdf("diffuse", std::string("<texture name='reflectance' type='") + type + "'>" +
                                                       file + inside + "</texture>")))
        .textures.at(0)
        .to_uv;
  };
  auto transform = [](const std::string& steps) { return "<transform name='to_uv'>" + steps + "</transform>"; };
  auto is_at = [](std::array<float, 2> found, float u, float v) {
    return std::abs(found[0] - u) < 1e-5f && std::abs(found[1] - v) < 1e-5f;
  };
  CHECK(is_at(apply(to_uv(""), 0.25f, 0.125f), 0.25f, 0.875f));
  CHECK(is_at(apply(to_uv(transform("<translate x='0.5'/>")), 0.1f, 0.1f), 0.6f, 0.9f));
  CHECK(is_at(apply(to_uv(transform("<translate y='0.5'/>")), 0.1f, 0.1f), 0.1f, 0.4f));
  CHECK(is_at(apply(to_uv(transform("<scale x='2' y='3'/>")), 0.1f, 0.2f), 0.2f, 0.4f));
  CHECK(is_at(apply(to_uv(transform("<scale value='2'/><translate value='-.5,-.5,0'/>")), 0.5f, 0.25f), 0.5f, 1.0f));
  CHECK(is_at(apply(to_uv(transform("<rotate z='1' angle='90'/>")), 0.2f, 0.1f), -0.1f, 0.8f));
  CHECK(is_at(
      apply(to_uv(number("uscale", "2") + number("vscale", "4") + number("uoffset", "0.5") + number("voffset", "0.25")),
            0.1f, 0.1f),
      0.7f, 0.35f));
  CHECK(is_at(apply(to_uv(number("uvscale", "2")), 0.1f, 0.2f), 0.2f, 0.6f));
  // Checkerboards are symmetric under the flip of v.
  CHECK(is_at(apply(to_uv("", "checkerboard"), 0.25f, 0.125f), 0.25f, 0.125f));
  CHECK(is_at(apply(to_uv(transform("<translate x='0.5'/>"), "checkerboard"), 0.1f, 0.1f), 0.6f, 0.1f));
  CHECK(is_at(apply(to_uv(number("vscale", "4"), "checkerboard"), 0.1f, 0.1f), 0.1f, 0.4f));
}

TEST_CASE("Mitsuba textures: checkerboards and mesh attributes and spectra are read") {
  const std::string as_is = " to_uv " + dump_all(1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f);
  CHECK(texture("", "checkerboard") == dump_all("checkerboard constant", 0.4f, "constant", 0.2f) + as_is);
  CHECK(texture("<rgb name='color0' value='0,0.5,1'/>" + number("color1", "0.5"), "checkerboard") ==
        "checkerboard rgb 0x0p+0 0x1p-1 0x1p+0 constant 0x1p-1" + as_is);
  CHECK(texture("<texture type='checkerboard' name='color0'/>", "checkerboard") ==
        dump_all("checkerboard texture 0 constant", 0.2f) + as_is);
  CHECK(texture(word("name", "vertex_color"), "mesh_attribute") == "mesh_attribute vertex_color 0x1p+0" + as_is);
  CHECK(texture(word("name", "face_x") + number("scale", "2"), "mesh_attribute") ==
        "mesh_attribute face_x 0x1p+1" + as_is);
  CHECK(material("diffuse", "<texture type='uniform' name='reflectance'>" + number("value", "0.25") + "</texture>") ==
        "diffuse constant 0x1p-2");
  CHECK(material("diffuse", "<texture type='srgb' name='reflectance'><rgb name='color' value='0,0,1'/></texture>") ==
        "diffuse rgb 0x0p+0 0x0p+0 0x1p+0");
}

TEST_CASE("Mitsuba textures: references to a texture share it") {
  const Description d = read_text(mitsuba_scene(
      "<bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf><texture type='mesh_attribute' id='t'>" +
      word("name", "vertex_x") +
      "</texture>"
      "<bsdf type='principled'><ref name='base_color' id='t'/><ref name='roughness' id='t'/></bsdf>"
      "<texture type='mesh_attribute'><string name='name' value='vertex_color'/></texture>"));
  REQUIRE(d.textures.size() == 2);
  CHECK(d.textures[0].id == "t");
  CHECK(d.textures[0].where.line == 4);
  CHECK(dump(d.materials.at(0)) == "diffuse texture 0");
  CHECK(contains(dump(d.materials.at(1)), "principled texture 0 texture 0 "));
}

TEST_CASE("Mitsuba textures: errors have line and fault and nearest name") {
  auto bitmap = [](const std::string& inside) {
    return "<bsdf type='diffuse'><texture type='bitmap' name='reflectance'>" + word("filename", "image.png") + "\n" +
           inside + "</texture></bsdf>";
  };
  check_errors(
      {
          {"<texture type='checkerboard' id='a'><ref name='color0' id='a'/></texture>" +
               bsdf("diffuse", "<ref name='reflectance' id='a'/>"),
           "texture 'checkerboard' refers to itself"},
          {bsdf("diffuse", "<texture type='uniform' name='reflectance'>" + number("value", "2") + "</texture>"),
           "property 'reflectance' of bsdf 'diffuse' contains 2, expected values within [0, 1]"},
          {bsdf("diffuse", "<texture type='curvature' name='reflectance'/>"),
           "unknown texture plugin 'curvature' (known: bitmap, blackbody, checkerboard, d65, gridtexture, illuminant, "
           "irregular, mesh_attribute,"},
          {"<texture type='mesh_attribute'/>", "scene.xml:4: texture 'mesh_attribute' needs the string 'name'"},
          {"<texture type='mesh_attribute'>" + word("name", "color") + "</texture>", "begins with vertex_ or face_"},
          {"<texture type='bitmap'>\n" + word("filename", "gone.png") + "</texture>",
           "scene.xml:5: file 'gone.png' not found"},
          {bitmap(word("filter_type", "cubic")), "scene.xml:5: property 'filter_type' of texture 'bitmap' is 'cubic'"},
          {bitmap(word("wrap_mode", "zero")), "is 'zero', expected repeat, mirror or clamp"},
          {bitmap(word("wrap_mode", "mirror") + word("wrap", "clamp")), "is set together with 'wrap_mode'"},
          {bitmap(number("gamma", "1.8")), "expected 1 (linear) or -1 (sRGB)"},
          {bitmap(number("gamma", "1") + "<boolean name='raw' value='true'/>"), "is set together with 'raw'"},
          {bitmap(word("channel", "x")), "is 'x', expected all, r, g, b or a"},
          {bitmap(number("uscale", "2") + "<transform name='to_uv'><scale value='2'/></transform>"),
           "is set together with 'to_uv'"},
          {bitmap(number("uscal", "2")),
           "scene.xml:5: unknown property 'uscal' of texture 'bitmap', did you mean 'uscale'?"},
      },
      error_of_elements);
}

}  // namespace sheaf::test_mitsuba_textures
