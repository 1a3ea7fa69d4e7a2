// Exposure, tone maps and OpenColorIO views of whole images.
#include "core/color/color.h"
#include "core/image/display_transform.h"
#include "tests/support/contains.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

namespace sheaf::test_display_transform {

using test::contains;

namespace {

Image image_of(std::vector<std::string> channels, std::vector<float> pixels) {
  const auto width = static_cast<int>(pixels.size() / channels.size());
  Image image(width, 1, std::move(channels));
  image.data = std::move(pixels);
  return image;
}

DisplayTransform transform(std::optional<double> exposure, ToneMap map = ToneMap::kClamp) {
  DisplaySettings settings;
  settings.exposure = exposure;
  settings.tone_map = map;
  return DisplayTransform(settings);
}

/// A configuration whose only view inverts colors: display = 1 - 0.5 scene.
constexpr const char* kConfig = R"(ocio_profile_version: 2
search_path: ""
roles: {default: scene, scene_linear: scene}
displays:
  tiny:
    - !<View> {name: inverted, colorspace: negative}
    - !<View> {name: plain, colorspace: scene}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: scene
  - !<ColorSpace>
    name: negative
    from_scene_reference: !<MatrixTransform> {matrix: [-0.5, 0, 0, 0, 0, -0.5, 0, 0, 0, 0, -0.5, 0, 0, 0, 0, 1], offset: [1, 1, 1, 0]}
)";

}  // namespace

TEST_CASE("display: exposure scales colors by powers of two, and nothing else") {
  const Image image = image_of({"A", "R", "G", "B", "Z"}, {0.5f, 1, 2, 3, 9, 1, 0.1f, 0.2f, 0.4f, 9});
  const Image out = transform(-2).apply(image);
  CHECK(out.channels == std::vector<std::string>{"R", "G", "B", "A"});
  CHECK(out.data == std::vector<float>{0.25f, 0.5f, 0.75f, 0.5f, 0.025f, 0.05f, 0.1f, 1});
  CHECK(transform(0).is_identity());
  CHECK_FALSE(transform(-2).is_identity());
  CHECK_FALSE(transform(0, ToneMap::kAgx).is_identity());
  CHECK_FALSE(transform(std::nullopt).is_identity());
}

TEST_CASE("display: automatic exposure brings the log-average luminance to middle gray") {
  // The geometric mean of 0.02, 2 and 20 is 0.2^(1/3) x ... = (0.8)^(1/3).
  const Image image = image_of({"R", "G", "B"}, {0.02f, 0.02f, 0.02f, 2, 2, 2, 20, 20, 20, 0, 0, 0});
  const double expected = std::log2(0.18 / std::cbrt(0.8));
  CHECK(auto_exposure(image) == near(expected, 1e-5));
  CHECK(transform(std::nullopt).exposure_of(image) == near(expected, 1e-5));
  CHECK(transform(std::nullopt).apply(image).data[3] == near(2 * std::exp2(expected), 1e-5));
  // Colors count by their luminance, and behind alpha by their straight value.
  CHECK(auto_exposure(image_of({"R", "G", "B"}, {0, 0.5f, 0})) ==
        near(std::log2(0.18 / static_cast<double>(luminance({0, 0.5f, 0}))), 1e-5));
  CHECK(auto_exposure(image_of({"R", "G", "B", "A"}, {0.1f, 0.1f, 0.1f, 0.25f, 0, 0, 0, 0})) ==
        near(std::log2(0.18 / 0.4), 1e-4));
  // Images without light, or with invalid values
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  CHECK(auto_exposure(image_of({"R", "G", "B"}, {0, 0, 0, -1, -1, -1, nan, nan, nan, inf, inf, inf})) == 0.0);
}

