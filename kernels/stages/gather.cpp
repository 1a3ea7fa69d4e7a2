// Stage: gather. Photons around a vertex become the radiance that it sends along the path (Jensen, "Global Illumination
// using Photon Maps", 1996, equation 8): L = sum of f Phi_i k(d_i), the kernel k over the disc of the radius.
//
// Vertices are taken one by one, and photons a register at a time. Which map a vertex asks is for PhotonMaps to say.
#include "core/octahedral.h"
#include "kernels/bsdf/all.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/stages.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Photons count where their surface is turned from the vertex's by less than the angle of this cosine.
constexpr float kSameSide = 0.5f;

/// One vertex, the same in all lanes.
template <class L, template <class> class Bsdf> struct GatheringVertex {
  VertexItem<L> item;
  Bsdf<L> bsdf;
  ShadingFrame<L, Bsdf<L>::kIsAnisotropic> frame;
  bool mapped;
  Vec3<L> ns_unmapped;
  typename L::Float terminator;
  typename L::Uint edges_left;  ///< most segments that a photon's path may have

  static GatheringVertex load(const StageContext& context, const Wave& wave, Slot slot, int column, bool mapped) {
    using F = Float<L>;
    const auto one = wave.vertices.load<Scalar>(column);
    const VertexItem<L> item{broadcast<L>(one.p),  broadcast<L>(one.ng), broadcast<L>(one.ns),
                             broadcast<L>(one.wo), F(one.offset),        {F(one.tangent.x), F(one.tangent.y)}};
    float* const* words = wave.closures.columns().words;
    const auto bsdf = bsdf_of_words<Bsdf<L>>([words, column](int k, Float<L>& word)
                                                 SHEAF_LAMBDA_INLINE { word = F(words[k][column]); });
    const std::uint32_t depth = wave.throughput.get(slot).depth() + 1;
    const auto most = static_cast<std::uint32_t>(context.transport.max_depth);  // -1: larger than any depth
    GatheringVertex out{item,    bsdf,    ShadingFrame<L, Bsdf<L>::kIsAnisotropic>(item), mapped,
                        item.ns, F(0.0f), Uint<L>(most > depth ? most - depth : 0u)};
    if (mapped) {
      const auto t = wave.textured.load<Scalar>(column);
      out.ns_unmapped = broadcast<L>(t.ns_unmapped);
      out.terminator = F(t.terminator);
    }
    return out;
  }

  /// The radiance that photons [i, i + L::width) bring, lane by lane. `lanes`: which of them count.
  SHEAF_INLINE Spectrum<L> gather(const PhotonMapView& map, std::uint32_t i, Mask<L> lanes) const {
    using F = Float<L>;
    Vec3<L> p;
    load_column(map.x + i, p.x), load_column(map.y + i, p.y), load_column(map.z + i, p.z);
    const Vec3<L> d = p - item.p;
    const F squared = dot(d, d) * F(1.0f / (map.radius * map.radius));
    auto near = lanes & (squared < F(1.0f));
    if (!any(near)) return Spectrum<L>(F(0.0f));
    Uint<L> surface, direction;
    load_column(map.surface + i, surface), load_column(map.direction + i, direction);
    const Vec3<L> n = decode_octahedral<L>(surface), wi = decode_octahedral<L>(direction);
    near = near & (abs(dot(n, item.ng)) > F(kSameSide)) & !(edges_left < (surface & Uint<L>(kMostPhotonEdges)));
    if (!any(near)) return Spectrum<L>(F(0.0f));
    Spectrum<L> power;
    load_column(map.power[0] + i, power.c0), load_column(map.power[1] + i, power.c1);
    load_column(map.power[2] + i, power.c2), load_column(map.power[3] + i, power.c3);
    const Vec3<L> local = frame.to_local(wi);
    // A photon's flux has met the geometric surface, whatever the shading normal.
    F factor = kernel(map.kernel, squared) / max(abs(dot(wi, item.ng)), F(1e-4f));
    if (mapped) factor = factor * shadow_terminator<L>(ns_unmapped, terminator, wi, local.z);
    return select<L>(near, bsdf.evaluate(item.wo, local).f_cos * power * factor, Spectrum<L>(F(0.0f)));
  }

 private:
  template <class T, class V> static SHEAF_INLINE void load_column(const T* from, V& to) { sheaf::load(from, to); }

  /// The kernel times pi r^2, by the squared distance over r^2.
  static SHEAF_INLINE Float<L> kernel(PhotonKernel kind, Float<L> squared) {
    using F = Float<L>;
    switch (kind) {
      case PhotonKernel::kDisc:
        return F(1.0f);
      case PhotonKernel::kCone:
        return F(3.0f) * (F(1.0f) - sqrt(squared));
      case PhotonKernel::kEpanechnikov:
        return F(2.0f) * (F(1.0f) - squared);
    }
    return F(1.0f);
  }
};

