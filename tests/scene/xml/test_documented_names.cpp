// The names that readers of scenes accept, against the documentation.
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/xml/read_geometry.h"
#include "scene/dialects/xml/read_spectrum.h"
#include "scene/dialects/xml/read_texture.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace sheaf::test_documented_names {

TEST_CASE("the documentation names every shape, texture, spectrum, sampler, integrator and estimator") {
  std::string text;
  for (const auto& page : std::filesystem::directory_iterator(SHEAF_SOURCE_DIR "/docs/scene-format")) {
    std::ifstream file(page.path());
    REQUIRE(file);
    text.append(std::istreambuf_iterator<char>(file), {});
  }
  const auto check = [&](const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      CAPTURE(name);
      CHECK(text.find("`" + name + "`") != std::string::npos);
    }
  };
  check(kSharedShapes.names());
  for (const TexturePlugin& plugin : texture_plugins()) check({plugin.name});
  check(kSpectrumPlugins.names());
  check(kSamplers.names());
  check(kLightSelectors.names());
  check(kMediumEstimators.names());
  check(integrator_names());
}

}  // namespace sheaf::test_documented_names
