// Signs of numbers in OFF files.
#include "scene/formats/off.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_off_numbers {

using namespace test;

TEST_CASE("off: numbers may have a plus sign, but not two signs") {
  const TemporaryFolder folder;
  const auto off = [&](const std::string& number) {
    return write_below(folder, "model.off", "OFF\n3 +1 0\n0 0 0\n" + number + " 0 0\n0 +1 0\n3 0 +1 2\n");
  };
  const Mesh mesh = read_off(off("+2.5e+00")).mesh;
  REQUIRE(mesh.positions.size() == 3);
  CHECK(mesh.positions[1].x == 2.5f);
  CHECK(mesh.positions[2].y == 1);
  CHECK(mesh.triangles.size() == 1);
  for (const char* const number : {"+-2", "++2", "-+2", "+"})
    CHECK(contains(error_of(off(number)), std::string("model.off:4: '") + number + "' is not a number"));
}

}  // namespace sheaf::test_off_numbers
