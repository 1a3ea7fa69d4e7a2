// The list of integrators, and reading them: parameters, defaults, and replacements with a note.
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/common/setting_names.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>

namespace sheaf::test_integrator_reading {

using namespace test;

namespace {

Description with_integrator(const std::string& text) {
  return read_text(mitsuba_scene("", "<sensor type='perspective'/>", text));
}

/// A scene of Nori with an integrator.
std::string nori_scene(const std::string& integrator) {
  return "<scene><camera type='perspective'/>" + integrator + "</scene>";
}

}  // namespace

TEST_CASE("integrators: names are unique, and each kind has an integrator of its name") {
  const std::vector<std::string> names = integrator_names();
  CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
  for (const std::string& name : names) CHECK(find_integrator(name).has_value());
  for (const std::string& name : suggested_integrators()) {
    CAPTURE(name);
    REQUIRE(find_integrator(name).has_value());
    CHECK(find_integrator(name)->name == name);
    CHECK(contains(integrator_descriptions(), name + ": "));
  }
  std::size_t kind = 0;
  for (const IntegratorTraits& traits : kIntegratorTraits) {
    CAPTURE(std::string(traits.name));
    REQUIRE(find_integrator(traits.name).has_value());
    CHECK(find_integrator(traits.name)->entry->kind == static_cast<IntegratorKind>(kind++));
  }
}

TEST_CASE("integrators: settings keep the name that was given, or that of the substitute") {
  const auto mitsuba = [](const std::string& type) {
    return with_integrator("<integrator type='" + type + "'/>").integrator;
  };
  for (const char* name : {"path", "path_mis", "volpath", "direct", "direct_ems", "whitted", "ptracer", "lightpath",
                           "photonmapper", "ppm", "ao", "ambientocclusion", "av", "normals"}) {
    CHECK(mitsuba(name).name() == name);
    if (std::string(name) != "av")
      CHECK(read_text(nori_scene("<integrator type='" + std::string(name) + "'/>")).integrator.name() == name);
    CHECK(read_pbrt_world("", "Integrator \"" + std::string(name) + "\"").integrator.name() == name);
    Description d;
    apply_integrator_name(name, false, d);
    CHECK(d.integrator.name() == name);
  }
  CHECK(mitsuba("bdpt").name() == "path");
  CHECK(mitsuba("prbvolpath").name() == "volpath");
  CHECK(read_text(nori_scene("<integrator type='simple'/>")).integrator.name() == "simple");
  IntegratorSettings integrator;
  CHECK(integrator.name() == "path");
  integrator.kind = IntegratorKind::kLightTracer;
  CHECK(integrator.name() == "ptracer");
}

TEST_CASE("integrators: in pbrt scenes volpath is path") {
  CHECK(with_integrator("<integrator type='volpath'/>").integrator.thin_dielectrics_are_free);
  CHECK_FALSE(read_pbrt_world("", "Integrator \"volpath\"").integrator.thin_dielectrics_are_free);
  CHECK(read_pbrt_world("", "Integrator \"volpathmis\"").integrator.thin_dielectrics_are_free);
}

TEST_CASE("Mitsuba: integrators have the documented parameters") {
  const Description d = with_integrator(
      "<integrator type='moment'><integrator type='aov'><string name='aovs' value='d:depth'/><integrator type='path'>"
      "<integer name='maxDepth' value='7'/><integer name='rr_depth' value='3'/><boolean name='strictNormals' "
      "value='true'/><boolean name='hideEmitters' value='true'/></integrator></integrator></integrator>");
  CHECK(d.integrator.max_depth == 7);
  CHECK(d.integrator.rr_depth == 3);
  CHECK(d.integrator.hide_emitters);
  const Description tracer =
      with_integrator("<integrator type='ptracer'><integer name='max_depth' value='5'/></integrator>");
  CHECK(tracer.integrator.kind == IntegratorKind::kLightTracer);
  CHECK(tracer.integrator.max_depth == 5);
  CHECK(tracer.notes.empty());
  for (const char* name : {"volpath", "volpathmis", "volpath_simple"})
    CHECK(with_integrator(std::string("<integrator type='") + name + "'/>").integrator.max_depth == -1);
  const Description direct = with_integrator("<integrator type='direct'/>");
  CHECK(direct.integrator.max_depth == 2);
  CHECK(direct.integrator.strategy == LightStrategy::kMis);
  CHECK(with_integrator("<integrator type='direct'><integer name='emitter_samples' value='0'/></integrator>")
            .integrator.strategy == LightStrategy::kBsdfOnly);
  const Description lights = with_integrator(
      "<integrator type='direct'><integer name='bsdf_samples' value='0'/><integer "
      "name='emitter_samples' value='4'/></integrator>");
  CHECK(lights.integrator.strategy == LightStrategy::kLightOnly);
  CHECK(lights.notes.size() == 1);
  CHECK(with_integrator("<integrator type='depth'/>").integrator.kind == IntegratorKind::kDepth);
  const Description none = with_integrator("");
  CHECK(none.integrator.kind == IntegratorKind::kPath);
  CHECK(none.notes.size() == 1);
}

TEST_CASE("Mitsuba: integrators with the expectation of path tracing are rendered by it with a note") {
  for (const char* name : {"vpl", "prb", "prb_basic", "prbvolpath"}) {
    CAPTURE(std::string(name));
    const Description other = with_integrator(std::string("<integrator type='") + name + "'/>");
    REQUIRE(other.notes.size() == 1);
    CHECK(contains(other.notes[0], "has the same expectation"));
    CHECK(other.integrator.max_depth == (std::string(name).starts_with("prb") ? 6 : -1));
  }
}

TEST_CASE("integrators: bidirectional and Metropolis integrators are rendered by path tracing with a warning") {
  for (const std::string name : {"bdpt", "erpt", "mlt", "pssmlt", "vcm"}) {
    CAPTURE(name);
    const std::string text = "<integrator type='" + name + "'><integer name='maxDepth' value='7'/></integrator>";
    for (const Description& d : {with_integrator(text), read_text(nori_scene(text)),
                                 read_pbrt_world("", "Integrator \"" + name + "\" \"integer maxdepth\" 6")}) {
      CHECK(d.integrator.name() == "path");
      CHECK(d.integrator.max_depth == 7);
      REQUIRE(d.warnings.size() == 1);
      CHECK(contains(d.warnings[0], "integrator '" + name + "' is not supported: rendered with 'path'"));
      CHECK(contains(d.warnings[0], ":"));
      CHECK(contains(d.warnings[0], "--caustics mnee or --integrator sppm"));
    }
  }
}

TEST_CASE("Mitsuba: photon mappers have the documented parameters") {
  const Description mapper = with_integrator(
      "<integrator type='photonmapper'><integer name='globalPhotons' value='1234'/><float name='causticLookupRadius' "
      "value='0.5'/></integrator>");
  CHECK(mapper.integrator.kind == IntegratorKind::kPhotonMapper);
  CHECK(mapper.integrator.photons.global.count == 1234);
  CHECK(mapper.integrator.photons.global.relative_radius == 0.05f);
  CHECK(mapper.integrator.photons.caustic.count == 250'000);
  CHECK(mapper.integrator.photons.caustic.relative_radius == 0.5f);
  CHECK(mapper.integrator.photons.gathering == PhotonGathering::kIndirect);
  CHECK(mapper.integrator.photons.lookup_size == 120);
  CHECK(with_integrator("<integrator type='photonmapper'><boolean name='sampleDirect' value='false'/></integrator>")
            .integrator.photons.caustic.count == 0);
  const PhotonMappingSettings volumetric =
      with_integrator(
          "<integrator type='volumetricphotonmapper'><integer name='photonCount' value='1000'/><float "
          "name='photonRadius' value='0.25'/></integrator>")
          .integrator.photons;
  CHECK(volumetric.volume.count == 1000);
  CHECK(volumetric.volume.radius == 0.25f);
}

TEST_CASE("Mitsuba: progressive photon mappers have the documented parameters") {
  for (const char* name : {"ppm", "sppm"}) {
    const Description progressive = with_integrator(
        std::string("<integrator type='") + name +
        "'><integer name='photonCount' value='77'/><float name='initialRadius' value='0.25'/><float name='alpha' "
        "value='0.5'/><integer name='maxPasses' value='12'/></integrator>");
    const PhotonMappingSettings& photons = progressive.integrator.photons;
    CHECK(progressive.notes.empty());
    CHECK(photons.progressive);
    CHECK(photons.uses_beams());
    CHECK(!with_integrator(std::string("<integrator type='") + name +
                           "'><string name='mediumPhotons' value='points'/></integrator>")
               .integrator.photons.uses_beams());
    CHECK(photons.gathering == PhotonGathering::kIndirect);
    CHECK(photons.global.count == 77);
    CHECK(photons.global.radius == 0.25f);
    CHECK(photons.alpha == 0.5f);
    CHECK(photons.max_passes == 12);
    CHECK(photons.lookup_size == 0);
    CHECK(with_integrator(std::string("<integrator type='") + name + "'/>").integrator.photons.global.count == 250'000);
  }
}

TEST_CASE("Mitsuba: Russian roulette starts later in scenes with media") {
  const std::string ball = "<shape type='sphere'><medium name='interior' type='homogeneous'/>";
  for (const bool media : {false, true})
    for (const bool said : {false, true}) {
      const std::string integrator = std::string("<integrator type='volpath'>") +
                                     (said ? "<integer name='rr_depth' value='4'/>" : "") + "</integrator>";
      const Description d = read_text(mitsuba_scene(media ? ball + "</shape>" : "<shape type='sphere'/>",
                                                    "<sensor type='perspective'/>", integrator));
      CHECK(d.integrator.roulette_depth() == (said ? 4 : media ? 5 : 2));
    }
}

TEST_CASE("media: volumetric integrator names select strategy and estimator") {
  for (const char* name : {"vol_path", "vol_path_mis", "path_mis_vol", "path_vol_mis", "medium_path", "medium_path_mis",
                           "volpath_mis", "volpath", "volpathmis", "volpath_simple"}) {
    CAPTURE(name);
    REQUIRE(find_integrator(name).has_value());
    CHECK(find_integrator(name)->entry->strategy == LightStrategy::kMis);
    CHECK(find_integrator(name)->entry->kind == IntegratorKind::kPath);
    const std::string text = "<integrator type='" + std::string(name) + "'/>";
    CHECK(read_text(mitsuba_scene("", "<sensor type='perspective'/>", text)).notes.empty());
  }
  for (const char* name : {"vol_path_mats", "medium_path_mats"})
    CHECK(find_integrator(name)->entry->strategy == LightStrategy::kBsdfOnly);

  const auto integrator = [](const std::string& type, const std::string& estimator) {
    return "<integrator type='" + type + "'><string name='medium_estimator' value='" + estimator +
           "'/><float name='stepSize' value='0.25'/></integrator>";
  };
  for (const std::string& name : kMediumEstimators.names()) {
    const auto nori = read_text(nori_scene(integrator("vol_path_mis", name))).integrator;
    const auto mitsuba =
        read_text(mitsuba_scene("", "<sensor type='perspective'/>", integrator("volpathmis", name))).integrator;
    for (const IntegratorSettings& read : {nori, mitsuba}) {
      CHECK(kMediumEstimators.name_of(read.medium_estimator) == name);
      CHECK(read.step_size == 0.25f);
    }
    CHECK(kMediumEstimators.name_of(kMediumEstimators.option("medium estimator", name)) == name);
  }
  CHECK_THROWS_WITH_AS(kMediumEstimators.option("medium estimator", "deltas"),
                       "unknown medium estimator 'deltas', did you mean 'delta'? (known: null_mis, delta, ratio, "
                       "marching)",
                       Error);
  CHECK(contains(error_of_text(nori_scene(integrator("path", "rati"))),
                 "expected null_mis, delta, ratio or marching, did you mean 'ratio'?"));
  CHECK(contains(error_of_text(nori_scene("<integrator type='path'><float name='stepSize' value='0'/></integrator>")),
                 "expected a positive number"));
}

}  // namespace sheaf::test_integrator_reading
