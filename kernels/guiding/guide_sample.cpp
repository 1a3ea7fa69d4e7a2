// Sampling and evaluation of the guide, compiled once for Wide and Scalar.
#include "kernels/guiding/guide_sample.h"

namespace sheaf {

template <class L>
GuideSample<L> sample_guide(const GuideView& guide, Uint<L> rows, int count, const Random4<L>& u) noexcept {
  using F = Float<L>;
  alignas(kSimdAlignment) std::uint32_t row[L::width];
  alignas(kSimdAlignment) float number[L::width], rest[L::width], kappa[L::width], x[L::width], y[L::width],
      z[L::width];
  store(row, rows);
  store(number, u.x);
  alignas(kSimdAlignment) std::uint32_t taken[L::width] = {};
  for (int lane = 0; lane < L::width; ++lane) {
    const GuideMixture& m = guide.mixtures[lane < count ? row[lane] : 0];
    const float a = m.bsdf_share;
    // The BSDF uses the lower part of u, rescaled, so that its lobes are as well stratified as without guiding.
    rest[lane] = min(number[lane] / a, 0x1.fffffep-1f);
    kappa[lane] = 1, x[lane] = 0, y[lane] = 0, z[lane] = 1;
    if (number[lane] < a) continue;
    taken[lane] = 1;
    float v = clamp((number[lane] - a) / (1 - a), 0.0f, 0x1.fffffep-1f);
    const int k = choose_lobe(m, v);
    kappa[lane] = m.kappa[k], x[lane] = m.x[k], y[lane] = m.y[k], z[lane] = m.z[k];
  }
  // Sample the lobes.
  GuideSample<L> out{};
  load(rest, out.bsdf_u);
  Uint<L> words;
  load(taken, words);
  out.taken = words != Uint<L>(0u);
  if (!any(out.taken)) return out;
  Vec3<L> middle;
  F concentration;
  load(x, middle.x), load(y, middle.y), load(z, middle.z), load(kappa, concentration);
  out.direction = sample_lobe<L>(middle, concentration, u.y, u.z);
  return out;
}

template <class L>
GuideValue<L> evaluate_guide(const GuideView& guide, Uint<L> rows, std::uint32_t lanes, Vec3<L> direction) noexcept {
  if (lanes == 0) return {Float<L>(1.0f), Float<L>(0.0f)};
  alignas(kSimdAlignment) std::uint32_t row[L::width];
  alignas(kSimdAlignment) float x[L::width], y[L::width], z[L::width], share[L::width];
  alignas(kSimdAlignment) float parts[L::width][kGuideLobes];
  store(row, rows);
  store(x, direction.x), store(y, direction.y), store(z, direction.z);
  for (int lane = 0; lane < L::width; ++lane) {
    if ((lanes >> lane & 1u) == 0) {
      share[lane] = 1;
      std::fill_n(parts[lane], kGuideLobes, 0.0f);
      continue;
    }
    const GuideMixture& m = guide.mixtures[row[lane]];
    share[lane] = m.bsdf_share;
    lobe_parts(m, {x[lane], y[lane], z[lane]}, parts[lane]);
  }
  GuideValue<L> out;
  load(share, out.bsdf_share);
  out.pdf_solid_angle = sum_parts<L>(parts);
  return out;
}

template GuideSample<Wide> sample_guide(const GuideView&, Uint<Wide>, int, const Random4<Wide>&) noexcept;
template GuideSample<Scalar> sample_guide(const GuideView&, Uint<Scalar>, int, const Random4<Scalar>&) noexcept;
template GuideValue<Wide> evaluate_guide(const GuideView&, Uint<Wide>, std::uint32_t, Vec3<Wide>) noexcept;
template GuideValue<Scalar> evaluate_guide(const GuideView&, Uint<Scalar>, std::uint32_t, Vec3<Scalar>) noexcept;

}  // namespace sheaf
