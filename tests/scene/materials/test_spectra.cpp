// Spectrum rows: values of each kind of description, and colors that match RGB mode.
#include "scene/spectra/spectrum_set.h"

#include "core/color/spectral_sensor.h"
#include "core/io/error.h"
#include "core/sampling/rng.h"
#include "scene/data/illuminants.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"
#include "tests/support/spectral_testing.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_spectra {

namespace {

using Table = SpectrumDescription::Table;
constexpr std::array kUses = {SpectrumUse::kReflectance, SpectrumUse::kIlluminant, SpectrumUse::kUnbounded,
                              SpectrumUse::kRaw};

float at(const SpectrumSet& set, const SpectrumRow& row, float lambda) {
  return evaluate<Scalar>(&row, 0, set.view(), Spectrum4(lambda)).c0;
}

float integral(const SpectrumSet& set, const SpectrumRow& row) {
  double sum = 0;
  for (int i = 360; i <= 830; ++i)
    sum += (i == 360 || i == 830 ? 0.5 : 1.0) * static_cast<double>(at(set, row, static_cast<float>(i)));
  return static_cast<float>(sum);
}

/// The color of an emitter with this row.
Vec3f emission_color(const SpectrumSet& set, const SpectrumRow& row) {
  return power_to_rgb([&](float lambda) { return at(set, row, lambda); });
}

SpectrumDescription table(std::vector<float> wavelengths, std::vector<float> values) {
  return {Table{std::move(wavelengths), std::move(values)}};
}

void check_close(Vec3f found, Vec3f expected, double relative) {
  CHECK(found.x == near(static_cast<double>(expected.x), relative));
  CHECK(found.y == near(static_cast<double>(expected.y), relative));
  CHECK(found.z == near(static_cast<double>(expected.z), relative));
}

}  // namespace

TEST_CASE("spectrum rows: constants and grays are flat and emitters have the spectrum of D65") {
  SpectrumSet set;
  for (const SpectrumUse use : kUses)
    for (const auto& gray : {SpectrumDescription::constant(0.37f), SpectrumDescription::rgb(0.37f, 0.37f, 0.37f)}) {
      const SpectrumRow row = set.row(gray, use);
      CHECK(row.is_flat() == (use != SpectrumUse::kIlluminant));
      for (float lambda = 360; lambda <= 830; lambda += 47) {
        if (use == SpectrumUse::kIlluminant)
          CHECK(100 * at(set, row, lambda) / at(set, row, 560) == near(double(cie_d65(lambda))));
        else
          CHECK(at(set, row, lambda) == near(0.37, 1e-7));
      }
    }
  const SpectrumRow light = set.row(SpectrumDescription::constant(3), SpectrumUse::kIlluminant);
  check_close(emission_color(set, light), {3, 3, 3}, 1e-3);
}

TEST_CASE("spectrum rows: colors of every use match RGB mode") {
  SpectrumSet set;
  for (const Vec3f rgb : {Vec3f{0.8f, 0.1f, 0.2f}, {0.05f, 0.3f, 0.9f}, {0.9f, 0.85f, 0.1f}, {0.01f, 0.02f, 0.015f}}) {
    const auto description = SpectrumDescription::rgb(rgb.x, rgb.y, rgb.z);
    const auto reflects = set.row(description, SpectrumUse::kReflectance);
    CHECK(largest_difference(reflectance_to_rgb([&](float l) { return at(set, reflects, l); }), rgb) < 2e-4f);
    const Vec3f strong = rgb * 40.0f;
    const auto emits = set.row(SpectrumDescription::rgb(strong.x, strong.y, strong.z), SpectrumUse::kIlluminant);
    CHECK(largest_difference(emission_color(set, emits), strong) < 4e-3f * max_component(strong));
    const auto eta = set.row(SpectrumDescription::rgb(strong.x, strong.y, strong.z), SpectrumUse::kUnbounded);
    CHECK(largest_difference(reflectance_to_rgb([&](float l) { return at(set, eta, l); }), strong) < 1e-2f);
    // A coefficient in the range of reflectances has the same spectrum.
    CHECK(set.row(description, SpectrumUse::kUnbounded) == reflects);
    CHECK(at(set, set.row(description, SpectrumUse::kRaw), 444) == near(double(luminance(rgb))));
  }
}

