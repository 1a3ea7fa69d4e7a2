// Updates path throughput and rescaled pdfs in all lanes after density tracking.
//
// Notation: s is the extinction of a lane at density 1 and h that of the hero; M and m are the majorant and the
// minorant, rho the density; A and D are the integrals of M and m along the ray; n is the number of null collisions.
// For each null collision, a lane's weight is s (M - rho) over the pdf of the hero, and for each segment its
// transmittance. With q = s / h, the factor common to all cases is
//     q^n exp((h - s) A)
// The other factors contain TrackResult::ratio, a product over the n null collisions whose factors are called R:
//     paths are sampled with h (M - rho) exp(-h A). Light sampling would sample these collisions with s (M - m), so
//         r_l has q^n exp((h - s) (A - D)) exp(h D) R,  R = (M - m) / (M - rho);
//     shadow rays are sampled with h (M - m) exp(-h (A - D)). Both beta and r_u have
//         q^n exp((h - s) A) exp(-h D) R,  R = (M - rho) / (M - m),  and r_l has q^n exp((h - s) (A - D)).
// The treatment of the minorant along shadow rays is residual ratio tracking (Novak, Selle and Jarosz 2014). With delta
// tracking, light sampling treats collisions as paths do.
#pragma once

#include "core/sampling/sampler.h"
#include "kernels/media/density_tracking.h"
#include "kernels/media/medium_tracking.h"

#include <optional>

namespace sheaf {

/// Whether a ray uses density tracking.
inline bool is_tracked_by_density(const MediumRay& ray, MediumEstimator estimator) {
  return ray.has(kMediumSingleGrid) && estimator != MediumEstimator::kMarching;
}

/// Weights of the lanes relative to the hero, by path sampling and by light sampling.
struct LanePdfs {
  Float4 by_path, by_light;
};

inline LanePdfs lane_pdfs(const MediumRay& ray, const TrackResult<Scalar>& end) {
  if (ray.has(kMediumGray)) return {Float4(1.0f), Float4(1.0f)};
  const Float4 s = majorant_spectrum(ray, 1.0f), more = Float4(s[ray.hero]) - s;
  Float4 power(1.0f), square = end.nulls > 0 ? s * (1.0f / s[ray.hero]) : power;
  for (std::uint32_t n = end.nulls; n != 0; n >>= 1, square = square * square)
    if ((n & 1u) != 0) power = power * square;
  return {power * exp(more * end.majorants), power * exp(more * (end.majorants - end.minorants))};
}

/// Applies the result of kScattering: the path has passed, or scatters at TrackResult::t.
inline void weigh_scattering(const MediumRay& ray, const TrackResult<Scalar>& end, bool delta, PathWeights& path) {
  const LanePdfs pdf_ratio = lane_pdfs(ray, end);
  const float hero = majorant_spectrum(ray, 1.0f)[ray.hero];
  path.beta = path.beta * pdf_ratio.by_path;
  path.r_u = path.r_u * ray.pdf_ratio(pdf_ratio.by_path);
  path.r_l = path.r_l * (delta ? ray.pdf_ratio(pdf_ratio.by_path)
                               : ray.pdf_ratio(pdf_ratio.by_light) * (end.ratio * std::exp(hero * end.minorants)));
  if (end.outcome != static_cast<std::uint32_t>(DensityOutcome::kScattered)) return;
  const MediumCoefficients c = coefficients_per_density(ray.scene, ray.medium, ray.spectra, ray.at(end.t), ray.lambda);
  path.beta = path.beta * c.sigma_s * (1.0f / hero);
  path.r_u = path.r_u * ray.pdf_ratio(c.sigma_t * (1.0f / hero));
}

/// Applies the result of kTransmittance, or of kScattering with `delta`, to a shadow ray that has passed.
inline void weigh_transmittance(const MediumRay& ray, const TrackResult<Scalar>& end, bool delta, PathWeights& path) {
  const LanePdfs pdf_ratio = lane_pdfs(ray, end);
  const float passed = delta ? 1.0f : end.ratio * std::exp(-majorant_spectrum(ray, 1.0f)[ray.hero] * end.minorants);
  path.beta = path.beta * pdf_ratio.by_path * (passed * end.survival);
  path.r_u = path.r_u * (ray.pdf_ratio(pdf_ratio.by_path) * passed);
  path.r_l = path.r_l * ray.pdf_ratio(delta ? pdf_ratio.by_path : pdf_ratio.by_light);
}

/// A queue of rays to track, in any media. The sampler stratifies the distances to the first collisions over a pixel's
/// samples: paths and shadow rays each use one number of SampleBlock::kSelect.
class DensityQueue {
 public:
  static constexpr int kCapacity = kDensityRows;

