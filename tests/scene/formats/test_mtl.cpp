// MTL files: every keyword, every kind of error, and the resulting materials.
#include "scene/dialects/model/obj_materials.h"
#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/mtl.h"
#include "tests/support/files/mesh_files.h"

#include <doctest/doctest.h>

#include <limits>
#include <random>

namespace sheaf::test_mtl {

using namespace test;

namespace {

MtlLibrary read(const std::string& text) {
  const TemporaryFile file("lib.mtl", text);
  return read_mtl(file.path());
}

std::string error_in(const std::string& text) {
  return error_of([&] { read(text); });
}

MtlMaterial one(const std::string& properties) { return read("newmtl m\n" + properties).materials.at(0); }

/// A material with its nested materials, from the outside in.
struct Mapped {
  Description description;
  std::vector<MaterialDescription> layers;

  template <class T> const T& layer(std::size_t i) const { return std::get<T>(layers.at(i).model); }
  template <class T> const T& base() const { return std::get<T>(layers.back().model); }
  const TextureDescription& texture(TextureId id) const {
    return description.textures.at(static_cast<std::size_t>(id));
  }
  template <class Input> const BitmapDescription& bitmap(const Input& input) const {
    return std::get<BitmapDescription>(texture(std::get<TextureId>(input)).model);
  }
};

Mapped map(const std::string& properties, bool flip_tex_coords = true) {
  Mapped result;
  MaterialId id = add_mtl_material(one(properties), flip_tex_coords, result.description);
  for (;;) {
    result.layers.push_back(result.description.materials.at(static_cast<std::size_t>(id)));
    const auto& model = result.layers.back().model;
    if (const auto* mask = std::get_if<MaskDescription>(&model)) {
      id = mask->nested;
    } else if (const auto* sides = std::get_if<TwoSidedDescription>(&model)) {
      CHECK(sides->front == sides->back);
      id = sides->front;
    } else if (const auto* bump = std::get_if<BumpMapDescription>(&model)) {
      id = bump->nested;
    } else if (const auto* normals = std::get_if<NormalMapDescription>(&model)) {
      id = normals->nested;
    } else {
      return result;
    }
  }
}

Vec3f rgb(const SpectrumInput& input) {
  return std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(input).value).value;
}

}  // namespace

TEST_CASE("mtl: given parameters are read and missing ones have defaults") {
  const MtlLibrary library = read(
      "# comment\r\n\tnewmtl  red paint \r\nKd .5 +0.25 1e-1 # why\nKs 0.5\n Ns 100\n"
      "Ni\t1.5\nd 0.25\nTr 0.5\nillum 7\nTf 1 .5 0\nKe 2 0 0\nnewmtl empty\rnewmtl pbr\n"
      "Tr 0.25\nPr .1\nPm .2\nPs .3\nPc .4\nPcr .5\naniso .6\nanisor .7\nKa 1 1 1");
  CHECK(library.notes.empty());
  REQUIRE(library.materials.size() == 3);
  const MtlMaterial& red = library.materials[0];
  CHECK(red.name == "red paint");
  CHECK(red.where.line == 2);
  CHECK(red.diffuse == Vec3f{0.5f, 0.25f, 0.1f});
  CHECK(red.specular == Vec3f{0.5f, 0.5f, 0.5f});
  CHECK(red.transmission == Vec3f{1, 0.5f, 0});
  CHECK(red.emission == Vec3f{2, 0, 0});
  CHECK(red.shininess == 100.0f);
  CHECK(red.ior == 1.5f);
  CHECK(red.dissolve == 0.25f);
  CHECK(red.illum == 7);
  CHECK_FALSE(red.roughness);
  const MtlMaterial& empty = library.materials[1];
  CHECK(empty.where.line == 12);
  CHECK_FALSE((empty.diffuse || empty.specular || empty.shininess || empty.dissolve || empty.illum));
  const MtlMaterial& pbr = library.materials[2];
  CHECK(pbr.dissolve == 0.75f);
  CHECK(pbr.roughness == 0.1f);
  CHECK(pbr.metallic == 0.2f);
  CHECK(pbr.sheen == 0.3f);
  CHECK(pbr.clearcoat == 0.4f);
  CHECK(pbr.clearcoat_roughness == 0.5f);
  CHECK(pbr.anisotropy == 0.6f);
}

