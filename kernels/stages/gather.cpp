// Stage: gather. Estimates the radiance that a vertex reflects along the path from the photons around it (Jensen,
// "Global Illumination using Photon Maps", 1996, equation 8): L = sum of f Phi_i k(d_i), with the kernel k over the
// disc of the lookup radius. Vertices are processed one at a time, photons a register at a time. PhotonMaps selects the
// maps for each vertex.
//
// In spectral mode the path, the vertex and the photon may each have lost three of four wavelengths, and compensate for
// it by a factor of 4. Together they must apply it once. The pdf of a path with four wavelengths is the mean over its
// lanes. If only the first wavelength continues, only its own pdf remains, because the path's distances were sampled by
// it. The distances of photons are sampled by any of the four (kernels/stages/photon_rays.cpp), so their mean pdf holds
// for each wavelength.
#include "core/lane_array.h"
#include "core/octahedral.h"
#include "kernels/bsdf/list.h"
#include "kernels/photons/photon_kernel.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Minimum |cosine| between the normal at the vertex and the normal of a photon's surface.
constexpr float kSameSide = 0.5f;

/// One vertex, broadcast to all lanes.
template <class L, template <class> class Bsdf> struct GatheringVertex {
  VertexItem<L> item;
  Bsdf<L> bsdf;
  ShadingFrame<L, Bsdf<L>::kIsAnisotropic> frame;
  bool mapped;
  Vec3<L> ns_unmapped;
  typename L::Float terminator;
  typename L::Uint edges_left;  ///< maximum number of segments of a photon's path
  bool single_wavelength;       ///< the camera path has a single wavelength
  float first_ratio;            ///< pdf of the camera path over that of only its first wavelength

  static GatheringVertex load(const StageContext& context, const Wave& wave, Slot slot, int column, bool mapped) {
    using F = Float<L>;
    // Load the vertex and its BSDF
    const auto one = wave.vertices.load<Scalar>(column);
    const VertexItem<L> item{broadcast<L>(one.p),  broadcast<L>(one.ng), broadcast<L>(one.ns),
                             broadcast<L>(one.wo), F(one.offset),        {F(one.tangent.x), F(one.tangent.y)}};
    float* const* words = wave.closures.columns().words;
    const auto bsdf = bsdf_of_words<Bsdf<L>>(context.scene.materials.closure_tables,
                                             [words, column](int k, Float<L>& word)
                                                 SHEAF_LAMBDA_INLINE { word = F(words[k][column]); });
    // Limit the length of the photons' paths
    const std::uint32_t depth = wave.paths.get(slot).depth() + 1;
    const auto max_depth = static_cast<std::uint32_t>(context.max_depth);  // -1: larger than any depth
    GatheringVertex out{item,
                        bsdf,
                        ShadingFrame<L, Bsdf<L>::kIsAnisotropic>(item),
                        mapped,
                        item.ns,
                        F(0.0f),
                        Uint<L>(max_depth > depth ? max_depth - depth : 0u),
                        has_single_wavelength(context, wave, slot),
                        1.0f};
    // Account for lost wavelengths
    if (context.scene.color == ColorMode::kSpectral && context.scene.needs_transmittance) {
      const Spectrum4& r_u = wave.rescaled_pdfs.row(slot).r_u;
      out.first_ratio = lane_mean<Scalar>(ColorMode::kSpectral, r_u) / r_u.c0;
    }
    if (mapped) {
      const auto t = wave.textured.load<Scalar>(column);
      out.ns_unmapped = broadcast<L>(t.ns_unmapped);
      out.terminator = F(t.terminator);
    }
    return out;
  }

  /// The photons [i, i + L::width) of `lanes` that count, with their squared distances. `within`: squared radius, m^2.
  struct Near {
    Mask<L> lanes;
    typename L::Float squared;
  };
  SHEAF_INLINE Near near_photons(const PhotonMapView& map, std::uint32_t i, Mask<L> lanes, Float<L> within) const {
    Vec3<L> p;
    load_column(map.x + i, p.x), load_column(map.y + i, p.y), load_column(map.z + i, p.z);
    const Vec3<L> d = p - item.p;
    const Float<L> squared = dot(d, d);
    Mask<L> near = lanes & (squared < within);
    if (!any(near)) return {near, squared};
    Uint<L> surface;
    load_column(map.surface + i, surface);
    const Vec3<L> n = decode_octahedral<L>(surface);
    near = near & (abs(dot(n, item.ng)) > Float<L>(kSameSide)) & !(edges_left < (surface & Uint<L>(kMaxPhotonEdges)));
    return {near, squared};
  }

  /// Radiance times pi r^2 due to the photons [i, i + L::width), per lane. `within`: r^2, m^2.
  SHEAF_INLINE Spectrum<L> gather(const PhotonMapView& map, std::uint32_t i, Mask<L> lanes, float within) const {
    using F = Float<L>;
    const Near near = near_photons(map, i, lanes, F(within));
    if (!any(near.lanes)) return Spectrum<L>(F(0.0f));
    Uint<L> direction;
    load_column(map.direction + i, direction);
    const Vec3<L> wi = decode_octahedral<L>(direction);
    Spectrum<L> power;
    load_column(map.power[0] + i, power.c0), load_column(map.power[1] + i, power.c1);
    load_column(map.power[2] + i, power.c2), load_column(map.power[3] + i, power.c3);
    const Vec3<L> local = frame.to_local(wi);
    // The flux of a photon refers to the geometric surface, not to the shading normal.
    F factor = photon_kernel<L>(map.kernel, near.squared * F(1.0f / within)) / max(abs(dot(wi, item.ng)), F(1e-4f));
    if (mapped) factor = factor * shadow_terminator<L>(ns_unmapped, terminator, wi, local.z);
    if (kDisperses<Bsdf<L>> || single_wavelength || first_ratio != 1.0f) factor = factor * wavelengths(map, i, local);
    return select<L>(near.lanes, bsdf.evaluate(item.wo, local).f_cos * power * factor, Spectrum<L>(F(0.0f)));
  }

 private:
  /// Factor on photons [i, i + L::width) where path, vertex or photon have lost wavelengths.
  SHEAF_INLINE Float<L> wavelengths(const PhotonMapView& map, std::uint32_t i, Vec3<L> local) const {
    using F = Float<L>;
    Uint<L> surface;
    load_column(map.surface + i, surface);
    const auto by_photon = (surface & Uint<L>(kPhotonSingleWavelength)) != Uint<L>(0u);
    const auto by_vertex = loses_wavelengths<L>(bsdf, item.wo, local);
    const auto twice = by_photon & (by_vertex | Mask<L>(single_wavelength));
    const F once = select(by_photon | by_vertex, F(first_ratio), F(1.0f));
    return select(twice, once * F(0.25f), once);
  }

  template <class T, class V> static SHEAF_INLINE void load_column(const T* from, V& to) { sheaf::load(from, to); }
};

