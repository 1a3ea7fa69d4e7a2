// Converts whole records between registers and rows: fills a Record<Wide> lane by lane, and extracts a lane.
#pragma once

#include "core/color/spectrum.h"
#include "core/sampling/rng.h"
#include "core/soa/soa.h"
#include "tests/support/lanes_testing.h"

#include <algorithm>

namespace sheaf {

/// A register tile whose lane k holds the Record<Scalar> f(k).
template <template <class> class Record, class F> Record<Wide> wide_record(F&& f) {
  alignas(kSimdAlignment) std::uint32_t words[kLeafCount<Record>][kWidth];
  for (int lane = 0; lane < kWidth; ++lane) {
    Record<Scalar> row = f(lane);
    int k = 0;
    const auto put = [&](auto& leaf) { std::memcpy(&words[k++][lane], &leaf, sizeof(leaf)); };
    std::apply([&](auto&... leaf) { (put(leaf), ...); }, leaves(row));
  }
  Record<Wide> out;
  int k = 0;
  const auto get = [&](auto& leaf) {
    WideUint bits;
    load(words[k++], bits);
    if constexpr (std::is_same_v<std::decay_t<decltype(leaf)>, WideFloat>)
      leaf = bits_float(bits);
    else
      leaf = bits;
  };
  std::apply([&](auto&... leaf) { (get(leaf), ...); }, leaves(out));
  return out;
}

/// Lane `lane` of a register tile.
template <template <class> class Record> Record<Scalar> lane_record(const Record<Wide>& tile, int lane) {
  Record<Scalar> out;
  zip_leaves(tile, out, [lane](const auto& from, auto& to) { to = from[lane]; });
  return out;
}

/// Four random numbers in [0, 1) per lane, for samples first, first + 1, ...
inline Random4<Wide> wide_random(std::uint32_t seed, std::uint32_t first) {
  return random4<Wide>(seed, first + lane_index(), WideUint(0u), WideUint(0u));
}
inline Random4<Scalar> lane_random(std::uint32_t seed, std::uint32_t first, int lane) {
  return random4<Scalar>(seed, first + static_cast<std::uint32_t>(lane), 0, 0);
}

/// Maximum difference() over all leaves of two rows.
template <template <class> class Record> double record_difference(const Record<Scalar>& a, const Record<Scalar>& b) {
  double worst = 0;
  zip_leaves(a, b, [&](const auto& x, const auto& y) {
    if constexpr (std::is_same_v<std::decay_t<decltype(x)>, float>)
      worst = std::max(worst, difference(x, y));
    else
      worst = std::max(worst, x == y ? 0.0 : std::numeric_limits<double>::infinity());
  });
  return worst;
}

/// A uniformly distributed direction.
inline Vec3f random_direction(std::uint32_t seed, std::uint32_t index) {
  const auto u = random4<Scalar>(seed, index, 1, 0);
  const float z = 1.0f - 2.0f * u.x, r = safe_sqrt(1.0f - z * z), angle = 2.0f * kPi * u.y;
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace sheaf
