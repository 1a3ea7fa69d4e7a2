// Materials of Mitsuba: defaults, parameters in the notations of all versions, and nesting.
#include "scene/compile/compile.h"
#include "scene/compile/compile_materials.h"
#include "tests/support/mitsuba_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace sheaf::test_mitsuba_bsdf {

using namespace test;

TEST_CASE("Mitsuba materials: defaults match the documentation") {
  const std::string one = " constant 0x1p+0", half = " constant 0x1p-1";
  const std::string glass = dump_all(1.5046f, 1.000277f) + one + one;
  const std::string rough = dump_all(" beckmann", 0.1f, 0.1f);
  const std::string unscaled = " 0x1p+0 constant 0x1p+0";  // specular and specular_color, which glTF sets
  CHECK(material("diffuse") == "diffuse" + half);
  CHECK(material("conductor") == "conductor" + one);
  CHECK(material("roughconductor") == "conductor" + one + rough);
  CHECK(material("dielectric") == "dielectric " + glass + " 0" + unscaled);
  CHECK(material("thindielectric") == "dielectric " + glass + " 1" + unscaled);
  CHECK(material("roughdielectric") == "dielectric " + glass + " 0" + rough + unscaled);
  CHECK(material("plastic") == "plastic " + dump_all(1.49f, 1.000277f) + half + one + " 0");
  CHECK(material("roughplastic") == "plastic " + dump_all(1.49f, 1.000277f) + half + one + " 0" + rough);
  CHECK(material("principled") == "principled" + half + dump_all(" ", 0.5f).substr(1) + " 0x0p+0 0x0p+0 0x0p+0 0x0p+0" +
                                      " 0x0p+0 0x0p+0 0x0p+0 0x0p+0 0x0p+0 0x1.8p+0");
  CHECK(material("principledthin") ==
        "principledthin" + half + " 0x1p-1 0x0p+0 0x0p+0 0x1.8p+0 0x0p+0 0x0p+0 0x0p+0" + " 0x0p+0 0x0p+0");
  CHECK(material("hair") == "hair 0 " + dump_all(1.3f, 0.2f, 0.3f, 0.3f, 2.0f, 1.55f, 1.000277f));
  CHECK(material("null") == "null");
  CHECK(material("mask", bsdf("diffuse")) == "mask 0x1p-1 0");
  CHECK(material("blendbsdf", bsdf("diffuse") + bsdf("plastic")) == "blendbsdf 0x1p-1 0 1");
  const std::string image = "<texture type='bitmap' name='any'>" + word("filename", "image.png") + "</texture>";
  CHECK(material("bumpmap", bsdf("diffuse") + image) == "bumpmap 0 0x1p+0 0");
  CHECK(material("normalmap", bsdf("diffuse") + image) == "normalmap 0 0 0 0x1p+0 0");
}

TEST_CASE("Mitsuba materials: dispersion is off for names of Mitsuba and on for other names by default") {
  const auto disperses = [](const std::string& inside) {
    return read_material<DielectricDescription>("dielectric", inside).int_dispersion.has_value();
  };
  const std::string on = "<boolean name='dispersion' value='true'/>",
                    off = "<boolean name='dispersion' value='false'/>";
  CHECK_FALSE(disperses(word("int_ior", "bk7")));
  CHECK(disperses(word("int_ior", "bk7") + on));
  CHECK_FALSE(disperses(word("int_ior", "bk7") + off));
  CHECK(disperses(word("int_ior", "sf11")));
  CHECK_FALSE(disperses(word("int_ior", "sf11") + off));
  CHECK(disperses(word("int_cauchy", "1.5, 0.004")));
  CHECK_FALSE(disperses(number("int_ior", "1.5")));
  // Nori defines no names of its own, so that all names are Sheaf's.
  const auto nori = [](const std::string& inside) {
    const Description d = read_text(
        "<scene><camera type='perspective'/><integrator type='path'/><mesh type='sphere'>"
        "<bsdf type='dielectric'>" +
        inside + "</bsdf></mesh></scene>");
    return std::get<DielectricDescription>(d.materials.back().model).int_dispersion.has_value();
  };
  CHECK(nori(word("intIOR", "bk7")));
  CHECK_FALSE(nori(word("intIOR", "bk7") + off));
}

