// NanoVDB files: round trips in every precision and compression, and errors for damaged files.
#include "scene/compile/media/load_volume.h"
#include "scene/formats/blosc.h"
#include "scene/formats/nanovdb.h"
#include "tests/support/files/deflate.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/volume_testing.h"

#include <cstring>
#include <limits>
#include <random>

namespace sheaf::test_nanovdb {

using namespace test;

namespace {

using Values = NanoVdbGrid::Values;

/// Blocks of noise in [0, 1), a cube of ones, and background.
VoxelBlocks noise_blocks(int channels = 1) {
  VoxelBlocks blocks(channels);
  for (const auto& position : {std::array<int, 3>{0, 0, 0}, {-1, 2, 0}, {-1, 2, 1}, {40, -70, 3}}) {
    std::uint32_t i = static_cast<std::uint32_t>(1000 * position[0] + position[2]);
    for (float& v : blocks.add(position)) v = noise(i++, 1);
  }
  const float ones[3] = {1, 1, 1};
  blocks.add_constant({2, 2, 2}, ones, 2);
  return blocks;
}

struct Written {
  VoxelBlocks blocks = noise_blocks();
  Transform map = skewed_transform();
  Values values = Values::kFloat;
  NanoVdbCodec codec = NanoVdbCodec::kUncompressed;
  bool is_level_set = false;

  std::string bytes() const {
    const TemporaryFolder folder;
    const NanoVdbGrid grids[] = {{"density", &blocks, map, values, is_level_set}, {"heat", &blocks, Transform()}};
    write_nanovdb(folder / "cloud.nvdb", grids, codec);
    return read_bytes(folder / "cloud.nvdb");
  }
};

BrickGrid read(const std::string& bytes, const std::string& grid = "") {
  const TemporaryFile file("cloud.nvdb", bytes);
  GridVolumeDescription description;
  description.format = GridVolumeDescription::Format::kSparse;
  description.file = file.path();
  description.grid = grid;
  return load_volume(description, {});
}

std::string error_in(const std::string& bytes, const std::string& grid = "") {
  return error_of([&] { read(bytes, grid); });
}

/// The largest difference of voxels.
float largest_difference(BrickGrid a, BrickGrid b) {
  a.grid_to_local = b.grid_to_local = Transform();
  REQUIRE(a.channels == b.channels);
  const BrickGridRow row_a = make_brick_grid_row(a, Transform(), GridFilter::kNearest),
                     row_b = make_brick_grid_row(b, Transform(), GridFilter::kNearest);
  float most = 0;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto coordinate = [&](std::uint32_t axis, float lo, float hi) {
      return std::floor(lo + (hi - lo) * noise(i, 70 + axis));
    };
    const Vec3f p = i % 4 == 0 ? Vec3f{coordinate(0, 318, 330), coordinate(1, -562, -550), coordinate(2, 20, 34)}
                               : Vec3f{coordinate(0, -10, 34), coordinate(1, -2, 34), coordinate(2, -2, 34)};
    most = std::max(most, max_component(abs(lookup_grid_color(row_a, p) - lookup_grid_color(row_b, p))));
  }
  return most;
}

}  // namespace

TEST_CASE("nanovdb: floats and vectors are read exactly with every compression") {
  std::vector<NanoVdbCodec> codecs{NanoVdbCodec::kUncompressed, NanoVdbCodec::kZip};
  if (has_blosc()) codecs.push_back(NanoVdbCodec::kBlosc);
  for (const int channels : {1, 3})
    for (const NanoVdbCodec codec : codecs) {
      Written w;
      w.blocks = noise_blocks(channels);
      w.codec = codec;
      const BrickGrid expected = make_sparse_grid(w.blocks), found = read(w.bytes());
      CHECK(found.channels == channels);
      CHECK(found.voxel_min == expected.voxel_min);
      CHECK(found.voxel_max == expected.voxel_max);
      CHECK(found.max_value() == 1.0f);
      CHECK(largest_difference(expected, found) == 0.0f);
      const Vec3f a = found.grid_to_local.point({3, -4, 5}), b = w.map.point({3, -4, 5});
      CHECK(length(a - b) < 1e-5f);
    }
}

TEST_CASE("nanovdb: quantized values are accurate to their bits") {
  const BrickGrid expected = make_sparse_grid(noise_blocks());
  const std::pair<Values, float> kinds[] = {
      {Values::kFp4, 0.5f / 15}, {Values::kFp8, 0.5f / 255}, {Values::kFp16, 0.5f / 65535}, {Values::kFpN, 0.01f}};
  for (const auto& [values, error] : kinds) {
    Written w;
    w.values = values;
    const float found = largest_difference(expected, read(w.bytes()));
    CHECK(found <= 1.01f * error + 1e-7f);
    CHECK(found > 0.0f);
  }
}

