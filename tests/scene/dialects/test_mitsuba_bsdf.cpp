// Materials of Mitsuba: defaults, parameters in the notations of all versions, and nesting.
#include "scene/compile/compile.h"
#include "scene/compile/compile_materials.h"
#include "tests/support/mitsuba_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace sheaf::test_mitsuba_bsdf {

using namespace test;

namespace {

void check_constants(const std::vector<ScalarInput>& values, const std::vector<float>& expected) {
  REQUIRE(values.size() == expected.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    CAPTURE(i);
    CHECK(constant_of(values[i]) == expected[i]);
  }
}

void check_roughness(const std::optional<RoughnessDescription>& roughness, bool is_ggx, float alpha_u, float alpha_v) {
  REQUIRE(roughness.has_value());
  CHECK(roughness->is_ggx() == is_ggx);
  check_constants({roughness->alpha_u, roughness->alpha_v}, {alpha_u, alpha_v});
}

/// The distinct textures of a material's own parameters.
std::set<TextureId> textures_of(const MaterialDescription& material) {
  std::set<TextureId> found;
  const auto add = [&]<class Value>(const auto& self, const Value& value) -> void {
    if constexpr (std::is_same_v<Value, ScalarInput> || std::is_same_v<Value, SpectrumInput>) {
      if (const auto* texture = std::get_if<TextureId>(&value)) found.insert(*texture);
    } else if constexpr (requires { value.has_value(); }) {
      if (value) self(self, *value);
    } else if constexpr (requires { value.alpha_u; }) {
      self(self, value.alpha_u), self(self, value.alpha_v);
    } else if constexpr (requires { value.eta, value.k; }) {
      self(self, value.eta), self(self, value.k);
    }
  };
  const auto visit = [&]<class Model>(const Model& model) {
    std::apply([&](const auto&... field) { (add(add, field), ...); }, Model::fields(model));
  };
  std::visit(visit, material.model);
  return found;
}

/// The numbers of a principled material but for roughness, in the order of its fields.
std::vector<ScalarInput> numbers_of(const PrincipledDescription& m) {
  return {m.anisotropic, m.metallic, m.spec_trans, m.spec_tint,      m.sheen,
          m.sheen_tint,  m.flatness, m.clearcoat,  m.clearcoat_gloss};
}
std::vector<ScalarInput> numbers_of(const PrincipledThinDescription& m) {
  return {m.anisotropic, m.spec_trans, m.eta, m.spec_tint, m.sheen, m.sheen_tint, m.flatness, m.diff_trans};
}

}  // namespace