TEST_CASE("mtl: textures have options and are found in their folders") {
  const MtlMaterial m =
      one("map_Kd an image.png\nmap_Ks -s 2 3 4 -o 0.5 -clamp on sub\\dir\\b.png\nmap_d -s 2 c.png\n"
          "map_Bump -bm 0.5 -mm 0 1 -imfchan l d.png\nnorm -o 1 2 3 4.png\nmap_Pr -s 1 1 5\n");
  CHECK(m.map_diffuse->file.filename() == "an image.png");
  CHECK(m.map_diffuse->where.line == 2);
  CHECK(contains(m.map_specular->file.string(), "/sub/dir/b.png"));
  CHECK(m.map_specular->scale.x == 2.0f);
  CHECK(m.map_specular->scale.y == 3.0f);
  CHECK(m.map_specular->offset.x == 0.5f);
  CHECK(m.map_specular->offset.y == 0.0f);
  CHECK(m.map_specular->clamp);
  CHECK(m.map_dissolve->scale.y == 1.0f);
  CHECK(m.map_dissolve->file.filename() == "c.png");
  CHECK(m.bump->bump_multiplier == 0.5f);
  CHECK(m.bump->file.filename() == "d.png");
  CHECK(m.normal->offset.y == 2.0f);
  CHECK(m.normal->file.filename() == "4.png");
  CHECK(m.map_roughness->file.filename() == "5");
  const TemporaryFolder folder;
  write_bytes(folder / "lib.mtl", "newmtl m\nmap_Kd C:\\models\\textures\\x.png\n");
  write_bytes(folder / "x.png", "");
  CHECK(read_mtl(folder / "lib.mtl").materials[0].map_diffuse->file == folder / "x.png");
}

TEST_CASE("mtl: malformed lines are errors with a line number") {
  for (const std::string number : {"", "x", "1,5", "nan", "inf", "1e99", "0.5f", "--1"}) {
    CHECK_MESSAGE(contains(error_in("newmtl m\n\nKd " + number), "lib.mtl:3: expected a number after 'Kd'"), number);
    CHECK(contains(error_in("newmtl m\nNs " + number + "\n"), "lib.mtl:2: expected a number after 'Ns'"));
  }
  CHECK(contains(error_in("newmtl m\nKd 1 2\n"), "expected a number after 'Kd', found ''"));
  CHECK(contains(error_in("newmtl\n"), "expected a material's name"));
  CHECK(contains(error_in("Kd 1 1 1\n"), "lib.mtl:1: expected 'newmtl' in front of the first property, found 'Kd'"));
  CHECK(contains(error_in("newmtl m\nillum 11\n"), "illumination model from 0 to 10"));
  CHECK(contains(error_in("newmtl m\nillum 1.5\n"), "illumination model from 0 to 10"));
  CHECK(contains(error_in("newmtl m\nmap_Kd\n"), "expected the name of an image after 'map_Kd'"));
  CHECK(contains(error_in("newmtl m\nmap_Kd -s 1\n"), "lib.mtl:2: expected the name of an image"));
  CHECK(contains(error_in("newmtl m\nmap_Kd -clmp on x.png\n"), "unknown option '-clmp' of 'map_Kd', did you mean"));
  CHECK(contains(error_of([] { read_mtl("/nowhere/at/all.mtl"); }), "not found"));
}

TEST_CASE("mtl: unsupported statements are noted once") {
  const MtlLibrary library = read(
      "newmtl m\nmap_Kdd x.png\nrefl x.png\nrefl y.png\nKd xyz 1 1 1\n"
      "map_Kd -mm 0 1 x.png\n");
  REQUIRE(library.notes.size() == 4);
  CHECK(contains(library.notes[0], "lib.mtl:2: unknown keyword 'map_Kdd' ignored, did you mean 'map_Kd'?"));
  CHECK(contains(library.notes[1], "lib.mtl:3: 'refl' is not supported"));
  CHECK(contains(library.notes[2], "'Kd' by 'spectral' or 'xyz'"));
  CHECK(contains(library.notes[3], "'-mm' is not supported"));
  CHECK_FALSE(library.materials[0].diffuse);
}

