// MeasuredBsdf and MeasuredSpectralBsdf, compiled once.
#include "kernels/bsdf/measured.h"

namespace sheaf {

template <class L> BsdfValue<L> MeasuredBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  return measured_detail::evaluate(*this, wo, wi);
}

template <class L> BsdfSample<L> MeasuredBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  return measured_detail::sample(*this, wo, u);
}

template <class L> BsdfValue<L> MeasuredSpectralBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  return measured_detail::evaluate(*this, wo, wi);
}

template <class L> BsdfSample<L> MeasuredSpectralBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  return measured_detail::sample(*this, wo, u);
}

template struct MeasuredBsdf<Wide>;
template struct MeasuredBsdf<Scalar>;
template struct MeasuredSpectralBsdf<Wide>;
template struct MeasuredSpectralBsdf<Scalar>;

}  // namespace sheaf