TEST_CASE("Mitsuba materials: every number and colour and switch is read in both naming styles") {
  for (const bool camel : {false, true}) {
    CAPTURE(camel);
    auto name = [&](const char* snake, const char* other) { return camel ? other : snake; };
    const std::string iors = word(name("int_ior", "intIOR"), "water") + number(name("ext_ior", "extIOR"), "1.25");
    const std::string speculars = number(name("specular_reflectance", "specularReflectance"), "0.25") +
                                  number(name("specular_transmittance", "specularTransmittance"), "0.75");
    const std::string along = number(name("alpha_u", "alphaU"), "0.5") + number(name("alpha_v", "alphaV"), "0.25");
    const std::string visible =
        "<boolean name='" + std::string(name("sample_visible", "sampleVisible")) + "' value='false'/>";
    const std::string base = number(name("base_color", "baseColor"), "0.5");
    CHECK(material("dielectric", iors + speculars) ==
          dump_all("dielectric", 1.333f, 1.25f, "constant 0x1p-2 constant 0x1.8p-1 0 0x1p+0 constant 0x1p+0"));
    CHECK(material("thindielectric", iors + speculars) ==
          dump_all("dielectric", 1.333f, 1.25f, "constant 0x1p-2 constant 0x1.8p-1 1 0x1p+0 constant 0x1p+0"));
    CHECK(material("roughdielectric", iors + speculars + along + visible + word("distribution", "ggx")) ==
          dump_all("dielectric", 1.333f, 1.25f,
                   "constant 0x1p-2 constant 0x1.8p-1 0 ggx 0x1p-1 0x1p-2 0x1p+0 constant 0x1p+0"));
    CHECK(material("roughconductor", along + visible + number("eta", "2") + number("k", "3") +
                                         number(name("specular_reflectance", "specularReflectance"), "0.25")) ==
          "conductor constant 0x1p-2 constant 0x1p+1 constant 0x1.8p+1 beckmann 0x1p-1 0x1p-2");
    const std::string plastic = iors + number(name("diffuse_reflectance", "diffuseReflectance"), "0.25") +
                                number(name("specular_reflectance", "specularReflectance"), "0.75") +
                                "<boolean name='nonlinear' value='true'/>";
    CHECK(material("plastic", plastic) == dump_all("plastic", 1.333f, 1.25f, "constant 0x1p-2 constant 0x1.8p-1 1"));
    CHECK(material("roughplastic", plastic + visible + number("alpha", "0.5") + word("distribution", "ggx")) ==
          dump_all("plastic", 1.333f, 1.25f, "constant 0x1p-2 constant 0x1.8p-1 1 ggx 0x1p-1 0x1p-1"));
    const std::string common = base + number("roughness", "0.125") + number("anisotropic", "0.25") +
                               number(name("spec_trans", "specTrans"), "0.375") +
                               number(name("spec_tint", "specTint"), "0.5") + number("sheen", "0.625") +
                               number(name("sheen_tint", "sheenTint"), "0.75") + number("flatness", "0.875") +
                               number(name("diffuse_reflectance_sampling_rate", "diffuseReflectanceSamplingRate"), "2");
    CHECK(material("principled", common + number("metallic", "0.0625") + number("clearcoat", "0.1875") +
                                     number(name("clearcoat_gloss", "clearcoatGloss"), "0.3125") + number("eta", "2") +
                                     number(name("main_specular_sampling_rate", "mainSpecularSamplingRate"), "2") +
                                     number(name("clearcoat_sampling_rate", "clearcoatSamplingRate"), "2")) ==
          dump_all("principled constant 0x1p-1", 0.125f, 0.25f, 0.0625f, 0.375f, 0.5f, 0.625f, 0.75f, 0.875f, 0.1875f,
                   0.3125f, 2.0f));
    CHECK(material("principledthin",
                   common + number("eta", "2") + number(name("diff_trans", "diffTrans"), "1.5") +
                       number(name("specular_reflectance_sampling_rate", "specularReflectanceSamplingRate"), "2") +
                       number("specular_transmittance_sampling_rate", "2") +
                       number("diffuse_transmittance_sampling_rate", "2")) ==
          dump_all("principledthin constant 0x1p-1", 0.125f, 0.25f, 0.375f, 2.0f, 0.5f, 0.625f, 0.75f, 0.875f, 1.5f));
  }
  CHECK(material("mask", number("opacity", "0.25") + bsdf("diffuse")) == "mask 0x1p-2 0");
  CHECK(material("mask", "<rgb name='opacity' value='0.25'/>" + bsdf("diffuse")) == dump_all("mask", 0.25f, 0));
  CHECK(material("mask", "<spectrum name='opacity' value='0.25'/>" + bsdf("diffuse")) == "mask 0x1p-2 0");
  CHECK(material("blendbsdf", bsdf("null") + number("weight", "0.75") + bsdf("diffuse")) == "blendbsdf 0x1.8p-1 0 1");
}

