// Metals and dielectrics by name: ranges, order, and well-known colors.
#include "scene/data/metals.h"
#include "scene/data/named_ior.h"
#include "scene/spectra/spectrum_rgb.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_metals {

namespace {

/// Fresnel reflectance at normal incidence.
double reflectance(double eta, double k) { return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k); }

/// Reflectance of a metal, linear between its samples.
double reflectance_at(const char* name, float wavelength) {
  const auto samples = find_metal(name);
  const auto above =
      std::find_if(samples.begin(), samples.end(), [&](const MetalSample& s) { return s.wavelength >= wavelength; });
  const auto below = above - 1;
  const double t = (wavelength - below->wavelength) / (above->wavelength - below->wavelength);
  return reflectance(below->eta + t * (above->eta - below->eta), below->k + t * (above->k - below->k));
}

}  // namespace

TEST_CASE("metals: tables are ordered and positive and cover the visible range") {
  for (const std::string& name : metal_names()) {
    CAPTURE(name);
    const auto samples = find_metal(name);
    REQUIRE(samples.size() >= 5);
    CHECK(samples.front().wavelength <= 360);
    CHECK(samples.back().wavelength >= 830);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      CAPTURE(samples[i].wavelength);
      if (i > 0) CHECK(samples[i].wavelength > samples[i - 1].wavelength);
      CHECK(samples[i].eta > 0);
      CHECK(samples[i].k >= 0);
      CHECK((samples[i].k > 0 || samples[i].eta > 1));
      // Detects typing errors: neighbors have similar reflectance. The steepest step is that of titanium nitride,
      // which has few samples.
      if (i > 0)
        CHECK(std::abs(reflectance(samples[i].eta, samples[i].k) - reflectance(samples[i - 1].eta, samples[i - 1].k)) <
              0.25);
    }
  }
}

TEST_CASE("metals: all names of Mitsuba and pbrt are known") {
  for (const char* name : {"Ag", "Al", "Au", "Cr", "Cu", "Fe", "Hg", "Ir", "Ni", "Pt", "Ti", "TiN", "V", "W"})
    CHECK_FALSE(find_metal(name).empty());
  // All names of Mitsuba and pbrt.
  for (const char* name :
       {"Ag",         "Al",        "AlAs",       "AlAs_palik", "AlSb",         "AlSb_palik", "Au",         "Be",
        "Be_palik",   "Cr",        "CsI",        "CsI_palik",  "Cu",           "Cu2O",       "Cu2O_palik", "CuO",
        "CuO_palik",  "Cu_palik",  "Hg",         "HgTe",       "HgTe_palik",   "Hg_palik",   "Ir",         "Ir_palik",
        "K",          "K_palik",   "Li",         "Li_palik",   "MgO",          "MgO_palik",  "Mo",         "Mo_palik",
        "Na_palik",   "Nb",        "Nb_palik",   "Ni_palik",   "Rh",           "Rh_palik",   "Se",         "Se-e",
        "Se-e_palik", "Se_palik",  "SiC",        "SiC_palik",  "SnTe",         "SnTe_palik", "Ta",         "Ta_palik",
        "Te",         "Te-e",      "Te-e_palik", "Te_palik",   "ThF4",         "ThF4_palik", "TiC",        "TiC_palik",
        "TiN",        "TiN_palik", "TiO2",       "TiO2-e",     "TiO2-e_palik", "TiO2_palik", "VC",         "VC_palik",
        "VN",         "VN_palik",  "V_palik",    "W",          "a-C",          "d-C",        "d-C_palik",  "CuZn"}) {
    CAPTURE(std::string(name));
    CHECK_FALSE(find_metal(name).empty());
  }
  CHECK(find_metal("Cu_palik").data() != find_metal("Cu").data());
  CHECK(find_metal("Ni_palik").data() == find_metal("Ni").data());
  CHECK(find_metal("none").empty());
  CHECK(find_metal("").empty());
  CHECK(find_metal("_palik").empty());
  CHECK(find_metal("au").empty());
}

