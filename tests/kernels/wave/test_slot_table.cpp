// Slot tables: round trips through registers, partial tiles and unchanged neighbors.
#include "kernels/wave/slot_table.h"

#include "core/math/vec.h"
#include "core/sampling/rng.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace sheaf::test_slot_table {

namespace {

template <class L> struct Half {
  Vec3<L> origin, direction;
  typename L::Float t_max;
  typename L::Uint flags;
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.direction, s.t_max, s.flags); }
};

template <class L> struct Whole {
  Half<L> first, second;
  static constexpr auto fields(auto& s) { return std::tie(s.first, s.second); }
};

/// A value for every word of every row. The eighth word of each half is an integer with the bits of a signaling NaN.
std::uint32_t word_of(int row, int word) {
  const auto value = static_cast<std::uint32_t>(row * 16 + word);
  return word % 8 == 7 ? 0x7f800001u + value : float_bits(static_cast<float>(value));
}

/// The bytes of a row.
template <class AnyGroups> auto* bytes_of(AnyGroups& groups, int row) {
  using Byte = std::conditional_t<std::is_const_v<AnyGroups>, const unsigned char, unsigned char>;
  return reinterpret_cast<Byte*>(&groups.row(static_cast<Slot>(row)));
}

template <template <class> class Record> void fill(SlotTable<Record>& groups, int rows) {
  for (int row = 0; row < rows; ++row)
    for (int word = 0; word < SlotTable<Record>::kWords; ++word) {
      const std::uint32_t bits = word_of(row, word);
      std::memcpy(bytes_of(groups, row) + 4 * word, &bits, sizeof bits);
    }
}

/// Whether row `row` holds the values that fill() stored in row `source`.
template <template <class> class Record> bool holds(const SlotTable<Record>& groups, int row, int source) {
  for (int word = 0; word < SlotTable<Record>::kWords; ++word) {
    const std::uint32_t expected = word_of(source, word);
    if (std::memcmp(bytes_of(groups, row) + 4 * word, &expected, sizeof expected) != 0) return false;
  }
  return true;
}

/// Slots 0 .. rows - 1, shuffled.
std::vector<Slot> shuffled(int rows) {
  std::vector<Slot> slots(static_cast<std::size_t>(rows));
  std::iota(slots.begin(), slots.end(), Slot{0});
  const auto key = [](Slot s) { return random4<Scalar>(9, s, 0, 0).x; };
  std::sort(slots.begin(), slots.end(), [&](Slot a, Slot b) { return key(a) < key(b); });
  return slots;
}

template <template <class> class Record> void gather_matches_rows() {
  constexpr int kRows = 5 * kWidth;
  Arena arena(SlotTable<Record>::bytes(kRows));
  SlotTable<Record> groups;
  groups.bind(arena, kRows);
  fill(groups, kRows);
  const std::vector<Slot> slots = shuffled(kRows);
  int wrong = 0;
  for (int i = 0; i < kRows; i += kWidth) {
    const Record<Wide> tile = groups.template gather<Wide>(slots.data() + i);
    const auto flat = leaves(tile);
    std::apply(
        [&](const auto&... leaf) {
          int word = 0;
          const auto check = [&](const auto& l) {
            for (int lane = 0; lane < kWidth; ++lane) {
              const auto value = l[lane];
              const std::uint32_t expected = word_of(slots[static_cast<std::size_t>(i + lane)], word);
              wrong += std::memcmp(&value, &expected, sizeof expected) != 0;
            }
            ++word;
          };
          (check(leaf), ...);
        },
        flat);
  }
  CHECK(wrong == 0);
}

template <template <class> class Record> void scatter_touches_only_its_rows() {
  constexpr int kRows = 3 * kWidth;
  Arena arena(2 * SlotTable<Record>::bytes(kRows));
  SlotTable<Record> source, target;
  source.bind(arena, kRows);
  target.bind(arena, kRows);
  fill(source, kRows);
  const std::vector<Slot> from = shuffled(kRows);
  std::vector<Slot> to = from;
  std::reverse(to.begin(), to.end());
  for (int count = 0; count <= kWidth; ++count) {
    CAPTURE(count);
    fill(target, kRows);
    target.template scatter<Wide>(to.data(), count, source.template gather<Wide>(from.data()));
    int wrong = 0;
    for (int lane = 0; lane < kRows; ++lane) {
      const auto n = static_cast<std::size_t>(lane);
      wrong += !holds(target, to[n], lane < count ? from[n] : to[n]);
    }
    CHECK(wrong == 0);
  }
}

}  // namespace

