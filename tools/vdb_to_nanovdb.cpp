// vdb_to_nanovdb: converts the fog volumes of an OpenVDB file to NanoVDB. Built only if OpenVDB is installed; the rest
// of Sheaf does not need it.
#include "core/io/error.h"
#include "scene/formats/nanovdb.h"

#include <openvdb/openvdb.h>

#include <cstdio>
#include <list>

namespace sheaf {

namespace {

/// Copies all voxels of a grid, including tiles.
template <class Grid> VoxelBlocks to_blocks(const Grid& grid) {
  constexpr int kChannels = std::is_same_v<typename Grid::ValueType, float> ? 1 : 3;
  const auto set = [](const typename Grid::ValueType& value, float* out) {
    if constexpr (kChannels == 1)
      *out = value;
    else
      for (int c = 0; c < 3; ++c) out[c] = value[c];
  };
  std::array<float, 3> background{};
  set(grid.background(), background.data());
  VoxelBlocks blocks(kChannels, background);
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord origin = leaf->origin();
    const std::span<float> values = blocks.add({origin.x() >> 3, origin.y() >> 3, origin.z() >> 3});
    for (openvdb::Index i = 0; i < VoxelBlocks::kVoxels; ++i) {  // OpenVDB's order has z fastest
      const openvdb::Index ours = (i & 7) << 6 | (i & 0x38) | i >> 6;
      set(leaf->getValue(i), values.data() + ours * kChannels);
    }
  }
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::DEPTH - 2);  // skip the leaves
  for (; tile; ++tile) {
    std::array<float, 3> value{};
    set(*tile, value.data());
    if (value == background) continue;
    const openvdb::CoordBBox box = tile.getBoundingBox();
    const openvdb::Coord first = box.min();
    blocks.add_constant({first.x() >> 3, first.y() >> 3, first.z() >> 3}, std::span(value).first(kChannels),
                        (box.max().x() - first.x() + 1) / VoxelBlocks::kSide);
  }
  return blocks;
}

Transform map_of(const openvdb::GridBase& grid) {
  const auto map = grid.transform().baseMap()->getAffineMap();  // throws for frustum transforms
  const openvdb::Mat4d rows = map->getMat4();                   // for row vectors
  Matrix4 m;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      m.m[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = rows(column, row);
  return Transform(m);
}

int run(const std::string& in, const std::string& out) {
  // Open the file
  openvdb::initialize();
  openvdb::io::File file(in);
  file.open();
  // Convert the fog volumes
  std::list<VoxelBlocks> voxels;
  std::vector<NanoVdbGrid> grids;
  const openvdb::GridPtrVecPtr found = file.getGrids();
  for (const openvdb::GridBase::Ptr& base : *found) {
    const bool is_level_set = base->getGridClass() == openvdb::GRID_LEVEL_SET;
    const auto scalar = openvdb::gridPtrCast<openvdb::FloatGrid>(base);
    const auto vector = openvdb::gridPtrCast<openvdb::Vec3SGrid>(base);
    if (is_level_set || (!scalar && !vector)) {
      std::fprintf(stderr, "vdb_to_nanovdb: skipped '%s', %s\n", base->getName().c_str(),
                   is_level_set ? "a level set" : ("of type " + base->valueType()).c_str());
      continue;
    }
    voxels.push_back(scalar ? to_blocks(*scalar) : to_blocks(*vector));
    grids.push_back({base->getName(), &voxels.back(), map_of(*base)});
  }
  // Write them
  if (grids.empty()) throw SceneError(SourceLocation{in}, "contains no float fog volumes");
  write_nanovdb(out, grids);
  return 0;
}

}  // namespace

}  // namespace sheaf

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: vdb_to_nanovdb IN.vdb OUT.nvdb\n");
    return static_cast<int>(sheaf::ExitCode::kUsage);
  }
  try {
    return sheaf::run(argv[1], argv[2]);
  } catch (const sheaf::Error& error) {
    std::fprintf(stderr, "vdb_to_nanovdb: %s\n", error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vdb_to_nanovdb: %s: %s\n", argv[1], error.what());
    return static_cast<int>(sheaf::ExitCode::kScene);
  }
}
