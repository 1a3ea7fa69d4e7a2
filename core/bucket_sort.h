// Stable counting sort of slots by bucket.
#pragma once

#include "core/slot_list.h"

#include <algorithm>
#include <utility>

namespace sheaf {

/// Most buckets that one pass distinguishes.
inline constexpr int kMaxBuckets = 256;

/// Stable sort of slots[0 .. count) by keys[i], the key of slots[i], which must be below `buckets` <= kMaxBuckets.
/// sorted[] receives the result, of which [begin[b], begin[b + 1]) is bucket b; begin has buckets + 1 entries.
inline void bucket_sort(const Slot* slots, const std::uint8_t* keys, int count, int buckets, Slot* sorted,
                        int* begin) noexcept {
  assert(buckets <= kMaxBuckets);
  // The list is sorted in kParts consecutive parts at once, each with counters of its own: with few buckets, or with
  // long runs of equal keys, an item would otherwise wait for the store of the one before it.
  constexpr int kParts = 4;
  int next[kParts][kMaxBuckets];
  for (auto& counters : next) std::fill_n(counters, buckets, 0);
  const int part = count / kParts;
  for (int i = 0; i < part; ++i)
    for (int p = 0; p < kParts; ++p) ++next[p][keys[p * part + i]];
  for (int i = kParts * part; i < count; ++i) ++next[kParts - 1][keys[i]];
  int total = 0;
  for (int b = 0; b < buckets; ++b) {
    begin[b] = total;
    for (auto& counters : next) total += std::exchange(counters[b], total);
  }
  begin[buckets] = total;
  for (int i = 0; i < part; ++i)
    for (int p = 0; p < kParts; ++p) sorted[next[p][keys[p * part + i]]++] = slots[p * part + i];
  for (int i = kParts * part; i < count; ++i) sorted[next[kParts - 1][keys[i]]++] = slots[i];
}

}  // namespace sheaf
