// Stage: gather. Estimates the radiance that a vertex reflects along the path from the photons around it (Jensen,
// "Global Illumination using Photon Maps", 1996, equation 8): L = sum of f Phi_i k(d_i), with the kernel k over the
// disc of the lookup radius. Vertices are processed one at a time, photons a register at a time. PhotonMaps selects the
// maps for each vertex.
//
// Photons are added in the order of the map, each lane for itself, and then the lanes in their order.
//
// In spectral mode the path, the vertex and the photon may each have lost three of four wavelengths, and compensate for
// it by a factor of 4. Together they must apply it once. The pdf of a path with four wavelengths is the mean over its
// lanes. If only the first wavelength continues, only its own pdf remains, because the path's distances were sampled by
// it. The distances of photons are sampled by any of the four (kernels/stages/photon_rays.cpp), so their mean pdf holds
// for each wavelength.
#include "core/sampling/octahedral.h"
#include "core/simd/prefetch.h"
#include "core/simd/simd_compress.h"
#include "core/soa/lane_array.h"
#include "kernels/bsdf/list.h"
#include "kernels/photons/photon_kernel.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/photons/photon_search.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <algorithm>
#include <type_traits>

namespace sheaf {

namespace {

/// Whether a BSDF is constant over the hemisphere around the normal.
template <class Bsdf> inline constexpr bool kIsLambertian = std::is_same_v<typename Bsdf::Closure, DiffuseClosure>;

/// Maximum squared difference of shading and geometric normal that counts as rounding.
constexpr float kFlat = 1e-12f;

/// One vertex, broadcast to all lanes.
template <class L, template <class> class Bsdf> struct GatheringVertex {
  VertexItem<L> item;
  Bsdf<L> bsdf;
  ShadingFrame<L, Bsdf<L>::kIsAnisotropic> frame;
  bool mapped;
  Vec3<L> ns_unmapped;
  typename L::Float terminator;
  PhotonQuery<L> query;
  bool is_flat;            ///< shading and geometric normal are the same
  bool single_wavelength;  ///< the camera path has a single wavelength
  float first_ratio;       ///< pdf of the camera path over that of only its first wavelength

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
                        {item.p, item.ng, Uint<L>(max_depth > depth ? max_depth - depth : 0u)},
                        !mapped && length_squared(one.ns - one.ng) < kFlat,
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

  /// Whether the BSDF reflects all photons from the side of the normal alike.
  bool reflects_evenly() const {
    return kIsLambertian<Bsdf<L>> && is_flat && !single_wavelength && first_ratio == 1.0f;
  }

  /// Radiance times pi r^2 due to the photons `near`, [at, at + L::width) of a block, per lane. `within`: r^2, m^2.
  SHEAF_INLINE Spectrum<L> reflected(PhotonKernel kernel, const NearBlock<L>& block, std::uint32_t at,
                                     const NearPhotons<L>& near, float within) const {
    using F = Float<L>;
    const Vec3<L> wi = decode_octahedral<L>(block.direction(at));
    const Vec3<L> local = frame.to_local(wi);
    // The flux of a photon refers to the geometric surface, not to the shading normal.
    F factor = photon_kernel<L>(kernel, near.squared * F(1.0f / within)) / max(abs(dot(wi, item.ng)), F(1e-4f));
    if (mapped) factor = factor * shadow_terminator<L>(ns_unmapped, terminator, wi, local.z);
    if (kDisperses<Bsdf<L>> || single_wavelength || first_ratio != 1.0f)
      factor = factor * wavelengths(block.surface(at), local);
    return select<L>(near.lanes,
                     bsdf.evaluate(item.wo, local).f_cos * block.power(at) * (factor * F(block.power_step())),
                     Spectrum<L>(F(0.0f)));
  }

  /// Adds the same over reflected_evenly(), if reflects_evenly(): the cosines of f_cos and flux cancel.
  SHEAF_INLINE void add_arriving(PhotonKernel kernel, const NearBlock<L>& block, std::uint32_t at,
                                 const NearPhotons<L>& near, float within, Spectrum<L>& sum) const {
    using F = Float<L>;
    Mask<L> lanes = near.lanes;
    if (!block.is_lit()) lanes = lanes & (dot(decode_octahedral_direction<L>(block.direction(at)), item.ng) > F(0.0f));
    F factor(block.power_step());
    if (kernel != PhotonKernel::kDisc) factor = factor * photon_kernel<L>(kernel, near.squared * F(1.0f / within));
    factor = select(lanes, factor, F(0.0f));
    const Spectrum<L> power = block.power(at);
    sum = {fma(power.c0, factor, sum.c0), fma(power.c1, factor, sum.c1), fma(power.c2, factor, sum.c2),
           fma(power.c3, factor, sum.c3)};
  }
  SHEAF_INLINE Spectrum<L> reflected_evenly() const {
    using F = Float<L>;
    return bsdf.evaluate(item.wo, Vec3<L>{F(0.0f), F(0.0f), F(1.0f)}).f_cos;
  }

 private:
  /// Factor on photons where path, vertex or photon have lost wavelengths. `surface`: see photon_surface().
  SHEAF_INLINE Float<L> wavelengths(Uint<L> surface, Vec3<L> local) const {
    using F = Float<L>;
    const auto by_photon = (surface & Uint<L>(kPhotonSingleWavelength)) != Uint<L>(0u);
    const auto by_vertex = loses_wavelengths<L>(bsdf, item.wo, local);
    const auto twice = by_photon & (by_vertex | Mask<L>(single_wavelength));
    const F once = select(by_photon | by_vertex, F(first_ratio), F(1.0f));
    return select(twice, once * F(0.25f), once);
  }
};

template <class L> float sum_of_lanes(Float<L> value) {
  float sum = 0;
  for (const float lane : LaneArray<Float<L>>(value)) sum += lane;
  return sum;
}

/// Prefetches what a lookup reads of a block: directions only if some photons may arrive on the other side, and
/// surfaces only if they differ.
SHEAF_INLINE void prefetch_block(const PhotonMapView& map, std::uint32_t entry) {
  const PhotonBlock& block = map.blocks[entry & kBlockIndex];
  prefetch(block.positions), prefetch(block.powers);
  if ((entry & kBlockLit) == 0) prefetch(block.directions);
  if ((entry & kBlockMixed) != 0) prefetch(block.surfaces);
}

/// Calls f(total, block, at, near) for each register of photons that may hold some within the distance of the vertex:
/// photons [at, at + L::width) of the block, with `near` those that match. f adds them to `total`. `within`: squared
/// distance, m^2; f may shrink it. `sum`: see for_blocks_near().
template <class L, class T, class F>
SHEAF_INLINE void for_photons_near(const PhotonMapView& map, const PhotonQuery<L>& query, const float& within,
                                   bool needs_distances, SummedPhotons<L>* sum, PhotonSearchLists& lists, T& total,
                                   F&& f) {
  constexpr int kAhead = 16;
  for_blocks_near<L>(map, query, within, sum, lists, [&](const BlockList& list) SHEAF_LAMBDA_INLINE {
    for (int i = 0; i < std::min(list.count, kAhead); ++i) prefetch_block(map, list.entries[i]);
    T of_list = total;  // a copy that stays in registers
    for (int i = 0; i < list.count; ++i) {
      if (i + kAhead < list.count) prefetch_block(map, list.entries[i + kAhead]);
      const NearBlock<L> block(map, list, i);
      for (std::uint32_t at = 0; at < kPhotonBlock; at += static_cast<std::uint32_t>(L::width))
        f(of_list, block, at, block.near(at, query, within, needs_distances));
    }
    total = of_list;
  });
}

/// The squared distances of the nearest photons.
class NearestPhotons {
 public:
  /// For `size` photons, at most kMaxLookupSize.
  explicit NearestPhotons(int size) : size_(size) {}

