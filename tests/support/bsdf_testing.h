// Tests for every BSDF: chi-square of the samples, energy conservation, reciprocity, and SIMD lanes against scalar
// code.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "tests/support/chi_square.h"
#include "tests/support/records_testing.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf {

/// The scalar functions of a BSDF, so that tests of all BSDFs compile once. Refers to the BSDF.
class BsdfView {
 public:
  template <class Bsdf>
  BsdfView(const Bsdf& bsdf)  // NOLINT: a view of any BSDF
      : bsdf_(&bsdf),
        evaluate_(
            [](const void* self, Vec3f wo, Vec3f wi) { return static_cast<const Bsdf*>(self)->evaluate(wo, wi); }),
        sample_([](const void* self, Vec3f wo, const Random4<Scalar>& u) {
          return static_cast<const Bsdf*>(self)->sample(wo, u);
        }) {}

  BsdfValue<Scalar> evaluate(Vec3f wo, Vec3f wi) const { return evaluate_(bsdf_, wo, wi); }
  BsdfSample<Scalar> sample(Vec3f wo, const Random4<Scalar>& u) const { return sample_(bsdf_, wo, u); }

 private:
  const void* bsdf_;
  BsdfValue<Scalar> (*evaluate_)(const void*, Vec3f, Vec3f);
  BsdfSample<Scalar> (*sample_)(const void*, Vec3f, const Random4<Scalar>&);
};

/// Unit vector of an angle to the z axis and an azimuth in radians.
Vec3f direction_of(double cos_theta, double phi);

/// Outgoing directions from normal to grazing incidence, on both sides of the surface.
std::vector<Vec3f> outgoing_directions();

/// Whether any of 64 samples is valid.
bool scatters(const BsdfView& bsdf, Vec3f wo);

/// Chi-square test of a BSDF with a pdf, from every direction of outgoing_directions(). The pdf integrates to the
/// probability of a valid sample. `tests`: number of tests that share the significance level.
void check_bsdf_sampling(const BsdfView& bsdf, int tests);

/// Like check_bsdf_sampling(), for discontinuous pdfs: lobes that are clipped by the horizon, by their facets or at the
/// critical angle. Expected counts have a small lower bound, because quadrature nodes may miss the corner of a lobe.
/// Strips along the horizon are integrated separately. Invalid samples are counted unless quadrature errors exceed
/// their expected share. `depth`: maximum number of subdivisions of a cell.
void check_bsdf_sampling_with_edges(const BsdfView& bsdf, int tests, int depth = 6);

/// Chi-square test of a lobe that is too narrow for a grid over the sphere, for one outgoing direction. The domain is a
/// square of side 2 `half_width` in the plane that touches the sphere at `center`. The pdf may integrate to less than 1
/// there.
void check_bsdf_peak_sampling(const BsdfView& bsdf, Vec3f wo, Vec3f center, double half_width, int tests);

/// Compares the pdf and the weight of samples with evaluate(). `tolerance`: relative error; larger where the directions
/// determine the half vector badly.
void check_bsdf_weights(const BsdfView& bsdf, double tolerance = 1e-4);

/// Checks that evaluate(wo, wi) / |cos(wi)| is symmetric, after division by the squared index for transmission. `eta`:
/// index inside over index outside.
void check_bsdf_reciprocity(const BsdfView& bsdf, double eta = 1);

/// White furnace test: the mean sample weight is the albedo and must be at most 1 in every component. With `lossless`
/// it must equal 1 for every direction that scatters. eta_scale converts transmitted radiance back to power.
void check_white_furnace(const BsdfView& bsdf, bool lossless);

/// Directional albedo for `wo` in the brightest component.
double sampled_albedo(const BsdfView& bsdf, Vec3f wo);

/// Maximum albedo over outgoing_directions().
double largest_albedo(const BsdfView& bsdf);

/// Checks that values stay finite for grazing, equal, opposite and mirrored directions on the whole sphere.
void check_bsdf_finite(const BsdfView& bsdf);

/// Checks that registers of kWidth different materials match the scalar BSDFs. make(lane) -> Bsdf<Scalar>.
template <template <class> class Bsdf, class Make> void check_bsdf_lanes(Make&& make) {
  Bsdf<Wide> wide = wide_record<Bsdf>([&](int lane) { return make(lane); });
  if constexpr (kHasTables<Bsdf<Wide>>) wide.tables = make(0).tables;
  double worst = 0;
  int valid = 0;
  for (std::uint32_t i = 0; i < 200 * kWidth; i += kWidth) {
    const auto wo =
        wide_record<Vec3>([&](int lane) { return random_direction(16, i + static_cast<std::uint32_t>(lane)); });
    const auto wi =
        wide_record<Vec3>([&](int lane) { return random_direction(17, i + static_cast<std::uint32_t>(lane)); });
    const auto s = wide.sample(wo, wide_random(18, i));
    const auto f = wide.evaluate(wo, wi);
    for (int lane = 0; lane < kWidth; ++lane) {
      const Bsdf<Scalar> bsdf = make(lane);
      const BsdfView one(bsdf);
      const Vec3f o = lane_record(wo, lane), v = lane_record(wi, lane);
      worst = std::max(worst, record_difference<Spectrum>(lane_record(f.f_cos, lane), one.evaluate(o, v).f_cos));
      worst = std::max(worst, difference(f.pdf_solid_angle[lane], one.evaluate(o, v).pdf_solid_angle));
      const auto expected = one.sample(o, lane_random(18, i, lane));
      CHECK(lane_of(s.valid, lane) == expected.valid);
      if (!expected.valid) continue;
      ++valid;
      worst = std::max({worst, record_difference<Vec3>(lane_record(s.wi, lane), expected.wi),
                        record_difference<Spectrum>(lane_record(s.weight, lane), expected.weight),
                        difference(s.pdf_solid_angle[lane], expected.pdf_solid_angle),
                        difference(s.eta_scale[lane], expected.eta_scale)});
    }
  }
  CHECK(valid > 10 * kWidth);
  CHECK(worst < 1e-4);
}

}  // namespace sheaf
