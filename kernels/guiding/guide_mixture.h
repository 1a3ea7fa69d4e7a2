// A mixture of von Mises-Fisher lobes (density proportional to exp(kappa cos), Fisher 1953) that models the incident
// light in a guide cell, with the fraction of directions that the BSDF samples. The lobes are spread over the lanes of
// a register, so the pdf of one path takes one or two evaluations of exp().
//
// Path guiding with such mixtures: Herholz et al., "Product Importance Sampling for Light Transport Path Guiding",
// 2016; Ruppert, Herholz and Lensch, "Robust Fitting of Parallax-Aware Mixtures for Path Guiding", 2020.
#pragma once

#include "core/math/frame.h"
#include "core/sampling/warp.h"
#include "core/simd/simd_rows.h"

#include <bit>
#include <cmath>

namespace sheaf {

/// Number of lobes: a whole number of registers.
inline constexpr int kGuideLobes = 16;
static_assert(kGuideLobes % kWidth == 0);

/// A mixture as kernels read it.
struct alignas(64) GuideMixture {
  float x[kGuideLobes] = {}, y[kGuideLobes] = {}, z[kGuideLobes] = {};  ///< mean direction of each lobe, unit length
  float kappa[kGuideLobes] = {};                                        ///< concentration, in [kMinKappa, kMaxKappa]
  float peak[kGuideLobes] = {};   ///< pdf in the mean direction, 1/sr, times the lobe's weight
  float below[kGuideLobes] = {};  ///< cumulative weights, including this lobe
  float bsdf_probability =
      1;  ///< probability by which directions are sampled from the BSDF and not from the lobes; above 0
};

inline constexpr float kMinKappa = 0.01f, kMaxKappa = 5000;

/// Pdf of a lobe in its mean direction, per steradian.
inline float lobe_peak(float kappa) { return kappa * (0.5f * kInvPi) / -std::expm1(-2 * kappa); }

/// Contribution of each lobe to the pdf in a direction, per steradian.
SHEAF_INLINE void lobe_parts(const GuideMixture& m, Vec3f d, float (&parts)[kGuideLobes]) {
  for (int k = 0; k < kGuideLobes; k += kWidth) {
    WideFloat x, y, z, kappa, peak;
    load(m.x + k, x), load(m.y + k, y), load(m.z + k, z), load(m.kappa + k, kappa), load(m.peak + k, peak);
    const WideFloat cosine = fma(x, WideFloat(d.x), fma(y, WideFloat(d.y), z * WideFloat(d.z)));
    store(parts + k, peak * exp(kappa * min(cosine - WideFloat(1.0f), WideFloat(0.0f))));
  }
}

/// Sums of rows of such contributions, one row per lane.
template <class L> SHEAF_INLINE Float<L> sum_parts(const float (*parts)[kGuideLobes]) {
  const float* rows[L::width];
  for (int lane = 0; lane < L::width; ++lane) rows[lane] = parts[lane];
  Float<L> sum[4] = {}, more[4];
  for (int k = 0; k < kGuideLobes; k += 4) {
    load_rows4(rows, more);
    for (int i = 0; i < 4; ++i) sum[i] += more[i];
    for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// Chooses lobes by their weights, with `u` in [0, 1). `below`: cumulative weights, of each lane from `first` on.
template <class L> SHEAF_INLINE Uint<L> choose_lobe(const float* below, Uint<L> first, Float<L> u) {
  using U = Uint<L>;
  static_assert(std::has_single_bit(static_cast<unsigned>(kGuideLobes)));
  U lobe(0u);
  for (std::uint32_t step = kGuideLobes / 2; step > 0; step /= 2) {
    const U middle = lobe + U(step);
    lobe = select(gather(below, first + middle - U(1u)) <= u, middle, lobe);
  }
  return lobe;
}

/// Samples a direction around `middle` with pdf proportional to exp(kappa cos), by u, v in [0, 1) (Jakob, "Numerically
/// stable sampling of the von Mises-Fisher distribution on S2 (and other tricks)", 2012).
template <class L> SHEAF_INLINE Vec3<L> sample_lobe(Vec3<L> middle, Float<L> kappa, Float<L> u, Float<L> v) {
  using F = Float<L>;
  const F ratio = log(u + (F(1.0f) - u) * exp(F(-2.0f) * kappa)) / kappa;
  const F m = clamp(-ratio, F(0.0f), F(2.0f));  // 1 - cosine
  const F sine = safe_sqrt(m * (F(2.0f) - m));
  const auto azimuth = sincos_2pi<L>(v);
  return Frame<L>::from_normal(middle).to_world({sine * azimuth.cos, sine * azimuth.sin, F(1.0f) - m});
}

}  // namespace sheaf
