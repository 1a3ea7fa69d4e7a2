// Records of tables: the memory layout matches the order of fields().
#include "kernels/wave/path_state.h"
#include "scene/tables/scene_view.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_records {

namespace {

/// Whether leaf k of a record is its word k, as gather_rows() and SlotTable assume.
template <template <class> class Record> bool fields_in_order() {
  Record<Scalar> row{};
  const auto* next = reinterpret_cast<const unsigned char*>(&row);
  bool in_order = true;
  std::apply(
      [&](const auto&... leaf) {
        ((in_order = in_order && reinterpret_cast<const unsigned char*>(&leaf) == next, next += sizeof(leaf)), ...);
      },
      leaves(row));
  return in_order;
}

}  // namespace

TEST_CASE("records: fields are ordered like their members") {
  CHECK(fields_in_order<ShapeRecord>());
  CHECK(fields_in_order<VertexRecord>());
  CHECK(fields_in_order<QuadricRecord>());
  CHECK(fields_in_order<InstanceRecord>());
  CHECK(fields_in_order<AttributeRecord>());
  CHECK(fields_in_order<RayState>());
  CHECK(fields_in_order<HitState>());
  CHECK(fields_in_order<PathState>());
  CHECK(fields_in_order<RadianceState>());
  CHECK(fields_in_order<RescaledPdfs>());
}

TEST_CASE("records: quadrics are gathered into the lanes that ask for them") {
  std::vector<QuadricRow> table;
  for (std::uint32_t i = 0; i < 40; ++i) {
    QuadricRow row{};
    for (int k = 0; k < 12; ++k) {
      row.to_world[k] = static_cast<float>(100 * i) + static_cast<float>(k);
      row.to_object[k] = -row.to_world[k];
    }
    row.uniform_scale = 0.5f * static_cast<float>(i);
    row.kind = i % 2 == 0 ? ShapeKind::kSphere : ShapeKind::kCylinder;
    table.push_back(row);
  }
  alignas(kSimdAlignment) std::uint32_t rows[kWidth];
  for (std::uint32_t lane = 0; lane < kWidth; ++lane) rows[lane] = (lane * 7 + 3) % 40;
  WideUint index;
  load(rows, index);
  const QuadricRecord<Wide> wide = gather_rows<Wide>(table.data(), index);
  for (int lane = 0; lane < kWidth; ++lane) {
    const QuadricRow one = gather_rows<Scalar>(table.data(), rows[lane]);
    const QuadricRow& want = table[rows[lane]];
    CHECK(one.kind == want.kind);
    CHECK(wide.kind[lane] == static_cast<std::uint32_t>(want.kind));
    CHECK(one.to_object[11] == want.to_object[11]);
    CHECK(wide.to_object[11][lane] == want.to_object[11]);
    CHECK(wide.to_world[7][lane] == want.to_world[7]);
    CHECK(wide.uniform_scale[lane] == want.uniform_scale);
  }
}

}  // namespace sheaf::test_records
