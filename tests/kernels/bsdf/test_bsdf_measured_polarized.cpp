// The unpolarized part of polarimetric BRDFs: against the functions that were tabulated, against a diffuse BRDF, and
// against Mitsuba 3 with the same file.
#include "kernels/bsdf/list.h"
#include "scene/compile/compile.h"
#include "scene/scene.h"
#include "tests/support/bsdf_testing.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/measured_testing.h"
#include "tests/support/near.h"

#include <set>

namespace sheaf::test_bsdf_measured_polarized {

namespace {

using test::contains;

/// A BSDF with its tables.
struct Polarized {
  std::vector<float> floats;
  MeasuredBsdf<Scalar> bsdf;

  explicit Polarized(const PolarizedBrdf& brdf, float alpha = 0.3f) {
    ClosureTables tables;
    bsdf.table = tables.polarized(brdf, alpha);
    floats = tables.take();
    bsdf.tables = floats.data();
    bsdf.red = {1, 0, 0, 0}, bsdf.green = {0, 1, 0, 0}, bsdf.blue = {0, 0, 1, 0};
  }
};

constexpr double kDiffuse[] = {0.3 / kPi, 0.5 / kPi, 0.8 / kPi};

PolarizedBrdf lambertian() {
  return tabulate_polarized(3, 3, {}, [](double, double, double, std::size_t channel) { return kDiffuse[channel]; });
}

/// A smooth function of all angles.
double waves(double phi_d, double theta_d, double theta_h, std::size_t channel) {
  return 0.1 + 0.04 * std::cos(phi_d) * std::sin(theta_h) + 0.03 * std::cos(theta_d) * std::cos(theta_h) +
         0.02 * std::sin(2 * phi_d) * std::sin(theta_h) * std::sin(theta_d) + 0.02 * double(channel);
}

/// Half and difference angles by rotations, the definition of Rusinkiewicz 1998.
struct Angles {
  double phi_d, theta_d, theta_h;