TEST_CASE("nanovdb: grids are found by name and unknown names suggest the nearest") {
  const std::string bytes = Written{}.bytes();
  CHECK(read(bytes, "heat").grid_to_local.point({1, 2, 3}) == Vec3f{1, 2, 3});
  CHECK(contains(error_in(bytes, "densty"),
                 "no grid 'densty' (the file holds 'density', 'heat'), did you mean 'density'?"));
  const TemporaryFile file("cloud.nvdb", bytes + bytes);  // two segments
  GridVolumeDescription description;
  description.format = GridVolumeDescription::Format::kSparse;
  description.file = file.path();
  description.grid = "heat";
  CHECK(load_volume(description, {"scene.xml", 3}).max_value() == 1.0f);
  description.grid = "x";
  CHECK(error_of([&] { load_volume(description, {"scene.xml", 3}); }).starts_with("scene.xml:3: "));
  CHECK(contains(error_of([] { read_nanovdb("/nowhere/at/all.nvdb", ""); }), "not found"));
}

TEST_CASE("nanovdb: empty grids are read") {
  Written w;
  w.blocks = VoxelBlocks(1);
  CHECK(read(w.bytes()).is_empty());
}

TEST_CASE("nanovdb: grids that are not fog volumes are errors") {
  Written w;
  w.is_level_set = true;
  CHECK(contains(error_in(w.bytes()), "cloud.nvdb: grid 'density': is a level set (expected a fog volume)"));
  std::string bytes = Written{}.bytes();
  const std::size_t grid = bytes.find("NanoVDB0", 8);
  REQUIRE(grid != bytes.npos);
  bytes[grid + 636] = 8;
  CHECK(contains(
      error_in(bytes),
      "expected values of type float, Fp4, Fp8, Fp16, FpN, double, an integer, Vec3f or Vec3d, found type Mask"));
  bytes[grid + 639] = 9;
  CHECK(contains(error_in(bytes), "found type 150994952"));
}

TEST_CASE("nanovdb: files of other formats are errors") {
  CHECK(contains(error_in(""), "begins with the letters NanoVDB0"));
  CHECK(contains(error_in("PLY and more"), "begins with the letters NanoVDB0"));
  std::string bytes = Written{}.bytes();
  bytes[11] = 3;  // 0x03 << 24 is major 24
  CHECK(contains(error_in(bytes), "of NanoVDB's format, found 24"));
  bytes = Written{}.bytes();
  bytes[14] = 7;
  CHECK(contains(error_in(bytes), "codec 7"));
  CHECK(contains(error_in(Written{}.bytes() + "appended, no segment"), "expected a segment of grids at byte"));
}

