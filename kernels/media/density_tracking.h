// Vectorized delta and ratio tracking through media whose extinction is the product of their spectra and one grid
// (kMediumSingleGrid). A ray's outcome then depends only on one number per point, the density, and on the extinction of
// its hero lane. The number of null collisions and the integrals of the bounds along the ray suffice to weight the
// other lanes (kernels/media/density_weights.h).
//
// Each lane of a register follows its own ray, which steps from leaf to leaf of the majorant grid or waits at a
// collision for the density lookup. Steps continue until half of the lanes wait; a lookup serves all waiting lanes.
// Lanes whose rays have ended take the next rays, so no ray waits for others to end.
#pragma once

#include "core/soa/column_tile.h"
#include "kernels/media/majorant_walk.h"
#include "kernels/media/medium_random.h"
#include "scene/tables/brick_grid_lookup.h"

#include <bit>

namespace sheaf {

/// The purpose of tracking.
enum class DensityTracking {
  kScattering,     ///< find the first real collision, with the majorant
  kTransmittance,  ///< use the minorant's transmittance, and ratio tracking for the rest
};

/// A ray with this many tentative collisions is abandoned and contributes nothing. A medium of such an optical
/// thickness is opaque, unless its majorants are far too large. If they are so large that steps vanish against the
/// distance in 32 bits, the ray would never reach its end.
inline constexpr std::uint32_t kMaxCollisions = 1u << 20;

/// Optical thickness from the start of the ray, in the lane of the largest extinction, up to which minorants are used.
/// Beyond it the minorant is 0. Rays with little transmittance then have enough collisions for Russian roulette. The
/// limit does not depend on the hero: whatever the hero, a ray has the pdfs that r_l assumes for its lanes.
inline constexpr float kMaxControlDepth = 2.3f;
/// Russian roulette of shadow rays: below a transmittance of kRouletteThreshold, a ray survives with probability
/// kSurvival and a weight of 1 / kSurvival.
inline constexpr float kRouletteThreshold = 0.1f, kSurvival = 0.25f;

/// A ray to track.
template <class L> struct DensityRay {
  Vec3<L> origin, direction;  ///< as in MediumRay
  Float<L> length;            ///< meters
  Float<L> extinction;        ///< extinction of the hero lane at density 1
  Float<L> largest;           ///< maximum over all lanes of the extinction at density 1
  Float<L> first;             ///< in [0, 1): random number for the distance to the first collision
  MediumNumbers<L> numbers;   ///< random numbers for everything else
  static constexpr auto fields(auto& s) {
    return std::tie(s.origin, s.direction, s.length, s.extinction, s.largest, s.first, s.numbers);
  }
};

/// State or outcome of a ray.
enum class DensityOutcome : std::uint32_t {
  kWalking,    ///< still tracking: before the next collision
  kColliding,  ///< not ended: at a collision
  kIdle,
  kPassed,
  kScattered,
  kAbsorbed,   ///< kTransmittance: no light is left
  kAbandoned,  ///< see kMaxCollisions
};

/// Result of tracking a ray.
template <class L> struct TrackResult {
  Float<L> t;                     ///< distance in meters at which the ray scatters
  Float<L> majorants, minorants;  ///< integrals along the ray of the bounds that were used
  Float<L> ratio;                 ///< see density_weights.h
  Float<L> survival;              ///< product of 1 / kSurvival over Russian roulette
  Uint<L> nulls;                  ///< number of collisions, without the one that scatters
  Uint<L> outcome;                ///< DensityOutcome
  static constexpr auto fields(auto& s) {
    return std::tie(s.t, s.majorants, s.minorants, s.ratio, s.survival, s.nulls, s.outcome);
  }
};

/// The grids of a medium.
struct DensityMedium {
  const MajorantGridRow& majorants;
  const BrickGridRow& density;
};

/// Maximum number of rays tracked per call.
inline constexpr int kDensityRows = 256;
using DensityRays = ColumnTile<DensityRay, kDensityRows>;
using TrackResults = ColumnTile<TrackResult, kDensityRows>;

namespace detail {

/// A ray before its first step.
template <class L> struct DensityStart {
  LeafWalk<L> walk;
  Float<L> extinction, largest, depth;
  MediumNumbers<L> numbers;
  Uint<L> outcome;
  static constexpr auto fields(auto& s) {
    return std::tie(s.walk, s.extinction, s.largest, s.depth, s.numbers, s.outcome);
  }
};

/// A ray being tracked.
template <class L> struct DensityLane {
  DensityStart<L> start;        ///< with the current walk, depth and outcome
  TrackResult<L> end;           ///< running values; t and outcome are set at the end
  Float<L> majorant, minorant;  ///< at the collision
  static constexpr auto fields(auto& s) { return std::tie(s.start, s.end, s.majorant, s.minorant); }
};

template <class L> SHEAF_INLINE Mask<L> is_at(Uint<L> outcome, DensityOutcome which) {
  return outcome == Uint<L>(static_cast<std::uint32_t>(which));
}
template <class L> SHEAF_INLINE void set_where(Mask<L> m, DensityOutcome which, Uint<L>& outcome) {
  outcome = select(m, Uint<L>(static_cast<std::uint32_t>(which)), outcome);
}

/// Natural logarithm of a positive normal number, with the same bits in every lane. The logarithm of the mantissa m, in
/// [sqrt(1/2), sqrt(2)], is 2 artanh((m - 1) / (m + 1)). Five terms of its series reach the resolution of float.
template <class L> SHEAF_INLINE Float<L> natural_log(Float<L> x) {
  using F = Float<L>;
  using U = Uint<L>;
  constexpr std::uint32_t kRootOfHalf = 0x3f3504f3u;
  const U bits = float_bits(x), exponent = (bits - U(kRootOfHalf)) >> 23;  // 512 too large for x below the root
  const F m = bits_float(bits - (exponent << 23));
  const F s = (m - F(1.0f)) / (m + F(1.0f)), s2 = s * s;
  const F series =
      fma(s2, fma(s2, fma(s2, fma(s2, F(2.0f / 9.0f), F(2.0f / 7.0f)), F(2.0f / 5.0f)), F(2.0f / 3.0f)), F(2.0f));
  const F e = to_float(exponent) - select(exponent < U(128u), F(0.0f), F(512.0f));
  return fma(e, F(0.693147180559945f), s * series);
}

/// Exponentially distributed number from u in [0, 1).
template <class L> SHEAF_INLINE Float<L> exponential(Float<L> u) { return -natural_log<L>(Float<L>(1.0f) - u); }

template <class L>
SHEAF_INLINE DensityStart<L> start_density_ray(const DensityMedium& medium, const DensityRay<L>& ray) {
  DensityStart<L> start;
  Mask<L> hits;
  start.walk = start_leaf_walk<L>(medium.majorants, ray.origin, ray.direction, Float<L>(0.0f), ray.length, hits);
  start.extinction = ray.extinction;
  start.largest = ray.largest;
  start.numbers = MediumNumbers<L>::start(ray.numbers.x, ray.numbers.y, ray.numbers.z, ray.numbers.w);
  start.depth = exponential<L>(ray.first);
  start.outcome = Uint<L>(static_cast<std::uint32_t>(DensityOutcome::kWalking));
  set_where<L>(!hits, DensityOutcome::kPassed, start.outcome);
  return start;
}

/// Advances the walking lanes to the end of their leaf, or to a collision before it.
template <class L, DensityTracking kPurpose> SHEAF_INLINE void step(const DensityMedium& medium, DensityLane<L>& lane) {
  using F = Float<L>;
  LeafWalk<L>& walk = lane.start.walk;
  TrackResult<L>& sum = lane.end;
  const Mask<L> walking = is_at<L>(lane.start.outcome, DensityOutcome::kWalking);
  // Look up the bounds, and find the end of the step.
  const MajorantLeaf<L> leaf = find_leaf<L>(medium.majorants, walk);
  const F s = lane.start.extinction, max_control = F(kMaxControlDepth) / lane.start.largest;
  const F majorant = leaf.majorant;
  const F minorant = select(sum.minorants < max_control, leaf.minorant, F(0.0f));
  const F leaf_end = min(leaf.t_end, walk.leave);
  // At the limit of the minorants the step ends early; the next step enters the same leaf again.
  const F used_up = walk.t + (max_control - sum.minorants) / minorant;
  const Mask<L> is_used_up = (minorant > F(0.0f)) & (used_up < leaf_end);
  const F end = select(is_used_up, used_up, leaf_end);
  const F left = max(end - walk.t, F(0.0f));
  const F rate = kPurpose == DensityTracking::kTransmittance ? s * (majorant - minorant) : s * majorant;
  const F over = rate * left;
  // Step to the collision, or to the end.
  const Mask<L> collides = walking & (over > lane.start.depth), passes = walking & !collides;
  const F stretch = select(collides, lane.start.depth / rate, select(walking, left, F(0.0f)));
  sum.majorants = fma(majorant, stretch, sum.majorants);
  sum.minorants = select(passes & is_used_up, max_control, fma(minorant, stretch, sum.minorants));
  lane.start.depth = select(passes, lane.start.depth - over, lane.start.depth);
  walk.t = select(collides, walk.t + stretch, select(passes, max(walk.t, end), walk.t));
  // Leave the leaf or the box.
  const Mask<L> leaves_box = passes & !is_used_up & !(leaf.t_end < walk.leave);
  const Mask<L> leaves_leaf = passes & !is_used_up & (leaf.t_end < walk.leave);
  walk.position = select<L>(leaves_leaf, position_behind<L>(medium.majorants, walk, leaf), walk.position);
  lane.majorant = select(collides, majorant, lane.majorant);
  lane.minorant = select(collides, minorant, lane.minorant);
  set_where<L>(collides, DensityOutcome::kColliding, lane.start.outcome);
  set_where<L>(leaves_box, DensityOutcome::kPassed, lane.start.outcome);
}

/// Decides whether the colliding lanes have real or null collisions.
template <class L, DensityTracking kPurpose>
SHEAF_INLINE void collide(const DensityMedium& medium, DensityLane<L>& lane) {
  using F = Float<L>;
  using U = Uint<L>;
  const LeafWalk<L>& walk = lane.start.walk;
  TrackResult<L>& sum = lane.end;
  const Mask<L> colliding = is_at<L>(lane.start.outcome, DensityOutcome::kColliding);
  // Look up the density.
  const Random4<L> u = lane.start.numbers.at(sum.nulls + U(1u));
  const Vec3<L> p{fma(walk.t, walk.direction.x, walk.origin.x), fma(walk.t, walk.direction.y, walk.origin.y),
                  fma(walk.t, walk.direction.z, walk.origin.z)};
  // The bounds hold up to rounding only: clamp the density to them.
  const F density = min(max(lookup_density<L>(medium.density, p), lane.minorant), lane.majorant);
  const F residual = lane.majorant - lane.minorant, null = lane.majorant - density;
  set_where<L>(colliding, DensityOutcome::kWalking, lane.start.outcome);
  Mask<L> is_active = colliding;
  if constexpr (kPurpose == DensityTracking::kScattering) {
    const Mask<L> is_real = colliding & (u.y * lane.majorant < density);
    set_where<L>(is_real, DensityOutcome::kScattered, lane.start.outcome);
    is_active = colliding & !is_real;
    sum.ratio = select(is_active, sum.ratio * (residual / max(null, F(1e-30f))), sum.ratio);
  } else {
    sum.ratio = select(colliding, sum.ratio * (null / residual), sum.ratio);
    const F passed = sum.ratio * exp(-(lane.start.extinction * sum.minorants)) * sum.survival;
    const Mask<L> in_roulette = colliding & (passed < F(kRouletteThreshold));
    sum.survival = select(in_roulette, sum.survival * F(1.0f / kSurvival), sum.survival);
    const Mask<L> is_absorbed = (in_roulette & (u.y >= F(kSurvival))) | (colliding & !(sum.ratio > F(0.0f)));
    set_where<L>(is_absorbed, DensityOutcome::kAbsorbed, lane.start.outcome);
  }
  // Sample the distance to the next collision.
  sum.nulls = select(is_active, sum.nulls + U(1u), sum.nulls);
  lane.start.depth = select(colliding, exponential<L>(u.x), lane.start.depth);
  set_where<L>(is_active & !(sum.nulls < U(kMaxCollisions)), DensityOutcome::kAbandoned, lane.start.outcome);
}

/// Distributes rays to the lanes, tracks them, and stores their results.
template <class L, DensityTracking kPurpose> class DensityTracker {
 public:
  DensityTracker(const DensityMedium& medium, const DensityRays& rays, int count, TrackResults& ends)
      : medium_(medium), count_(count), ends_(ends) {
    for (int i = 0; i < count; i += L::width)
      starts_.template store<L>(i, start_density_ray<L>(medium, rays.load<L>(i)));
    DensityLane<Scalar> idle{};
    idle.start.outcome = static_cast<std::uint32_t>(DensityOutcome::kIdle);
    for (int lane = 0; lane < L::width; ++lane) lanes_.template store<Scalar>(lane, idle);
  }

  void run() {
    std::uint32_t ended = kAll;
    while (take(ended)) {
      DensityLane<L> lane = lanes_.template load<L>(0);
      std::uint32_t colliding = 0, walking = kAll & ~idle_;
      do {
        if (walking == 0 || std::popcount(colliding) >= kEnough) {
          collide<L, kPurpose>(medium_, lane);
        } else {
          step<L, kPurpose>(medium_, lane);
        }
        colliding = mask_bits(is_at<L>(lane.start.outcome, DensityOutcome::kColliding));
        walking = mask_bits(is_at<L>(lane.start.outcome, DensityOutcome::kWalking));
        ended = kAll & ~(colliding | walking | idle_);
      } while ((colliding | walking) != 0 && (next_ >= count_ || std::popcount(ended) < kEnoughEnded));
      lanes_.template store<L>(0, lane);
    }
  }

 private:
  static constexpr std::uint32_t kAll = static_cast<std::uint32_t>((std::uint64_t{1} << L::width) - 1);
  /// Number of colliding lanes that justify a lookup, and of ended lanes that justify a refill.
  static constexpr int kEnough = L::width > 1 ? L::width / 2 : 1, kEnoughEnded = L::width > 4 ? L::width / 4 : 1;

  /// Gives the next rays to the lanes of `ended`; false if all lanes are idle.
  bool take(std::uint32_t ended) {
    for (; ended != 0; ended &= ended - 1) {
      const int i = std::countr_zero(ended);
      DensityLane<Scalar> lane = lanes_.template load<Scalar>(i);
      if (lane.start.outcome != static_cast<std::uint32_t>(DensityOutcome::kIdle)) {
        lane.end.t = lane.start.walk.t;
        lane.end.outcome = lane.start.outcome;
        ends_.template store<Scalar>(ray_[i], lane.end);
      }
      lane = {};
      lane.end.ratio = lane.end.survival = 1.0f;
      if (next_ < count_) {
        ray_[i] = next_;
        lane.start = starts_.template load<Scalar>(next_++);
      } else {
        lane.start.outcome = static_cast<std::uint32_t>(DensityOutcome::kIdle);
        idle_ |= 1u << i;
      }
      lanes_.template store<Scalar>(i, lane);
    }
    return idle_ != kAll;
  }

  const DensityMedium& medium_;
  int count_, next_ = 0;
  TrackResults& ends_;
  std::uint32_t idle_ = 0;
  int ray_[L::width] = {};
  ColumnTile<DensityStart, kDensityRows> starts_;
  ColumnTile<DensityLane, kWidth> lanes_;
};

}  // namespace detail

/// Tracks the first `count` rays. Rows after them, up to a whole register, must be set too. The result of a ray does
/// not depend on the other rays.
template <class L, DensityTracking kPurpose>
inline void track_densities(const DensityMedium& medium, const DensityRays& rays, int count, TrackResults& ends) {
  detail::DensityTracker<L, kPurpose>(medium, rays, count, ends).run();
}

}  // namespace sheaf
