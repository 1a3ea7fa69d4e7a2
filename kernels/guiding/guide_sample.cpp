// Sampling and evaluation of the guide, compiled once for Wide and Scalar.
#include "kernels/guiding/guide_sample.h"

#include "core/soa/lane_array.h"

#include <algorithm>

namespace sheaf {

template <class L>
GuideSample<L> sample_guide(const GuideView& guide, Uint<L> rows, int count, const Random4<L>& u) noexcept {
  using F = Float<L>;
  using U = Uint<L>;
  constexpr auto kWords = static_cast<std::uint32_t>(sizeof(GuideMixture) / sizeof(float));
  const U first = select(L::first(count), rows, U(0u)) * U(kWords);
  // Choose between BSDF and guide
  const F a = gather(&guide.mixtures->bsdf_probability, first);
  GuideSample<L> out{};
  // The BSDF uses the lower part of u, rescaled, so that its lobes are as well stratified as without guiding.
  out.bsdf_u = min(u.x / a, F(kOneMinusEpsilon));
  out.taken = u.x >= a;
  if (!any(out.taken)) return out;
  // Choose a lobe by binary search, and sample it
  const U lobe = first + choose_lobe<L>(guide.mixtures->below, first, (u.x - a) / (F(1.0f) - a));
  const GuideMixture& m = *guide.mixtures;
  const Vec3<L> mean{gather(m.x, lobe), gather(m.y, lobe), gather(m.z, lobe)};
  out.direction = sample_lobe<L>(mean, gather(m.kappa, lobe), u.y, u.z);
  return out;
}

template <class L>
GuideValue<L> evaluate_guide(const GuideView& guide, Uint<L> rows, std::uint32_t lanes, Vec3<L> direction) noexcept {
  if (lanes == 0) return {Float<L>(1.0f), Float<L>(0.0f)};
  const LaneArray<Uint<L>> row(rows);
  const LaneRows<L, Vec3> directions(direction);
  LaneArray<Float<L>> probability;
  alignas(kSimdAlignment) float parts[L::width][kGuideLobes];
  for (int lane = 0; lane < L::width; ++lane) {
    if ((lanes >> lane & 1u) == 0) {
      probability[lane] = 1;
      std::fill_n(parts[lane], kGuideLobes, 0.0f);
      continue;
    }
    const GuideMixture& m = guide.mixtures[row[lane]];
    probability[lane] = m.bsdf_probability;
    lobe_parts(m, directions[lane], parts[lane]);
  }
  GuideValue<L> out;
  out.bsdf_probability = probability.load();
  out.pdf_solid_angle = sum_parts<L>(parts);
  return out;
}

template GuideSample<Wide> sample_guide(const GuideView&, Uint<Wide>, int, const Random4<Wide>&) noexcept;
template GuideSample<Scalar> sample_guide(const GuideView&, Uint<Scalar>, int, const Random4<Scalar>&) noexcept;
template GuideValue<Wide> evaluate_guide(const GuideView&, Uint<Wide>, std::uint32_t, Vec3<Wide>) noexcept;
template GuideValue<Scalar> evaluate_guide(const GuideView&, Uint<Scalar>, std::uint32_t, Vec3<Scalar>) noexcept;

}  // namespace sheaf
