// SoA columns of records: round trips, partial tiles, compaction and the padding that tiles need.
#include "core/soa/soa.h"

#include "core/color/spectrum.h"
#include "core/math/vec.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <set>
#include <vector>

namespace sheaf::test_soa {

namespace {

/// A record with nested records and both leaf types; nine leaves.
template <class L> struct Item {
  Vec3<L> position;
  typename L::Uint id;
  Spectrum<L> color;
  typename L::Float weight;
  static constexpr auto fields(auto& s) { return std::tie(s.position, s.id, s.color, s.weight); }
};

Item<Scalar> item(int i) {
  const auto x = static_cast<float>(i);
  return {{x, x + 0.25f, x + 0.5f},
          0xff800000u + static_cast<std::uint32_t>(i),
          {-x, 2 * x, 3 * x, 4 * x},
          1.0f / (1.0f + x)};
}

bool equal(const Item<Scalar>& a, const Item<Scalar>& b) {
  bool same_bits = a.id == b.id;
  zip_leaves(a, b, [&](auto x, auto y) { same_bits = same_bits && x == y; });
  return same_bits;
}

Soa<Item> filled(Arena& arena, int count) {
  Soa<Item> items;
  items.bind(arena, count);
  for (int i = 0; i < count; ++i) items.store<Scalar>(i, item(i));
  return items;
}

Item<Wide> tile(int first) {
  Item<Wide> out;
  const auto lane_item = [first](int lane) { return item(first + lane); };
  out.position = {wide_floats([&](int k) { return lane_item(k).position.x; }),
                  wide_floats([&](int k) { return lane_item(k).position.y; }),
                  wide_floats([&](int k) { return lane_item(k).position.z; })};
  out.id = wide_uints([&](int k) { return lane_item(k).id; });
  out.color = {wide_floats([&](int k) { return lane_item(k).color.c0; }),
               wide_floats([&](int k) { return lane_item(k).color.c1; }),
               wide_floats([&](int k) { return lane_item(k).color.c2; }),
               wide_floats([&](int k) { return lane_item(k).color.c3; })};
  out.weight = wide_floats([&](int k) { return lane_item(k).weight; });
  return out;
}

constexpr int kSizes[] = {1, kWidth - 1, kWidth, kWidth + 1, 3 * kWidth, 1000, 1024};

}  // namespace

TEST_CASE("soa: leaves of nested records are counted in order") {
  CHECK(kLeafCount<Item> == 9);
  CHECK(kLeafCount<Vec2> == 2);
  Item<Scalar> a = item(3);
  const auto flat = leaves(a);
  CHECK(&std::get<0>(flat) == &a.position.x);
  CHECK(&std::get<3>(flat) == &a.id);
  CHECK(&std::get<8>(flat) == &a.weight);
}

TEST_CASE("soa: rows and tiles store and load the same data") {
  for (const int size : kSizes) {
    CAPTURE(size);
    Arena arena(2 * Soa<Item>::bytes(size));
    const Soa<Item> by_rows = filled(arena, size);
    Soa<Item> by_tiles;
    by_tiles.bind(arena, size);
    for (int i = 0; i < size; i += kWidth) by_tiles.store<Wide>(i, tile(i));
    int wrong = 0;
    for (int i = 0; i < size; ++i) {
      wrong += !equal(by_rows.load<Scalar>(i), item(i)) || !equal(by_tiles.load<Scalar>(i), item(i));
      const Item<Wide> loaded = by_rows.load<Wide>(i / kWidth * kWidth);
      const int lane = i % kWidth;
      wrong += loaded.position.z[lane] != item(i).position.z || loaded.id[lane] != item(i).id ||
               loaded.color.c3[lane] != item(i).color.c3 || loaded.weight[lane] != item(i).weight;
    }
    CHECK(wrong == 0);
    CHECK(arena.used() <= arena.size());
    CHECK(by_rows.capacity() == size);
  }
}

TEST_CASE("soa: columns are aligned and an odd number of cache lines apart") {
  for (const int size : {1, 256, 960, 979, 1000, 1024, 1984, 4096, 1 << 14}) {
    Arena arena(Soa<Item>::bytes(size));
    const Soa<Item> items = filled(arena, size);
    const auto begin = [](const void* p) { return reinterpret_cast<std::uintptr_t>(p); };
    const auto& columns = items.columns();
    CHECK(begin(columns.position.x) % kSimdAlignment == 0);
    CHECK(begin(columns.id) % kSimdAlignment == 0);
    const std::size_t stride = begin(columns.position.y) - begin(columns.position.x);
    CHECK(stride % kSimdAlignment == 0);
    CHECK(stride / kSimdAlignment % 2 == 1);
    CHECK(stride >= static_cast<std::size_t>(size + kWidth) * sizeof(float));
    CHECK(begin(columns.weight) - begin(columns.position.x) == 8 * stride);
    // Nine columns start in nine different sets of a cache with 64 sets.
    std::set<std::uintptr_t> sets;
    for (std::uintptr_t k = 0; k < 9; ++k) sets.insert((begin(columns.position.x) + k * stride) / 64 % 64);
    CHECK(sets.size() == 9);
  }
}

TEST_CASE("soa: a tile written at the end of a column leaves the next column unchanged") {
  const int size = kWidth + 1;
  Arena arena(Soa<Item>::bytes(size));
  Soa<Item> items = filled(arena, size);
  items.store<Wide>(kWidth, tile(100));
  CHECK(equal(items.load<Scalar>(0), item(0)));
  CHECK(equal(items.load<Scalar>(kWidth), item(100)));
}

TEST_CASE("soa: compress keeps the selected rows in order for every mask") {
  const int size = 4 * kWidth;
  Arena arena(2 * Soa<Item>::bytes(size));
  Soa<Item> target = filled(arena, size), one_by_one;
  one_by_one.bind(arena, size);
  const Item<Wide> source = tile(500);
  int wrong = 0;
  for (std::uint32_t bits = 0; bits<1u << kWidth; bits += kWidth> 8 ? 37 : 1) {
    const int start = static_cast<int>(bits % 5);
    const int count =
        target.compress<Wide>(start, source, wide_mask([bits](int lane) { return (bits >> lane & 1u) != 0; }));
    wrong += count != std::popcount(bits);
    int next = start;
    for (int lane = 0; lane < kWidth; ++lane)
      if (bits >> lane & 1u) wrong += !equal(target.load<Scalar>(next++), item(500 + lane));
    next = start;
    for (int lane = 0; lane < kWidth; ++lane)
      next += one_by_one.compress<Scalar>(next, item(500 + lane), (bits >> lane & 1u) != 0);
    wrong += next != start + count;
    for (int i = start; i < next; ++i) wrong += !equal(target.load<Scalar>(i), one_by_one.load<Scalar>(i));
    for (int i = 0; i < start; ++i) target.store<Scalar>(i, item(i));
  }
  CHECK(wrong == 0);
}

TEST_CASE("soa: a compaction loop over any number of rows keeps exactly the selected ones") {
  for (const int size : kSizes) {
    CAPTURE(size);
    Arena arena(2 * Soa<Item>::bytes(size));
    const Soa<Item> source = filled(arena, size);
    Soa<Item> target;
    target.bind(arena, size);
    int kept = 0;
    for (int i = 0; i < size; i += kWidth) {
      const Item<Wide> rows = source.load<Wide>(i);
      const WideMask third = wide_mask([i](int lane) { return (i + lane) % 3 == 0; });
      kept += target.compress<Wide>(kept, rows, third & Wide::first(std::min(kWidth, size - i)));
    }
    CHECK(kept == (size + 2) / 3);
    int wrong = 0;
    for (int i = 0; i < kept; ++i) wrong += !equal(target.load<Scalar>(i), item(3 * i));
    CHECK(wrong == 0);
  }
}

}  // namespace sheaf::test_soa
