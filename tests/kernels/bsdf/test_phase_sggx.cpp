// SGGX microflakes: projected area against the distribution of normals, samples against pdfs, and reciprocity.
#include "kernels/bsdf/list.h"
#include "scene/tables/medium_lookup.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

#include <array>
#include <utility>

namespace sheaf::test_phase_sggx {

namespace {

using Matrix = std::array<float, 6>;  ///< xx, yy, zz, xy, xz, yz

/// A matrix with the given projected areas along three orthogonal, oblique axes.
Matrix oblique(double along_x, double along_y, double along_z) {
  const Frame<Scalar> axes = Frame<Scalar>::from_normal(normalize(Vec3f{0.3f, -0.5f, 0.7f}));
  Matrix m{};
  for (const auto& [axis, area] :
       {std::pair{axes.s, along_x}, std::pair{axes.t, along_y}, std::pair{axes.n, along_z}}) {
    const double w[3] = {axis.x, axis.y, axis.z};
    const int rows[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (std::size_t k = 0; k < 6; ++k) m[k] += static_cast<float>(area * area * w[rows[k][0]] * w[rows[k][1]]);
  }
  return m;
}

const Matrix kShapes[] = {{1, 1, 1, 0, 0, 0}, oblique(1, 1, 0.1), oblique(0.2, 0.2, 1), oblique(0.3, 0.6, 0.9)};
constexpr int kTests = 2 * static_cast<int>(std::size(kShapes)) * 3;

SggxBsdf<Scalar> flakes(const Matrix& m, const Frame<Scalar>& frame) {
  float words[6];
  std::copy(m.begin(), m.end(), words);
  SggxBsdf<Scalar> out;
  static_cast<SggxParameters<Scalar>&>(out) = sggx_parameters<Scalar>(words, frame);
  return out;
}

double projected_area(const Matrix& m, Vec3f w) {
  FlakeMatrix s;
  std::copy(m.begin(), m.end(), s.entries);
  return s.projected_area(w);
}

/// The distribution of normals by equation 11 ff. of the paper, with determinant and cofactors.
double distribution(const Matrix& m, Vec3f h) {
  const double xx = m[0], yy = m[1], zz = m[2], xy = m[3], xz = m[4], yz = m[5], x = h.x, y = h.y, z = h.z;
  const double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  const double square = x * x * (yy * zz - yz * yz) + y * y * (xx * zz - xz * xz) + z * z * (xx * yy - xy * xy) +
                        2 * (x * y * (xz * yz - xy * zz) + x * z * (xy * yz - xz * yy) + y * z * (xy * xz - yz * xx));
  return std::pow(determinant, 1.5) / (3.141592653589793 * square * square);
}

const Vec3f kViews[] = {{0, 0, 1}, normalize(Vec3f{0.8f, -0.1f, -0.5f}), normalize(Vec3f{-0.3f, 0.5f, -0.7f})};

}  // namespace

TEST_CASE("sggx: the projected area matches its closed form and the integral over normals") {
  CHECK(projected_area({4, 9, 16, 0, 0, 0}, {0, 1, 0}) == near(3));
  CHECK(projected_area({1, 1, 0.25f, 0, 0, 0.5f}, {0, 0.6f, 0.8f}) == near(std::sqrt(0.36 + 0.16 + 0.48)));
  for (const Matrix& m : kShapes)
    for (const Vec3f w : kViews) {
      const auto facing = [&](double azimuth, double z) {
        const Vec3f h = direction_of(z, azimuth);
        return distribution(m, h) * std::max(double(dot(h, w)), 0.0);
      };
      const double sum = detail::integrate(facing, 0, 6.283185307179586, -1, 1, 9, 1e-6);
      CHECK(projected_area(m, w) == near(sum, 2e-4));
    }
}

TEST_CASE("sggx: values follow the matrix in world space and are reciprocal weighted by projected area") {
  for (const Matrix& m : kShapes)
    for (std::uint32_t i = 0; i < 200; ++i) {
      const Vec3f wo = random_direction(31, i), wi = random_direction(32, i);
      const Frame<Scalar> there = Frame<Scalar>::from_normal(wo), back = Frame<Scalar>::from_normal(wi);
      const double value = flakes(m, there).evaluate({0, 0, 1}, there.to_local(wi)).pdf_solid_angle;
      const double other = flakes(m, back).evaluate({0, 0, 1}, back.to_local(wo)).pdf_solid_angle;
      const double expected = distribution(m, normalize(wo + wi)) / (4 * projected_area(m, wo));
      CHECK(value == near(expected, 2e-3));
      CHECK(projected_area(m, wo) * value == near(projected_area(m, wi) * other, 2e-3));
    }
}

TEST_CASE("sggx: samples follow their pdf and the pdf integrates to one from every direction") {
  for (const Matrix& m : kShapes)
    for (const Vec3f wo : kViews) {
      const SggxBsdf<Scalar> phase = flakes(m, Frame<Scalar>::from_normal(wo));
      const auto sample = [&](Random4<Scalar> u) -> std::optional<Vec3f> {
        const auto s = phase.sample({0, 0, 1}, u);
        return s.valid ? std::optional<Vec3f>(s.wi) : std::nullopt;
      };
      const auto pdf = [&](Vec3f wi) { return double(phase.evaluate({0, 0, 1}, wi).pdf_solid_angle); };
      const ChiSquare result = chi_square_sphere(sample, pdf, -1, 1, 50000);
      CHECK(result.integral == near(1, 1e-3));
      CHECK(result.p_value > significance_of_each(kTests));
      for (std::uint32_t i = 0; i < 500; ++i) {
        const auto s = phase.sample({0, 0, 1}, lane_random(12, i, 0));
        CHECK(length(s.wi) == near(1, 1e-6));
        CHECK(s.weight.c0 == 1.0f);
        CHECK(s.pdf_solid_angle == near(pdf(s.wi), 2e-3));
      }
    }
}

TEST_CASE("sggx: the identity scatters isotropically and degenerate matrices stay finite") {
  for (const Vec3f wi : {Vec3f{0, 0, 1}, Vec3f{0, 0, -1}, Vec3f{0.6f, 0, -0.8f}})
    CHECK(flakes({5, 5, 5, 0, 0, 0}, Frame<Scalar>::from_normal({0, 0, 1})).evaluate({0, 0, 1}, wi).pdf_solid_angle ==
          near(0.0795774715));
  for (const Matrix& m : {Matrix{0, 0, 1, 0, 0, 0}, Matrix{1, 1, 0, 0, 0, 0}, Matrix{}, oblique(0, 0, 1e-9)})
    for (const Vec3f w : kViews) {
      const SggxBsdf<Scalar> phase = flakes(m, Frame<Scalar>::from_normal(w));
      check_bsdf_finite(phase);
      CHECK(phase.sample({0, 0, 1}, lane_random(3, 4, 0)).valid);
    }
}

TEST_CASE("sggx: SIMD results equal scalar ones") {
  check_bsdf_lanes<SggxBsdf>([](int lane) {
    return flakes(kShapes[static_cast<std::size_t>(lane) % std::size(kShapes)],
                  Frame<Scalar>::from_normal(random_direction(5, static_cast<std::uint32_t>(lane))));
  });
}

}  // namespace sheaf::test_phase_sggx
