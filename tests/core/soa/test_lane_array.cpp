// Lanes in memory: registers and records lane by lane, loops over set lanes, rows of tables.
#include "core/soa/lane_array.h"

#include "core/math/vec.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_lane_array {

TEST_CASE("for_each_lane visits the set lanes in ascending order") {
  std::vector<int> lanes;
  for_each_lane(0b101101u, [&](int lane) { lanes.push_back(lane); });
  CHECK(lanes == std::vector<int>{0, 2, 3, 5});
  for_each_lane(0u, [&](int) { FAIL("no lane is set"); });
  lanes.clear();
  for_each_lane(mask_bits(WideMask(true)), [&](int lane) { lanes.push_back(lane); });
  CHECK(lanes.size() == kWidth);
}

TEST_CASE("a register keeps its bits in memory") {
  const WideUint bits = wide_uints([](int lane) { return 0x7f800001u + static_cast<std::uint32_t>(lane); });
  LaneArray<WideFloat> floats(bits_float(bits));
  const LaneArray<WideUint> uints(bits);
  CHECK(LaneArray<WideFloat>::kLanes == kWidth);
  for (int lane = 0; lane < kWidth; ++lane) CHECK(uints[lane] == 0x7f800001u + static_cast<std::uint32_t>(lane));
  CHECK(all(float_bits(floats.load()) == bits));
  floats[kWidth - 1] = 2.0f;
  const WideFloat changed = floats.load();
  for (int lane = 0; lane < kWidth - 1; ++lane) CHECK(float_bits(changed[lane]) == uints[lane]);
  CHECK(changed[kWidth - 1] == 2.0f);
  std::uint32_t lane = 0;
  for (const std::uint32_t value : uints) CHECK(value == 0x7f800001u + lane++);
  CHECK(lane == kWidth);
}

TEST_CASE("one lane of scalar code") {
  LaneArray<float> one(3.0f);
  CHECK(LaneArray<float>::kLanes == 1);
  CHECK(one[0] == 3.0f);
  one[0] = 4.0f;
  CHECK(one.load() == 4.0f);
  CHECK(make_lanes<std::uint32_t>([](int lane) { return static_cast<std::uint32_t>(lane) + 7u; }) == 7u);
}

TEST_CASE_TEMPLATE("records row by row", L, Scalar, Wide) {
  const auto x = make_lanes<Float<L>>([](int lane) { return static_cast<float>(lane); });
  LaneRows<L, Vec3> rows(Vec3<L>{x, x + Float<L>(100.0f), x + Float<L>(200.0f)});
  for (int lane = 0; lane < L::width; ++lane) {
    const auto number = static_cast<float>(lane);
    CHECK(rows[lane] == Vec3f{number, number + 100.0f, number + 200.0f});
  }
  rows.set(L::width - 1, {1.0f, 2.0f, 3.0f});
  const Vec3<L> changed = rows.load();
  const LaneArray<Float<L>> z(changed.z);
  CHECK(z[L::width - 1] == 3.0f);
  if (L::width > 1) CHECK(z[0] == 200.0f);
}

TEST_CASE_TEMPLATE("rows of a table, four words at a time", L, Scalar, Wide) {
  struct Row {
    float words[8];
  };
  std::vector<Row> table(100);
  for (std::size_t i = 0; i < table.size(); ++i)
    for (std::size_t k = 0; k < 8; ++k) table[i].words[k] = static_cast<float>(8 * i + k);
  const auto index = make_lanes<Uint<L>>([](int lane) { return static_cast<std::uint32_t>(99 - 5 * lane); });
  RowPointers<L> rows(table.data(), index);
  for (int first = 0; first < 8; first += 4) {
    Float<L> words[4];
    rows.read_four(words);
    for (int k = 0; k < 4; ++k) {
      const LaneArray<Float<L>> word(words[k]);
      for (int lane = 0; lane < L::width; ++lane)
        CHECK(word[lane] == static_cast<float>(8 * (99 - 5 * lane) + first + k));
    }
  }
}

}  // namespace sheaf::test_lane_array
