// Images in memory, reading and writing of PNG and other formats, and atomic file output.
#include "core/image/image.h"

#include "core/color/color.h"
#include "core/io/error.h"
#include "core/io/output_file.h"
#include "tests/support/capture.h"
#include "tests/support/files/image_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

namespace sheaf::test_image {

namespace {

Image make_ramp() {
  Image image(256, 2, {"B", "G", "R"});
  for (int x = 0; x < 256; ++x) {
    const float linear = srgb_to_linear(static_cast<float>(x) / 255.0f);
    for (int y = 0; y < 2; ++y) {
      image.at(x, y, image.find_channel("R")) = linear;
      image.at(x, y, image.find_channel("G")) = srgb_to_linear(static_cast<float>(255 - x) / 255.0f);
      image.at(x, y, image.find_channel("B")) = y == 0 ? 0.0f : 1.0f;
    }
  }
  return image;
}

int byte_at(const Image& image, int x, int y, int c) {
  return static_cast<int>(std::lround(image.at(x, y, c) * 255.0f));
}

}  // namespace

TEST_CASE("an image starts black and finds channels by name") {
  const Image image(3, 2, {"A", "variance.R"});
  CHECK(image.data.size() == 12);
  CHECK(image.find_channel("variance.R") == 1);
  CHECK(image.find_channel("R") == -1);
  CHECK(image.frame_width == 3);
  CHECK(image.at(2, 1, 1) == 0.0f);
}

TEST_CASE("a PNG stores the sRGB encoding of linear values") {
  const TemporaryFolder folder;
  write_png(folder / "ramp.png", make_ramp());
  const Image back = read_image(folder / "ramp.png");
  REQUIRE(back.width == 256);
  REQUIRE(back.height == 2);
  REQUIRE(back.channels.size() == 3);
  bool all_equal = true;
  for (int x = 0; x < 256; ++x) {
    all_equal = all_equal && byte_at(back, x, 0, 0) == x && byte_at(back, x, 0, 1) == 255 - x;
  }
  CHECK(all_equal);
  CHECK(byte_at(back, 7, 0, 2) == 0);
  CHECK(byte_at(back, 7, 1, 2) == 255);
  CHECK(folder.entry_count() == 1);
}

TEST_CASE("a PNG clamps and rounds to nearest and stores NaN as black") {
  const TemporaryFolder folder;
  Image image(6, 1, {"Y"});
  const float half_step = srgb_to_linear(100.499f / 255.0f), next_half = srgb_to_linear(100.501f / 255.0f);
  image.data = {std::numeric_limits<float>::quiet_NaN(), -3,        1e30f,
                std::numeric_limits<float>::infinity(),  half_step, next_half};
  write_png(folder / "grey.png", image);
  const Image back = read_image(folder / "grey.png");
  REQUIRE(back.channels.size() == 1);
  const int expected[] = {0, 0, 255, 255, 100, 101};
  for (int x = 0; x < 6; ++x) CHECK(byte_at(back, x, 0, 0) == expected[x]);
}

TEST_CASE("a PNG stores alpha only where pixels are transparent and stores unpremultiplied colors") {
  const TemporaryFolder folder;
  Image image(2, 1, {"R", "G", "B", "A"});
  image.data = {0.5f, 0.25f, 0, 1, 0.1f, 0.1f, 0.1f, 1};
  write_png(folder / "opaque.png", image);
  CHECK(read_image(folder / "opaque.png").channels.size() == 3);
  image.data = {0.25f, 0.125f, 0, 0.5f, 0, 0, 0, 0};
  write_png(folder / "alpha.png", image);
  const Image back = read_image(folder / "alpha.png");
  REQUIRE(back.channels.size() == 4);
  CHECK(byte_at(back, 0, 0, 0) == std::lround(255 * linear_to_srgb(0.5f)));
  CHECK(byte_at(back, 0, 0, 1) == std::lround(255 * linear_to_srgb(0.25f)));
  CHECK(byte_at(back, 0, 0, 3) == 128);
  CHECK(byte_at(back, 1, 0, 0) == 0);
  CHECK(byte_at(back, 1, 0, 3) == 0);
}

TEST_CASE("a PNG keeps light that adds to the background") {
  const TemporaryFolder folder;
  Image image(3, 1, {"R", "G", "B", "A"});
  image.data = {0.5f, 0.25f, 0, 0, 3, 0.5f, 0, 0.25f, 0, 0, 0, 0};
  write_png(folder / "glow.png", image);
  const Image back = read_image(folder / "glow.png");
  REQUIRE(back.channels.size() == 4);
  CHECK(byte_at(back, 0, 0, 0) == 255);
  CHECK(byte_at(back, 0, 0, 1) == std::lround(255 * linear_to_srgb(0.5f)));
  CHECK(byte_at(back, 0, 0, 3) == 128);
  CHECK(byte_at(back, 1, 0, 0) == 255);
  CHECK(byte_at(back, 1, 0, 1) == std::lround(255 * linear_to_srgb(0.5f)));
  CHECK(byte_at(back, 1, 0, 3) == 255);
  CHECK(byte_at(back, 2, 0, 3) == 0);
}

TEST_CASE("the same image gives the same PNG bytes") {
  const TemporaryFolder folder;
  write_png(folder / "a.png", make_ramp());
  write_png(folder / "b.png", make_ramp());
  CHECK(read_bytes(folder / "a.png").size() > 100);
  CHECK(read_bytes(folder / "a.png") == read_bytes(folder / "b.png"));
}

TEST_CASE("a truncated or damaged PNG is an error and not a crash") {
  const TemporaryFolder folder;
  write_png(folder / "whole.png", make_ramp());
  const std::string bytes = read_bytes(folder / "whole.png");
  for (std::size_t i = 0; i < 16; ++i) {
    write_bytes(folder / "cut.png", bytes.substr(0, bytes.size() * i / 16));
    CHECK_THROWS_AS(read_image(folder / "cut.png"), SceneError);
  }
  write_bytes(folder / "text.png", "not an image at all");
  CHECK_THROWS_AS(read_image(folder / "text.png"), SceneError);
  CHECK_THROWS_AS(read_image(folder / "missing.png"), SceneError);
  CHECK_THROWS_AS(read_image(folder.path()), SceneError);
}

TEST_CASE("a PNG whose chunks claim more than the file holds is rejected before the library allocates") {
  const TemporaryFolder folder;
  write_png(folder / "whole.png", make_ramp());
  std::string bytes = read_bytes(folder / "whole.png");
  const std::size_t end = bytes.find("IEND") - 4;
  const std::string text("\0\0\0\5tEXta\0b c\0\0\0\0", 17);
  bytes.insert(end, text);  // the chunk's checksum is wrong, but the chunk is optional
  write_bytes(folder / "text.png", bytes);
  CHECK(read_image(folder / "text.png").width == 256);
  bytes[end] = 0x6c;
  write_bytes(folder / "much.png", bytes);
  const auto ends_early = doctest::Contains("ends too early");
  CHECK_THROWS_WITH_AS(read_image(folder / "much.png"), ends_early, SceneError);
  bytes.replace(end, 4, std::string("\0\0\0\x12", 4));  // one byte more than the chunk has
  write_bytes(folder / "more.png", bytes);
  CHECK_THROWS_WITH_AS(read_image(folder / "more.png"), ends_early, SceneError);
  bytes = read_bytes(folder / "whole.png");
  write_bytes(folder / "head.png", bytes.substr(0, bytes.find("IEND") + 2));
  CHECK_THROWS_WITH_AS(read_image(folder / "head.png"), ends_early, SceneError);
  bytes += std::string("\x7f\0\0\0tEXt", 8) + std::string(8, 'x');
  write_bytes(folder / "after.png", bytes);  // readers ignore data after the end
  CHECK(read_image(folder / "after.png").width == 256);
}

TEST_CASE("a BMP of a size that the file cannot hold is rejected before the library allocates") {
  const TemporaryFolder folder;
  std::vector<int> values(600);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<int>(i % 256);
  write_bmp(folder / "a.bmp", 10, 20, values);
  const std::string bytes = read_bytes(folder / "a.bmp");
  const auto refused = [&](std::size_t at, std::string_view number, const char* why) {
    std::string changed = bytes + std::string(1024, '\0');
    changed.replace(at, number.size(), number);
    changed[28] = 8;  // 8 bits per pixel, run-length encoded
    changed[30] = 1;
    write_bytes(folder / "changed.bmp", changed);
    CHECK_THROWS_WITH_AS(read_image(folder / "changed.bmp"), doctest::Contains(why), SceneError);
  };
  using namespace std::string_view_literals;
  refused(18, "\xff\xff\xff\x7f"sv, "the image is too large");
  refused(18, "\xf6\xff\xff\xff"sv, "the image is empty");
  refused(22, "\1\0\1\0"sv, "the image is too large");
  refused(22, "\xff\xff\xfe\xff"sv, "the image is too large");
  std::string upright = bytes;
  upright.replace(22, 4, "\xec\xff\xff\xff"sv);  // -20 rows: top row first
  write_bytes(folder / "upright.bmp", upright);
  const Image image = read_image(folder / "a.bmp"), rotated = read_image(folder / "upright.bmp");
  CHECK(rotated.height == 20);
  CHECK(rotated.at(3, 4, 1) == image.at(3, 15, 1));
}

TEST_CASE("image formats are detected by content and TGA by its name") {
  const TemporaryFolder folder;
  const std::vector<int> rgb = {0, 1, 2, 50, 51, 52, 100, 101, 102, 150, 151, 152, 200, 201, 202, 250, 251, 252};
  write_png(folder / "a.png", make_ramp());
  write_jpeg(folder / "a.jpg", 200);
  write_tiff(folder / "a.tif", 3, 2, 3, 16, rgb);
  write_hdr(folder / "a.hdr", 3, 2, rgb);
  write_bmp(folder / "a.bmp", 3, 2, rgb);
  write_pnm(folder / "a.ppm", 3, 2, 3, 255, rgb);
  for (const char* const name : {"a.png", "a.jpg", "a.tif", "a.hdr", "a.bmp", "a.ppm"}) {
    CAPTURE(std::string(name));
    const Image image = read_image(folder / name);
    CHECK(image.pixel_count() >= 6);
    for (const char* const other : {"b.tga", "b.gif", "b.xyz", "b"}) {
      CAPTURE(std::string(other));
      write_bytes(folder / other, read_bytes(folder / name));
      CHECK(read_image(folder / other).data == image.data);
    }
  }
  write_tga(folder / "a.tga", 3, 2, 3, rgb);
  CHECK(read_image(folder / "a.tga").width == 3);
  write_tga(folder / "tga.png", 3, 2, 3, rgb);
  CHECK_THROWS_AS(read_image(folder / "tga.png"), SceneError);
  write_bytes(folder / "A.TGA", read_bytes(folder / "a.tga"));
  CHECK(read_image(folder / "A.TGA").data == read_image(folder / "a.tga").data);
  // A format that is not supported, with a large size
  write_bytes(folder / "large.gif", std::string("GIF89a\x40\x9c\x40\x9c\xf0\0\0", 13) + std::string(64, ','));
  CHECK_THROWS_WITH_AS(read_image(folder / "large.gif"), doctest::Contains("expected a file of OpenEXR, PNG"),
                       SceneError);
}

TEST_CASE("a TIFF with strips far higher than the image is read without memory for a whole strip") {
  const TemporaryFolder folder;
  std::vector<int> values;
  for (int i = 0; i < 18; ++i) values.push_back(1000 * i);
  write_tiff(folder / "a.tif", 3, 2, 3, 16, values);
  std::string bytes = read_bytes(folder / "a.tif");
  const std::size_t rows = bytes.find(std::string("\x16\x01\x04\0\x01\0\0\0", 8)) + 8;  // tag 278, one value
  bytes.replace(rows, 4, std::string("\x10\0\0\0", 4));
  write_bytes(folder / "high.tif", bytes);
  CHECK(read_image(folder / "high.tif").data == read_image(folder / "a.tif").data);
  bytes.replace(rows, 4, std::string("\xff\xff\x7f\x2d", 4));
  write_bytes(folder / "higher.tif", bytes);
  CHECK(read_image(folder / "higher.tif").data == read_image(folder / "a.tif").data);
  CHECK(read_stored_image(folder / "higher.tif").floats == read_stored_image(folder / "a.tif").floats);
  const std::size_t compression = bytes.find(std::string("\x03\x01\x03\0\x01\0\0\0", 8)) + 8;
  bytes[compression] = 8;  // declared as deflate although it is not
  write_bytes(folder / "far.tif", bytes);
  CHECK_THROWS_WITH_AS(read_image(folder / "far.tif"), doctest::Contains("cannot read the image"), SceneError);
}

TEST_CASE("a TIFF with tiles far larger than the image is rejected before the library allocates") {
  const TemporaryFolder folder;
  const std::vector<int> values = {0, 51, 102, 153, 204, 255};
  write_tiled_tiff(folder / "tiled.tif", 3, 2, values);
  const Image image = read_image(folder / "tiled.tif");
  REQUIRE(image.data.size() == values.size());
  for (std::size_t i = 0; i < values.size(); ++i) CHECK(image.data[i] == near(static_cast<float>(values[i]) / 255.0f));
  const std::uint32_t claims[][2] = {
      {65536, 40000}, {16, 1u << 22}, {1u << 22, 16}, {0x80000000u, 16}, {16, 0xfffffff0u}};
  for (const auto& [width, height] : claims) {
    CAPTURE_BINDING(width);
    CAPTURE_BINDING(height);
    write_tiled_tiff(folder / "large.tif", 3, 2, values, width, height);
    CHECK_THROWS_WITH_AS(read_image(folder / "large.tif"), doctest::Contains("the header claims tiles of"), SceneError);
    CHECK_THROWS_AS(read_stored_image(folder / "large.tif"), SceneError);
  }
}

TEST_CASE("a message about an image has one line however many rows fail") {
  const TemporaryFolder folder;
  write_bmp(folder / "a.bmp", 1, 200, std::vector<int>(600, 7));
  std::string bytes = read_bytes(folder / "a.bmp");
  bytes.replace(10, 4, std::string("\x36\0\0\xdf", 4));  // offset of the pixels
  write_bytes(folder / "far.bmp", bytes.substr(0, 60));
  try {
    (void)read_image(folder / "far.bmp");
    FAIL("the file has no pixels");
  } catch (const SceneError& problem) {
    const std::string text = problem.what();
    CAPTURE(text);
    CHECK(text.find("cannot read the image: ") != std::string::npos);
    CHECK(text.find('\n') == std::string::npos);
  }
}

TEST_CASE("sizes that a file cannot hold are rejected before memory is allocated") {
  CHECK_THROWS_AS(check_image_size("x", 60000, 60000, 4, 1000), SceneError);
  CHECK_THROWS_AS(check_image_size("x", 70000, 1, 1, 1 << 30), SceneError);
  CHECK_THROWS_AS(check_image_size("x", 0, 5, 1, 1000), SceneError);
  CHECK_THROWS_AS(check_image_size("x", 5, 5, 0, 1000), SceneError);
  CHECK_THROWS_AS(check_image_size("x", 1LL << 40, 1LL << 40, 3, std::size_t{1} << 40), SceneError);
  CHECK_NOTHROW(check_image_size("x", 4096, 4096, 4, 1 << 20));
}

TEST_CASE("writing to an unwritable path fails with the exit code for outputs") {
  const TemporaryFolder folder;
  const auto code_of = [](const std::filesystem::path& path) {
    try {
      check_writable(path);
    } catch (const Error& error) { return error.exit_code(); }
    return ExitCode::kDone;
  };
  CHECK(code_of(folder / "no/such/folder/out.exr") == ExitCode::kOutput);
  CHECK(code_of(folder.path()) == ExitCode::kOutput);
  CHECK(code_of(folder.path() / "") == ExitCode::kOutput);
  CHECK(code_of("/dev/null") == ExitCode::kOutput);
  CHECK(code_of(folder / "out.exr") == ExitCode::kDone);
  CHECK(folder.entry_count() == 0);
  CHECK_THROWS_AS(write_png(folder / "no/out.png", make_ramp()), Error);
  CHECK_THROWS_AS(write_png(folder / "empty.png", Image()), Error);
  CHECK(folder.entry_count() == 0);
}

TEST_CASE("an output file replaces its target only when committed") {
  const TemporaryFolder folder;
  write_text_file(folder / "a.txt", "old");
  {
    OutputFile file(folder / "a.txt");
    file.stream() << "half of the ne";
  }
  CHECK(read_bytes(folder / "a.txt") == "old");
  CHECK(folder.entry_count() == 1);
  write_text_file(folder / "a.txt", "new");
  CHECK(read_bytes(folder / "a.txt") == "new");
  std::filesystem::create_symlink(folder / "a.txt", folder / "link.txt");
  write_text_file(folder / "link.txt", "through the link");
  CHECK(std::filesystem::is_symlink(folder / "link.txt"));
  CHECK(read_bytes(folder / "a.txt") == "through the link");
}

}  // namespace sheaf::test_image