  /// `sampler` must outlive the queue.
  DensityQueue(const SamplerView& sampler, MediumStream use) : sampler_(sampler), use_(use) {}

  bool is_full() const { return size_ == kCapacity; }
  int size() const { return size_; }
  void clear() { size_ = 0; }
  const MediumRay& ray(int i) const { return *rays_[static_cast<std::size_t>(i)]; }
  const TrackResult<Scalar>& end(int i) const { return ends_[static_cast<std::size_t>(i)]; }

  /// `pixel`, `sample` and `dimension` identify the ray's random numbers.
  void add(const MediumRay& ray, std::uint32_t pixel, std::uint32_t sample, std::uint32_t dimension) {
    rays_[static_cast<std::size_t>(size_)].emplace(ray);
    numbers_[static_cast<std::size_t>(size_++)] = {pixel, sample, dimension,
                                                   MediumNumbers<Scalar>::key(sampler_.seed, use_)};
  }

  /// Tracks all rays as shadow rays and sets end(). `delta`: by delta tracking.
  template <class L> void track_shadows(bool delta) {
    if (delta)
      track<L, DensityTracking::kScattering>();
    else
      track<L, DensityTracking::kTransmittance>();
  }
  /// Weights of shadow ray `i` after track_shadows(); nothing if no light is left.
  std::optional<PathWeights> passed(int i, bool delta, TrackingCounts& counts) const {
    const auto outcome = static_cast<DensityOutcome>(end(i).outcome);
    counts.shadow += end(i).nulls + (outcome == DensityOutcome::kScattered ? 1u : 0u);
    if (outcome == DensityOutcome::kAbandoned) ++counts.abandoned;
    if (outcome != DensityOutcome::kPassed) return std::nullopt;
    PathWeights weights{Float4(1.0f), Float4(1.0f), Float4(1.0f)};
    weigh_transmittance(ray(i), end(i), delta, weights);
    return weights;
  }

  /// Tracks all rays and sets end().
  template <class L, DensityTracking kPurpose> void track() {
    std::array<bool, kCapacity> is_tracked{};
    for (int i = 0; i < size_; ++i)
      if (!is_tracked[static_cast<std::size_t>(i)]) track_medium<L, kPurpose>(i, is_tracked);
  }

 private:
  /// Tracks all rays in the medium of ray `first`; earlier rays are done already.
  template <class L, DensityTracking kPurpose> void track_medium(int first, std::array<bool, kCapacity>& is_tracked) {
    // Collect the rays.
    DensityRays rows;
    TrackResults ends;
    std::array<int, kCapacity> index;
    int count = 0;
    const MediumRow& medium = ray(first).medium;
    const SceneView& scene = ray(first).scene;
    for (int i = first; i < size_; ++i) {
      if (&ray(i).medium != &medium) continue;
      is_tracked[static_cast<std::size_t>(i)] = true;
      index[static_cast<std::size_t>(count)] = i;
      const MediumRay& r = ray(i);
      const Float4 extinction = majorant_spectrum(r, 1.0f);
      rows.template store<Scalar>(count++, {r.origin, r.direction, r.length, extinction[r.hero],
                                            max_component(extinction), 0.0f, numbers_[static_cast<std::size_t>(i)]});
    }
    for (int i = count; i % L::width != 0; ++i) rows.template store<Scalar>(i, {});
    // Draw the numbers for the first collisions.
    const bool is_shadow = use_ == MediumStream::kShadow;
    for (int i = 0; i < count; i += L::width) {
      DensityRay<L> row = rows.template load<L>(i);
      const Random4<L> u = draw<L>(sampler_, row.numbers.x, row.numbers.y, row.numbers.z, SampleBlock::kSelect, {},
                                   is_shadow ? kNumberZ : kNumberY);
      row.first = is_shadow ? u.z : u.y;
      rows.template store<L>(i, row);
    }
    const std::uint32_t grid = medium.density != kNone ? medium.density : medium.first_grid;
    track_densities<L, kPurpose>({scene.media.majorants[medium.majorants], scene.media.grids.rows[grid]}, rows, count,
                                 ends);
    for (int i = 0; i < count; ++i)
      ends_[static_cast<std::size_t>(index[static_cast<std::size_t>(i)])] = ends.template load<Scalar>(i);
  }

  const SamplerView& sampler_;
  MediumStream use_;
  int size_ = 0;
  std::array<std::optional<MediumRay>, kCapacity> rays_;
  std::array<MediumNumbers<Scalar>, kCapacity> numbers_;
  std::array<TrackResult<Scalar>, kCapacity> ends_;
};

}  // namespace sheaf