TEST_CASE("spectrum rows: tables keep their values and their colors match RGB mode") {
  SpectrumSet set;
  const std::vector<float> wavelengths{400, 500, 600, 700}, values{0, 0.3f, 0.6f, 0.7f}, strong{0, 8, 15.6f, 18.4f};
  const auto row = set.row(table(wavelengths, values), SpectrumUse::kReflectance);
  CHECK(at(set, row, 550) == near(0.45));
  CHECK(at(set, row, 550.5f) == near(0.4515));
  CHECK(at(set, row, 399) == 0.0f);
  CHECK(at(set, row, 702) == 0.0f);
  CHECK(largest_difference(reflectance_to_rgb([&](float l) { return at(set, row, l); }),
                           reflectance_table_to_rgb(wavelengths, values)) < 2e-4f);
  const auto emits = set.row(table(wavelengths, strong), SpectrumUse::kIlluminant);
  check_close(emission_color(set, emits), emission_table_to_rgb(wavelengths, strong), 2e-4);
  CHECK(at(set, set.row(table(wavelengths, strong), SpectrumUse::kReflectance), 600) == 1.0f);
  const auto unbounded = set.row(table(wavelengths, strong), SpectrumUse::kUnbounded);
  CHECK(at(set, unbounded, 600) == near(15.6, 1e-3));
  CHECK(set.row(table({300, 900}, {2, 2}), SpectrumUse::kUnbounded).is_flat());
}

TEST_CASE("spectrum rows: resampling keeps the power of lines and steps at any wavelength") {
  SpectrumSet set;
  for (const float center : {500.0f, 546.07f, 611.5f, 435.83f}) {
    // A line of width 0.02 nm and power 1, which point samples would miss or overestimate.
    const auto line = set.row(table({center - 0.02f, center, center + 0.02f}, {0, 50, 0}), SpectrumUse::kIlluminant);
    CHECK(integral(set, line) == near(1, 5e-3));
    CHECK(at(set, line, center + 2.1f) == 0.0f);
    const Vec3f seen = emission_color(set, line) * 100.0f;  // outside the gamut, where RGB mode clamps
    check_close({std::max(seen.x, 0.0f), std::max(seen.y, 0.0f), std::max(seen.z, 0.0f)},
                emission_table_to_rgb(std::vector<float>{center - 0.02f, center, center + 0.02f},
                                      std::vector<float>{0, 5000, 0}),
                2e-2);
  }
  // The line is no wider than necessary.
  const auto sharp = set.row(table({499.99f, 500, 500.01f}, {0, 100, 0}), SpectrumUse::kIlluminant);
  CHECK(at(set, sharp, 500) == near(1, 2e-2));
  CHECK(at(set, sharp, 501) < 0.01f);
  const auto step = set.row(table({450.3f, 620.8f}, {1, 1}), SpectrumUse::kIlluminant);
  CHECK(integral(set, step) == near(170.5, 1e-5));
}

TEST_CASE("spectrum rows: black bodies have absolute radiance") {
  SpectrumSet set;
  const auto row = set.row({SpectrumDescription::Blackbody{2856, 2}}, SpectrumUse::kIlluminant);
  for (const float lambda : {360.0f, 500.5f, 830.0f})
    CHECK(at(set, row, lambda) == near(2 * blackbody_radiance(double(lambda), 2856), 1e-4));
  check_close(emission_color(set, row), blackbody_to_rgb(2856, 2), 1e-4);
}