TEST_CASE("mtl: random edits give a library or an error") {
  const std::string valid = "newmtl m\nKd 1 0.5 0\nNs 10\nmap_Kd -s 1 2 -clamp on a.png\nillum 2\nTr 0.5\n# x\n";
  constexpr std::string_view kBytes = "0123456789 -.eKdNsmap_\r\n#\t\\\0";
  std::mt19937 random(5);
  for (int round = 0; round < 1000; ++round) {
    std::string text = valid;
    for (int edit = 0; edit < 3; ++edit) text[random() % text.size()] = kBytes[random() % kBytes.size()];
    error_in(text);
  }
  for (std::size_t size = 0; size < valid.size(); ++size) error_in(valid.substr(0, size));
}

TEST_CASE("mtl: diffuse materials are read") {
  const Mapped plain = map("Kd 0.5 0.25 0.125\nillum 1\nKs 1 1 1");
  REQUIRE(plain.layers.size() == 2);
  CHECK(rgb(plain.base<DiffuseDescription>().reflectance) == Vec3f{0.5f, 0.25f, 0.125f});
  CHECK(plain.layers[0].id == "m");
  CHECK(plain.layers[0].where.line == 1);
  CHECK(rgb(map("").base<DiffuseDescription>().reflectance) == Vec3f{0.5f, 0.5f, 0.5f});
  const Mapped mapped = map("Kd 0 0 0\nmap_Kd -clamp on a.png\n");
  const BitmapDescription& bitmap = mapped.bitmap(mapped.base<DiffuseDescription>().reflectance);
  CHECK(bitmap.file.filename() == "a.png");
  CHECK_FALSE(bitmap.raw);
  CHECK(bitmap.wrap_v == TextureWrap::kClamp);
  CHECK(mapped.description.textures[0].where.line == 3);
}

TEST_CASE("mtl: textures are flipped with the uv of the mesh") {
  for (const bool flip : {true, false}) {
    const Mapped m = map("map_Kd -s 2 3 -o 0.25 0.5 a.png\n", flip);
    const std::array<float, 6>& to = m.texture(TextureId{0}).to_uv;
    const Vec2f vt{0.125f, 0.375f}, uv{vt.x, flip ? 1 - vt.y : vt.y};
    CHECK(to[0] * uv.x + to[1] * uv.y + to[2] == 2 * vt.x + 0.25f);
    CHECK(to[3] * uv.x + to[4] * uv.y + to[5] == 3 * vt.y + 0.5f);
  }
}

TEST_CASE("mtl: plastics and metals and mirrors are recognized") {
  const Mapped coated = map("Kd 0.5 0.5 0.5\nKs 0.25 0.25 0.25\nNs 30\nNi 1.7\n");
  const auto& plastic = coated.base<PlasticDescription>();
  CHECK(rgb(plastic.diffuse_reflectance) == Vec3f{0.5f, 0.5f, 0.5f});
  CHECK(rgb(plastic.specular_reflectance) == Vec3f{0.25f, 0.25f, 0.25f});
  CHECK(plastic.int_ior == 1.7f);
  CHECK(std::get<float>(plastic.roughness->alpha_u) == 0.25f);
  CHECK(std::get<float>(plastic.roughness->alpha_v) == 0.25f);
  const Mapped gold = map("Kd 0 0 0\nKs 1 0.75 0.25\nNs 6\nillum 2\n");
  CHECK(rgb(gold.base<ConductorDescription>().specular_reflectance) == Vec3f{1, 0.75f, 0.25f});
  CHECK(std::get<float>(gold.base<ConductorDescription>().roughness->alpha_u) == 0.5f);
  const Mapped mirror = map("Kd 0.125 0.125 0.125\nKs 0.75 0.75 0.75\nNs 6\nillum 3\n");
  CHECK_FALSE(mirror.base<ConductorDescription>().roughness);
  CHECK_FALSE(mirror.base<ConductorDescription>().ior);
  CHECK_NOTHROW(map("Kd 0.75 0 0\nKs 0.5 0.5 0.5\nillum 3\n").base<PlasticDescription>());
  CHECK_NOTHROW(map("map_Kd a.png\nKs 0.5 0.5 0.5\nillum 5\n").base<PlasticDescription>());
  const Mapped mapped = map("Kd 1 1 1\nmap_Ks a.png\nNs 1e9");
  CHECK(mapped.bitmap(mapped.base<PlasticDescription>().specular_reflectance).file.filename() == "a.png");
  CHECK(std::get<float>(mapped.base<PlasticDescription>().roughness->alpha_u) == 1e-3f);
  CHECK(std::get<float>(map("Ks 1 1 1\nNs -5").base<PlasticDescription>().roughness->alpha_u) == 1.0f);
}