TEST_CASE("Mitsuba materials: defaults match the documentation") {
  CHECK(constant_of(read_material<DiffuseDescription>("diffuse").reflectance) == 0.5f);
  for (const bool rough : {false, true}) {
    CAPTURE(rough);
    const auto conductor = read_material<ConductorDescription>(rough ? "roughconductor" : "conductor");
    CHECK_FALSE(conductor.ior.has_value());
    CHECK(constant_of(conductor.specular_reflectance) == 1.0f);
    const auto plastic = read_material<PlasticDescription>(rough ? "roughplastic" : "plastic");
    CHECK(plastic.int_ior == 1.49f);
    CHECK(plastic.ext_ior == 1.000277f);
    CHECK(constant_of(plastic.diffuse_reflectance) == 0.5f);
    CHECK(constant_of(plastic.specular_reflectance) == 1.0f);
    CHECK_FALSE(plastic.nonlinear);
    CHECK(conductor.roughness.has_value() == rough);
    CHECK(plastic.roughness.has_value() == rough);
    if (rough) check_roughness(conductor.roughness, false, 0.1f, 0.1f);
    if (rough) check_roughness(plastic.roughness, false, 0.1f, 0.1f);
  }
  for (const char* type : {"dielectric", "thindielectric", "roughdielectric"}) {
    CAPTURE(std::string(type));
    const auto glass = read_material<DielectricDescription>(type);
    CHECK(glass.int_ior == 1.5046f);
    CHECK(glass.ext_ior == 1.000277f);
    CHECK(constant_of(glass.specular_reflectance) == 1.0f);
    CHECK(constant_of(glass.specular_transmittance) == 1.0f);
    CHECK(constant_of(glass.specular) == 1.0f);
    CHECK(constant_of(glass.specular_color) == 1.0f);
    CHECK(glass.thin == (std::string(type) == "thindielectric"));
    CHECK(glass.roughness.has_value() == (std::string(type) == "roughdielectric"));
  }
  check_roughness(read_material<DielectricDescription>("roughdielectric").roughness, false, 0.1f, 0.1f);
  const auto principled = read_material<PrincipledDescription>("principled");
  CHECK(constant_of(principled.base_color) == 0.5f);
  CHECK(constant_of(principled.roughness) == 0.5f);
  check_constants(numbers_of(principled), {0, 0, 0, 0, 0, 0, 0, 0, 0});
  CHECK(principled.eta == 1.5f);
  const auto thin = read_material<PrincipledThinDescription>("principledthin");
  CHECK(constant_of(thin.base_color) == 0.5f);
  CHECK(constant_of(thin.roughness) == 0.5f);
  check_constants(numbers_of(thin), {0, 0, 1.5f, 0, 0, 0, 0, 0});
  const auto hair = read_material<HairDescription>("hair");
  const auto& melanin = std::get<HairDescription::Melanin>(hair.color);
  check_constants({melanin.eumelanin, melanin.pheomelanin, hair.longitudinal_roughness, hair.azimuthal_roughness},
                  {1.3f, 0.2f, 0.3f, 0.3f});
  CHECK(hair.scale_tilt == 2.0f);
  CHECK(hair.int_ior == 1.55f);
  CHECK(hair.ext_ior == 1.000277f);
  read_material<NullDescription>("null");
  CHECK(constant_of(read_material<MaskDescription>("mask", bsdf("diffuse")).opacity) == 0.5f);
  const auto blend = read_material<BlendDescription>("blendbsdf", bsdf("diffuse") + bsdf("plastic"));
  CHECK(constant_of(blend.weight) == 0.5f);
  CHECK(blend.nested[0] == MaterialId{0});
  CHECK(blend.nested[1] == MaterialId{1});
  const std::string image = "<texture type='bitmap' name='any'>" + word("filename", "image.png") + "</texture>";
  CHECK(read_material<BumpMapDescription>("bumpmap", bsdf("diffuse") + image).scale == 1.0f);
  const auto normal_map = read_material<NormalMapDescription>("normalmap", bsdf("diffuse") + image);
  CHECK_FALSE(normal_map.flip_green);
  CHECK(normal_map.scale == 1.0f);
  CHECK_FALSE(normal_map.follows_uv);
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

TEST_CASE("Mitsuba materials: every number and color and switch is read in both naming styles") {
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
    for (const char* type : {"dielectric", "thindielectric", "roughdielectric"}) {
      CAPTURE(std::string(type));
      const bool rough = std::string(type) == "roughdielectric";
      const auto glass = read_material<DielectricDescription>(
          type, iors + speculars + (rough ? along + visible + word("distribution", "ggx") : ""));
      CHECK(glass.int_ior == 1.333f);
      CHECK(glass.ext_ior == 1.25f);
      CHECK(constant_of(glass.specular_reflectance) == 0.25f);
      CHECK(constant_of(glass.specular_transmittance) == 0.75f);
      if (rough) check_roughness(glass.roughness, true, 0.5f, 0.25f);
    }
    const auto metal = read_material<ConductorDescription>(
        "roughconductor", along + visible + number("eta", "2") + number("k", "3") +
                              number(name("specular_reflectance", "specularReflectance"), "0.25"));
    REQUIRE(metal.ior.has_value());
    CHECK(constant_of(metal.ior->eta) == 2.0f);
    CHECK(constant_of(metal.ior->k) == 3.0f);
    CHECK(constant_of(metal.specular_reflectance) == 0.25f);
    check_roughness(metal.roughness, false, 0.5f, 0.25f);
    const std::string plastic = iors + number(name("diffuse_reflectance", "diffuseReflectance"), "0.25") +
                                number(name("specular_reflectance", "specularReflectance"), "0.75") +
                                "<boolean name='nonlinear' value='true'/>";
    for (const bool rough : {false, true}) {
      CAPTURE(rough);
      const auto coated = read_material<PlasticDescription>(
          rough ? "roughplastic" : "plastic",
          plastic + (rough ? visible + number("alpha", "0.5") + word("distribution", "ggx") : ""));
      CHECK(coated.int_ior == 1.333f);
      CHECK(coated.ext_ior == 1.25f);
      CHECK(constant_of(coated.diffuse_reflectance) == 0.25f);
      CHECK(constant_of(coated.specular_reflectance) == 0.75f);
      CHECK(coated.nonlinear);
      if (rough) check_roughness(coated.roughness, true, 0.5f, 0.5f);
    }
    const std::string common = base + number("roughness", "0.125") + number("anisotropic", "0.25") +
                               number(name("spec_trans", "specTrans"), "0.375") +
                               number(name("spec_tint", "specTint"), "0.5") + number("sheen", "0.625") +
                               number(name("sheen_tint", "sheenTint"), "0.75") + number("flatness", "0.875") +
                               number(name("diffuse_reflectance_sampling_rate", "diffuseReflectanceSamplingRate"), "2");
    const auto principled = read_material<PrincipledDescription>(
        "principled", common + number("metallic", "0.0625") + number("clearcoat", "0.1875") +
                          number(name("clearcoat_gloss", "clearcoatGloss"), "0.3125") + number("eta", "2") +
                          number(name("main_specular_sampling_rate", "mainSpecularSamplingRate"), "2") +
                          number(name("clearcoat_sampling_rate", "clearcoatSamplingRate"), "2"));
    CHECK(constant_of(principled.base_color) == 0.5f);
    CHECK(constant_of(principled.roughness) == 0.125f);
    check_constants(numbers_of(principled), {0.25f, 0.0625f, 0.375f, 0.5f, 0.625f, 0.75f, 0.875f, 0.1875f, 0.3125f});
    CHECK(principled.eta == 2.0f);
    const auto thin = read_material<PrincipledThinDescription>(
        "principledthin",
        common + number("eta", "2") + number(name("diff_trans", "diffTrans"), "1.5") +
            number(name("specular_reflectance_sampling_rate", "specularReflectanceSamplingRate"), "2") +
            number("specular_transmittance_sampling_rate", "2") + number("diffuse_transmittance_sampling_rate", "2"));
    CHECK(constant_of(thin.base_color) == 0.5f);
    CHECK(constant_of(thin.roughness) == 0.125f);
    check_constants(numbers_of(thin), {0.25f, 0.375f, 2.0f, 0.5f, 0.625f, 0.75f, 0.875f, 1.5f});
  }
  for (const char* element : {"float", "rgb", "spectrum"}) {
    CAPTURE(std::string(element));
    const auto mask = read_material<MaskDescription>(
        "mask", "<" + std::string(element) + " name='opacity' value='0.25'/>" + bsdf("diffuse"));
    CHECK(constant_of(mask.opacity) == 0.25f);
    CHECK(mask.nested == MaterialId{0});
  }
  const auto blend =
      read_material<BlendDescription>("blendbsdf", bsdf("null") + number("weight", "0.75") + bsdf("diffuse"));
  CHECK(constant_of(blend.weight) == 0.75f);
  CHECK(blend.nested[0] == MaterialId{0});
  CHECK(blend.nested[1] == MaterialId{1});
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
  const std::string sigma_a = "<rgb name='sigma_a' value='0.25, 0.5, 4'/>";
  for (const bool absorbs : {false, true}) {
    CAPTURE(absorbs);
    const auto hair = read_material<HairDescription>(
        "hair", (absorbs ? sigma_a + number("scale", "10") : number("pheomelanin", "0.5")) + rest);
    if (absorbs) {
      const auto& absorption = std::get<HairDescription::Absorption>(hair.color);
      CHECK(rgb_of(absorption.sigma_a) == Vec3f{0.25f, 0.5f, 4});
      CHECK(absorption.scale == 10.0f);
    } else {
      const auto& melanin = std::get<HairDescription::Melanin>(hair.color);
      check_constants({melanin.eumelanin, melanin.pheomelanin}, {1.3f, 0.5f});
    }
    check_constants({hair.longitudinal_roughness, hair.azimuthal_roughness}, {0.1f, 0.2f});
    CHECK(hair.scale_tilt == 3.0f);
    CHECK(hair.int_ior == 1.4f);
    CHECK(hair.ext_ior == 1.1f);
  }
  const std::string attribute = " type='mesh_attribute'><string name='name' value='vertex_x'/></texture>";
  std::string textures;
  for (const char* name : {"eumelanin", "pheomelanin", "longitudinal_roughness", "azimuthal_roughness"})
    textures += std::string("<texture name='") + name + "'" + attribute;
  const auto textured = read_material<HairDescription>("hair", textures);
  const auto& pigments = std::get<HairDescription::Melanin>(textured.color);
  CHECK(std::get<TextureId>(pigments.eumelanin) == TextureId{0});
  CHECK(std::get<TextureId>(pigments.pheomelanin) == TextureId{1});
  CHECK(std::get<TextureId>(textured.longitudinal_roughness) == TextureId{2});
  CHECK(std::get<TextureId>(textured.azimuthal_roughness) == TextureId{3});
  const auto dyed = read_material<HairDescription>("hair", std::string("<texture name='sigma_a'") + attribute);
  CHECK(std::get<TextureId>(std::get<HairDescription::Absorption>(dyed.color).sigma_a) == TextureId{0});

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
    const char* parameters;  // colors and numbers
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
    CHECK(textures_of(d.materials.back()).size() == static_cast<std::size_t>(count));
  }
  const auto rough =
      *read_material<ConductorDescription>("roughconductor", "<texture name='alpha'" + attribute).roughness;
  CHECK(std::get<TextureId>(rough.alpha_u) == TextureId{0});
  CHECK(std::get<TextureId>(rough.alpha_v) == TextureId{0});
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
  CHECK(constant_of(given) == 2.0f);
}