TEST_CASE("slot table: gather transposes rows of 8 and 16 words into registers") {
  gather_matches_rows<Half>();
  gather_matches_rows<Whole>();
}

TEST_CASE("slot table: scatter writes the rows of its active lanes only") {
  scatter_touches_only_its_rows<Half>();
  scatter_touches_only_its_rows<Whole>();
}

TEST_CASE("slot table: rows are aligned to their size") {
  Arena arena(SlotTable<Whole>::bytes(3) + SlotTable<Half>::bytes(3));
  SlotTable<Whole> whole;
  SlotTable<Half> half;
  whole.bind(arena, 3);
  half.bind(arena, 3);
  CHECK(reinterpret_cast<std::uintptr_t>(&whole.row(1)) % 64 == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(&half.row(1)) % 32 == 0);
}

TEST_CASE("slot table: get and set access one row") {
  constexpr int kRows = 4;
  Arena arena(SlotTable<Half>::bytes(kRows));
  SlotTable<Half> groups;
  groups.bind(arena, kRows);
  fill(groups, kRows);
  Half<Scalar> row = groups.get(2);
  CHECK(row.origin.x == 32.0f);
  CHECK(row.t_max == 38.0f);
  CHECK(row.flags == word_of(2, 7));
  row.flags = 5;
  row.direction.y = -1.0f;
  groups.set(1, row);
  CHECK(groups.get(1).flags == 5u);
  CHECK(groups.get(1).direction.y == -1.0f);
  CHECK(groups.get(1).origin.x == 32.0f);
  CHECK(holds(groups, 0, 0));
  CHECK(holds(groups, 2, 2));
}

TEST_CASE("slot table: members of a row can be accessed in place") {
  constexpr int kRows = 4;
  Arena arena(SlotTable<Whole>::bytes(kRows));
  SlotTable<Whole> groups;
  groups.bind(arena, kRows);
  fill(groups, kRows);
  const SlotTable<Whole>& reader = groups;
  CHECK(reader.row(2).second.direction.y == 32.0f + 12.0f);
  CHECK(reader.row(2).second.flags == word_of(2, 15));
  groups.row(2).second.flags = 7;
  groups.row(2).first.origin.z = -2.0f;
  CHECK(groups.get(2).second.flags == 7u);
  CHECK(groups.get(2).first.origin.z == -2.0f);
  CHECK(groups.get(2).first.origin.y == 33.0f);
  CHECK(holds(groups, 1, 1));
  CHECK(holds(groups, 3, 3));
}

TEST_CASE("slot table: a padded list of any length gathers and scatters every row once") {
  constexpr int kRows = 2 * kWidth + 3;
  for (const int count : {0, 1, kWidth - 1, kWidth, kWidth + 1, kRows}) {
    CAPTURE(count);
    Arena arena(SlotTable<Half>::bytes(kRows) + SlotList::bytes(kRows));
    SlotTable<Half> groups;
    groups.bind(arena, kRows);
    SlotList list;
    list.bind(arena, kRows);
    fill(groups, kRows);
    const std::vector<Slot> order = shuffled(kRows);
    for (int i = 0; i < count; ++i) list.push(order[static_cast<std::size_t>(i)]);
    list.pad();
    for_tiles<Wide>(list.size(), [&](int begin, int n) {
      Half<Wide> tile = groups.gather<Wide>(list.data() + begin);
      tile.t_max += WideFloat(1000.0f);
      groups.scatter<Wide>(list.data() + begin, n, tile);
    });
    int wrong = 0;
    for (int i = 0; i < kRows; ++i) {
      const Slot slot = order[static_cast<std::size_t>(i)];
      wrong += groups.get(slot).t_max != bits_float(word_of(slot, 6)) + (i < count ? 1000.0f : 0.0f);
    }
    CHECK(wrong == 0);
  }
}

}  // namespace sheaf::test_slot_table
