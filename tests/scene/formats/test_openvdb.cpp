// OpenVDB files: files of the library in every type and compression (written by tests/smoke/make_vdb_files.cpp), their
// conversion to NanoVDB, and errors for damaged files.
#include "core/io/inflate.h"
#include "scene/compile/media/load_volume.h"
#include "scene/formats/blosc.h"
#include "scene/formats/nanovdb.h"
#include "scene/formats/openvdb.h"
#include "scene/formats/sparse_volume.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/volume_testing.h"

#include <array>
#include <cstring>
#include <random>
#include <set>

namespace sheaf::test_openvdb {

using namespace test;

namespace {

std::string inflated_file(const std::string& name) {
  const std::string stored = read_bytes(SHEAF_SOURCE_DIR "/tests/scene/formats/vdb/" + name + ".gz");
  Inflater inflater(stored);
  std::string bytes(std::size_t{12} << 20, '\0');
  bytes.resize(inflater.read(bytes));
  return bytes;
}

/// The compressions that this build reads.
std::vector<std::string> file_names() {
  std::vector<std::string> names = {"none.vdb", "active.vdb", "zip.vdb", "zip_active.vdb"};
  if (has_blosc()) names.push_back("blosc_active.vdb");
  return names;
}

using Position = std::array<int, 3>;

float expected_sixteenths(const Position& p) { return static_cast<float>((7 * p[0] + 3 * p[1] + 5 * p[2]) & 15); }

/// The value that make_vdb_files writes into voxel `i` of a block; `channel` of a value in units of `one`.
float expected_voxel(int block, int i, const Position& p, float one, int channel) {
  const auto value = [&] {
    return expected_sixteenths({p[0] + channel, p[1] + channel, p[2] + channel}) * (one == 4 ? 1 : 1 / 16.0f);
  };
  if (block == 0 || i % 3 == 0 || block == 7) return value();
  const float other[] = {0.25f * one, -0.25f * one, 0.5f * one, 0.75f * one};
  constexpr int kKinds[8][2] = {{0, 0}, {0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {2, 3}, {0, 0}};
  return other[kKinds[block][i % 2]];
}

/// The value that a volume of make_vdb_files has at a voxel of its blocks.
Position voxel_of(int block, int i) {
  return {8 * block - 24 + (i >> 6), (i >> 3 & 7) - 8 * (block % 3), (i & 7) + 128 * (block / 5)};
}

/// Finds voxels.
class Voxels {
 public:
  explicit Voxels(const VoxelBlocks& blocks) : blocks_(blocks) {}

  std::array<float, 3> at(const Position& p) const {
    std::array<float, 3> value = blocks_.background();
    for (const VoxelBlocks::Block& block : blocks_.blocks()) {
      Position in{};
      bool inside = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        in[axis] = p[axis] - 8 * block.position[axis];
        inside = inside && in[axis] >= 0 && in[axis] < 8 * block.edge;
      }
      if (!inside) continue;
      const int i = block.is_constant ? 0 : (in[2] * 8 + in[1]) * 8 + in[0];
      std::copy_n(&blocks_.values()[block.first_value + static_cast<std::size_t>(i * blocks_.channels())],
                  blocks_.channels(), value.data());
    }
    return value;
  }

 private:
  const VoxelBlocks& blocks_;
};

/// Counts voxels of the blocks that differ from what was written.
int count_wrong(const SparseVolume& volume, float one) {
  const Voxels voxels(volume.voxels);
  int wrong = 0;
  for (int block = 0; block < 8; ++block)
    for (int i = 0; i < 512; ++i) {
      const Position p = voxel_of(block, i);
      // Tiles replace these blocks
      if ((block == 0 || block == 3) && p[0] >= 48 && p[0] < 64 && p[1] >= 0) continue;
      const std::array<float, 3> found = voxels.at(p);
      for (int c = 0; c < volume.voxels.channels(); ++c)
        wrong += found[static_cast<std::size_t>(c)] != expected_voxel(block, i, p, one, c) ? 1 : 0;
    }
  return wrong;
}

std::string error_in(const std::string& bytes, const std::string& grid = "") {
  const TemporaryFile file("cloud.vdb", bytes);
  return error_of([&] { read_openvdb(file.path(), grid); });
}

/// Where a point of index space (1, 2, 3) lies.
struct Grid {
  const char* name;
  float one;  ///< integers are stored in units of 1/4 or 1/16
  int channels;
  Vec3f mapped;
};
const Grid kGrids[] = {{"density", 1, 1, {7.75f, 12.5f, 4}},
                       {"half", 1, 1, {0.5f, 1, 1.5f}},
                       {"color", 1, 3, {1.5f, 3, 4.5f}},
                       {"half color", 1, 3, {1, 4, 12}},
                       {"double", 1, 1, {2, 6, 15}},
                       {"double color", 1, 3, {2, 4, 6}},
                       {"int", 4, 1, {-2, 1, 3}},
                       {"long", 4, 1, {0.5f, 1, 1.5f}},
                       {"instance", 1, 1, {0.25f, 0.5f, 0.75f}}};

}  // namespace

TEST_CASE("openvdb: values of all types are read exactly with every compression") {
  for (const std::string& name : file_names()) {
    CAPTURE(name);
    const TemporaryFile file(name, inflated_file(name));
    for (const Grid& grid : kGrids) {
      CAPTURE(std::string(grid.name));
      const SparseVolume volume = read_sparse_volume(file.path(), grid.name);
      REQUIRE(volume.voxels.channels() == grid.channels);
      CHECK(count_wrong(volume, grid.one) == 0);
      const Voxels voxels(volume.voxels);
      CHECK(volume.voxels.background()[0] == 0.25f * grid.one);
      CHECK(voxels.at({130, 200, 5})[0] == 0.5f * grid.one);
      CHECK(voxels.at({49, 1, 2})[0] == 0.5f * grid.one);
      CHECK(voxels.at({57, 7, 7})[0] == 0.75f * grid.one);
      CHECK(voxels.at({300, 7, 7})[0] == 0.25f * grid.one);
      CHECK(length(volume.grid_to_local.point({1, 2, 3}) - grid.mapped) < 1e-5f);
    }
  }
}

TEST_CASE("openvdb: NanoVDB files of doubles and integers have the same values") {
  const TemporaryFile file("types.nvdb", inflated_file("types.nvdb"));
  for (const Grid& grid : kGrids) {
    if (std::set<std::string>{"double", "double color", "int", "long"}.count(grid.name) == 0) continue;
    CAPTURE(std::string(grid.name));
    const SparseVolume volume = read_sparse_volume(file.path(), grid.name);
    CHECK(volume.voxels.channels() == grid.channels);
    CHECK(count_wrong(volume, grid.one) == 0);
  }
}

TEST_CASE("openvdb: a grid and its conversion to NanoVDB have the same bricks") {
  const TemporaryFile file("a.vdb", inflated_file("active.vdb"));
  for (const Grid& grid : kGrids) {
    CAPTURE(std::string(grid.name));
    const SparseVolume volume = read_openvdb(file.path(), grid.name);
    const TemporaryFolder folder;
    const NanoVdbGrid converted[] = {{"grid", &volume.voxels, volume.grid_to_local}};
    write_nanovdb(folder / "a.nvdb", converted);
    GridVolumeDescription description;
    description.format = GridVolumeDescription::Format::kSparse;
    description.file = folder / "a.nvdb";
    const BrickGrid expected = load_volume(description, {});
    description.file = file.path();
    description.grid = grid.name;
    const BrickGrid found = load_volume(description, {});
    CHECK(found.voxel_min == expected.voxel_min);
    CHECK(found.voxel_max == expected.voxel_max);
    CHECK(found.bytes() == expected.bytes());
    CHECK(found.minimum == expected.minimum);
    CHECK(found.maximum == expected.maximum);
    CHECK(found.grid_to_local.matrix().m == expected.grid_to_local.matrix().m);
  }
}

TEST_CASE("openvdb: grids are found by name and unknown names list the grids") {
  const TemporaryFile file("smoke.vdb", inflated_file("active.vdb"));
  CHECK(read_openvdb(file.path(), "").voxels.background()[0] == 0.25f);
  CHECK(openvdb_grid_names(file.path()).at(9) == "twin[0]");
  for (const auto& [name, value] : {std::pair{"twin", 0.5f}, {"twin[0]", 0.5f}, {"twin[1]", 0.75f}}) {
    CHECK(has_sparse_grid(file.path(), name));
    CHECK(Voxels(read_openvdb(file.path(), name).voxels).at({1, 1, 1})[0] == value);
  }
  CHECK_FALSE(has_sparse_grid(file.path(), "twin[2]"));
  CHECK(read_openvdb(file.path(), "empty").voxels.blocks().empty());
  const auto error = [&](const char* grid) { return error_of([&] { read_openvdb(file.path(), grid); }); };
  CHECK(
      error("densty").ends_with("smoke.vdb: no grid 'densty' (the file holds 'density', 'half', 'color', 'half color', "
                                "'double', 'double color', 'int', 'long', 'instance', 'twin[0]', 'twin[1]', "
                                "'surface', 'mask', 'frustum', 'empty'), did you mean 'density'?"));
  CHECK(error("surface").ends_with("smoke.vdb: grid 'surface': is a level set (expected a fog volume)"));
  CHECK(
      error("mask").ends_with("grid 'mask': expected values of type float, double, int32, int64, vec3s or vec3d in a "
                              "tree 5_4_3, found 'Tree_bool_5_4_3'"));
  CHECK(contains(error("frustum"), "has a transform of type 'NonlinearFrustumMap' (expected an affine transform)"));
  CHECK(contains(error_of([] { read_sparse_volume("/nowhere/at/all.vdb", ""); }), "OpenVDB file not found"));
}

TEST_CASE("openvdb: files of other kinds and versions are errors") {
  CHECK(contains(error_in(""), "cloud.vdb: expected an OpenVDB file, which begins with a space and the letters BDV"));
  const std::string valid = inflated_file("active.vdb");
  std::string bytes = valid;
  bytes[8] = '\xdd';  // 221
  CHECK(contains(error_in(bytes), "cloud.vdb: expected version 222 or newer of OpenVDB's format, found 221"));
  bytes = valid;
  bytes[20] = 0;  // has positions
  CHECK(contains(error_in(bytes), "was written as a stream"));
  // The content decides, then the extension
  const TemporaryFile nano("nano.vdb", inflated_file("types.nvdb")), open("open.nvdb", valid), text("text.vdb", "text");
  CHECK(read_sparse_volume(nano.path(), "int").voxels.channels() == 1);
  CHECK(read_sparse_volume(open.path(), "int").voxels.channels() == 1);
  CHECK(contains(error_of([&] { read_sparse_volume(text.path(), ""); }), "expected an OpenVDB file"));
}

TEST_CASE("openvdb: every truncation is an error") {
  for (const std::string& name : file_names()) {
    CAPTURE(name);
    const std::string valid = inflated_file(name);
    const TemporaryFolder folder;
    for (std::size_t size = 0; size < valid.size(); size += size < 1000 ? 7 : valid.size() / 37) {
      write_bytes(folder / "cut.vdb", valid.substr(0, size));
      for (const char* const grid : {"", "empty"})  // the last one
        CHECK(contains(error_of([&] { read_openvdb(folder / "cut.vdb", grid); }),
                       size < 8 ? "expected an OpenVDB file" : "the file is truncated"));
    }
  }
}

TEST_CASE("openvdb: wild sizes and positions are errors and not allocations") {
  const std::string valid = inflated_file("zip_active.vdb");
  // Every 32-bit number in the headers of the file and of the first grid in turn
  std::vector<std::size_t> positions;
  for (std::size_t at = 8; at < 1100; ++at) positions.push_back(at);
  for (const std::size_t at : positions)
    for (const std::uint32_t number : {0xffffffffu, 0x7fffffffu, 0x01000000u}) {
      std::string bytes = valid;
      std::memcpy(bytes.data() + at, &number, sizeof number);
      error_in(bytes);  // an error, or another valid file
    }
}

TEST_CASE("openvdb: random edits give a grid or an error") {
  std::mt19937 random(7);
  for (const std::string& name : file_names()) {
    if (name == "none.vdb" || name == "zip.vdb") continue;  // large
    const std::string valid = inflated_file(name);
    for (int round = 0; round < 300; ++round) {
      std::string bytes = valid;
      for (int edit = 0; edit < 3; ++edit) {
        const std::size_t range = random() % 2 == 0 ? 4000 : bytes.size();
        bytes[random() % range] = static_cast<char>(random());
      }
      const TemporaryFile file("cloud.vdb", bytes);
      for (const char* const grid : {"", "half color"})
        error_of([&] {
          const SparseVolume volume = read_openvdb(file.path(), grid);
          const BrickGrid bricks = make_sparse_grid(volume.voxels, std::size_t{256} << 20);
          CHECK(std::isfinite(bricks.max_value()));
        });
    }
  }
}

}  // namespace sheaf::test_openvdb