TEST_CASE("nanovdb: sizes that the file cannot hold are errors and not allocations") {
  for (const NanoVdbCodec codec : {NanoVdbCodec::kUncompressed, NanoVdbCodec::kZip}) {
    Written w;
    w.codec = codec;
    const std::string valid = w.bytes();
    for (const std::uint64_t size : {std::uint64_t{0}, std::uint64_t{600}, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
      std::string bytes = valid;
      std::memcpy(bytes.data() + 16, &size, 8);  // size in memory
      CHECK_FALSE(error_in(bytes).empty());
      bytes = valid;
      if (size == 0) continue;
      std::memcpy(bytes.data() + 24, &size, 8);  // size in the file
      CHECK_FALSE(error_in(bytes).empty());
    }
    std::string bytes = valid;
    bytes.replace(16 + 136, 4, "\xff\xff\xff\xff");
    CHECK(contains(error_in(bytes), "truncated"));
  }
}

TEST_CASE("nanovdb: every truncation is an error") {
  for (const NanoVdbCodec codec : {NanoVdbCodec::kUncompressed, NanoVdbCodec::kZip, NanoVdbCodec::kBlosc}) {
    if (codec == NanoVdbCodec::kBlosc && !has_blosc()) continue;
    Written w;
    w.codec = codec;
    const std::string valid = w.bytes();
    for (std::size_t size = 0; size < valid.size(); size += size < 1000 ? 13 : valid.size() / 60)
      CHECK_FALSE(error_in(valid.substr(0, size)).empty());
  }
}

TEST_CASE("nanovdb: random edits give a grid or an error") {
  std::mt19937 random(11);
  for (const Values values : {Values::kFloat, Values::kFp4, Values::kFpN}) {
    Written w;
    w.values = values;
    const std::string valid = w.bytes();
    // Positions of all non-zero bytes: headers, masks and offsets among megabytes of empty tables.
    std::vector<std::size_t> positions;
    for (std::size_t i = 0; i < valid.size(); ++i)
      if (valid[i] != 0 && (i < 3000 || valid.size() - i > 20000 || i % 50 == 0)) positions.push_back(i);
    for (int round = 0; round < 150; ++round) {
      std::string bytes = valid;
      for (int edit = 0; edit < 3; ++edit) {
        const std::size_t byte = positions[random() % positions.size()] + random() % 8;
        if (byte < bytes.size()) bytes[byte] = static_cast<char>(random());
      }
      error_of([&] {
        const BrickGrid grid = read(bytes);
        CHECK(std::isfinite(grid.max_value()));
      });
    }
  }
}

TEST_CASE("nanovdb: trees with wild offsets are errors") {
  const std::string valid = Written{}.bytes();
  const std::size_t grid = valid.find("NanoVDB0", 8), tree = grid + 672;
  std::uint64_t root = 0;
  std::memcpy(&root, valid.data() + tree + 24, 8);
  const std::size_t first_tile = tree + root + 64;  // after the 64 bytes of the root
  for (const std::int64_t offset : {std::int64_t{1}, std::int64_t{-32}, std::int64_t{1} << 62,
                                    std::numeric_limits<std::int64_t>::min(), std::int64_t{32}}) {
    std::string bytes = valid;
    std::memcpy(bytes.data() + tree + 24, &offset, 8);
    CHECK_FALSE(error_in(bytes).empty());
    bytes = valid;
    std::memcpy(bytes.data() + first_tile + 8, &offset, 8);
    const std::string error = error_in(bytes);  // a neighboring position may look like a node
    if (std::abs(offset + 1) > 100 || offset == 1) CHECK(contains(error, "corrupt"));
  }
  std::string bytes = valid;
  bytes.replace(tree + root + 24, 4, "\xff\xff\xff\x7f");  // number of tiles of the root
  CHECK(contains(error_in(bytes), "corrupt"));
}

namespace {

/// A file of one grid with tiles of 128^3 voxels of value 1 at the given positions in one node of 32^3 tiles, and
/// nothing else. It is compressed, because it is almost all zeros.
std::string tile_file(const std::vector<std::array<std::uint32_t, 3>>& tiles) {
  VoxelBlocks blocks(1);
  blocks.add({0, 0, 0})[0] = 1;
  const TemporaryFolder folder;
  const NanoVdbGrid grids[] = {{"density", &blocks, Transform()}};
  write_nanovdb(folder / "one.nvdb", grids, NanoVdbCodec::kUncompressed);
  std::string bytes = read_bytes(folder / "one.nvdb");
  const std::size_t grid = bytes.find("NanoVDB0", 8), tree = grid + 672;
  std::uint64_t root = 0, upper = 0;
  std::memcpy(&root, bytes.data() + tree + 24, 8);
  std::memcpy(&upper, bytes.data() + tree + root + 64 + 8, 8);
  constexpr std::size_t kTable = 8256;  // after the node's box, flags, masks and statistics
  const float one = 1;
  for (const auto& at : tiles) {
    const std::size_t tile = (at[0] * 32 + at[1]) * 32 + at[2];
    std::memcpy(bytes.data() + tree + root + upper + kTable + 8 * tile, &one, sizeof(one));
  }
  const std::string stream = deflated(bytes.substr(grid));
  std::string stored(8, '\0');
  const std::uint64_t size = stream.size(), with_size = size + 8;
  std::memcpy(stored.data(), &size, 8);
  std::string head = bytes.substr(0, grid);
  head[14] = 1;                                  // codec of the segment: deflate
  std::memcpy(head.data() + 24, &with_size, 8);  // size of the grid in the file
  return head + stored + stream;
}

}  // namespace

TEST_CASE("nanovdb: tiles have one value for all their voxels") {
  const BrickGrid grid = read(tile_file({{1, 0, 0}, {2, 0, 0}, {0, 3, 1}}));
  CHECK(grid.voxel_min == std::array<int, 3>{0, 0, 0});
  CHECK(grid.voxel_max == std::array<int, 3>{383, 511, 255});
  const BrickGridRow row = make_brick_grid_row(grid, Transform(), GridFilter::kTrilinear);
  for (const Vec3f inside : {Vec3f{128, 0, 0}, {255.5f, 64, 100}, {383, 127, 127}, {5, 384, 128}, {0, 0, 0}})
    CHECK(lookup_grid(row, inside) == 1.0f);
  for (const Vec3f outside : {Vec3f{127, 1, 0}, {384, 0, 0}, {255, 128, 3}, {5, 383, 128}, {1, 0, 0}})
    CHECK(lookup_grid(row, outside) == 0.0f);
  CHECK(lookup_grid(row, {383.5f, 64, 64}) == 0.5f);
}

TEST_CASE("nanovdb: scattered tiles in a small file do not take gigabytes of memory") {
  const std::string bytes = tile_file({{30, 30, 30}, {0, 30, 0}, {30, 0, 30}});
  REQUIRE(bytes.size() < 5000);
  const std::string error = error_in(bytes);
  CHECK(contains(error, "cloud.nvdb: a grid of 39"));
  CHECK(contains(error, "MB of memory or more (expected at most"));
  CHECK(contains(error, "stray tiles"));
  // A checkerboard of tiles has the most surface, and each brick at the edge of a tile is distinct.
  std::vector<std::array<std::uint32_t, 3>> checkers;
  for (std::uint32_t i = 0; i < 8 * 8 * 8; ++i)
    if (((i & 7) + (i >> 3 & 7) + (i >> 6)) % 2 == 1) checkers.push_back({i & 7, i >> 3 & 7, i >> 6});
  CHECK(contains(error_in(tile_file(checkers)), "stray tiles"));
}

}  // namespace sheaf::test_nanovdb
