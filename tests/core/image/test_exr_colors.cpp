// Reading of OpenEXR files as images: channels, parts, windows and color spaces.
#include "core/image/exr_colors.h"

#include "core/image/exr.h"
#include "core/io/error.h"
#include "tests/support/contains.h"
#include "tests/support/files/exr_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <limits>

namespace sheaf::test_exr_colors {

using test::contains;

namespace {

StoredImage read(const std::vector<ExrTestPart>& parts, bool raw = false) {
  const TemporaryFolder folder;
  write_exr_parts(folder / "a.exr", parts);
  return read_stored_image(folder / "a.exr", raw);
}

std::string error_in(const std::vector<ExrTestPart>& parts) {
  try {
    read(parts);
  } catch (const SceneError& error) { return error.what(); }
  return {};
}

/// Checks the channels of the first pixel.
void check_pixel(const StoredImage& image, const std::vector<float>& expected) {
  REQUIRE(image.channels.size() == expected.size());
  for (std::size_t c = 0; c < expected.size(); ++c) CHECK(image.floats.at(c) == near(double{expected[c]}, 1e-5));
}

}  // namespace

TEST_CASE("exr image: red and green and blue are found by all their names and in layers and later parts") {
  const std::vector<float> expected{0.25f, 0.5f, 0.75f};
  const std::map<std::string, float> junk{{"N.X", 9}, {"N.Y", 9}, {"N.Z", 9}, {"Z", 9}, {"albedo.R", 9}};
  const std::array<std::array<const char*, 3>, 6> names{
      {{"R", "G", "B"},
       {"r", "g", "b"},
       {"red", "green", "blue"},
       {"diffuse.R", "diffuse.G", "diffuse.B"},
       {"View Layer.Combined.r", "View Layer.Combined.g", "View Layer.Combined.b"},
       {"diffuse.light.R", "diffuse.light.G", "diffuse.light.B"}}};
  for (const auto& name : names) {
    CAPTURE(name[0]);
    std::map<std::string, float> values{{name[0], 0.25f}, {name[1], 0.5f}, {name[2], 0.75f}};
    check_pixel(read({exr_part(2, 2, values)}), expected);
    values.insert(junk.begin(), junk.end());
    const StoredImage image = read({exr_part(2, 2, values)});
    check_pixel(image, expected);
    CHECK(image.channels == std::vector<std::string>{"R", "G", "B"});
    check_pixel(read({exr_part(2, 2, {{"Z", 9}}, {}, "depth"), exr_part(2, 2, values, {}, "colours")}), expected);
  }
}

TEST_CASE("exr image: root channels precede layers and the layer of the image precedes others") {
  std::map<std::string, float> values;
  for (const char* layer : {"a.", "b.", "Combined."})
    for (const char* channel : {"R", "G", "B"}) values[std::string(layer) + channel] = layer[0] == 'C' ? 0.5f : 9;
  check_pixel(read({exr_part(1, 1, values)}), {0.5f, 0.5f, 0.5f});
  for (const char* channel : {"R", "G", "B"}) values[channel] = 0.25f;
  check_pixel(read({exr_part(1, 1, values)}), {0.25f, 0.25f, 0.25f});
  check_pixel(read({exr_part(1, 1, {{"R", 1}, {"G", 1}, {"B", 1}}, {}, "left"),
                    exr_part(1, 1, {{"R", 9}, {"G", 9}, {"B", 9}}, {}, "right")}),
              {1, 1, 1});
}

TEST_CASE("exr image: alpha belongs to the layer of the colors and is not converted") {
  const std::vector<float> xyz{1, 0, 0, 1, 0, 0, 1 / 3.0f, 1 / 3.0f};
  const std::map<std::string, float> values{{"a.R", 0.2f}, {"a.G", 0.5f}, {"a.B", 0.3f}, {"a.A", 0.125f}, {"A", 9}};
  const StoredImage image = read({exr_part(2, 1, values, xyz)});
  CHECK(image.channels == std::vector<std::string>{"R", "G", "B", "A"});
  REQUIRE(image.floats.size() == 8);
  for (const std::size_t i : {0u, 4u}) {
    CHECK(image.floats[i] == near(-0.27008048));
    CHECK(image.floats[i + 3] == 0.125f);
  }
}

TEST_CASE("exr image: a luminance channel becomes gray") {
  check_pixel(read({exr_part(1, 1, {{"Y", 0.5f}})}), {0.5f});
  check_pixel(read({exr_part(1, 1, {{"y", 0.5f}, {"a", 0.25f}})}), {0.5f, 0.25f});
  check_pixel(read({exr_part(1, 1, {{"height", 0.5f}, {"A", 1}})}), {0.5f, 1});
  check_pixel(read({exr_part(1, 1, {{"Y", 0.5f}, {"albedo.R", 1}, {"albedo.G", 1}, {"N.X", 1}})}), {0.5f});
  check_pixel(read({exr_part(1, 1, {{"bump.V", 0.5f}})}), {0.5f});
}

TEST_CASE("exr image: unknown channels are an error that lists them and never become gray") {
  const std::string expected = "(expected R, G and B, or X, Y and Z, or one channel, optionally with A)";
  for (const std::map<std::string, float>& values :
       {std::map<std::string, float>{{"R", 1}, {"G", 1}},
        {{"Y", 1}, {"Z", 1}},
        {{"Y", 1}, {"RY", 1}, {"BY", 1}},
        {{"N.X", 1}, {"N.Y", 1}, {"N.Z", 1}},
        {{"a.R", 1}, {"a.G", 1}, {"a.B", 1}, {"b.R", 1}, {"b.G", 1}, {"b.B", 1}},
        {{"S0.400,0nm", 1}, {"S0.500,0nm", 1}},
        {{"U", 1}, {"V", 1}, {"A", 1}}}) {
    const std::string message = error_in({exr_part(1, 1, values)});
    CAPTURE(message);
    CHECK(contains(message, "a.exr: no colors among the channels "));
    CHECK(contains(message, expected));
    for (const auto& [name, value] : values) CHECK(contains(message, name));
  }
  CHECK(contains(error_in({exr_part(1, 1, {{"Z", 1}}, {}, "depth"), exr_part(1, 1, {{"id", 1}}, {}, "ids")}),
                 "part 'depth': Z; part 'ids': id"));
  std::map<std::string, float> many;
  for (int i = 0; i < 500; ++i) many["channel" + std::to_string(i)] = 1;
  const std::string message = error_in({exr_part(1, 1, many)});
  CHECK(contains(message, "channel0, channel1, "));
  CHECK(message.size() < 1000);
}

TEST_CASE("exr image: chromaticities and XYZ are converted to Rec.709 unless the image is raw") {
  const std::vector<float> p3{0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f};
  const std::vector<float> aces{0.7347f, 0.2653f, 0, 1, 0.0001f, -0.0770f, 0.32168f, 0.33767f};
  const std::vector<float> xyz{1, 0, 0, 1, 0, 0, 1 / 3.0f, 1 / 3.0f};
  const std::map<std::string, float> rgb{{"R", 0.2f}, {"G", 0.5f}, {"B", 0.3f}},
      tristimulus{{"X", 0.2f}, {"Y", 0.5f}, {"Z", 0.3f}}, small{{"x", 0.2f}, {"y", 0.5f}, {"z", 0.3f}};
  const std::vector<float> of_xyz{-0.27008048f, 0.7566018f, 0.2262289f};
  check_pixel(read({exr_part(1, 1, rgb, aces)}), {-0.16560157f, 0.59936446f, 0.24660677f});
  check_pixel(read({exr_part(1, 1, rgb, xyz)}), of_xyz);
  check_pixel(read({exr_part(1, 1, tristimulus)}), of_xyz);
  check_pixel(read({exr_part(1, 1, small)}), of_xyz);
  check_pixel(read({exr_part(1, 1, tristimulus, p3)}), of_xyz);
  check_pixel(read({exr_part(1, 1, {{"R", 1}, {"G", 1}, {"B", 1}}, p3)}), {1, 1, 1});
  for (const auto& values : {rgb, tristimulus})
    check_pixel(read({exr_part(1, 1, values, aces)}, true), {0.2f, 0.5f, 0.3f});
  check_pixel(read({exr_part(1, 1, {{"Y", 0.5f}}, aces)}), {0.5f});
  check_pixel(read({exr_part(1, 1, {{"Z", 1}}, xyz, "depth"), exr_part(1, 1, rgb, xyz, "colours")}), of_xyz);
  CHECK(contains(error_in({exr_part(1, 1, rgb, std::vector<float>(8, 0))}), "chromaticities define no color space"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(contains(error_in({exr_part(1, 1, rgb, std::vector<float>(8, nan))}), "no color space"));
}

TEST_CASE("exr image: the image is the display window wherever the data window lies") {
  ExrTestPart part = exr_part(2, 2, {{"Y", 0}});
  part.values["Y"] = {1, 2, 3, 4};
  const auto with_windows = [&](std::array<int, 4> window, std::array<int, 4> frame) {
    part.window = window;
    part.frame = frame;
    return read({part});
  };
  const StoredImage inside = with_windows({1, 1, 2, 2}, {0, 0, 3, 3});
  CHECK(inside.width == 4);
  CHECK(inside.height == 4);
  CHECK(inside.floats == std::vector<float>{0, 0, 0, 0, 0, 1, 2, 0, 0, 3, 4, 0, 0, 0, 0, 0});
  CHECK(with_windows({5, -3, 6, -2}, {5, -3, 6, -2}).floats == std::vector<float>{1, 2, 3, 4});
  const StoredImage across = with_windows({-1, 0, 0, 1}, {0, 0, 1, 0});
  CHECK(across.floats == std::vector<float>{2, 0});
  CHECK(with_windows({-1, -1, 0, 0}, {0, 0, 0, 0}).floats == std::vector<float>{4});
  part.window = {8, 8, 9, 9};
  part.frame = {0, 0, 3, 3};
  CHECK(contains(error_in({part}), "data window lies outside of its display window"));
  part.frame = {0, 0, 60000, 60000};
  CHECK(contains(error_in({part}), "the header claims 60001 x 60001 pixels"));
}

TEST_CASE("exr image: a crop rendered by Sheaf keeps its position in the frame") {
  const TemporaryFolder folder;
  Image crop(2, 1, {"A", "B", "G", "R", "Z"});
  for (int x = 0; x < 2; ++x)
    for (int c = 0; c < 5; ++c) crop.at(x, 0, c) = static_cast<float>(10 * c + x);
  crop.x0 = 1;
  crop.y0 = 2;
  crop.frame_width = 4;
  crop.frame_height = 3;
  write_exr(folder / "crop.exr", crop);
  const StoredImage image = read_stored_image(folder / "crop.exr");
  CHECK(image.width == 4);
  CHECK(image.height == 3);
  std::vector<float> expected(4 * 3 * 4);
  for (std::size_t x = 0; x < 2; ++x)
    for (std::size_t c = 0; c < 4; ++c)
      expected[4 * (2 * 4 + 1 + x) + c] = static_cast<float>(10 * (c < 3 ? 3 - c : 0) + x);
  CHECK(image.floats == expected);
}

TEST_CASE("exr image: non-finite values are unchanged") {
  const float infinity = std::numeric_limits<float>::infinity();
  const StoredImage image =
      read({exr_part(1, 1, {{"R", infinity}, {"G", 2}, {"B", 3}}, {1, 0, 0, 1, 0, 0, 0.3f, 0.3f})});
  CHECK(image.floats == std::vector<float>{infinity, 2, 3});
}

}  // namespace sheaf::test_exr_colors
