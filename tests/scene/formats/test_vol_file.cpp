// Grid volumes of Mitsuba, written byte by byte: encodings, boxes, borders, and inconsistent files.
#include "scene/compile/media/load_volume.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/near.h"
#include "tests/support/volume_testing.h"

#include <cstring>
#include <limits>
#include <random>

namespace sheaf::test_vol_file {

using namespace test;

namespace {

template <class T> std::string raw(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

/// Contents of a file, by default 4 x 3 x 2 floats that count up from 0.
struct Written {
  std::string magic = "VOL";
  std::uint8_t version = 3;
  std::int32_t encoding = 1, x = 4, y = 3, z = 2, channels = 1;
  std::array<float, 6> box{-1, -2, -3, 1, 2, 3};

  std::string header() const {
    std::string bytes = magic + raw(version) + raw(encoding) + raw(x) + raw(y) + raw(z) + raw(channels);
    for (const float side : box) bytes += raw(side);
    return bytes;
  }
  std::string bytes() const {
    std::string result = header();
    for (std::int32_t i = 0; i < 24 * channels; ++i) {
      if (encoding == 1) result += raw(static_cast<float>(i));
      // In half precision, 2^5 has exponent field 20. i is in units of 1/1024.
      if (encoding == 2) result += raw(static_cast<std::uint16_t>(20 << 10 | i));
      if (encoding == 3) result += raw(static_cast<std::uint8_t>(10 * i));
    }
    return result;
  }
};

BrickGrid read(const std::string& bytes, bool use_grid_bbox = false) {
  const TemporaryFile file("smoke.vol", bytes);
  GridVolumeDescription description;
  description.file = file.path();
  description.use_grid_bbox = use_grid_bbox;
  return load_volume(description, {});
}

std::string error_in(const std::string& bytes, bool use_grid_bbox = false) {
  return error_of([&] { read(bytes, use_grid_bbox); });
}

float at(const BrickGrid& grid, Vec3f p) {
  return lookup_grid(make_brick_grid_row(grid, Transform(), GridFilter::kTrilinear), p);
}

}  // namespace

TEST_CASE("vol: values are at cell centers of the unit cube with x fastest") {
  const BrickGrid grid = read(Written{}.bytes());
  CHECK(grid.channels == 1);
  CHECK(grid.max_value() == 23.0f);
  CHECK(grid.voxel_box().min == Vec3f{0, 0, 0});
  CHECK(grid.voxel_box().max == Vec3f{1, 1, 1});
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 4; ++x) {
        const auto center = [](int i, int n) { return (static_cast<float>(i) + 0.5f) / static_cast<float>(n); };
        CHECK(at(grid, {center(x, 4), center(y, 3), center(z, 2)}) == near(static_cast<float>((z * 3 + y) * 4 + x)));
      }
  CHECK(at(grid, {0, 0, 0}) == 0.0f);
  CHECK(at(grid, {2, 2, 2}) == 23.0f);
  CHECK(at(grid, {0.25f, 0.5f / 3, 0.25f}) == near(0.5f));
}

TEST_CASE("vol: the box and encodings and channels of the file are read") {
  const BrickGrid boxed = read(Written{}.bytes(), true);
  CHECK(boxed.voxel_box().min == Vec3f{-1, -2, -3});
  CHECK(boxed.voxel_box().max == Vec3f{1, 2, 3});
  CHECK(at(boxed, {0.75f, 4.0f / 3, 1.5f}) == near(23.0f));
  Written w;
  w.encoding = 2;
  CHECK(at(read(w.bytes()), {9, 9, 9}) == 32.0f * (1 + 23.0f / 1024));
  CHECK(at(read(w.bytes()), {-9, -9, -9}) == 32.0f);
  w.encoding = 3;
  CHECK(at(read(w.bytes()), {9, 9, 9}) == 230.0f / 255);
  w = {};
  w.channels = 3;
  const BrickGrid color = read(w.bytes());
  const BrickGridRow row = make_brick_grid_row(color, Transform(), GridFilter::kNearest);
  CHECK(lookup_grid_color(row, {0.9f, 0.9f, 0.9f}) == Vec3f{69, 70, 71});
}

TEST_CASE("vol: half floats of every kind are read") {
  const std::uint16_t halves[] = {0, 0x8000, 0x3c00, 0xbc00, 1, 0x03ff, 0x7bff, 0x3555};
  const float expected[] = {0, -0.0f, 1, -1, 5.9604645e-8f, 6.0975552e-5f, 65504, 0.33325195f};
  Written w;
  w.encoding = 2;
  for (int i = 0; i < 8; ++i) {
    std::string bytes = w.bytes();
    const std::string half = raw(halves[i]);
    for (std::size_t k = 48; k < bytes.size(); k += 2) bytes.replace(k, 2, half);
    CHECK(at(read(bytes), {0.5f, 0.5f, 0.5f}) == expected[i]);
  }
}

TEST_CASE("vol: scenes read a volume by file name") {
  const TemporaryFile file("smoke.vol", Written{}.bytes());
  GridVolumeDescription description;
  description.file = file.path();
  description.wrap = GridVolumeDescription::Wrap::kRepeat;
  const BrickGrid grid = load_volume(description, {"scene.xml", 7});
  CHECK(grid.border == GridBorder::kRepeat);
  CHECK(at(grid, {1.125f, 1.0f + 0.5f / 3, -0.75f}) == within(0, 1e-6));
  description.file = "/nowhere/at/all.vol";
  const std::string error = error_of([&] { load_volume(description, {"scene.xml", 7}); });
  CHECK(error.starts_with("scene.xml:7: /nowhere/at/all.vol: grid volume not found"));
}

TEST_CASE("vol: malformed headers are errors") {
  CHECK(contains(error_in(""), "smoke.vol: expected a grid volume, which begins with the letters VOL"));
  CHECK(contains(error_in("VO"), "begins with the letters VOL"));
  CHECK(contains(error_in(std::string(100, 'x')), "begins with the letters VOL"));
  CHECK(contains(error_in("VOL\3"), "truncated"));
  Written w;
  w.version = 2;
  CHECK(contains(error_in(w.bytes()), "expected version 3 of the format, found 2"));
  w = {};
  w.encoding = 4;
  CHECK(contains(error_in(w.bytes()), "found 4"));
  w = {};
  w.channels = 2;
  CHECK(contains(error_in(w.bytes()), "expected 1 or 3 channels, found 2"));
  w = {};
  w.box = {0, 0, 0, 1, 0, 1};
  CHECK(contains(error_in(w.bytes(), true), "bounding box is empty"));
  CHECK(error_in(w.bytes()).empty());
  w.box = {0, 0, 0, 1, std::numeric_limits<float>::quiet_NaN(), 1};
  CHECK(contains(error_in(w.bytes(), true), "not finite"));
}

TEST_CASE("vol: sizes that the file cannot hold and non-finite values are errors") {
  for (const std::int32_t side : {0, -1, std::numeric_limits<std::int32_t>::min(), 1 << 17}) {
    Written w;
    w.y = side;
    CHECK(contains(error_in(w.bytes()), "sides from 1 to"));
  }
  Written w;
  w.x = w.y = w.z = 65536;
  CHECK(contains(error_in(w.bytes()), "takes 1125899906842624 bytes, found 96: truncated?"));
  w = {};
  CHECK(contains(error_in(w.bytes() + "x"), "takes 96 bytes, found 97"));
  const std::string valid = w.bytes();
  for (std::size_t size = 0; size < valid.size(); ++size) CHECK_FALSE(error_in(valid.substr(0, size)).empty());
  std::string broken = valid;
  broken.replace(48 + 4 * 17, 4, raw(std::numeric_limits<float>::infinity()));
  CHECK(contains(error_in(broken), "voxel (1, 1, 1) is not finite"));
}

TEST_CASE("vol: random edits give a grid or an error") {
  std::mt19937 random(5);
  for (int round = 0; round < 1000; ++round) {
    std::string bytes = Written{}.bytes();
    for (int edit = 0; edit < 2; ++edit) bytes[random() % 60] = static_cast<char>(random());
    error_of([&] {
      const BrickGrid grid = read(bytes, round % 2 == 0);
      CHECK(grid.channels > 0);
    });
  }
}

}  // namespace sheaf::test_vol_file