  Angles(Vec3f wo, Vec3f wi) {
    const Vec3f h = normalize(wo + wi);
    theta_h = std::acos(std::min(1.0, double(h.z)));
    const double phi_h = std::atan2(double(h.y), double(h.x));
    // Rotate wi by -phi_h about z, then by -theta_h about y
    const double x = std::cos(phi_h) * double(wi.x) + std::sin(phi_h) * double(wi.y);
    const double y = -std::sin(phi_h) * double(wi.x) + std::cos(phi_h) * double(wi.y), z = double(wi.z);
    const double a = std::cos(theta_h) * x - std::sin(theta_h) * z, b = std::sin(theta_h) * x + std::cos(theta_h) * z;
    phi_d = std::atan2(y, a), theta_d = std::acos(std::min(1.0, b));
  }
};

Vec3f upper(std::uint32_t stream, std::uint32_t i) {
  Vec3f w = random_direction(stream, i);
  w.z = std::fabs(w.z);
  return w;
}

std::string error_of_fields(const std::vector<TensorField>& fields) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.pbsdf", tensor_bytes(fields));
  try {
    read_polarized_brdf(folder / "a.pbsdf");
  } catch (const SceneError& error) {
    CHECK(contains(error.what(), "a.pbsdf: "));
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("measured_polarized: a tabulated diffuse BRDF is diffuse") {
  const Polarized polarized(lambertian());
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3f wo = upper(3, i), wi = upper(4, i);
    const auto value = polarized.bsdf.evaluate(wo, wi);
    CHECK(value.f_cos.c0 == near(kDiffuse[0] * double(wi.z), 1e-5));
    CHECK(value.f_cos.c1 == near(kDiffuse[1] * double(wi.z), 1e-5));
    CHECK(value.f_cos.c2 == near(kDiffuse[2] * double(wi.z), 1e-5));
  }
  // The same direction, the normal, and below the surface
  const Vec3f up{0, 0, 1}, down{0, 0, -1};
  CHECK(polarized.bsdf.evaluate(up, up).f_cos.c1 == near(kDiffuse[1], 1e-5));
  CHECK(polarized.bsdf.evaluate(upper(3, 1), upper(3, 1)).pdf_solid_angle > 0.0f);
  CHECK(polarized.bsdf.evaluate(down, up).pdf_solid_angle == 0.0f);
  CHECK(polarized.bsdf.evaluate(up, down).pdf_solid_angle == 0.0f);
  CHECK_FALSE(polarized.bsdf.sample(down, {0.5f, 0.2f, 0.3f, 0.4f}).valid);
  check_bsdf_weights(polarized.bsdf, 2e-3);
  check_white_furnace(polarized.bsdf, false);
}

TEST_CASE("measured_polarized: values are those at the half and difference angles") {
  const Polarized polarized(tabulate_polarized(181, 46, {}, waves));
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vec3f wo = upper(3, i), wi = upper(4, i);
    const Angles angles(wo, wi);
    const Spectrum4 f = polarized.bsdf.evaluate(wo, wi).f_cos;
    const float found[] = {f.c0, f.c1, f.c2};
    for (std::size_t c = 0; c < 3; ++c)
      CHECK(found[c] == near(waves(angles.phi_d, angles.theta_d, angles.theta_h, c) * double(wi.z), 2e-3));
  }
  check_bsdf_weights(polarized.bsdf, 2e-3);
}

TEST_CASE("measured_polarized: samples follow the pdf for any roughness of the facets") {
  for (const float alpha : {0.1f, 0.4f, 1.0f}) check_bsdf_sampling_with_edges(Polarized(lambertian(), alpha).bsdf, 30);
}

TEST_CASE("measured_polarized: values and pdfs match Mitsuba for the same file") {
  // f times the cosine at 430, 480, 560 and 640 nm, and the pdf, by Mitsuba 3.9 (scalar_spectral_polarized)
  constexpr float kReferences[][5] = {{0.0388373f, 0.0420473f, 0.0506072f, 0.0591672f, 0.049352f},
                                      {0.0569186f, 0.0618204f, 0.074892f, 0.0879636f, 0.124991f},
                                      {0.0689422f, 0.0754259f, 0.0927156f, 0.110005f, 0.499099f},
                                      {0.0796344f, 0.0875542f, 0.108674f, 0.129793f, 0.272254f},
                                      {0.0890771f, 0.0982552f, 0.12273f, 0.147205f, 0.103599f},
                                      {0.0910882f, 0.101318f, 0.128599f, 0.15588f, 0.0818683f}};
  const PolarizedBrdf brdf = tabulate_polarized(37, 19, {450, 500, 550, 600, 650}, waves);
  const std::vector<float> positions = wavelength_positions(brdf.wavelengths);
  ClosureTables tables;
  MeasuredSpectralBsdf<Scalar> bsdf;
  bsdf.table = tables.polarized(brdf, 0.3f);
  const std::vector<float> floats = tables.take();
  bsdf.tables = floats.data();
  bsdf.position = {positions[70], positions[120], positions[200], positions[280]};
  for (int i = 0; i < 6; ++i) {
    const Vec3f wo = direction_at(0.2 + 0.2 * i, 0.7 * i), wi = direction_at(1.3 - 0.15 * i, 2.0 + 1.3 * i);
    const auto [f, pdf] = bsdf.evaluate(wo, wi);
    const float found[] = {f.c0, f.c1, f.c2, f.c3, pdf};
    for (std::size_t k = 0; k < 5; ++k) CHECK(found[k] == near(kReferences[i][k], 2e-4));
  }
}

TEST_CASE("measured_polarized: lanes with tables of both kinds keep their own") {
  ClosureTables tables;
  MeasuredBsdf<Scalar> one[2];
  one[0].table = tables.polarized(lambertian(), 0.3f);
  one[1].table = tables.measured(TabulatedFacets{}.tabulate());
  const std::vector<float> floats = tables.take();
  for (MeasuredBsdf<Scalar>& bsdf : one) {
    bsdf.red = {1, 0, 0, 0}, bsdf.green = {0, 1, 0, 0}, bsdf.blue = {0, 0, 1, 0};
    bsdf.tables = floats.data();
  }
  auto wide = wide_record<MeasuredBsdf>([&](int lane) { return one[lane % 2]; });
  wide.tables = floats.data();
  const Vec3f wo = direction_at(0.4, 1), wi = direction_at(0.9, 2);
  const auto value = wide.evaluate(broadcast<Wide>(wo), broadcast<Wide>(wi));
  for (int lane = 0; lane < kWidth; ++lane) {
    const auto expected = one[lane % 2].evaluate(wo, wi);
    CHECK(value.pdf_solid_angle[lane] == near(expected.pdf_solid_angle, 1e-4));
    CHECK(value.f_cos.c1[lane] == near(expected.f_cos.c1, 1e-4));
  }
}

TEST_CASE("measured_polarized: files hold the first elements of Mueller matrices") {
  const TemporaryFolder folder;
  PolarizedBrdf expected = tabulate_polarized(5, 4, {450, 500, 550, 600, 650}, waves);
  expected.values[3] = -0.5f, expected.values[4] = std::nanf("");
  write_bytes(folder / "a.pbsdf", tensor_bytes(polarized_fields(expected)));
  PolarizedBrdf found = read_polarized_brdf(folder / "a.pbsdf");
  expected.values[3] = expected.values[4] = 0;
  CHECK(found.phi_d == expected.phi_d);
  CHECK(found.theta_d == expected.theta_d);
  CHECK(found.theta_h == expected.theta_h);
  CHECK(found.wavelengths == expected.wavelengths);
  CHECK(found.channels == 5);
  CHECK(found.values == expected.values);
  // One wavelength
  const std::size_t size = 16, at = 7;
  for (const auto& [nm, low, t] :
       {std::tuple{450.0f, 0, 0.0f}, {520.0f, 1, 0.4f}, {650.0f, 3, 1.0f}, {400.0f, 0, 0.0f}}) {
    PolarizedBrdf one = expected;
    select_wavelength(one, nm);
    CHECK(one.channels == 1);
    const float* const value = expected.values.data() + size * static_cast<std::size_t>(low) + at;
    CHECK(one.values[at] == near((1 - t) * value[0] + t * value[size], 1e-5));
  }
  // Colors: equal values at all wavelengths are gray
  make_rgb(found);
  CHECK(found.channels == 3);
  PolarizedBrdf gray = tabulate_polarized(2, 2, {450, 650}, [](double, double, double, std::size_t) { return 0.4; });
  make_rgb(gray);
  for (const float value : gray.values) CHECK(value == near(0.4, 1e-5));
}

TEST_CASE("measured_polarized: malformed files are errors with a message") {
  const PolarizedBrdf small = tabulate_polarized(3, 2, {450, 650}, waves);
  CHECK(error_of_fields(polarized_fields(small)).empty());
  const auto with = [&](std::size_t field, const std::function<void(TensorField&)>& change) {
    std::vector<TensorField> fields = polarized_fields(small);
    change(fields[field]);
    return error_of_fields(fields);
  };
  CHECK(contains(with(0, [](TensorField& f) { f.name = "phi"; }), "has no field 'phi_d' (it has: M, phi, "));
  CHECK(contains(with(1, [](TensorField& f) { f.shape = {1, 1}; }), "field 'theta_d' has 1 numbers, expected 2 to"));
  CHECK(contains(with(2, [](TensorField& f) { std::swap(f.bytes[3], f.bytes[7]), std::swap(f.bytes[2], f.bytes[6]); }),
                 "field 'theta_h': its numbers do not increase"));
  CHECK(contains(with(3, [](TensorField& f) { f.type = 10, f.bytes += f.bytes; }),
                 "field 'wvls' holds float32, expected uint16"));
  CHECK(contains(with(4, [](TensorField& f) { f.shape[3] = 1; }),
                 "field 'M' has 3 x 2 x 2 x 1 x 4 x 4 numbers, expected 3 x 2 x 2 x 2 x 4 x 4"));
  CHECK(contains(with(4, [](TensorField& f) { std::memcpy(f.bytes.data(), "\0\0\x80\x7f", 4); }),
                 "field 'M' has an infinite value"));
  const std::string bytes = tensor_bytes(polarized_fields(small));
  const TemporaryFolder folder;
  for (std::size_t length = 0; length < bytes.size(); length += 41) {
    write_bytes(folder / "a.pbsdf", bytes.substr(0, length));
    CHECK_THROWS_AS(read_polarized_brdf(folder / "a.pbsdf"), SceneError);
  }
}

TEST_CASE("measured_polarized: scenes name the file, the roughness for sampling and the wavelength") {
  const TemporaryFolder folder;
  write_bytes(folder / "a.pbsdf", tensor_bytes(polarized_fields(tabulate_polarized(3, 2, {450, 650}, waves))));
  const auto scene = [&](const std::string& more) {
    return read_scene(test::write_below(
        folder, "scene.xml",
        test::mitsuba_scene("<shape type='sphere'><bsdf type='measured_polarized'><string name='filename' "
                            "value='a.pbsdf'/>" +
                            more + "</bsdf></shape>")));
  };
  const Description d = scene("<float name='alpha_sample' value='0.2'/><float name='wavelength' value='500'/>");
  const auto& model = std::get<MeasuredDescription>(d.materials.back().model);
  CHECK((model.is_polarized && model.alpha_sample == 0.2f && model.wavelength == 500.0f));
  REQUIRE(d.notes.size() == 1);
  CHECK(contains(d.notes[0], "bsdf 'measured_polarized' rendered without polarization, which is not simulated"));
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    CompileOptions options;
    options.color = color;
    for (const char* const more : {"", "<float name='wavelength' value='500'/>"})
      CHECK(compile_scene(scene(more), options)->view().materials.closure_tables != nullptr);
  }
  CHECK(contains(test::error_of_text(test::mitsuba_scene("<bsdf type='measured_polarized'/>")),
                 "needs the string 'filename'"));
}

}  // namespace sheaf::test_bsdf_measured_polarized