TEST_CASE("Mitsuba materials: specular of principled becomes an index of refraction") {
  for (const float specular : {0.0f, 0.2f, 0.5f, 1.0f}) {
    const float eta =
        read_material<PrincipledDescription>("principled", number("specular", std::to_string(specular))).eta;
    // The reflectance at normal incidence is 0.08 times as large.
    CHECK(std::pow((eta - 1) / (eta + 1), 2) == near(0.08 * specular));
  }
}

TEST_CASE("Mitsuba materials: a principled metal that specular 0 turns black gives a warning") {
  const auto warnings = [](const std::string& inside) {
    return compile_scene(read_text(mitsuba_scene("<shape type='sphere'>" + bsdf("principled", inside) + "</shape>" +
                                                 "<shape type='disk'>" + bsdf("principled", "") + "</shape>")))
        ->warnings();
  };
  const std::string metal = number("metallic", "1"), none = number("specular", "0");
  for (const std::string& inside : {metal + none, number("metallic", "0.2") + none, metal + number("eta", "1")}) {
    CAPTURE(inside);
    const std::vector<std::string> found = warnings(inside);
    REQUIRE(found.size() == 1);
    CHECK(contains(found[0], "scene.xml:"));
    CHECK(contains(found[0], "the metallic part of this principled material is black: with 'specular' 0"));
  }
  CHECK(warnings(metal).empty());
  CHECK(warnings(none).empty());
  CHECK(warnings(metal + number("specular", "0.01")).empty());
  CHECK(warnings(metal + none + number("spec_trans", "0.5")).empty());
}

TEST_CASE("Mitsuba materials: hair is defined by pigments or by absorption") {
  const std::string rest = number("longitudinal_roughness", "0.1") + number("azimuthal_roughness", "0.2") +
                           number("scale_tilt", "3") + number("int_ior", "1.4") + number("ext_ior", "1.1");
  const std::string expected = dump_all(0.1f, 0.2f, 3.0f, 1.4f, 1.1f);
  CHECK(material("hair", number("pheomelanin", "0.5") + rest) == "hair 0 " + dump_all(1.3f, 0.5f) + " " + expected);
  const std::string sigma_a = "<rgb name='sigma_a' value='0.25, 0.5, 4'/>";
  CHECK(material("hair", sigma_a + number("scale", "10") + rest) ==
        "hair 1 " + dump_all(SpectrumDescription::rgb(0.25f, 0.5f, 4), 10.0f) + " " + expected);
  const std::string attribute = " type='mesh_attribute'><string name='name' value='vertex_x'/></texture>";
  std::string textures;
  for (const char* name : {"eumelanin", "pheomelanin", "longitudinal_roughness", "azimuthal_roughness"})
    textures += std::string("<texture name='") + name + "'" + attribute;
  CHECK(contains(material("hair", textures), "hair 0 texture 0 texture 1 texture 2 texture 3 "));
  CHECK(contains(material("hair", std::string("<texture name='sigma_a'") + attribute), "hair 1 texture 0 "));

  CHECK(
      contains(error_of_elements(bsdf("hair", sigma_a + number("eumelanin", "1"))), "is set together with 'sigma_a'"));
  CHECK(
      contains(error_of_elements(bsdf("hair", number("azimuthal_roughness", "1.5"))), "expected a number from 0 to 1"));
  CHECK(contains(error_of_elements(bsdf("hair", number("roughness", "0.5"))), "unknown property 'roughness'"));
  CHECK(contains(error_of_elements(bsdf("twosided", bsdf("hair"))), "transmits light"));
}

