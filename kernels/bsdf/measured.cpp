// MeasuredBsdf and MeasuredSpectralBsdf, compiled once, for tables of both parameterizations.
#include "kernels/bsdf/measured.h"

#include "kernels/bsdf/half_angle_table.h"

namespace sheaf {

namespace {

template <class L, class Bsdf> BsdfValue<L> evaluate_table(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  const Mask<L> by_half_angle = half_angle_detail::has_table<L>(bsdf.tables, bsdf.table);
  if (all(by_half_angle)) return half_angle_detail::evaluate(bsdf, wo, wi);
  const BsdfValue<L> value = measured_detail::evaluate(bsdf, wo, wi);
  if (!any(by_half_angle)) return value;
  const BsdfValue<L> other = half_angle_detail::evaluate(bsdf, wo, wi);
  return {select<L>(by_half_angle, other.f_cos, value.f_cos),
          select(by_half_angle, other.pdf_solid_angle, value.pdf_solid_angle)};
}

template <class L, class Bsdf> BsdfSample<L> sample_table(const Bsdf& bsdf, Vec3<L> wo, const Random4<L>& u) {
  const Mask<L> by_half_angle = half_angle_detail::has_table<L>(bsdf.tables, bsdf.table);
  if (all(by_half_angle)) return half_angle_detail::sample(bsdf, wo, u);
  const BsdfSample<L> sample = measured_detail::sample(bsdf, wo, u);
  if (!any(by_half_angle)) return sample;
  const BsdfSample<L> other = half_angle_detail::sample(bsdf, wo, u);
  const Mask<L> valid = (by_half_angle & other.valid) | ((!by_half_angle) & sample.valid);
  return {select<L>(by_half_angle, other.wi, sample.wi), select<L>(by_half_angle, other.weight, sample.weight),
          select(by_half_angle, other.pdf_solid_angle, sample.pdf_solid_angle), sample.eta_scale, valid};
}

}  // namespace

template <class L> BsdfValue<L> MeasuredBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  return evaluate_table(*this, wo, wi);
}

template <class L> BsdfSample<L> MeasuredBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  return sample_table(*this, wo, u);
}

template <class L> BsdfValue<L> MeasuredSpectralBsdf<L>::evaluate(Vec3<L> wo, Vec3<L> wi) const {
  return evaluate_table(*this, wo, wi);
}

template <class L> BsdfSample<L> MeasuredSpectralBsdf<L>::sample(Vec3<L> wo, const Random4<L>& u) const {
  return sample_table(*this, wo, u);
}

template struct MeasuredBsdf<Wide>;
template struct MeasuredBsdf<Scalar>;
template struct MeasuredSpectralBsdf<Wide>;
template struct MeasuredSpectralBsdf<Scalar>;

}  // namespace sheaf
