// HairBsdf, compiled once.
#include "kernels/bsdf/hair.h"

namespace sheaf {

template <class L> BsdfValue<L> HairBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  return evaluate(Lobes(*this, wo), wi);
}

// A photon that passes through the fiber is treated as if it were at the opposite point of the fiber, so that h is that
// of the camera's direction. Photons land on the lit points of the fiber, camera paths on the visible ones. Moving the
// lit points that are not visible to the opposite side covers every visible point exactly once. On an isolated fiber,
// photons therefore transport the same light as camera paths. Shadows of other fibers may differ between the two
// points.
template <class L> Spectrum<L> HairBsdf<L>::adjoint_f_cos(Vec3<L> wo, Vec3<L> wi) const {
  const Mask<L> passes = (wo.z > F(0.0f)) & (wi.z < F(0.0f));
  const auto side = [&](Vec3<L> w) SHEAF_LAMBDA_INLINE {
    return Vec3<L>{select(passes, -w.x, w.x), w.y, select(passes, -w.z, w.z)};
  };
  return evaluate(side(wi), side(wo)).f_cos * (abs(wi.z) / max(abs(wo.z), F(1e-6f)));
}

template <class L> BsdfSample<L> HairBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  const Lobes lobes(*this, wo);
  // Select the lobe by u.x, and rescale the rest of u.x.
  F begin(0.0f), lobe_probability = lobes.probability[0], variance = lobes.variance[0], middle = lobes.middle[0];
  Angles around = lobes.around[0];
  Mask<L> is_last(false);
  F end = lobe_probability;
  for (std::size_t p = 1; p < kLobes; ++p) {
    const Mask<L> further = (u.x >= end) & (lobes.probability[p] > F(0.0f));
    begin = select(further, end, begin);
    lobe_probability = select(further, lobes.probability[p], lobe_probability);
    variance = select(further, lobes.variance[p], variance);
    around.sin_theta = select(further, lobes.around[p].sin_theta, around.sin_theta);
    around.cos_theta = select(further, lobes.around[p].cos_theta, around.cos_theta);
    if (p < kLobes - 1) middle = select(further, lobes.middle[p], middle);
    if (p == kLobes - 1) is_last = further;
    end += lobes.probability[p];
  }
  const F rest = clamp((u.x - begin) / max(lobe_probability, F(1e-30f)), F(0.0f), F(kOneMinusEpsilon));

  // Sample M_p and N_p (d'Eon, Marschner and Hanika, "Importance Sampling for Physically-Based Hair Fiber Models",
  // SIGGRAPH Asia 2013).
  const F one(1.0f);
  const F drawn = fma(u.y, one - exp(F(-2.0f) / variance), exp(F(-2.0f) / variance));
  const F one_minus_cos = clamp(-variance * log(max(drawn, F(1e-37f))), F(0.0f), F(2.0f));
  const F sine = sqrt(one_minus_cos * (F(2.0f) - one_minus_cos));
  const F sin_theta =
      clamp(fma(sine * sincos_2pi<L>(u.z).cos, around.cos_theta, (one_minus_cos - one) * around.sin_theta), -one, one);
  const F cos_theta = safe_sqrt(one - sin_theta * sin_theta);
  const F gamma = select(is_last, rest * F(2.0f * kPi), middle + lobes.azimuth.sample(rest));
  const F revolution = gamma * F(0.5f * kInvPi);
  const auto direction = sincos_2pi<L>(revolution - floor(revolution));

  BsdfSample<L> s;
  // Evaluate all lobes.
  s.wi = {-(cos_theta * direction.sin), sin_theta, cos_theta * direction.cos};
  const BsdfValue<L> value = evaluate(lobes, s.wi);
  s.pdf_solid_angle = value.pdf_solid_angle;
  s.valid = value.pdf_solid_angle > F(0.0f);
  s.weight = value.f_cos * (one / select(s.valid, value.pdf_solid_angle, one));
  s.eta_scale = one;
  return s;
}

template struct HairBsdf<Wide>;
template struct HairBsdf<Scalar>;

}  // namespace sheaf
