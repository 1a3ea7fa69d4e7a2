// Sampling and evaluation of the guide, compiled once for Wide and Scalar.
#include "kernels/guiding/guide_sample.h"

#include "core/lane_array.h"

namespace sheaf {

template <class L>
GuideSample<L> sample_guide(const GuideView& guide, Uint<L> rows, int count, const Random4<L>& u) noexcept {
  const LaneArray<Uint<L>> row(rows);
  const LaneArray<Float<L>> number(u.x);
  LaneArray<Float<L>> rest, kappa;
  LaneArray<Uint<L>> taken(Uint<L>(0u));
  LaneRows<L, Vec3> mean;
  // Choose between BSDF and guide, and a lobe
  for (int lane = 0; lane < L::width; ++lane) {
    const GuideMixture& m = guide.mixtures[lane < count ? row[lane] : 0];
    const float a = m.bsdf_share;
    // The BSDF uses the lower part of u, rescaled, so that its lobes are as well stratified as without guiding.
    rest[lane] = min(number[lane] / a, kOneMinusEpsilon);
    kappa[lane] = 1;
    mean.set(lane, {0, 0, 1});
    if (number[lane] < a) continue;
    taken[lane] = 1;
    float v = clamp((number[lane] - a) / (1 - a), 0.0f, kOneMinusEpsilon);
    const int k = choose_lobe(m, v);
    kappa[lane] = m.kappa[k];
    mean.set(lane, {m.x[k], m.y[k], m.z[k]});
  }
  // Sample the lobes
  GuideSample<L> out{};
  out.bsdf_u = rest.load();
  out.taken = taken.load() != Uint<L>(0u);
  if (!any(out.taken)) return out;
  out.direction = sample_lobe<L>(mean.load(), kappa.load(), u.y, u.z);
  return out;
}

template <class L>
GuideValue<L> evaluate_guide(const GuideView& guide, Uint<L> rows, std::uint32_t lanes, Vec3<L> direction) noexcept {
  if (lanes == 0) return {Float<L>(1.0f), Float<L>(0.0f)};
  const LaneArray<Uint<L>> row(rows);
  const LaneRows<L, Vec3> directions(direction);
  LaneArray<Float<L>> share;
  alignas(kSimdAlignment) float parts[L::width][kGuideLobes];
  for (int lane = 0; lane < L::width; ++lane) {
    if ((lanes >> lane & 1u) == 0) {
      share[lane] = 1;
      std::fill_n(parts[lane], kGuideLobes, 0.0f);
      continue;
    }
    const GuideMixture& m = guide.mixtures[row[lane]];
    share[lane] = m.bsdf_share;
    lobe_parts(m, directions[lane], parts[lane]);
  }
  GuideValue<L> out;
  out.bsdf_share = share.load();
  out.pdf_solid_angle = sum_parts<L>(parts);
  return out;
}

template GuideSample<Wide> sample_guide(const GuideView&, Uint<Wide>, int, const Random4<Wide>&) noexcept;
template GuideSample<Scalar> sample_guide(const GuideView&, Uint<Scalar>, int, const Random4<Scalar>&) noexcept;
template GuideValue<Wide> evaluate_guide(const GuideView&, Uint<Wide>, std::uint32_t, Vec3<Wide>) noexcept;
template GuideValue<Scalar> evaluate_guide(const GuideView&, Uint<Scalar>, std::uint32_t, Vec3<Scalar>) noexcept;

}  // namespace sheaf
