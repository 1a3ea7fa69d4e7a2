// EXR files: round trips with crop windows, types and metadata; determinism; damaged files.
#include "core/image/exr.h"

#include "core/io/error.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace sheaf::test_exr {

namespace {

Image make_noise(int width, int height, std::vector<std::string> channels) {
  Image image(width, height, std::move(channels));
  std::mt19937 generator(7);
  for (float& value : image.data) value = static_cast<float>(generator()) / 4e8f - 1.0f;
  return image;
}

/// Whether every channel of `a` exists in `b` with the same values, up to the relative error `tolerance`.
bool same_values(const Image& a, const Image& b, float tolerance = 0) {
  if (a.width != b.width || a.height != b.height || a.channels.size() != b.channels.size()) return false;
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    const int other = b.find_channel(a.channels[c]);
    if (other < 0) return false;
    for (int y = 0; y < a.height; ++y) {
      for (int x = 0; x < a.width; ++x) {
        const float u = a.at(x, y, static_cast<int>(c)), v = b.at(x, y, other);
        if (!(std::abs(u - v) <= tolerance * std::abs(u))) return false;
      }
    }
  }
  return true;
}

const std::vector<std::string> kLayers{"R", "G", "B", "A", "variance.R", "sampleCount", "Z"};

}  // namespace

TEST_CASE("an EXR round trip keeps every float and the window in the frame") {
  const TemporaryFolder folder;
  Image image = make_noise(37, 21, kLayers);
  image.data[5] = std::numeric_limits<float>::infinity();
  image.data[6] = 1e-42f;
  image.x0 = 11;
  image.y0 = 5;
  image.frame_width = 100;
  image.frame_height = 50;
  write_exr(folder / "crop.exr", image);
  const Image back = read_exr(folder / "crop.exr");
  CHECK(back.x0 == 11);
  CHECK(back.y0 == 5);
  CHECK(back.frame_width == 100);
  CHECK(back.frame_height == 50);
  const int red = back.find_channel("R"), count = back.find_channel("sampleCount");
  REQUIRE(red >= 0);
  REQUIRE(count >= 0);
  CHECK(back.at(0, 0, count) == image.at(0, 0, 5));
  CHECK(back.at(0, 0, back.find_channel("Z")) == 1e-42f);
  image.data[5] = 0;
  Image finite = back;
  finite.at(0, 0, count) = 0;
  CHECK(same_values(image, finite));
  CHECK(folder.entry_count() == 1);
}

TEST_CASE("windows may begin to the left of the frame and above it") {
  const TemporaryFolder folder;
  Image image = make_noise(8, 8, {"R", "G", "B"});
  image.x0 = -3;
  image.y0 = -2;
  write_exr(folder / "overscan.exr", image);
  const Image back = read_exr(folder / "overscan.exr");
  CHECK(back.x0 == -3);
  CHECK(back.y0 == -2);
  CHECK(same_values(image, back));
}

TEST_CASE("half channels lose precision and float channels beside them do not") {
  const TemporaryFolder folder;
  const Image image = make_noise(33, 17, {"N.X", "R"});
  ExrMetadata metadata;
  metadata.half_channels = {"N.X"};
  write_exr(folder / "half.exr", image, metadata);
  const Image back = read_exr(folder / "half.exr");
  CHECK(same_values(image, back, 1.0f / 1024));
  CHECK_FALSE(same_values(image, back));
  CHECK(back.at(5, 5, back.find_channel("R")) == image.at(5, 5, 1));
}

TEST_CASE("metadata survives a round trip") {
  const TemporaryFolder folder;
  ExrMetadata metadata;
  metadata.software = "Sheaf";
  metadata.attributes = {{"sheaf/seed", std::string("4294967295")}, {"sheaf/spp", 64}, {"sheaf/exposure", 0.5f}};
  metadata.world_to_camera = Matrix4{};
  write_exr(folder / "meta.exr", make_noise(4, 4, {"R"}), metadata);
  const std::vector<ExrMetadata::Attribute> found = read_exr_attributes(folder / "meta.exr");
  const auto value_of = [&found](const std::string& name) -> std::variant<int, float, double, std::string> {
    for (const auto& attribute : found) {
      if (attribute.name == name) return attribute.value;
    }
    return -12345;
  };
  CHECK(std::get<std::string>(value_of("sheaf/seed")) == "4294967295");
  CHECK(std::get<int>(value_of("sheaf/spp")) == 64);
  CHECK(std::get<float>(value_of("sheaf/exposure")) == 0.5f);
  CHECK(std::get<std::string>(value_of("Software")) == "Sheaf");
  const std::string bytes = read_bytes(folder / "meta.exr");
  CHECK(bytes.find("chromaticities") != std::string::npos);
  CHECK(bytes.find("worldToCamera") != std::string::npos);
  CHECK(bytes.find("capDate") == std::string::npos);
}

