// Stable counting sort of slots by bucket.
#pragma once

#include "kernels/wave/slot_list.h"
#include "scene/tables/material_tables.h"

#include <algorithm>
#include <utility>

namespace sheaf {

/// Sorts slots[0 .. count) stably by keys[i], the key of slots[i]. Keys must be below `buckets` <= kMaxBuckets.
/// sorted[] receives the result, in which bucket b is [begin[b], begin[b + 1]). begin has buckets + 1 entries.
inline void bucket_sort(const Slot* slots, const std::uint8_t* keys, int count, int buckets, Slot* sorted,
                        int* begin) noexcept {
  assert(buckets <= kMaxBuckets);
  // Sort kParts consecutive parts of the list at once, each with its own counters. With few buckets, or with long runs
  // of equal keys, an item would otherwise wait for the store of the item before it.
  constexpr int kParts = 4;
  int next[kParts][kMaxBuckets];
  for (auto& counters : next) std::fill_n(counters, buckets, 0);
  const int part = count / kParts;
  for (int i = 0; i < part; ++i)
    for (int p = 0; p < kParts; ++p) ++next[p][keys[p * part + i]];
  for (int i = kParts * part; i < count; ++i) ++next[kParts - 1][keys[i]];
  // Convert the counts to the first index of each part of each bucket
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