TEST_CASE("metals: values match the handbook") {
  // Palik 1985 and 1991, and Querry 1985 for brass.
  struct Case {
    const char* name;
    float wavelength, eta, k;
  };
  for (const Case& c : {Case{"Ag", 619.92f, 0.131f, 3.88f},
                        {"Ag", 413.28f, 0.173f, 2.11f},
                        {"Al", 619.92f, 1.3f, 7.48f},
                        {"Au", 619.92f, 0.194f, 3.06f},
                        {"Au", 495.94f, 0.916f, 1.84f},
                        {"Cu", 619.92f, 0.272f, 3.24f},
                        {"a-C", 619.9f, 2.43f, 0.75f},
                        {"CuZn", 550, 0.527f, 2.765f}}) {
    CAPTURE(std::string(c.name));
    const auto samples = find_metal(c.name);
    const auto found = std::find_if(samples.begin(), samples.end(), [&](const MetalSample& s) {
      return std::abs(s.wavelength - c.wavelength) < 0.02f;
    });
    REQUIRE(found != samples.end());
    CHECK(found->eta == near(c.eta));
    CHECK(found->k == near(c.k, 0.02));
  }
}

TEST_CASE("metals: reflectance at normal incidence matches clean surfaces") {
  // The spread of published measurements.
  struct Case {
    const char* name;
    float wavelength;
    double low, high;
  };
  const Case cases[] = {{"Ag", 400, 0.84, 0.97}, {"Ag", 550, 0.94, 0.99}, {"Al", 450, 0.90, 0.93},
                        {"Al", 550, 0.90, 0.93}, {"Au", 450, 0.33, 0.42}, {"Au", 550, 0.74, 0.85},
                        {"Au", 700, 0.95, 0.99}, {"Cu", 450, 0.50, 0.60}, {"Cu", 700, 0.94, 0.99},
                        {"Cr", 550, 0.53, 0.72}, {"Fe", 550, 0.48, 0.60}, {"Ni", 550, 0.57, 0.67},
                        {"Pt", 550, 0.57, 0.72}, {"W", 550, 0.45, 0.54},  {"Hg", 550, 0.73, 0.82}};
  for (const Case& c : cases) {
    CAPTURE(std::string(c.name));
    CAPTURE(c.wavelength);
    CHECK(reflectance_at(c.name, c.wavelength) > c.low);
    CHECK(reflectance_at(c.name, c.wavelength) < c.high);
  }
  // Gold is yellow, copper red, aluminum almost gray.
  CHECK(reflectance_at("Au", 700) > 2.3 * reflectance_at("Au", 450));
  CHECK(reflectance_at("Cu", 650) > 1.5 * reflectance_at("Cu", 520));
  CHECK(std::abs(reflectance_at("Al", 650) - reflectance_at("Al", 450)) < 0.02);
}

TEST_CASE("metals: eta and k of a Mitsuba scene match Mitsuba in RGB mode") {
  struct Case {
    const char* name;
    Vec3f eta, k;  // of Mitsuba 3.9.1, scalar_rgb
  };
  for (const Case& c : {Case{"a-C", {2.94405f, 2.22714f, 1.96816f}, {0.887465f, 0.799299f, 0.81529f}},
                        {"Au", {0.143036f, 0.375307f, 1.44205f}, {3.983f, 2.38556f, 1.60336f}},
                        {"Ag", {0.155276f, 0.116728f, 0.138388f}, {4.82835f, 3.12222f, 2.1469f}}}) {
    CAPTURE(std::string(c.name));
    const Description d = test::read_text(
        "<scene version='3.0.0'><sensor type='perspective'/><shape type='sphere'><bsdf type='conductor'>"
        "<string name='material' value='" +
        std::string(c.name) + "'/></bsdf></shape></scene>");
    for (const MaterialDescription& material : d.materials)
      if (const auto* conductor = std::get_if<ConductorDescription>(&material.model)) {
        const Vec3f eta = unbounded_rgb(std::get<SpectrumDescription>(conductor->ior->eta));
        const Vec3f k = unbounded_rgb(std::get<SpectrumDescription>(conductor->ior->k));
        CHECK(length(eta - c.eta) < 5e-3f * length(c.eta));
        CHECK(length(k - c.k) < 5e-3f * length(c.k));
      }
    REQUIRE_FALSE(d.materials.empty());
  }
}

TEST_CASE("dielectrics are found by name") {
  CHECK(find_ior("vacuum") == 1.0f);
  CHECK(find_ior("air") == 1.000277f);
  CHECK(find_ior("water") == 1.333f);
  CHECK(find_ior("bk7") == 1.5046f);
  CHECK(find_ior("diamond") == 2.419f);
  CHECK_FALSE(find_ior("Water").has_value());
  CHECK_FALSE(find_ior("").has_value());
  CHECK(ior_names().size() == 23);
  for (const std::string& name : ior_names()) CHECK(find_ior(name).value() >= 1);
}

}  // namespace sheaf::test_metals
