// The color space of images in OpenColorIO configurations: by name, or by the interchange space ACES2065-1.
#include "core/color/color.h"
#include "core/color/color_space.h"
#include "core/image/display_transform.h"
#include "tests/support/contains.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_aces_interchange {

namespace {

const RgbChromaticities kAces{{0.7347, 0.2653}, {0, 1}, {0.0001, -0.0770}, {0.32168, 0.33767}};

/// Linear Rec.709 to ACES2065-1 with the Bradford transform (Lam 1985) between the white points.
Matrix3 rec709_to_aces() {
  const Matrix3 bradford{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
  const auto from = bradford * xyz_of(kRec709Space.white), to = bradford * xyz_of(kAces.white);
  const Matrix3 scale{{{to[0] / from[0], 0, 0}, {0, to[1] / from[1], 0}, {0, 0, to[2] / from[2]}}};
  return inverse(rgb_to_xyz(kAces)) * (inverse(bradford) * (scale * (bradford * rgb_to_xyz(kRec709Space))));
}

/// A configuration whose reference space is ACES2065-1, and whose only view shows its values.
const std::string kConfig = R"(ocio_profile_version: 2
search_path: ""
roles: {default: ACES2065-1, scene_linear: halved, aces_interchange: ACES2065-1}
displays:
  tiny:
    - !<View> {name: plain, colorspace: ACES2065-1}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: ACES2065-1
  - !<ColorSpace>
    name: halved
    to_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
)";

/// Values of the view for one pixel.
std::array<float, 3> displayed(const std::string& config, Vec3f color) {
  const TemporaryFolder folder;
  write_bytes(folder / "tiny.ocio", config);
  std::string problem;
  DisplaySettings settings;
  settings.display_view = open_display_view({(folder / "tiny.ocio").string(), "", ""}, problem);
  REQUIRE_MESSAGE(settings.display_view, problem);
  Image image(1, 1, {"R", "G", "B"});
  image.data = {color.x, color.y, color.z};
  const Image out = DisplayTransform(settings).apply(image);
  return {linear_to_srgb(out.data[0]), linear_to_srgb(out.data[1]), linear_to_srgb(out.data[2])};
}

bool has_opencolorio() {
  std::string problem;
  const bool has = open_display_view({"raw", "", ""}, problem) != nullptr;
  if (!has) CHECK(test::contains(problem, "lacks OpenColorIO"));
  return has;
}

}  // namespace

TEST_CASE("display: images are converted to ACES2065-1 where a configuration has it as interchange space") {
  if (!has_opencolorio()) return;
  const Matrix3 matrix = rec709_to_aces();
  for (const Vec3f color : {Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}, Vec3f{0.8f, 0.1f, 0.4f}}) {
    CAPTURE(color.x);
    CAPTURE(color.y);
    const auto expected = matrix * std::array<double, 3>{color.x, color.y, color.z};
    const std::array<float, 3> found = displayed(kConfig, color);
    for (std::size_t c = 0; c < 3; ++c) CHECK(found[c] == near(expected[c], 1e-4));
  }
  for (const float value : displayed(kConfig, {1, 1, 1})) CHECK(value == near(1, 1e-4));
}

TEST_CASE("display: a linear Rec.709 space of the configuration precedes the interchange space and scene_linear") {
  if (!has_opencolorio()) return;
  for (const std::string name : {"lin_rec709", "Linear Rec.709 (sRGB)", "Utility - Linear - sRGB", "lin_srgb"}) {
    CAPTURE(name);
    const std::string named = kConfig + "  - !<ColorSpace>\n    name: " + name +
                              "\n    to_scene_reference: !<MatrixTransform> {matrix: "
                              "[0, 0.75, 0, 0, 0.25, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\n";
    const std::array<float, 3> found = displayed(named, {0.4f, 0.8f, 0.3f});
    CHECK(found[0] == near(0.75 * 0.8, 1e-4));
    CHECK(found[1] == near(0.25 * 0.4, 1e-4));
    CHECK(found[2] == near(0.3, 1e-4));
  }
  // Without either, scene_linear
  std::string text = kConfig;
  const std::string role = ", aces_interchange: ACES2065-1";
  text.erase(text.find(role), role.size());
  CHECK(displayed(text, {0.4f, 0.8f, 0.3f})[1] == near(0.4, 1e-4));
}

}  // namespace sheaf::test_aces_interchange
