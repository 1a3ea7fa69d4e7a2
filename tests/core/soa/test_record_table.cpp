// Tables of records with lookup by index.
#include "core/math/vec.h"
#include "core/soa/record_table.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_record_table {

namespace {

enum class Kind : std::uint32_t { kNone, kSome, kMany };

template <class L> struct alignas(row_alignment<L>(64)) Row {
  EnumIn<L, Kind> kind;
  Vec3<L> row;
  typename L::Float values[9];
  typename L::Uint pair[2];
  typename L::Uint last;
  static constexpr auto fields(auto& s) { return std::tie(s.kind, s.row, s.values, s.pair, s.last); }
};
static_assert(sizeof(Row<Scalar>) == 64 && alignof(Row<Scalar>) == 64 && kLeafCount<Row> == 16);

std::vector<Row<Scalar>> make_table(std::uint32_t size) {
  std::vector<Row<Scalar>> table;
  for (std::uint32_t i = 0; i < size; ++i) {
    const auto x = static_cast<float>(i);
    table.push_back({static_cast<Kind>(i % 3), {x, x + 0.25f, x + 0.5f}, {}, {i + 1000u, i + 2000u}, ~i});
    for (int k = 0; k < 9; ++k) table.back().values[k] = x * 100 + static_cast<float>(k);
  }
  return table;
}

template <class T> auto lane_value(const T& value, int lane) {
  if constexpr (requires { value[lane]; })
    return value[lane];
  else
    return value;
}

template <class L> void check_gathers() {
  const auto table = make_table(100);
  alignas(kSimdAlignment) std::uint32_t rows[kWidth];
  for (std::uint32_t lane = 0; lane < kWidth; ++lane) rows[lane] = (lane * 37u + 99u) % 100u;
  Uint<L> index;
  load(rows, index);
  const Row<L> got = gather_rows<L>(table.data(), index);
  const Vec3<L> row = gather_member<L>(table.data(), &Row<Scalar>::row, index);
  Float<L> four[4];
  gather_four<L>(table.data(), &Row<Scalar>::values, 5, index, four);
  for (int lane = 0; lane < L::width; ++lane) {
    const Row<Scalar>& want = table[rows[lane]];
    const auto number = static_cast<std::uint32_t>(want.kind);
    CHECK(static_cast<std::uint32_t>(lane_value(got.kind, lane)) == number);
    CHECK(lane_value(gather_member<L>(table.data(), &Row<Scalar>::kind, index), lane) == number);
    CHECK(lane_value(got.row.y, lane) == want.row.y);
    CHECK(lane_value(row.x, lane) == want.row.x);
    CHECK(lane_value(row.z, lane) == want.row.z);
    for (int k = 0; k < 9; ++k) CHECK(lane_value(got.values[k], lane) == want.values[k]);
    for (int k = 0; k < 4; ++k) CHECK(lane_value(four[k], lane) == want.values[5 + k]);
    CHECK(lane_value(got.pair[1], lane) == want.pair[1]);
    CHECK(lane_value(gather_element<L>(table.data(), &Row<Scalar>::pair, 0, index), lane) == want.pair[0]);
    CHECK(lane_value(gather_element<L>(table.data(), &Row<Scalar>::pair, 1, index), lane) == want.pair[1]);
    CHECK(lane_value(got.last, lane) == want.last);
    CHECK(lane_value(gather_member<L>(table.data(), &Row<Scalar>::last, index), lane) == want.last);
  }
}

}  // namespace

TEST_CASE("rows and members of a record table are gathered into the lanes that ask for them") {
  check_gathers<Scalar>();
  check_gathers<Wide>();
}

TEST_CASE("triples of a record table are gathered into the lanes that ask for them") {
  std::vector<std::uint32_t> table;
  for (std::uint32_t i = 0; i < 3 * 50 + 1; ++i) table.push_back(7 * i);
  alignas(kSimdAlignment) std::uint32_t rows[kWidth];
  for (std::uint32_t lane = 0; lane < kWidth; ++lane) rows[lane] = 49u - lane % 50u;
  WideUint index;
  load(rows, index);
  const auto wide = gather_triple<Wide>(table.data(), index);
  for (int lane = 0; lane < kWidth; ++lane) {
    const auto one = gather_triple<Scalar>(table.data(), rows[lane]);
    for (std::uint32_t k = 0; k < 3; ++k) {
      CHECK(one[k] == 7 * (3 * rows[lane] + k));
      CHECK(wide[k][lane] == one[k]);
    }
  }
}

}  // namespace sheaf::test_record_table
