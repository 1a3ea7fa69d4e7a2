// Stable counting sort: order, conservation of items, empty buckets.
#include "kernels/wave/bucket_sort.h"

#include "core/sampling/rng.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace sheaf::test_bucket_sort {

namespace {

using KeyOf = std::function<int(int)>;

/// Sorts `count` slots by key_of and compares with std::stable_sort. Memory around the result must not change.
bool sorts_stably(int count, int buckets, const KeyOf& key_of) {
  const auto n = static_cast<std::size_t>(count);
  std::vector<Slot> slots(n), sorted(n + 2, Slot{0xabcd});
  std::vector<std::uint8_t> keys(n);
  std::vector<std::pair<int, Slot>> expected(n);
  for (std::size_t i = 0; i < n; ++i) {
    slots[i] = static_cast<Slot>((i * 7919 + 13) & 0xffff);  // distinct and shuffled
    keys[i] = static_cast<std::uint8_t>(key_of(static_cast<int>(i)));
    expected[i] = {keys[i], slots[i]};
  }
  std::stable_sort(expected.begin(), expected.end(), [](auto& a, auto& b) { return a.first < b.first; });
  std::vector<int> begin(static_cast<std::size_t>(buckets) + 2, -7);
  bucket_sort(slots.data(), keys.data(), count, buckets, sorted.data() + 1, begin.data());
  if (sorted.front() != 0xabcd || sorted.back() != 0xabcd || begin.back() != -7) return false;
  for (std::size_t i = 0; i < n; ++i)
    if (sorted[i + 1] != expected[i].second) return false;
  if (begin[0] != 0 || begin[static_cast<std::size_t>(buckets)] != count) return false;
  for (std::size_t b = 0; b < static_cast<std::size_t>(buckets); ++b)
    for (int i = begin[b]; i < begin[b + 1]; ++i)
      if (expected[static_cast<std::size_t>(i)].first != static_cast<int>(b)) return false;
  return true;
}

}  // namespace

TEST_CASE("bucket sort: the order is stable and complete for every size and number of buckets") {
  for (const int count : {0, 1, 2, kWidth - 1, kWidth, kWidth + 1, 255, 1024, 4096, 65535})
    for (const int buckets : {1, 2, 7, 64, kMaxBuckets}) {
      CAPTURE(count);
      CAPTURE(buckets);
      const auto random = [&](int i) {
        return static_cast<int>(random4<Scalar>(1, static_cast<std::uint32_t>(i), 0, 0).x *
                                static_cast<float>(buckets));
      };
      CHECK(sorts_stably(count, buckets, random));
      CHECK(sorts_stably(count, buckets, [&](int) { return buckets - 1; }));
      CHECK(sorts_stably(count, buckets, [](int) { return 0; }));
      CHECK(sorts_stably(count, buckets, [&](int i) { return i % buckets; }));
      CHECK(sorts_stably(count, buckets, [&](int i) { return i % 2 == 0 ? 0 : buckets - 1; }));
      CHECK(sorts_stably(count, buckets, [&](int i) { return buckets - 1 - i % buckets; }));
    }
}

}  // namespace sheaf::test_bucket_sort
