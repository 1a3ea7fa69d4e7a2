// Dispersion: published indices at the yellow helium line, Abbe numbers, and compiled rows.
#include "scene/data/glasses.h"

#include "scene/data/named_ior.h"
#include "scene/spectra/spectrum_set.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_glasses {

namespace {

/// Fraunhofer's d, F and C lines in nm.
constexpr float kLineD = 587.5618f, kLineF = 486.1327f, kLineC = 656.2725f;

double index(const char* name, float lambda) {
  return static_cast<double>(ior<Scalar>(*find_dispersion(name), lambda));
}
double abbe_number(const char* name) { return (index(name, kLineD) - 1) / (index(name, kLineF) - index(name, kLineC)); }

}  // namespace

TEST_CASE("glasses: indices and Abbe numbers match the published ones") {
  struct Case {
    const char* name;
    double n_d, n_tolerance, abbe, abbe_tolerance;
  };
  // Schott's data sheets for the glasses. For the others, figures of the papers or the spread of handbooks.
  for (const Case& c : {Case{"bk7", 1.51680, 2e-5, 64.17, 0.02},
                        {"sf11", 1.78472, 2e-5, 25.76, 0.02},
                        {"n-sf11", 1.78472, 2e-5, 25.68, 0.02},
                        {"fused silica", 1.45846, 2e-5, 67.82, 0.05},
                        {"diamond", 2.4175, 5e-4, 55.3, 0.3},
                        {"water", 1.33340, 1e-4, 55.75, 0.2},
                        {"sapphire", 1.7682, 2e-4, 72.3, 0.2},
                        {"sodium chloride", 1.54420, 2e-4, 42.8, 0.3},
                        {"water ice", 1.3098, 2e-4, 53.2, 3.0},
                        {"acrylic glass", 1.4900, 3e-3, 58.0, 2.0},
                        {"ethanol", 1.3617, 5e-4, 59.4, 3.0},
                        {"acetone", 1.3592, 5e-4, 54.5, 3.0},
                        {"benzene", 1.4965, 3e-3, 30.5, 2.0}}) {
    CAPTURE(std::string(c.name));
    CHECK(std::abs(index(c.name, kLineD) - c.n_d) < c.n_tolerance);
    CHECK(std::abs(abbe_number(c.name) - c.abbe) < c.abbe_tolerance);
  }
}

TEST_CASE("glasses: the fit for ice is within 1e-4 of its table") {
  // Warren and Brandt 2008.
  for (const auto& [lambda, n] : {std::pair{390.0f, 1.3203},
                                  {450.0f, 1.3157},
                                  {500.0f, 1.3130},
                                  {550.0f, 1.3110},
                                  {600.0f, 1.3094},
                                  {700.0f, 1.3069},
                                  {830.0f, 1.3044}})
    CHECK(std::abs(index("water ice", lambda) - n) < 1e-4);
}

TEST_CASE("glasses: fused silica matches the table of Malitson") {
  // Malitson 1965, table I: computed values at spectral lines.
  for (const auto& [lambda, n] : {std::pair{404.656f, 1.469618},
                                  {435.835f, 1.466693},
                                  {546.074f, 1.460078},
                                  {632.8f, 1.457018},
                                  {706.520f, 1.455145}})
    CHECK(index("fused silica", lambda) == near(n, 2e-6));
}

TEST_CASE("glasses: indices decrease with wavelength and are close to the constants of the same name") {
  for (const std::string& name : dispersion_names()) {
    CAPTURE(name);
    for (float lambda = 361; lambda <= 830; lambda += 1) {
      REQUIRE(index(name.c_str(), lambda) < index(name.c_str(), lambda - 1) + 1e-7);
      REQUIRE(index(name.c_str(), lambda) > 1.29);
    }
    if (const auto constant = find_ior(name))
      CHECK(index(name.c_str(), 589.3f) == near(static_cast<double>(*constant), 0.009));
  }
  CHECK(find_dispersion("BK7") == nullptr);
  CHECK(find_dispersion("") == nullptr);
}

TEST_CASE("glasses: compiled rows match the formulas and SIMD results equal scalar ones") {
  SpectrumSet set;
  std::vector<SpectrumRow> rows;
  for (const std::string& name : dispersion_names()) rows.push_back(dispersion_row(set, *find_dispersion(name)));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Dispersion& d = *find_dispersion(dispersion_names()[k]);
    CHECK_FALSE(rows[k].is_flat());
    for (int run = 0; run < 10; ++run) {
      const float start = 360.7f + 46.7f * static_cast<float>(run);
      const WideFloat lambda =
          wide_floats([&](int lane) { return std::min(start + static_cast<float>(lane), 830.0f); });
      const WideUint index(static_cast<std::uint32_t>(k));
      const auto row = evaluate<Wide>(rows.data(), index, set.view(), Spectrum<Wide>(lambda));
      const WideFloat formula = ior<Wide>(d, lambda);
      for (int lane = 0; lane < kWidth; ++lane) {
        CHECK(std::abs(row.c2[lane] - formula[lane]) < 2e-6f);
        CHECK(difference(formula[lane], ior<Scalar>(d, lambda[lane])) < 1e-6);
      }
    }
  }
}

}  // namespace sheaf::test_glasses
