// A tabulated phase function: a piecewise linear density of the cosine of the deflection angle, uniform in azimuth. Its
// integral is quadratic between two values and is inverted exactly.
#pragma once

#include "core/sampling/warp.h"
#include "core/soa/find_interval.h"
#include "kernels/phase/phase_function.h"
#include "scene/materials/phase_functions.h"
#include "scene/tables/closure_tables.h"

namespace sheaf {

template <class L> struct TabulatedPhaseBsdf : TabulatedPhaseParameters<L> {
  using F = typename L::Float;
  using U = typename L::Uint;
  using Closure = TabulatedPhaseClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;
  const float* tables = nullptr;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L> wi) const {
    const FoundTable<L> found = find_table<L>(tables, this->table, TableTag::kPhase);
    if (!any(found.valid)) return {Spectrum<L>(F(0.0f)), F(0.0f)};
    const U last = count(found) - U(1u);
    const F at = clamp(fma(F(-0.5f), wi.z, F(0.5f)), F(0.0f), F(1.0f)) * to_float(last);
    const U i = min(to_uint(at), last - U(1u));
    const U values = found.first + U(kValues);
    const F pdf =
        F(0.5f * kInvPi) * lerp(at - to_float(i), gather(tables, values + i), gather(tables, values + i + U(1u)));
    return {Spectrum<L>(pdf), pdf};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L>, const Random4<L>& u) const {
    BsdfSample<L> s{{F(0.0f), F(0.0f), F(-1.0f)}, Spectrum<L>(F(1.0f)), F(0.0f), F(1.0f), Mask<L>(false)};
    const FoundTable<L> found = find_table<L>(tables, this->table, TableTag::kPhase);
    if (!any(found.valid)) return s;
    const U n = count(found), values = found.first + U(kValues), integrals = values + n;
    const U i = find_interval<L>(n, [&](U k) SHEAF_LAMBDA_INLINE { return gather(tables, integrals + k) <= u.y; });
    const F a = gather(tables, values + i), b = gather(tables, values + i + U(1u));
    const F step = F(2.0f) / to_float(n - U(1u));
    const F twice = F(2.0f) * max(u.y - gather(tables, integrals + i), F(0.0f)) / step;
    const F t = clamp(twice / max(a + sqrt(max(fma(a, a, twice * (b - a)), F(0.0f))), F(1e-30f)), F(0.0f), F(1.0f));
    // 1 - cosine and 1 + cosine, each computed without cancellation: near the poles the sine needs all digits.
    const F from_back = (to_float(i) + t) * step, from_front = (to_float(n - U(1u) - i) - t) * step;
    const F sine = sqrt(max(from_back * from_front, F(0.0f)));
    const auto azimuth = sincos_2pi<L>(u.z);
    s.wi = {sine * azimuth.cos, sine * azimuth.sin, F(1.0f) - from_back};
    s.pdf_solid_angle = F(0.5f * kInvPi) * lerp(t, a, b);
    s.valid = s.pdf_solid_angle > F(0.0f);
    return s;
  }

 private:
  static constexpr std::uint32_t kValues = 1 + kLeafCount<PhaseHead>;  ///< after the tag and the head

  SHEAF_INLINE U count(const FoundTable<L>& found) const {
    return to_uint(load_table_record<L, PhaseHead>(tables, found.first + U(1u)).count);
  }
};

template <> struct BsdfOf<TabulatedPhaseClosure> : BsdfTag<TabulatedPhaseBsdf> {};

}  // namespace sheaf
