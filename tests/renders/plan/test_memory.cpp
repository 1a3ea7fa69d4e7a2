// Peak memory of a render.
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>

namespace sheaf::test_memory {

namespace {

/// Peak bytes of heap and stacks of a render of 800 x 600 pixels, as reported by --stats. Shared libraries do not
/// count.
double peak_bytes(int samples, int threads) {
  const TemporaryFolder folder;
  const std::string command = "cd '" + folder.path().string() +
                              "' && '" SHEAF_EXECUTABLE "' render '" SHEAF_SOURCE_DIR
                              "/scenes/cornell/cornell.xml' -D width=800 -D height=600 -o out.exr -o out.png --quiet"
                              " --stats stats.json --max-depth 2 --spp " +
                              std::to_string(samples) + " --threads " + std::to_string(threads) + " >/dev/null 2>&1";
  REQUIRE(std::system(command.c_str()) == 0);
  const auto stats = nlohmann::json::parse(read_bytes(folder / "stats.json"));
  REQUIRE(stats.at("width") == 800);
  REQUIRE(stats.at("height") == 600);
  return stats.at("peak_private_bytes").get<double>();
}

}  // namespace

TEST_SUITE("slow") {
  TEST_CASE("an image of 800 x 600 pixels takes less than 130 MB at any sample count") {
    const double few = peak_bytes(1, 2), more = peak_bytes(5, 2);
    CHECK(few > 20e6);
    CHECK(few < 130e6);
    CHECK(more < 130e6);
    CHECK(more < few + 10e6);
    CHECK(peak_bytes(1, 16) < 130e6);
  }
}

}  // namespace sheaf::test_memory