TEST_CASE("Mitsuba materials: two-sided materials may have one or two children") {
  const auto check_sides = [](const std::string& inside, unsigned front, unsigned back) {
    CAPTURE(inside);
    const auto sides = read_material<TwoSidedDescription>("twosided", inside);
    CHECK(sides.front == MaterialId{front});
    CHECK(sides.back == MaterialId{back});
  };
  check_sides(bsdf("diffuse") + bsdf("plastic"), 0, 1);
  check_sides(bsdf("principled"), 0, 0);
  check_sides(bsdf("principled", number("spec_trans", "0")), 0, 0);
  check_sides(bsdf("twosided", bsdf("diffuse") + bsdf("plastic")), 0, 0);
  check_sides(bsdf("blendbsdf", bsdf("diffuse") + bsdf("plastic")), 2, 2);
  const std::string map = "<texture type='checkerboard'/>";
  check_sides(bsdf("bumpmap", map + bsdf("diffuse")), 1, 1);
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
    if (std::string(name) != "scale") {
      const auto bumps = read_material<BumpMapDescription>("bumpmap", bsdf("diffuse") + named(name));
      CHECK(bumps.displacement == TextureId{0});
      CHECK(bumps.scale == 1.0f);
      CHECK(bumps.nested == MaterialId{0});
    }
    const auto normals = read_material<NormalMapDescription>("normalmap", bsdf("diffuse") + named(name));
    CHECK(normals.normals == TextureId{0});
    CHECK_FALSE(normals.flip_green);
    CHECK(normals.nested == MaterialId{0});
  }
  const std::string start = bsdf("diffuse") + named("a");
  CHECK(read_material<BumpMapDescription>("bumpmap", start + number("scale", "-2")).scale == -2.0f);
  CHECK(
      read_material<NormalMapDescription>("normalmap", start + "<boolean name='flip_green' value='true'/>").flip_green);
  for (const char* type : {"normalmap", "bumpmap"}) {
    const auto options = [&](const std::string& inside) {
      const bool bumps = std::string(type) == "bumpmap";
      return bumps ? read_material<BumpMapDescription>(type, start + inside).options
                   : read_material<NormalMapDescription>(type, start + inside).options;
    };
    CHECK_FALSE(options("<boolean name='flip_invalid_normals' value='false'/>").fix_invalid_normals);
    CHECK_FALSE(options("<boolean name='useShadowingFunction' value='false'/>").soften_terminator);
    CHECK(options("").fix_invalid_normals);
    CHECK(options("").soften_terminator);
  }
  // Before version 2, a texture around another one scales it.
  const Description old = read_mitsuba06(
      bsdf("bumpmap", bsdf("diffuse") + "<texture type='scale'>" + number("scale", "10") + named("") + "</texture>"));
  CHECK(std::get<BumpMapDescription>(old.materials.back().model).scale == 10.0f);
  const Description referred =
      read_mitsuba06("<texture type='scale' id='s'><float name='scale' value='2'/>" + named("") + "</texture>" +
                     bsdf("bumpmap", bsdf("diffuse") + "<ref id='s'/>"));
  CHECK(std::get<BumpMapDescription>(referred.materials.back().model).scale == 2.0f);
}

TEST_CASE("Mitsuba materials: polarizers transmit half of the light with a note") {
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
