// Sampling and evaluation of the lobes, compiled once for Wide and Scalar.
#include "kernels/guiding/glow_lobes.h"

#include "core/math/frame.h"

namespace sheaf {

namespace {

template <class F> SHEAF_INLINE F eighth_root(F x) { return sqrt(sqrt(sqrt(x))); }
template <class F> SHEAF_INLINE F eighth_power(F x) { return sqr(sqr(sqr(x))); }

/// The lobe of a group of lights as seen from a point.
template <class L> struct GlowLobe {
  Vec3<L> direction;               ///< to the center of the group, unit length
  typename L::Float weight;        ///< power over distance, times the transmittance
  typename L::Float unattenuated;  ///< power over distance
  typename L::Float c0;            ///< see kernels/guiding/glow_lobes.h
  typename L::Float least, span;   ///< eighth root of c0, and that of 2 + c0 less that

  SHEAF_INLINE Vec3<L> sample(typename L::Float u, typename L::Float v) const {
    using F = Float<L>;
    const F root = fma(u, span, least);
    const F c = clamp(eighth_power(root) - c0, F(0.0f), F(2.0f));
    const F sine = safe_sqrt(c * (F(2.0f) - c));
    const auto azimuth = sincos_2pi<L>(v);
    return Frame<L>::from_normal(direction).to_world({sine * azimuth.cos, sine * azimuth.sin, F(1.0f) - c});
  }
  SHEAF_INLINE typename L::Float pdf(Vec3<L> w) const {
    using F = Float<L>;
    const F x = clamp(F(1.0f) - dot(direction, w), F(0.0f), F(2.0f)) + c0;
    return F(kInvPi / 16.0f) * eighth_root(x) / (span * x);
  }
};

template <class L> SHEAF_INLINE GlowLobe<L> lobe_of(const GlowSource& group, Vec3<L> p, Float<L> extinction) {
  using F = Float<L>;
  // Wide enough that rounding of the cosine does not matter.
  constexpr float kLeast = 2e-6f;
  const Vec3<L> d = broadcast<L>(group.center) - p;
  const F squared = max(dot(d, d), F(1e-30f)), inverse = F(1.0f) / sqrt(squared);
  const F size = min(F(group.radius) * inverse, F(1.0f));
  const F c0 = fma(F(0.5f) * size, size, F(kLeast));
  const F least = eighth_root(c0);
  const auto inside = squared <= F(1e-30f);
  const Vec3<L> direction = select<L>(inside, Vec3<L>{F(0.0f), F(0.0f), F(1.0f)}, d * inverse);
  const F distance = max(squared * inverse, F(group.radius));
  const F unattenuated = F(group.power) / distance;
  return {direction,    unattenuated * exp(max(extinction, F(0.0f)) * -distance),
          unattenuated, c0,
          least,        eighth_root(F(2.0f) + c0) - least};
}

template <class L> struct LobeSums {
  typename L::Float weight{}, unattenuated{};

  SHEAF_INLINE void add(const GlowLobe<L>& lobe) {
    weight = weight + lobe.weight;
    unattenuated = unattenuated + lobe.unattenuated;
  }
  SHEAF_INLINE typename L::Float bsdf_probability(typename L::Float extinction) const {
    using F = Float<L>;
    // Underflow of all weights leaves no lobe to sample.
    const F transmittance = select(weight > F(1e-30f), weight / max(unattenuated, F(1e-37f)), F(0.0f));
    return select(extinction >= F(0.0f), fma(F(-kGlowProbability), transmittance, F(1.0f)), F(1.0f));
  }
};

}  // namespace

template <class L>
GuideSample<L> sample_glow(const LightTreeView& tree, Vec3<L> p, Float<L> extinction, const Random4<L>& u) noexcept {
  using F = Float<L>;
  GlowLobe<L> lobes[kMaxGlowSources];
  LobeSums<L> sums;
  for (int k = 0; k < tree.glow_source_count; ++k) {
    lobes[k] = lobe_of<L>(tree.glow_sources[k], p, extinction);
    sums.add(lobes[k]);
  }
  // Choose between BSDF and lobes
  const F a = sums.bsdf_probability(extinction);
  GuideSample<L> out{};
  out.bsdf_u = min(u.x / a, F(kOneMinusEpsilon));
  out.taken = u.x >= a;
  if (!any(out.taken)) return out;
  // Choose a lobe and sample it
  const F target = (u.x - a) / max(F(1.0f) - a, F(1e-30f)) * sums.weight;
  F below(0.0f);
  GlowLobe<L> chosen = lobes[0];
  for (int k = 1; k < tree.glow_source_count; ++k) {
    below = below + lobes[k - 1].weight;
    const auto beyond = target >= below;
    chosen.direction = select<L>(beyond, lobes[k].direction, chosen.direction);
    chosen.c0 = select(beyond, lobes[k].c0, chosen.c0);
    chosen.least = select(beyond, lobes[k].least, chosen.least);
    chosen.span = select(beyond, lobes[k].span, chosen.span);
  }
  out.direction = chosen.sample(u.y, u.z);
  return out;
}

template <class L>
GuideValue<L> evaluate_glow(const LightTreeView& tree, Vec3<L> p, Float<L> extinction, Vec3<L> direction) noexcept {
  using F = Float<L>;
  if (!any(extinction >= F(0.0f))) return {F(1.0f), F(0.0f)};
  LobeSums<L> sums;
  F weighted(0.0f);
  for (int k = 0; k < tree.glow_source_count; ++k) {
    const GlowLobe<L> lobe = lobe_of<L>(tree.glow_sources[k], p, extinction);
    sums.add(lobe);
    weighted = fma(lobe.weight, lobe.pdf(direction), weighted);
  }
  return {sums.bsdf_probability(extinction), weighted / max(sums.weight, F(1e-37f))};
}

template GuideSample<Wide> sample_glow(const LightTreeView&, Vec3<Wide>, WideFloat, const Random4<Wide>&) noexcept;
template GuideSample<Scalar> sample_glow(const LightTreeView&, Vec3<Scalar>, float, const Random4<Scalar>&) noexcept;
template GuideValue<Wide> evaluate_glow(const LightTreeView&, Vec3<Wide>, WideFloat, Vec3<Wide>) noexcept;
template GuideValue<Scalar> evaluate_glow(const LightTreeView&, Vec3<Scalar>, float, Vec3<Scalar>) noexcept;

}  // namespace sheaf
