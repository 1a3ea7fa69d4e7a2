// The table of layers in docs/layers.md against the list in the code.
#include "kernels/film/aovs.h"

#include <doctest/doctest.h>

#include <fstream>
#include <iterator>

namespace sheaf::test_layer_docs {

TEST_CASE("docs/layers.md lists every layer with its channels, storage and contents") {
  std::ifstream file(SHEAF_SOURCE_DIR "/docs/layers.md");
  REQUIRE(file);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const AovEntry& entry : kAovList) {
    std::string line = "\n| `" + std::string(entry.name) + "` | ";
    for (const std::string_view channel : entry.channels)
      if (!channel.empty()) line += "`" + std::string(channel) + "` ";
    if (entry.name.starts_with("cryptomatte")) line += "... ";
    line += std::string("| ") + (entry.type == PixelType::kHalf ? "16" : "32") + " bits | ";
    line += std::string(entry.description) + " |\n";
    CAPTURE(line);
    CHECK(text.find(line) != std::string::npos);
  }
}

}  // namespace sheaf::test_layer_docs