template <class L> float sum_of_lanes(Float<L> value) {
  float sum = 0;
  for (const float lane : LaneArray<Float<L>>(value)) sum += lane;
  return sum;
}

/// Calls f(i, lanes) for each register of photons, from i on, that may lie within the map's radius of `p`.
template <class L, class F> SHEAF_INLINE void for_photons_around(const PhotonMapView& map, Vec3f p, F&& f) {
  constexpr auto kLanes = static_cast<std::uint32_t>(L::width);
  std::uint32_t buckets[8];
  const int count = map.buckets_around(p, buckets);
  for (int b = 0; b < count; ++b) {
    const std::uint32_t begin = map.bucket_begin[buckets[b]], end = map.bucket_begin[buckets[b] + 1];
    for (std::uint32_t i = begin / kLanes * kLanes; i < end; i += kLanes) {
      const Uint<L> index = Uint<L>(i) + L::index();
      f(i, (!(index < Uint<L>(begin))) & (index < Uint<L>(end)));
    }
  }
}

/// Squared lookup radius, m^2: that of the map, or less if it contains lookup_size photons or more. The photon that
/// defines the radius does not count, which makes the density estimate unbiased (Loftsgaarden and Quesenberry, "A
/// Nonparametric Estimate of a Multivariate Density Function", 1965).
template <class L, class Vertex> float squared_lookup_radius(const PhotonMapView& map, Vec3f p, const Vertex& vertex) {
  float within = map.radius * map.radius;
  if (map.lookup_size == 0) return within;
  float nearest[kMaxLookupSize];  // heap, farthest first
  int count = 0;
  for_photons_around<L>(map, p, [&](std::uint32_t i, Mask<L> lanes) {
    const auto near = vertex.near_photons(map, i, lanes, Float<L>(within));
    const LaneArray<Float<L>> squared(near.squared);
    for_each_lane(mask_bits(near.lanes), [&](int lane) {
      if (!(squared[lane] < within)) return;
      if (count == map.lookup_size) std::pop_heap(nearest, nearest + count--);
      nearest[count++] = squared[lane];
      std::push_heap(nearest, nearest + count);
      if (count == map.lookup_size) within = nearest[0];
    });
  });
  return within;
}

template <class L, template <class> class Bsdf>
Spectrum4 gather_at(const PhotonMapView& map, Vec3f p, const GatheringVertex<L, Bsdf>& vertex) {
  const float within = squared_lookup_radius<L>(map, p, vertex);
  if (!(within > 0.0f)) return {};
  Spectrum<L> sum(Float<L>(0.0f));
  for_photons_around<L>(map, p, [&](std::uint32_t i, Mask<L> lanes) SHEAF_LAMBDA_INLINE {
    sum = sum + vertex.gather(map, i, lanes, within);
  });
  const float scale = kInvPi / within;
  return {sum_of_lanes<L>(sum.c0) * scale, sum_of_lanes<L>(sum.c1) * scale, sum_of_lanes<L>(sum.c2) * scale,
          sum_of_lanes<L>(sum.c3) * scale};
}

template <class L, template <class> class Bsdf>
void gather_run(const StageContext& context, Wave& wave, const VertexRun& run) {
  const bool mapped = (context.scene.materials.buckets.kind_flags[static_cast<int>(kKindOf<Bsdf<L>>)] & kMapped) != 0;
  for (int i = 0; i < run.count; ++i) {
    const Slot slot = wave.sorted[run.slot_begin + i];
    const PhotonMaps::SelectedMaps selected = context.photon_maps().maps_at(wave.rays.row(slot).flags);
    for (const PhotonMapView* map : {selected.first, selected.second}) {
      if (map == nullptr || map->empty()) continue;
      const auto vertex = GatheringVertex<L, Bsdf>::load(context, wave, slot, run.column_begin + i, mapped);
      const Spectrum4 found = gather_at<L, Bsdf>(*map, wave.vertices.load<Scalar>(run.column_begin + i).p, vertex);
      const float divisor = context.scene.needs_transmittance
                                ? lane_mean<Scalar>(context.scene.color, wave.rescaled_pdfs.row(slot).r_u)
                                : 1.0f;
      add_radiance(wave, slot, Float4(wave.paths.row(slot).beta) * Float4(found) * (1.0f / divisor), kNone);
    }
  }
}

}  // namespace

template <class L> void gather(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("gather"));
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