TEST_CASE("spectrum rows: equal tables are stored once and invalid ones are rejected") {
  SpectrumSet set;
  const auto a = set.row(table({400, 700}, {1, 0}), SpectrumUse::kUnbounded);
  const std::size_t size = set.samples().size();
  CHECK(set.row(table({400, 700}, {1, 0}), SpectrumUse::kUnbounded) == a);
  CHECK(set.samples().size() == size);
  CHECK_FALSE(set.row(table({400, 701}, {1, 0}), SpectrumUse::kUnbounded) == a);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const SpectrumUse use : kUses) {
    CHECK_THROWS_AS(set.row(table({400, 500}, {1}), use), SceneError);
    CHECK_THROWS_AS(set.row(table({500, 400}, {1, 1}), use), SceneError);
    CHECK_THROWS_AS(set.row(table({500, 600}, {1, nan}), use), SceneError);
    CHECK_THROWS_AS(set.row(table({500, kInfinity}, {1, 1}), use), SceneError);
    CHECK_THROWS_AS(set.row(table({}, {}), use), SceneError);
    CHECK_THROWS_AS(set.row(SpectrumDescription::constant(nan), use), SceneError);
    CHECK_THROWS_AS(set.row(SpectrumDescription::rgb(1, nan, 0), use), SceneError);
    CHECK_THROWS_AS(set.row({SpectrumDescription::Blackbody{5000, kInfinity}}, use), SceneError);
  }
  CHECK(at(set, set.row(table({1, 2}, {1, 1}), SpectrumUse::kIlluminant), 500) == 0.0f);
  CHECK(at(set, set.row(table({1e30f, 2e30f}, {1, 1}), SpectrumUse::kIlluminant), 500) == 0.0f);
}

TEST_CASE("spectrum rows: SIMD results of mixed kinds equal scalar ones") {
  SpectrumSet set;
  std::vector<SpectrumRow> rows{set.row(SpectrumDescription::constant(0.5f), SpectrumUse::kReflectance),
                                set.row(SpectrumDescription::rgb(0.9f, 0.2f, 0.1f), SpectrumUse::kReflectance),
                                set.row(SpectrumDescription::rgb(7, 9, 3), SpectrumUse::kIlluminant),
                                set.row({SpectrumDescription::Blackbody{4000, 1}}, SpectrumUse::kIlluminant),
                                set.row(table({400, 650}, {3, 1}), SpectrumUse::kUnbounded)};
  for (std::uint32_t run = 0; run < 20; ++run) {
    const WideFloat u = wide_floats([&](int lane) { return random4<Scalar>(3, run, std::uint32_t(lane), 0).x; });
    // The last runs contain rows without tables only, which use the other branch.
    const WideUint index = wide_uints([&](int lane) { return std::uint32_t(lane) % (run < 15 ? 5u : 2u); });
    const auto w = sample_wavelengths<Wide>(u);
    const auto wide = evaluate<Wide>(rows.data(), index, set.view(), w.lambda);
    for (int lane = 0; lane < kWidth; ++lane) {
      const Spectrum4 lambda(w.lambda.c0[lane], w.lambda.c1[lane], w.lambda.c2[lane], w.lambda.c3[lane]);
      const Spectrum4 one = evaluate<Scalar>(rows.data(), index[lane], set.view(), lambda);
      CHECK(difference(wide.c0[lane], one.c0) < 1e-5);
      CHECK(difference(wide.c3[lane], one.c3) < 1e-5);
    }
  }
}

TEST_CASE("illuminants: chromaticities match the published ones and luminance is 1") {
  struct Case {
    const char* name;
    double x, y;  // CIE 15:2018, tables 3 and 11.1
  };
  for (const Case& c : {Case{"a", 0.44758, 0.40745},
                        {"d50", 0.34567, 0.35851},
                        {"d55", 0.33243, 0.34744},
                        {"d65", 0.31272, 0.32903},
                        {"d75", 0.29903, 0.31488},
                        {"e", 1.0 / 3, 1.0 / 3}}) {
    CAPTURE(std::string(c.name));
    SpectrumSet set;
    const auto row = set.row({find_illuminant(c.name).value()}, SpectrumUse::kIlluminant);
    const auto [x, y, z] = power_to_xyz([&](float lambda) { return at(set, row, lambda); });
    CHECK(std::abs(x / (x + y + z) - c.x) < 5e-5);
    CHECK(std::abs(y / (x + y + z) - c.y) < 5e-5);
    CHECK(y == near(1, 1e-4));
  }
  CHECK_FALSE(find_illuminant("D65").has_value());
  CHECK_FALSE(find_illuminant("").has_value());
  CHECK(illuminant_names().size() == 6);
}

}  // namespace sheaf::test_spectra