TEST_CASE("mtl: glass is recognized") {
  for (const std::string illum : {"4", "6", "7", "9"}) {
    const Mapped glass = map("Kd 0 0 0\nKs 1 1 1\nd 0.5\nNi 1.25\nTf 1 0.5 1\nillum " + illum);
    REQUIRE(glass.layers.size() == 1);
    const auto& dielectric = glass.base<DielectricDescription>();
    CHECK(dielectric.int_ior == 1.25f);
    CHECK(dielectric.ext_ior == 1.0f);
    CHECK(rgb(dielectric.specular_transmittance) == Vec3f{1, 0.5f, 1});
    CHECK_FALSE(dielectric.roughness);
  }
  CHECK(map("Tf 1 1 1\nillum 7").base<DielectricDescription>().int_ior == 1.5f);
  CHECK(std::get<float>(map("Pr 0.5\nNi 1.5\nillum 7").base<DielectricDescription>().roughness->alpha_v) == 0.25f);
  CHECK_NOTHROW(map("Tf 1 1 1\nNi 1\nillum 4").base<DiffuseDescription>());  // as exporters write for opaque materials
  CHECK_NOTHROW(map("Ni 1.5\nillum 2\nd 0.5").base<DiffuseDescription>());
  CHECK_NOTHROW(map("Ni 1.5\nillum 4\nmap_d a.png").base<DiffuseDescription>());
}

TEST_CASE("mtl: principled materials are read and values out of range are clamped") {
  const Mapped m = map("Kd 1 0 0\nPr 0.25\nPm 2\nPs -1\nPc 0.5\nPcr 0.25\naniso 0.75\nNi 1.25\nKs 1 1 1\n");
  const auto& p = m.base<PrincipledDescription>();
  CHECK(rgb(p.base_color) == Vec3f{1, 0, 0});
  CHECK(std::get<float>(p.roughness) == 0.25f);
  CHECK(std::get<float>(p.metallic) == 1.0f);
  CHECK(std::get<float>(p.sheen) == 0.0f);
  CHECK(std::get<float>(p.clearcoat) == 0.5f);
  CHECK(std::get<float>(p.clearcoat_gloss) == 0.75f);
  CHECK(std::get<float>(p.anisotropic) == 0.75f);
  CHECK(p.eta == 1.25f);
  const Mapped mapped = map("map_Kd a.png\nmap_Pr b.png\nmap_Pm c.png\nmap_Ps d.png\n");
  const auto& q = mapped.base<PrincipledDescription>();
  CHECK_FALSE(mapped.bitmap(q.base_color).raw);
  CHECK(mapped.bitmap(q.roughness).raw);
  CHECK(mapped.bitmap(q.metallic).file.filename() == "c.png");
  CHECK(mapped.bitmap(q.sheen).file.filename() == "d.png");
}