TEST_CASE("display: tone maps act on straight colors and keep alpha") {
  for (const ToneMap map : {ToneMap::kFilmic, ToneMap::kAces, ToneMap::kAgx}) {
    const Image opaque = transform(1, map).apply(image_of({"R", "G", "B"}, {0.4f, 0.2f, 0.1f}));
    const Image half = transform(1, map).apply(image_of({"R", "G", "B", "A"}, {0.2f, 0.1f, 0.05f, 0.5f}));
    for (std::size_t c = 0; c < 3; ++c) CHECK(half.data[c] == near(0.5f * opaque.data[c], 1e-3));
    CHECK(half.data[3] == 0.5f);
    const Vec3f expected = tone_mapped(map, {0.8f, 0.4f, 0.2f});
    CHECK(opaque.data == std::vector<float>{expected.x, expected.y, expected.z});
    // Gray images, and light without alpha
    CHECK(transform(0, map).apply(image_of({"Y"}, {0.3f})).data[0] == near(tone_mapped(map, {0.3f, 0.3f, 0.3f}).x));
    const Image glow = transform(0, map).apply(image_of({"R", "G", "B", "A"}, {0.5f, 0, 0, 0, 0, 0, 0, 0}));
    CHECK(glow.data[3] == 0.5f);
    CHECK(glow.data[7] == 0.0f);
  }
}

TEST_CASE("display: views of OpenColorIO configurations") {
  std::string problem;
  if (!open_display_view({"raw", "", ""}, problem)) {
    CHECK(contains(problem, "lacks OpenColorIO"));
    return;
  }
  const TemporaryFolder folder;
  const std::string file = (folder / "tiny.ocio").string();
  write_bytes(folder / "tiny.ocio", kConfig);
  const auto displayed = [&](const DisplayView& view, std::vector<float> pixels) {
    DisplaySettings settings;
    settings.display_view = open_display_view(view, problem);
    REQUIRE_MESSAGE(settings.display_view, problem);
    return DisplayTransform(settings).apply(image_of({"R", "G", "B"}, std::move(pixels))).data;
  };
  // The encoder applies the sRGB curve to the result, which gives the values of the view.
  const std::vector<float> inverted = displayed({file, "", ""}, {0.5f, 1, 0, 4, -1, 0.2f});
  const float expected[] = {0.75f, 0.5f, 1, 0, 1, 0.9f};
  for (std::size_t i = 0; i < 6; ++i) CHECK(linear_to_srgb(inverted[i]) == near(expected[i], 1e-4));
  const std::vector<float> plain = displayed({file, "TINY", "Plain"}, {0.5f, 0.25f, 0.125f});
  CHECK(linear_to_srgb(plain[1]) == near(0.25, 1e-4));
  CHECK(linear_to_srgb(displayed({"raw", "", ""}, {0.5f, 0.25f, 0.125f})[0]) == near(0.5, 1e-4));
}

TEST_CASE("display: errors in OpenColorIO configurations") {
  std::string problem;
  if (!open_display_view({"raw", "", ""}, problem)) return;
  const TemporaryFolder folder;
  const auto problem_of = [&](const DisplayView& view) {
    problem.clear();
    CHECK(open_display_view(view, problem) == nullptr);
    return problem;
  };
  const std::string file = (folder / "tiny.ocio").string();
  write_bytes(folder / "tiny.ocio", kConfig);
  CHECK(contains(problem_of({file, "", "vivid"}), "unknown view 'vivid' (known: inverted, plain)"));
  CHECK(contains(problem_of({file, "cinema", ""}), "unknown display 'cinema' (known: tiny)"));
  CHECK_FALSE(problem_of({(folder / "none.ocio").string(), "", ""}).empty());
  write_bytes(folder / "bad.ocio", "ocio_profile_version: 2\ncolorspaces: 7\n");
  CHECK_FALSE(problem_of({(folder / "bad.ocio").string(), "", ""}).empty());
  write_bytes(folder / "noise.ocio", std::string("\x01\xff\0{[", 5));
  CHECK_FALSE(problem_of({(folder / "noise.ocio").string(), "", ""}).empty());
}

}  // namespace sheaf::test_display_transform
