// The list of kinds of lights, and the data of each kind in the rows.
#include "scene/lights/list.h"
#include "tests/support/records_testing.h"

#include <doctest/doctest.h>

#include <set>

namespace sheaf::test_light_list {

namespace {

/// The leaves of `Data`, numbered from 1.
template <template <class> class Data> Data<Scalar> numbered() {
  Data<Scalar> data{};
  std::apply(
      [](auto&... leaf) {
        std::uint32_t next = 1;
        ((leaf = static_cast<std::remove_reference_t<decltype(leaf)>>(next++)), ...);
      },
      leaves(data));
  return data;
}

/// Checks that every lane gets the data of its own row back.
template <template <class> class Data> void check_data() {
  LightRow rows[2];
  rows[1].set_data(numbered<Data>());
  const Data<Scalar> expected[2] = {Data<Scalar>{}, numbered<Data>()};
  CHECK(record_difference<Data>(rows[1].data<Data>(), expected[1]) == 0);
  const Data<Wide> wide = gather_rows<Wide>(rows, lane_index() & WideUint(1u)).template data<Data>();
  for (int lane = 0; lane < kWidth; ++lane)
    CHECK(record_difference<Data>(lane_record<Data>(wide, lane), expected[lane % 2]) == 0);
}

}  // namespace

TEST_CASE("light list: rows keep the data of every kind") {
  check_data<MeshLightData>();
  check_data<RectangleLightData>();
  check_data<SphereLightData>();
  check_data<QuadricLightData>();
  check_data<PointLightData>();
  check_data<FramedLightData>();
  check_data<SpotLightData>();
  check_data<ProjectorLightData>();
  check_data<BeamLightData>();
  check_data<DirectionalLightData>();
  check_data<SunLightData>();
  check_data<VolumeLightData>();
}

TEST_CASE("light list: kinds are numbered by their position, and have a table each") {
  CHECK(static_cast<std::uint32_t>(kLightKind<MeshLightKind>) == 0);
  CHECK(static_cast<std::uint32_t>(kLightKind<VolumeLightKind>) == LightKinds::kCount - 1);
  for (const LightCompiler& kind : light_compilers()) {
    CHECK(!std::string(kind.label).empty());
    CHECK((kind.power != nullptr));
    CHECK((kind.bounds != nullptr) == (kind.domain == LightDomain::kBounded));
    CHECK((kind.integral != nullptr) == (kind.integral_key != nullptr));
  }
}

TEST_CASE("light list: no two lights have the same name in files") {
  std::set<std::string_view> names;
  for (const LightReader& reader : light_readers()) CHECK(names.insert(reader.name).second);
  CHECK(names.contains("constant"));
}

TEST_CASE("light list: numbers of cells fit into a word") {
  for (const VolumeCells cells : {VolumeCells{1, 1, 1}, VolumeCells{1023, 1, 1023}, VolumeCells{2, 1023, 3}}) {
    const VolumeCells other = VolumeCells::of_word(cells.word());
    CHECK(other.x == cells.x);
    CHECK(other.y == cells.y);
    CHECK(other.z == cells.z);
  }
}

}  // namespace sheaf::test_light_list