  /// Begins a search of photons nearer than `limit`, a squared distance, m^2.
  void begin(float limit) {
    limit_ = limit;
    count_ = 0;
  }
  /// Adds the distances of `lanes`, which are less than limit().
  template <class L> SHEAF_INLINE void add(Float<L> squared, Mask<L> lanes) {
    const std::uint32_t bits = mask_bits(lanes);
    compress_store(distances_ + count_, squared, bits);
    count_ += std::popcount(bits);
    if (count_ >= 2 * size_ + kSpare) keep_nearest();
  }
  /// Farther photons do not count any more.
  const float& limit() const { return limit_; }
  bool is_complete() const { return count_ >= size_; }
  /// The squared distance of the last of `size` photons, if is_complete().
  float last() const;

 private:
  static constexpr int kSpare = 256;

  void keep_nearest() {
    std::nth_element(distances_, distances_ + size_ - 1, distances_ + count_);
    count_ = size_;
    limit_ = distances_[size_ - 1];
  }

  int size_, count_ = 0;
  float limit_ = 0;
  float distances_[2 * kMaxLookupSize + kSpare + kWidth];
};

float NearestPhotons::last() const {
  // Squared distances of photons on a plane are uniform. Find the bin that holds the last one
  constexpr int kBins = 64;
  int bins[kBins] = {};
  const float scale = limit_ > 1e-30f ? static_cast<float>(kBins) / limit_ : 0.0f;
  const auto bin_of = [scale](float squared) { return std::min(static_cast<int>(squared * scale), kBins - 1); };
  for (int i = 0; i < count_; ++i) ++bins[bin_of(distances_[i])];
  int bin = 0, before = 0;
  while (before + bins[bin] < size_) before += bins[bin++];
  // Select it among those in the bin
  float candidates[2 * kMaxLookupSize + kSpare + kWidth];
  int count = 0;
  for (int i = 0; i < count_; ++i) {
    candidates[count] = distances_[i];
    count += bin_of(distances_[i]) == bin ? 1 : 0;
  }
  float* last = candidates + (size_ - before - 1);
  std::nth_element(candidates, last, candidates + count);
  return *last;
}

/// Squared lookup radius, m^2: that of the map, or less if it contains lookup_size photons or more. The photon that
/// defines the radius does not count, which makes the density estimate unbiased (Loftsgaarden and Quesenberry, "A
/// Nonparametric Estimate of a Multivariate Density Function", 1965). `guess`: positive; the search begins with it, but
/// the result does not depend on it. Receives a guess for a vertex nearby.
template <class L>
float squared_lookup_radius(const PhotonMapView& map, const PhotonQuery<L>& query, PhotonSearchLists& lists,
                            NearestPhotons& nearest, float& guess) {
  const float largest = map.radius * map.radius;
  if (map.lookup_size == 0) return largest;
  for (float limit = std::min(guess, largest);; limit = std::min(4 * limit, largest)) {
    nearest.begin(limit);
    NearestPhotons* all = &nearest;
    for_photons_near<L>(map, query, nearest.limit(), true, nullptr, lists, all,
                        [](NearestPhotons* found, const NearBlock<L>&, std::uint32_t, const NearPhotons<L>& near)
                            SHEAF_LAMBDA_INLINE { found->add<L>(near.squared, near.lanes); });
    const bool is_complete = nearest.is_complete();
    if (!is_complete && limit < largest) continue;
    const float within = is_complete ? nearest.last() : largest;
    guess = std::max(1.5f * within, 1e-6f * largest);
    return within;
  }
}

/// Registers that lookups tested, photons that they found in them, and photons of blocks that they did not need to
/// read.
struct LookupCounts {
  std::uint64_t registers = 0, photons = 0, summed = 0;
};

/// Sums of a lookup so far.
template <class L> struct LookupTotal {
  Spectrum<L> light{Float<L>(0.0f)};  ///< arriving, or reflected
  LookupCounts counts = {};

  SHEAF_INLINE void count(const NearPhotons<L>& near) {
    ++counts.registers;
    counts.photons += static_cast<std::uint32_t>(std::popcount(mask_bits(near.lanes)));
  }
};

template <class L, template <class> class Bsdf>
Spectrum4 gather_at(const PhotonMapView& map, const GatheringVertex<L, Bsdf>& vertex, float within,
                    PhotonSearchLists& lists, LookupCounts& counts) {
  if (!(within > 0.0f)) return {};
  const bool needs_distances = map.kernel != PhotonKernel::kDisc;
  LookupTotal<L> total;
  if (vertex.reflects_evenly()) {
    SummedPhotons<L> summed{Spectrum<L>(Float<L>(0.0f))};
    for_photons_near<L>(map, vertex.query, within, needs_distances, needs_distances ? nullptr : &summed, lists, total,
                        [&](LookupTotal<L>& sum, const NearBlock<L>& block, std::uint32_t at,
                            const NearPhotons<L>& near) SHEAF_LAMBDA_INLINE {
                          sum.count(near);
                          vertex.add_arriving(map.kernel, block, at, near, within, sum.light);
                        });
    total.light = (total.light + summed.power) * vertex.reflected_evenly();
    counts.summed += summed.photons;
  } else {
    for_photons_near<L>(map, vertex.query, within, needs_distances, nullptr, lists, total,
                        [&](LookupTotal<L>& sum, const NearBlock<L>& block, std::uint32_t at,
                            const NearPhotons<L>& near) SHEAF_LAMBDA_INLINE {
                          sum.count(near);
                          if (!any(near.lanes)) return;
                          sum.light = sum.light + vertex.reflected(map.kernel, block, at, near, within);
                        });
  }
  counts.registers += total.counts.registers, counts.photons += total.counts.photons;
  const Spectrum<L>& sum = total.light;
  const float scale = kInvPi / within;
  return {sum_of_lanes<L>(sum.c0) * scale, sum_of_lanes<L>(sum.c1) * scale, sum_of_lanes<L>(sum.c2) * scale,
          sum_of_lanes<L>(sum.c3) * scale};
}

template <class L, template <class> class Bsdf>
void gather_run(const StageContext& context, Wave& wave, const VertexRun& run, PhotonSearchLists& lists,
                LookupCounts& counts) {
  const bool mapped = (context.scene.materials.buckets.kind_flags[static_cast<int>(kKindOf<Bsdf<L>>)] & kMapped) != 0;
  float guesses[2] = {kInfinity, kInfinity};
  for (int i = 0; i < run.count; ++i) {
    const Slot slot = wave.sorted[run.slot_begin + i];
    const PhotonMaps::SelectedMaps selected = context.photon_maps().maps_at(wave.rays.row(slot).flags);
    for (const PhotonMapView* map : {selected.first, selected.second}) {
      if (map == nullptr || map->empty()) continue;
      const auto vertex = GatheringVertex<L, Bsdf>::load(context, wave, slot, run.column_begin + i, mapped);
      float& guess = map == &context.photon_maps().caustic ? guesses[1] : guesses[0];
      NearestPhotons nearest(map->lookup_size);
      const float within = squared_lookup_radius<L>(*map, vertex.query, lists, nearest, guess);
      const Spectrum4 found = gather_at<L, Bsdf>(*map, vertex, within, lists, counts);
      ++wave.stats.gathering.queries;
      const float divisor = context.scene.needs_transmittance
                                ? lane_mean<Scalar>(context.scene.color, wave.rescaled_pdfs.row(slot).r_u)
                                : 1.0f;
      add_radiance(wave, slot, Float4(wave.paths.row(slot).beta) * Float4(found) * (1.0f / divisor), kNone, 1);
    }
  }
}

}  // namespace

template <class L> void gather(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("gather"));
  PhotonSearchLists lists;
  LookupCounts counts;
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular && !kIsPhaseFunction<Bsdf<L>>) {
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      gather_run<L, Bsdf>(context, wave, run, lists, counts);
      timer.count_lanes(run.count, 0, 0);
    }
  });
  timer.count_lanes(0, counts.registers, counts.photons);
  wave.stats.gathering.photons += counts.photons + counts.summed;
}

SHEAF_INSTANTIATE_STAGE(gather);

}  // namespace sheaf
