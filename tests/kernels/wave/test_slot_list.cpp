// Slot lists and tiles.
#include "kernels/wave/slot_list.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_slot_list {

namespace {
struct Fixture {
  Arena arena{2 * SlotList::bytes(64)};
  SlotList list, other;
  Fixture() {
    list.bind(arena, 64);
    other.bind(arena, 64);
  }
};
std::vector<Slot> contents(const SlotList& list) { return {list.span().begin(), list.span().end()}; }
}  // namespace

TEST_CASE_FIXTURE(Fixture, "slot list: push, pop, resize and clear") {
  CHECK(list.empty());
  for (const Slot slot : {5, 3, 9}) list.push(slot);
  CHECK(contents(list) == std::vector<Slot>{5, 3, 9});
  CHECK(list.pop() == 9);
  CHECK(list.size() == 2);
  CHECK(list[1] == 3);
  list.data()[2] = 7;
  list.resize(3);
  CHECK(contents(list) == std::vector<Slot>{5, 3, 7});
  list.clear();
  CHECK(list.empty());
}

TEST_CASE_FIXTURE(Fixture, "slot list: a masked push keeps lane order, for every mask of a register's lanes") {
  Slot slots[kWidth];
  for (int lane = 0; lane < kWidth; ++lane) slots[lane] = static_cast<Slot>(65521 - 4095 * lane);
  int wrong = 0;
  for (std::uint32_t bits = 0; bits < (std::uint64_t{1} << kWidth); ++bits) {
    list.clear();
    list.push(1);
    list.push(slots, bits);
    list.push(2);
    std::vector<Slot> expected{1};
    for (int lane = 0; lane < kWidth; ++lane)
      if (bits >> lane & 1u) expected.push_back(slots[lane]);
    expected.push_back(2);
    wrong += contents(list) != expected;
  }
  CHECK(wrong == 0);
}

TEST_CASE_FIXTURE(Fixture, "slot list: a masked push of one lane reads no further") {
  const std::vector<Slot> one{7};
  list.push(one.data(), 0);
  CHECK(list.empty());
  list.push(one.data(), 1);
  CHECK(contents(list) == std::vector<Slot>{7});
}

TEST_CASE_FIXTURE(Fixture, "slot list: padding repeats the last slot and is not part of the list") {
  list.pad();
  CHECK(list.empty());
  for (Slot slot = 0; slot < 64; ++slot) list.push(slot);
  other.push(999);
  list.pad();
  CHECK(list.size() == 64);
  for (int i = 0; i < kWidth; ++i) CHECK(list.data()[64 + i] == 63);
  CHECK(contents(other) == std::vector<Slot>{999});
}

TEST_CASE_FIXTURE(Fixture, "slot list: swap exchanges contents") {
  list.push(1);
  other.push(2);
  other.push(3);
  list.swap(other);
  CHECK(contents(list) == std::vector<Slot>{2, 3});
  CHECK(contents(other) == std::vector<Slot>{1});
}

TEST_CASE("for_tiles: every item is covered once and the last tile is partial") {
  for (const int items : {0, 1, kWidth - 1, kWidth, kWidth + 1, 10 * kWidth + 3}) {
    int next = 0, calls = 0;
    for_tiles<Wide>(items, [&](int begin, int count) {
      CHECK(begin == next);
      CHECK(count == std::min(kWidth, items - begin));
      next += count;
      ++calls;
    });
    CHECK(next == items);
    CHECK(calls == (items + kWidth - 1) / kWidth);
  }
  int calls = 0;
  for_tiles<Scalar>(5, [&](int, int count) { calls += count; });
  CHECK(calls == 5);
}

}  // namespace sheaf::test_slot_list