TEST_CASE("every compression is read back; only DWA changes values, and only those of colors") {
  const TemporaryFolder folder;
  const Image image = make_noise(70, 50, {"CryptoObject00.r", "R", "Z"});
  std::vector<std::size_t> sizes;
  for (const ExrCompression compression :
       {ExrCompression::kUncompressed, ExrCompression::kRle, ExrCompression::kZips, ExrCompression::kZip,
        ExrCompression::kPiz, ExrCompression::kDwaa, ExrCompression::kDwab}) {
    CAPTURE(static_cast<int>(compression));
    ExrMetadata metadata;
    metadata.compression = compression;
    write_exr(folder / "a.exr", image, metadata);
    const Image back = read_exr(folder / "a.exr");
    const bool is_dwa = compression == ExrCompression::kDwaa || compression == ExrCompression::kDwab;
    CHECK(same_values(image, back) == !is_dwa);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (const int c : {0, 2}) CHECK(back.at(x, y, c) == image.at(x, y, c));
    sizes.push_back(read_bytes(folder / "a.exr").size());
    // The compression is a byte of the header, as in the file format's enumeration.
    const std::string bytes = read_bytes(folder / "a.exr"), name("compression\0compression\0\1\0\0\0", 28);
    REQUIRE(bytes.find(name) != std::string::npos);
    constexpr int kCodes[] = {0, 1, 2, 3, 4, 8, 9};
    CHECK(bytes[bytes.find(name) + name.size()] == kCodes[static_cast<int>(compression)]);
  }
  ExrMetadata coarse;
  coarse.compression = ExrCompression::kDwaa;
  coarse.dwa_level = 1000;
  write_exr(folder / "a.exr", image, coarse);
  CHECK(read_bytes(folder / "a.exr").size() < sizes[5]);
}

TEST_CASE("numbers in attributes: integers of any size, and texts of older versions") {
  using Attribute = ExrMetadata::Attribute;
  CHECK(std::get<int>(integer_attribute("a", 2147483647).value) == 2147483647);
  CHECK(std::get<double>(integer_attribute("a", 2147483648).value) == 2147483648.0);
  const TemporaryFolder folder;
  ExrMetadata metadata;
  metadata.attributes = {integer_attribute("seed", 4294967295)};
  write_exr(folder / "a.exr", make_noise(4, 4, {"R"}), metadata);
  bool found = false;
  for (const Attribute& attribute : read_exr_metadata(folder / "a.exr").attributes)
    if (attribute.name == "seed") found = number_of(attribute) == 4294967295.0;
  CHECK(found);
  CHECK(number_of(Attribute{"a", 3}) == 3.0);
  CHECK(number_of(Attribute{"a", 0.5f}) == 0.5);
  CHECK(number_of(Attribute{"a", std::string("0.0123")}) == 0.0123);
  CHECK_FALSE(number_of(Attribute{"a", std::string("unknown")}));
  CHECK_FALSE(number_of(Attribute{"a", std::string("")}));
  CHECK_FALSE(number_of(Attribute{"a", std::string("12 ")}));
}

TEST_CASE("the bytes do not depend on the order of the channels") {
  const TemporaryFolder folder;
  const Image image = make_noise(300, 40, {"R", "G"});
  Image swapped(300, 40, {"G", "R"});
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 300; ++x) {
      swapped.at(x, y, 0) = image.at(x, y, 1);
      swapped.at(x, y, 1) = image.at(x, y, 0);
    }
  }
  write_exr(folder / "a.exr", image);
  write_exr(folder / "b.exr", image);
  write_exr(folder / "c.exr", swapped);
  CHECK(read_bytes(folder / "a.exr").size() > 10000);
  CHECK(read_bytes(folder / "a.exr") == read_bytes(folder / "b.exr"));
  CHECK(read_bytes(folder / "a.exr") == read_bytes(folder / "c.exr"));
}