TEST_CASE("compile materials: hair gets its absorption and needs its tangent") {
  const auto parameters = [](const HairDescription& hair) {
    Description d;
    d.materials.push_back({hair, "", {}});
    const CompiledMaterials out = compile_materials(d.materials);
    const MaterialRow& row = out.tables.rows.at(out.row_of[0]);
    CHECK(row.kind == kClosureKind<HairClosure>);
    CHECK((row.flags & kNeedsUv) != 0);
    return record_of_words<Scalar, HairParameters>(row.words);
  };
  HairDescription hair;
  const auto brown = parameters(hair);
  CHECK(brown.eumelanin == 1.3f);
  CHECK(brown.eumelanin_absorption.c2 == 1.37f);
  CHECK(brown.pheomelanin_absorption.c0 == 0.187f);
  CHECK(brown.eta == near(1.55 / 1.000277));
  CHECK(brown.tilt == near(0.0349066));
  CHECK(brown.fourth == 0);
  hair.color = HairDescription::Absorption{SpectrumDescription::rgb(0.25f, 0.5f, 4), 10};
  const auto dyed = parameters(hair);
  CHECK(dyed.eumelanin == 0.0f);
  CHECK(dyed.absorption.c2 == 4.0f);
  CHECK(dyed.scale == 10.0f);
  CHECK(dyed.by_reflectance == 0);
  hair.color = HairDescription::Reflectance{SpectrumDescription::rgb(0.25f, 0.5f, 0.75f)};
  CHECK(parameters(hair).absorption.c1 == 0.5f);
  CHECK(parameters(hair).by_reflectance == 1);
}

TEST_CASE("Mitsuba materials: a roughness of zero becomes 1e-4") {
  const auto rough = *read_material<ConductorDescription>("roughconductor", number("alpha", "0")).roughness;
  CHECK(std::get<float>(rough.alpha_u) == 1e-4f);
  CHECK(std::get<float>(rough.alpha_v) == 1e-4f);
}

TEST_CASE("Mitsuba materials: every parameter that may be textured is") {
  const std::string attribute = " type='mesh_attribute'><string name='name' value='vertex_x'/></texture>";
  struct Case {
    const char* type;
    const char* parameters;  // colours and numbers
  };
  const Case cases[] = {
      {"diffuse", "reflectance"},
      {"conductor", "specular_reflectance eta k"},
      {"roughconductor", "specular_reflectance eta k alpha_u alpha_v"},
      {"dielectric", "specular_reflectance specular_transmittance"},
      {"thindielectric", "specular_reflectance specular_transmittance"},
      {"roughdielectric", "specular_reflectance specular_transmittance alpha_u alpha_v"},
      {"plastic", "diffuse_reflectance specular_reflectance"},
      {"roughplastic", "diffuse_reflectance specular_reflectance"},
      {"principled",
       "base_color roughness anisotropic metallic spec_trans spec_tint sheen sheen_tint flatness clearcoat "
       "clearcoat_gloss"},
      {"principledthin",
       "base_color roughness anisotropic spec_trans eta spec_tint sheen sheen_tint flatness diff_trans"},
      {"mask", "opacity"},
      {"blendbsdf", "weight"},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.type));
    std::istringstream names(c.parameters);
    std::string inside;
    int count = 0;
    for (std::string name; names >> name; ++count) inside += "<texture name='" + name + "'" + attribute;
    if (std::string(c.type) == "mask") inside += bsdf("null");
    if (std::string(c.type) == "blendbsdf") inside += bsdf("null") + bsdf("null");
    const Description d = read_text(mitsuba_scene(bsdf(c.type, inside)));
    CHECK(d.textures.size() == static_cast<std::size_t>(count));
    const std::string text = dump(d.materials.back());
    for (int i = 0; i < count; ++i) {
      CAPTURE(text);
      CHECK(contains(text + " ", " texture " + std::to_string(i) + " "));
    }
  }
  CHECK(material("roughconductor", "<texture name='alpha'" + attribute) ==
        "conductor constant 0x1p+0 beckmann texture 0 texture 0");
}