TEST_CASE("mtl: masks and bump maps wrap the material in the order of Mitsuba") {
  const Mapped half = map("d 0.25\nmap_Bump -bm 3 a.png");
  REQUIRE(half.layers.size() == 4);
  CHECK(std::get<float>(half.layer<MaskDescription>(0).opacity) == 0.25f);
  CHECK_NOTHROW(half.layer<TwoSidedDescription>(1));
  CHECK(half.layer<BumpMapDescription>(2).scale == 3.0f);
  const Mapped cut_out = map("map_d a.png\nd 0.5\nnorm b.png\nbump c.png");
  REQUIRE(cut_out.layers.size() == 4);
  CHECK(cut_out.bitmap(cut_out.layer<MaskDescription>(0).opacity).raw);
  const TextureId normals = cut_out.layer<NormalMapDescription>(2).normals;
  CHECK(cut_out.texture(normals).id == "b.png");
  CHECK(std::get<BitmapDescription>(cut_out.texture(normals).model).raw);
  CHECK(map("d 1").layers.size() == 2);
  CHECK(std::get<float>(map("d -1").layer<MaskDescription>(0).opacity) == 0.0f);
}

TEST_CASE("mtl: options may follow a file name and names may be quoted or contain spaces") {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "my image.png", "wood -s 2.png", "2.png"}) write_bytes(folder / name, "");
  const auto texture = [&](const std::string& arguments) {
    write_bytes(folder / "lib.mtl", "newmtl m\nmap_Kd " + arguments + "\n");
    return read_mtl(folder / "lib.mtl").materials.at(0).map_diffuse.value();
  };
  const auto check = [&](const std::string& arguments, const std::string& name, Vec2f scale, Vec2f offset, bool clamp) {
    CAPTURE(arguments);
    const MtlTexture found = texture(arguments);
    CHECK(found.file.filename() == name);
    CHECK(found.scale.x == scale.x);
    CHECK(found.scale.y == scale.y);
    CHECK(found.offset.x == offset.x);
    CHECK(found.offset.y == offset.y);
    CHECK(found.clamp == clamp);
  };
  check("a.png -s 2 3 1", "a.png", {2, 3}, {0, 0}, false);
  check("a.png -s 2", "a.png", {2, 1}, {0, 0}, false);
  check("a.png -s 2 3", "a.png", {2, 3}, {0, 0}, false);
  check("-s 2 3 a.png -o .5 .25 0 -clamp on", "a.png", {2, 3}, {0.5f, 0.25f}, true);
  check("my image.png -clamp on", "my image.png", {1, 1}, {0, 0}, true);
  check("\"my image.png\"", "my image.png", {1, 1}, {0, 0}, false);
  check("-s 2 2 \"my image.png\" -o 1 1", "my image.png", {2, 2}, {1, 1}, false);
  check("\"wood -s 2.png\" -clamp on", "wood -s 2.png", {1, 1}, {0, 0}, true);
  check("wood -s 2.png", "wood -s 2.png", {1, 1}, {0, 0}, false);
  check("-s 3 2.png", "2.png", {3, 1}, {0, 0}, false);
  check("lost image.png -s 2 2", "lost image.png", {2, 2}, {0, 0}, false);
  check("a.png # the wood", "a.png", {1, 1}, {0, 0}, false);
  check("a.png -clamp on # the wood", "a.png", {1, 1}, {0, 0}, true);
  CHECK(texture("a.png -bm 0.5").bump_multiplier == 0.5f);
  CHECK(contains(error_in("newmtl m\nmap_Kd \"a.png\n"), "lib.mtl:2: a name has no closing quotation mark"));
  CHECK(contains(error_in("newmtl m\nmap_Kd \"a.png\" b.png\n"), "expected nothing or an option after the name"));
  CHECK(contains(error_in("newmtl m\nmap_Kd \"a.png\" -clmp on\n"), "unknown option '-clmp'"));
  CHECK(contains(error_in("newmtl m\nmap_Kd a.png -s x\n"), "expected a number after 'map_Kd', found 'x'"));
  CHECK(contains(error_in("newmtl m\nmap_Kd \"\"\n"), "expected the name of an image after 'map_Kd'"));
}

}  // namespace sheaf::test_mtl