TEST_CASE("a truncated EXR is an error at any length") {
  const TemporaryFolder folder;
  write_exr(folder / "whole.exr", make_noise(64, 64, {"R", "G", "B"}));
  const std::string bytes = read_bytes(folder / "whole.exr");
  for (std::size_t i = 0; i < 16; ++i) {
    CAPTURE(i);
    write_bytes(folder / "cut.exr", bytes.substr(0, bytes.size() * i / 16));
    CHECK_THROWS_AS(read_exr(folder / "cut.exr"), SceneError);
    CHECK_THROWS_AS(read_image(folder / "cut.exr"), SceneError);
  }
}

TEST_CASE("a damaged EXR is read or rejected and never crashes") {
  const TemporaryFolder folder;
  write_exr(folder / "whole.exr", make_noise(32, 32, {"R", "G", "B"}));
  const std::string bytes = read_bytes(folder / "whole.exr");
  std::mt19937 generator(3);
  int refused = 0;
  for (int attempt = 0; attempt < 300; ++attempt) {
    std::string damaged = bytes;
    const std::size_t range = attempt % 2 == 0 ? 400 : bytes.size();
    for (int k = 0; k < 3; ++k) damaged[generator() % range] = static_cast<char>(generator());
    write_bytes(folder / "damaged.exr", damaged);
    try {
      read_exr(folder / "damaged.exr");
    } catch (const SceneError&) { ++refused; }
  }
  CHECK(refused > 50);
}

TEST_CASE("a header that claims a huge image is rejected without allocating it") {
  const TemporaryFolder folder;
  write_exr(folder / "small.exr", make_noise(4, 4, {"R"}));
  const std::string bytes = read_bytes(folder / "small.exr");
  const std::size_t window = bytes.find("dataWindow") + std::string("dataWindow").size() + 1 + 6 + 4;
  for (const char high : {'\x00', '\x7f'}) {
    std::string claim = bytes;
    for (const std::size_t corner : {window + 8, window + 12}) claim.replace(corner, 4, {'\xff', '\xff', '\0', high});
    write_bytes(folder / "claim.exr", claim);
    CHECK_THROWS_AS(read_exr(folder / "claim.exr"), SceneError);
  }
}

TEST_CASE("a header with an impossible attribute size is rejected before the library reads it") {
  const TemporaryFolder folder;
  ExrMetadata metadata;
  metadata.software = "test";
  write_exr(folder / "small.exr", make_noise(4, 4, {"R"}), metadata);
  const std::string bytes = read_bytes(folder / "small.exr");
  const auto error_with = [&](const std::string& attribute, const std::string& size) {
    std::string claim = bytes;
    claim.replace(claim.find(attribute) + attribute.size(), size.size(), size);
    write_bytes(folder / "claim.exr", claim);
    std::string messages;
    for (const auto& read : std::vector<std::function<void(const std::filesystem::path&)>>{
             [](auto& path) { read_exr(path); }, [](auto& path) { read_exr_header(path); },
             [](auto& path) { read_exr_metadata(path); }}) {
      try {
        read(folder / "claim.exr");
        messages += "(none)";
      } catch (const SceneError& error) { messages += error.what(); }
    }
    const std::string expected = "impossible size of the attribute";
    std::size_t found = 0;
    for (auto at = messages.find(expected); at != std::string::npos; at = messages.find(expected, at + 1)) ++found;
    CAPTURE(messages);
    CHECK(found == 3);
  };
  using namespace std::string_literals;
  error_with("Software\0string\0"s, "\xff\xff\xff\x7f"s);
  error_with("Software\0string\0"s, "\xff\xff\xff\xff"s);
  error_with("channels\0chlist\0"s, "\x10"s);
  error_with("compression\0compression\0"s, "\x05"s);
}

TEST_CASE("files that are not EXR are rejected with their name") {
  const TemporaryFolder folder;
  write_bytes(folder / "text.exr", "<scene/>");
  CHECK_FALSE(is_exr(folder / "text.exr"));
  try {
    read_exr(folder / "text.exr");
    FAIL("no error");
  } catch (const SceneError& error) { CHECK(std::string(error.what()).find("text.exr") != std::string::npos); }
  CHECK_THROWS_AS(read_exr(folder / "missing.exr"), SceneError);
  CHECK_THROWS_AS(write_exr(folder / "empty.exr", Image()), Error);
  CHECK_THROWS_AS(write_exr(folder / "no/folder.exr", make_noise(2, 2, {"R"})), Error);
  CHECK(folder.entry_count() == 1);
}

}  // namespace sheaf::test_exr
