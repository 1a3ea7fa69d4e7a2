// <subsurface> of Mitsuba 0.6, which becomes a dielectric boundary around a medium.
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_subsurface {

using namespace test;

namespace {

std::string old_scene(const std::string& inside) {
  return mitsuba_scene(inside, "<sensor type='perspective'/>", "<integrator type='volpath'/>", "0.6.0");
}
std::string sphere(const std::string& inside) { return old_scene("<shape type='sphere'>" + inside + "</shape>"); }
std::string dipole(const std::string& inside) { return "<subsurface type='dipole'>" + inside + "</subsurface>"; }

const DielectricDescription& boundary(const Description& d, std::size_t shape = 0) {
  const auto material = static_cast<std::size_t>(d.shapes.at(shape).material.value());
  return std::get<DielectricDescription>(d.materials.at(material).model);
}
const MediumDescription& interior(const Description& d, std::size_t shape = 0) {
  return d.media.at(static_cast<std::size_t>(d.shapes.at(shape).interior.value()));
}
std::string coefficients(const Description& d) {
  const auto& pair = std::get<AbsorptionScatteringDescription>(interior(d).coefficients);
  return dump(std::get<SpectrumDescription>(pair.sigma_a)) + " | " + dump(std::get<SpectrumDescription>(pair.sigma_s));
}
std::string measured(Vec3f sigma_a, Vec3f sigma_s) {
  const auto rgb = [](Vec3f v) { return dump(SpectrumDescription::rgb(v.x, v.y, v.z)); };
  return rgb(sigma_a) + " | " + rgb(sigma_s);
}

}  // namespace

TEST_CASE("subsurface: a preset gives the medium and the index of refraction") {
  const Description d = read_text(sphere(dipole("<string name='material' value='SkimMilk'/>")));
  CHECK(coefficients(d) == measured({0.0014f, 0.0025f, 0.0142f}, {0.70f, 1.22f, 1.90f}));
  CHECK(interior(d).scale == 1);
  CHECK(boundary(d).int_ior == 1.3f);
  CHECK(boundary(d).ext_ior == 1.0f);
  CHECK_FALSE(boundary(d).roughness.has_value());
  REQUIRE(d.notes.size() == 1);
  CHECK(contains(d.notes[0], "'dipole' rendered as a dielectric around a scattering medium"));
  // skin1 is the default.
  CHECK(coefficients(read_text(sphere(dipole("")))) == measured({0.032f, 0.17f, 0.48f}, {0.74f, 0.88f, 1.01f}));
  CHECK(boundary(read_text(sphere(dipole("<string name='material' value='marble'/>")))).int_ior == 1.5f);
}

TEST_CASE("subsurface: explicit parameters override the preset") {
  const Description d = read_text(sphere(dipole(
      "<rgb name='sigmaA' value='1,2,3'/><rgb name='sigmaS' value='4,5,6'/><float name='scale' value='10'/>"
      "<string name='intIOR' value='water'/><float name='g' value='0.5'/><integer name='irrSamples' value='64'/>")));
  CHECK(coefficients(d) == measured({1, 2, 3}, {4, 5, 6}));
  CHECK(interior(d).scale == 10);
  CHECK(boundary(d).int_ior == near(1.333));
  CHECK(boundary(d).ext_ior == near(1.000277));
  const auto phase = static_cast<std::size_t>(interior(d).phase.value());
  CHECK(std::get<HenyeyGreensteinDescription>(d.phases.at(phase).model).g == 0.5f);
  // Without indices the preset applies, as in Mitsuba 0.6. If one is given, the other defaults to bk7 or air.
  CHECK(boundary(read_text(sphere(dipole("<rgb name='sigmaA' value='1'/>")))).int_ior == 1.3f);
  CHECK(boundary(read_text(sphere(dipole("<float name='extIOR' value='1.2'/>")))).int_ior == 1.5046f);
}

TEST_CASE("subsurface: the boundary has the roughness of the BSDF that it replaces") {
  const std::string rough = "<bsdf type='roughplastic'><float name='alpha' value='0.25'/></bsdf>";
  const std::string both_sides = "<bsdf type='twosided'>" + rough + "</bsdf>";
  for (const std::string& bsdf : {rough, both_sides}) {
    const Description d = read_text(sphere(dipole("") + bsdf));
    REQUIRE(boundary(d).roughness.has_value());
    CHECK(std::get<float>(boundary(d).roughness->alpha_u) == 0.25f);
  }
  CHECK_FALSE(boundary(read_text(sphere("<bsdf type='plastic'/>" + dipole("")))).roughness.has_value());
}

TEST_CASE("subsurface: shapes share a common definition") {
  const std::string reference = "<shape type='sphere'><ref id='skin'/></shape>";
  const Description d = read_text(old_scene("<subsurface type='dipole' id='skin'/>" + reference + reference));
  CHECK(d.media.size() == 1);
  CHECK(interior(d, 0).id == "skin");
  CHECK(&interior(d, 0) == &interior(d, 1));
  CHECK(boundary(d, 1).int_ior == 1.3f);
}

TEST_CASE("subsurface: errors have line and nearest name") {
  CHECK(contains(error_of_text(sphere("<subsurface type='dipol'/>")),
                 "unknown subsurface plugin 'dipol', did you mean 'dipole'?"));
  CHECK(contains(error_of_text(old_scene("<subsurface type='dipole'/>")), "expected it inside a <shape>"));
  CHECK(contains(error_of_text(sphere(dipole("") + "<medium name='interior' type='homogeneous'/>")),
                 "has an interior medium and a <subsurface>"));
  CHECK(
      contains(error_of_text(sphere(dipole("<string name='material' value='skimilk'/>"))), "did you mean 'skimmilk'?"));
  CHECK(contains(error_of_text(sphere(dipole("<string name='material' value='skin1'/><rgb name='sigmaA' value='1'/>"))),
                 "is set together with coefficients"));
  CHECK(contains(error_of_text(sphere(dipole("<float name='sgima' value='1'/>"))), "unknown property 'sgima'"));
}

}  // namespace sheaf::test_subsurface