TEST_CASE("Mitsuba materials: metals are found by name") {
  const auto gold = read_material<ConductorDescription>("conductor", word("material", "Au"));
  REQUIRE(gold.ior);
  const auto& eta = std::get<SpectrumDescription::Table>(std::get<SpectrumDescription>(gold.ior->eta).value);
  CHECK(eta.wavelengths.front() <= 360);
  CHECK(eta.wavelengths.back() >= 830);
  CHECK(read_material<ConductorDescription>("roughconductor", word("material", "Ag")).ior.has_value());
  CHECK_FALSE(read_material<ConductorDescription>("conductor", word("material", "none")).ior.has_value());
  CHECK_FALSE(read_material<ConductorDescription>("conductor").ior.has_value());
  // Before version 2, the default is copper in air.
  auto eta_of = [](const std::string& inside) {
    const auto m = std::get<ConductorDescription>(read_mitsuba06(bsdf("roughconductor", inside)).materials.at(0).model);
    return std::get<SpectrumDescription>(m.ior.value().eta);
  };
  const auto copper = read_material<ConductorDescription>("conductor", word("material", "Cu"));
  const auto& table = std::get<SpectrumDescription::Table>(std::get<SpectrumDescription>(copper.ior->eta).value);
  const SpectrumDescription in_air = eta_of("");
  CHECK(std::get<SpectrumDescription::Table>(in_air.value).values.at(3) == near(table.values.at(3) / 1.000277));
  const SpectrumDescription in_water = eta_of(word("extEta", "water"));
  CHECK(std::get<SpectrumDescription::Table>(in_water.value).values.at(3) == near(table.values.at(3) / 1.333));
  const SpectrumDescription given =
      eta_of("<spectrum name='eta' value='3'/><rgb name='k' value='1,2,3'/>" + number("extEta", "1.5"));
  CHECK(dump(given) == "constant 0x1p+1");
}

TEST_CASE("Mitsuba materials: two-sided materials may have one or two children") {
  auto sides = [](const std::string& inside) { return material("twosided", inside); };
  CHECK(sides(bsdf("diffuse") + bsdf("plastic")) == "twosided 0 1");
  CHECK(sides(bsdf("principled")) == "twosided 0 0");
  CHECK(sides(bsdf("principled", number("spec_trans", "0"))) == "twosided 0 0");
  CHECK(sides(bsdf("twosided", bsdf("diffuse") + bsdf("plastic"))) == "twosided 0 0");
  CHECK(sides(bsdf("blendbsdf", bsdf("diffuse") + bsdf("plastic"))) == "twosided 2 2");
  const std::string map = "<texture type='checkerboard'/>";
  CHECK(sides(bsdf("bumpmap", map + bsdf("diffuse"))) == "twosided 1 1");
  const std::string transmitting[] = {bsdf("dielectric"),
                                      bsdf("thindielectric"),
                                      bsdf("roughdielectric"),
                                      bsdf("null"),
                                      bsdf("principledthin"),
                                      bsdf("principled", number("spec_trans", "0.5")),
                                      bsdf("principled", "<texture type='checkerboard' name='spec_trans'/>"),
                                      bsdf("mask", bsdf("diffuse")),
                                      bsdf("blendbsdf", bsdf("diffuse") + bsdf("null")),
                                      bsdf("bumpmap", map + bsdf("dielectric")),
                                      bsdf("normalmap", map + bsdf("dielectric"))};
  for (const std::string& child : transmitting) {
    CAPTURE(child);
    const std::string message = error_of_elements("<bsdf type='twosided'>\n" + child + "</bsdf>");
    CHECK_MESSAGE(contains(message, "scene.xml:4: bsdf 'twosided' has a nested material that transmits light (line 5)"),
                  message);
  }
}

