// Materials of Mitsuba 0.6 and mixtures: both notations, and compiled rows.
#include "scene/compile/compile_materials.h"
#include "tests/support/mitsuba_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <map>

namespace sheaf::test_mitsuba06_bsdf {

using namespace test;

namespace {

std::string color(const std::string& name, const std::string& value) {
  return "<rgb name='" + name + "' value='" + value + "'/>";
}
Description read_new(const std::string& text) { return read_text(mitsuba_scene(text)); }
SpectrumInput gray(float v) { return SpectrumDescription::constant(v); }

/// The shares of the diffuse rows below a material's row, by reflectance.
void add_fractions(const CompiledMaterials& c, std::uint32_t row, float fraction, std::map<float, float>& out) {
  const MaterialRow& m = c.tables.rows.at(row);
  if ((m.flags & kComposite) == 0) {
    out[m.words[0]] += fraction;
    return;
  }
  add_fractions(c, m.choice[0], fraction * (1 - m.second_weight()), out);
  add_fractions(c, m.choice[1], fraction * m.second_weight(), out);
}
std::map<float, float> fractions(const Description& d) {
  const CompiledMaterials c = compile_materials(d.materials);
  std::map<float, float> out;
  add_fractions(c, c.row_of.back(), 1, out);
  return out;
}
std::string gray_bsdf(const std::string& value) {
  return bsdf("diffuse", "<spectrum name='reflectance' value='" + value + "'/>");
}

}  // namespace

TEST_CASE("old materials: defaults and parameters are read in both notations") {
  CHECK(material("phong") == dump_all("phong", gray(0.5f), gray(0.2f), 30.0f));
  CHECK(material("roughdiffuse") == dump_all("roughdiffuse", gray(0.5f), 0.2f, false));
  CHECK(material("ward") == dump_all("ward", 2, gray(0.5f), gray(0.2f), 0.1f, 0.1f));
  CHECK(material("difftrans") == dump_all("difftrans", gray(0.5f), gray(0)));
  CHECK(material("difftrans", color("transmittance", "0.1, 0.2, 0.3")) ==
        dump_all("difftrans", SpectrumInput(SpectrumDescription::rgb(0.1f, 0.2f, 0.3f)), gray(0)));
  const std::string lobes =
      color("diffuseReflectance", "0.1, 0.2, 0.3") + color("specularReflectance", "0.4, 0.5, 0.6");
  const SpectrumInput d = SpectrumDescription::rgb(0.1f, 0.2f, 0.3f), s = SpectrumDescription::rgb(0.4f, 0.5f, 0.6f);
  CHECK(material("phong", lobes + number("exponent", "100")) == dump_all("phong", d, s, 100.0f));
  CHECK(material("ward", lobes + word("variant", "ward-duer") + number("alphaU", "0.3") + number("alpha_v", "0.2")) ==
        dump_all("ward", 1, d, s, 0.3f, 0.2f));
  CHECK(material("ward", word("variant", "ward") + number("alpha", "0.3")) ==
        dump_all("ward", 0, gray(0.5f), gray(0.2f), 0.3f, 0.3f));
  CHECK(material("roughdiffuse", number("alpha", "0.6") + "<boolean name='useFastApprox' value='true'/>") ==
        dump_all("roughdiffuse", gray(0.5f), 0.6f, true));
}

TEST_CASE("old materials: lobes that reflect too much are scaled down with a note") {
  const std::string much = color("diffuse_reflectance", "0.5, 0.9, 0") + color("specular_reflectance", "0.5, 0.6, 0");
  const Description scaled = read_new(bsdf("phong", much));
  const auto& phong = std::get<PhongDescription>(scaled.materials.back().model);
  const auto rgb = [](const SpectrumInput& input) {
    return std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(input).value).value;
  };
  CHECK(rgb(phong.diffuse_reflectance).y + rgb(phong.specular_reflectance).y == near(0.99));
  CHECK(rgb(phong.diffuse_reflectance).x == near(0.5 * 0.99 / 1.5));
  REQUIRE(scaled.notes.size() == 1);
  CHECK(scaled.notes[0].find("scaled down") != std::string::npos);
  const Description as_is = read_new(bsdf("ward", much + "<boolean name='ensureEnergyConservation' value='false'/>"));
  CHECK(rgb(std::get<WardDescription>(as_is.materials.back().model).diffuse_reflectance).y == 0.9f);
  CHECK(as_is.notes.empty());
}