template <class L> float sum_of_lanes(Float<L> value) {
  alignas(kSimdAlignment) float words[L::width];
  store(words, value);
  float sum = 0;
  for (const float word : words) sum += word;
  return sum;
}

template <class L, template <class> class Bsdf>
Spectrum4 gather_at(const StageContext& context, const Wave& wave, Slot slot, int column, bool mapped,
                    const PhotonMapView& map) {
  const auto vertex = GatheringVertex<L, Bsdf>::load(context, wave, slot, column, mapped);
  const Vec3f p = wave.vertices.load<Scalar>(column).p;
  std::uint32_t buckets[8];
  const int count = map.buckets_around(p, buckets);
  Spectrum<L> sum(Float<L>(0.0f));
  for (int b = 0; b < count; ++b) {
    const std::uint32_t begin = map.bucket_begin[buckets[b]], end = map.bucket_begin[buckets[b] + 1];
    constexpr auto kLanes = static_cast<std::uint32_t>(L::width);
    for (std::uint32_t i = begin / kLanes * kLanes; i < end; i += kLanes) {
      const Uint<L> index = Uint<L>(i) + L::index();
      sum = sum + vertex.gather(map, i, (!(index < Uint<L>(begin))) & (index < Uint<L>(end)));
    }
  }
  const float scale = kInvPi / (map.radius * map.radius);
  return {sum_of_lanes<L>(sum.c0) * scale, sum_of_lanes<L>(sum.c1) * scale, sum_of_lanes<L>(sum.c2) * scale,
          sum_of_lanes<L>(sum.c3) * scale};
}

template <class L, template <class> class Bsdf>
void gather_run(const StageContext& context, Wave& wave, const VertexRun& run) {
  const bool mapped = (context.scene.kind_flags[static_cast<int>(Bsdf<L>::kKind)] & kMapped) != 0;
  for (int i = 0; i < run.count; ++i) {
    const Slot slot = wave.sorted[run.slot_begin + i];
    const PhotonMapView& map = context.maps->map_of(wave.rays.row(slot).flags);
    if (map.empty()) continue;
    const Spectrum4 found = gather_at<L, Bsdf>(context, wave, slot, run.column_begin + i, mapped, map);
    const float divisor = context.scene.has_transparency
                              ? lane_mean<Scalar>(context.scene.color, wave.probabilities.row(slot).r_u)
                              : 1.0f;
    add_radiance(wave, slot, Quad(wave.throughput.row(slot).beta) * Quad(found) * (1.0f / divisor), kNone);
  }
}

}  // namespace

template <class L> void gather(const StageContext& context, Wave& wave) noexcept {
  if (context.maps == nullptr) return;
  StageTimer timer(wave.stats, Stage::kGather);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular && !kIsPhaseFunction<Bsdf<L>>) {
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, 1);
      gather_run<L, Bsdf>(context, wave, run);
    }
  });
}

SHEAF_INSTANTIATE_STAGE(gather);

}  // namespace sheaf