TEST_CASE("Mitsuba materials: bump and normal maps are read") {
  const std::string image = "<texture type='bitmap' NAME>" + word("filename", "image.png") + "</texture>";
  auto named = [&](const std::string& name) {
    std::string text = image;
    return text.replace(text.find("NAME"), 4, name.empty() ? "" : "name='" + name + "'");
  };
  for (const char* name : {"", "normalmap", "bump", "arbitrary", "scale"}) {
    CAPTURE(std::string(name));
    if (std::string(name) != "scale") CHECK(material("bumpmap", bsdf("diffuse") + named(name)) == "bumpmap 0 0x1p+0 0");
    CHECK(material("normalmap", bsdf("diffuse") + named(name)) == "normalmap 0 0 0 0x1p+0 0");
  }
  CHECK(material("bumpmap", bsdf("diffuse") + named("a") + number("scale", "-2")) == "bumpmap 0 -0x1p+1 0");
  CHECK(material("normalmap", bsdf("diffuse") + named("a") + "<boolean name='flip_green' value='true'/>") ==
        "normalmap 0 1 0 0x1p+0 0");
  for (const char* type : {"normalmap", "bumpmap"}) {
    const std::string start = bsdf("diffuse") + named("a");
    CHECK(contains(material(type, start + "<boolean name='flip_invalid_normals' value='false'/>"), " keep_normals"));
    CHECK(contains(material(type, start + "<boolean name='useShadowingFunction' value='false'/>"), " hard_terminator"));
    CHECK_FALSE(contains(material(type, start), "keep_normals"));
  }
  // Before version 2, a texture around another one scales it.
  const Description old = read_mitsuba06(
      bsdf("bumpmap", bsdf("diffuse") + "<texture type='scale'>" + number("scale", "10") + named("") + "</texture>"));
  CHECK(dump(old.materials.back()) == "bumpmap 0 0x1.4p+3 0");
  const Description referred =
      read_mitsuba06("<texture type='scale' id='s'><float name='scale' value='2'/>" + named("") + "</texture>" +
                     bsdf("bumpmap", bsdf("diffuse") + "<ref id='s'/>"));
  CHECK(dump(referred.materials.back()) == "bumpmap 0 0x1p+1 0");
}

TEST_CASE("Mitsuba materials: polarisers transmit half of the light with a note") {
  const auto opacity = [](const std::string& plugin, const std::string& inside = "") {
    const Description d = read_text(mitsuba_scene("<bsdf type='" + plugin + "'>" + inside + "</bsdf>"));
    CHECK(d.notes.size() == 1);
    const auto& mask = std::get<MaskDescription>(d.materials.back().model);
    const auto& black = d.materials.at(static_cast<std::size_t>(mask.nested)).model;
    CHECK(std::holds_alternative<DiffuseDescription>(black));
    return std::get<float>(mask.opacity);
  };
  CHECK(opacity("polarizer", "<spectrum name='theta' value='30'/>") == 0.5f);
  CHECK(opacity("circular", "<float name='transmittance' value='0.5'/>") == 0.75f);
  CHECK(opacity("retarder") == 0);
  const Description d = read_text(mitsuba_scene("<bsdf type='pplastic'><float name='alpha' value='0.2'/></bsdf>"));
  CHECK(std::get<PlasticDescription>(d.materials.back().model).roughness.has_value());
}

}  // namespace sheaf::test_mitsuba_bsdf