TEST_CASE("old materials: single-scattering slabs are read") {
  CHECK(material("hk", number("thickness", "0.5") + color("sigmaS", "1, 2, 3") + color("sigmaA", "0, 1, 0")) ==
        dump_all("hk", SpectrumInput(SpectrumDescription::rgb(1, 2, 3)),
                 SpectrumInput(SpectrumDescription::rgb(0, 1, 0)), false, 0.5f, 0.0f));
  CHECK(material("hk", number("sigma_t", "2") + number("albedo", "0.5") +
                           "<phase type='hg'><float name='g' value='0.4'/></phase>") ==
        dump_all("hk", gray(2), gray(0.5f), true, 1.0f, 0.4f));
  CHECK(material("hk") == material("hk", word("material", "skin1")));
  CHECK(material("hk") != material("hk", word("material", "marble")));
  CHECK(error_of_elements(bsdf("hk", number("sigma_t", "2"))).find("has only one coefficient") != std::string::npos);
  CHECK(error_of_elements(bsdf("hk", number("sigma_t", "2") + number("sigma_a", "1"))).find("mixes") !=
        std::string::npos);
  CHECK(error_of_elements(bsdf("hk", "<phase type='rayleigh'/>")).find("isotropic or hg") != std::string::npos);
}

TEST_CASE("old materials: coats are read") {
  CHECK(material("coating", bsdf("diffuse")) == dump_all("coating", 1.5046f, 1.000277f, 1.0f, gray(0), gray(1),
                                                         std::optional<RoughnessDescription>(), MaterialId{0}));
  const std::string all = number("intIOR", "1.7") + word("extIOR", "water") + number("thickness", "2") +
                          color("sigmaA", "1, 2, 3") + color("specularReflectance", "0.5, 0.5, 0.4");
  const SpectrumInput sigma = SpectrumDescription::rgb(1, 2, 3), tint = SpectrumDescription::rgb(0.5f, 0.5f, 0.4f);
  CHECK(material("roughcoating", all + number("alpha", "0.3") + word("distribution", "ggx") + bsdf("plastic")) ==
        dump_all("coating", 1.7f, 1.333f, 2.0f, sigma, tint,
                 std::optional(RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.3f, 0.3f}),
                 MaterialId{0}));
  const auto refused = [](const std::string& text, const char* what) {
    CHECK(error_of_elements(text).find(what) != std::string::npos);
  };
  refused(bsdf("coating"), "has 0 nested <bsdf>, expected one");
  refused(bsdf("coating", bsdf("dielectric")), "transmits light (line ");
  refused(bsdf("coating", bsdf("mask", bsdf("diffuse"))), "transmits light (line ");
  refused(bsdf("ward", word("variant", "blinn")), "expected ward, ward-duer or balanced");
}

TEST_CASE("compile materials: the material under a coat is found with its textures") {
  Description d;
  ConductorDescription metal;
  metal.ior = {SpectrumDescription::constant(0.2f), TextureId{5}};
  metal.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, TextureId{3}, 0.25f};
  d.materials.push_back({metal, "", {}});
  CoatDescription coat;
  coat.int_ior = 1.5f, coat.ext_ior = 1, coat.thickness = 0.5f;
  coat.sigma_a = TextureId{7};
  d.materials.push_back({coat, "", {}});
  const CompiledMaterials out = compile_materials(d.materials);
  const MaterialRow& row = out.tables.rows.at(out.row_of[1]);
  REQUIRE(row.kind == kClosureKind<CoatedClosure>);
  CHECK((row.flags & kNeedsUv) != 0);
  const auto p = record_of_words<Scalar, CoatedParameters>(row.words);
  CHECK(p.coat_eta == 1.5f);
  CHECK(p.coat_thickness == 0.5f);
  CHECK(p.nested_kind == static_cast<std::uint32_t>(kClosureKind<RoughConductorGgxClosure>));
  CHECK(p.nested_spectra[0].c1 == 0.2f);
  CHECK(p.nested_spectra[2].c2 == 1.0f);
  CHECK(p.nested_numbers[1] == 0.25f);
  REQUIRE(row.binding_count == 3);
  const auto bound = [&](std::uint32_t i) { return out.tables.bindings.at(row.first_binding + i); };
  CHECK(bound(0).texture == 5);
  CHECK(bound(0).word == 11 + 4);
  CHECK(bound(1).texture == 3);
  CHECK(bound(1).word == 11 + 12);
  CHECK(bound(2).texture == 7);
  CHECK(bound(2).word == 2);
}

TEST_CASE("compile materials: coats apply to blends and to both sides") {
  const Description d = read_mitsuba06(
      bsdf("twosided",
           bsdf("coating", bsdf("blendbsdf", number("weight", "0.25") + bsdf("diffuse") + bsdf("roughconductor")))));
  const CompiledMaterials c = compile_materials(d.materials);
  const MaterialRow& blend = c.tables.rows.at(c.row_of.back());
  REQUIRE((blend.flags & kComposite) != 0);
  for (const std::uint32_t part : blend.choice) {
    CHECK(c.tables.rows.at(part).kind == kClosureKind<CoatedClosure>);
    CHECK((c.tables.rows.at(part).flags & (kPart | kTwoSided)) == (kPart | kTwoSided));
  }
  CHECK_THROWS_WITH_AS(compile_materials(read_new(bsdf("coating", bsdf("roughcoating", bsdf("diffuse")))).materials),
                       doctest::Contains("a coat cannot hold another one"), SceneError);
}

TEST_CASE("mixtures: weights become shares and the remainder is black") {
  const std::string three = gray_bsdf("0.1") + gray_bsdf("0.2") + gray_bsdf("0.3");
  const auto of = [&](const std::string& weights, const std::string& inside) {
    return fractions(read_mitsuba06(bsdf("mixturebsdf", word("weights", weights) + inside)));
  };
  const auto full = of("0.5, 0.2, 0.3", three);
  CHECK(full.size() == 3);
  CHECK(full.at(0.1f) == near(0.5));
  CHECK(full.at(0.2f) == near(0.2));
  CHECK(full.at(0.3f) == near(0.3));
  const auto dark = of("0.2 0.1 0.3", three);
  CHECK(dark.at(0.0f) == near(0.4));
  CHECK(dark.at(0.2f) == near(0.1));
  CHECK(of("1", gray_bsdf("0.1")).at(0.1f) == near(1));
  const Description bright = read_new(bsdf("mixturebsdf", word("weights", "2, 1, 1") + three));
  CHECK(fractions(bright).at(0.1f) == near(0.5));
  REQUIRE(bright.notes.size() == 1);
  CHECK(bright.notes[0].find("normalized to 1") != std::string::npos);
  // The depth of nested blends is logarithmic: 100 materials are accepted.
  std::string many, weights;
  for (int i = 1; i <= 100; ++i) many += gray_bsdf(std::to_string(i * 0.01)), weights += "0.01 ";
  CHECK(of(weights, many).at(0.5f) == near(0.01));
  const auto refused = [&](const std::string& w, const std::string& inside, const char* what) {
    CHECK(error_of_elements(bsdf("mixturebsdf", word("weights", w) + inside)).find(what) != std::string::npos);
  };
  refused("0.5", three, "has 1 numbers, expected as many as there are nested <bsdf>, 3");
  refused("0.5, -0.1, 0.1", three, "has a negative number");
  refused("0, 0, 0", three, "add up to 0");
  refused("", "", "has 0 nested <bsdf>");
}

}  // namespace sheaf::test_mitsuba06_bsdf
