// Writes NanoVDB files: builds the tree of each grid from its voxels. The encodings instantiate much of NanoVDB, which
// is why this file is apart from the reader and less optimized (CMakeLists.txt).
#define NANOVDB_USE_ZIP
#include "core/io/output_file.h"
#include "scene/formats/nanovdb.h"

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

namespace sheaf {

namespace {

/// Builds a grid with values of one type and encoding.
template <class ValueT, class BuildT> nanovdb::GridHandle<> build(const NanoVdbGrid& grid) {
  const VoxelBlocks& voxels = *grid.voxels;
  const auto to_value = [&](const float* v) {
    if constexpr (std::is_same_v<ValueT, float>)
      return *v;
    else
      return ValueT(v[0], v[1], v[2]);
  };
  const auto kind = grid.is_level_set        ? nanovdb::GridClass::LevelSet
                    : voxels.channels() == 1 ? nanovdb::GridClass::FogVolume
                                             : nanovdb::GridClass::Unknown;
  const ValueT background = to_value(voxels.background().data());
  // Set the voxels
  nanovdb::GridBuilder<ValueT, BuildT> builder(background, kind);
  auto accessor = builder.getAccessor();
  for (const VoxelBlocks::Block& block : voxels.blocks()) {
    const int side = block.edge * VoxelBlocks::kSide;
    for (int z = 0; z < side; ++z)
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
          const int i = block.is_constant ? 0 : (z * VoxelBlocks::kSide + y) * VoxelBlocks::kSide + x;
          const ValueT value =
              to_value(&voxels.values()[block.first_value + static_cast<std::size_t>(i * voxels.channels())]);
          if (value != background)
            accessor.setValue({block.position[0] * VoxelBlocks::kSide + x, block.position[1] * VoxelBlocks::kSide + y,
                               block.position[2] * VoxelBlocks::kSide + z},
                              value);
        }
  }
  // Set the transform
  nanovdb::Map map{};
  const auto &m = grid.index_to_world.matrix().m, &inverse = grid.index_to_world.inverse_matrix().m;
  double columns[3][3], inverse_columns[3][3], translation[3];  // layout expected by Map::set()
  for (std::size_t row = 0; row < 3; ++row) {
    translation[row] = m[row][3];
    for (std::size_t column = 0; column < 3; ++column) {
      columns[column][row] = m[row][column];
      inverse_columns[column][row] = inverse[row][column];
    }
  }
  map.set(columns, inverse_columns, translation, 1.0);
  return builder.getHandle(map, grid.name);
}

/// Builds a grid in its encoding.
nanovdb::GridHandle<> build_as(const NanoVdbGrid& grid) {
  if (grid.voxels->channels() == 3) return build<nanovdb::Vec3f, nanovdb::Vec3f>(grid);
  switch (grid.values) {
    case NanoVdbGrid::Values::kFp4:
      return build<float, nanovdb::Fp4>(grid);
    case NanoVdbGrid::Values::kFp8:
      return build<float, nanovdb::Fp8>(grid);
    case NanoVdbGrid::Values::kFp16:
      return build<float, nanovdb::Fp16>(grid);
    case NanoVdbGrid::Values::kFpN:
      return build<float, nanovdb::FpN>(grid);
    default:
      return build<float, float>(grid);
  }
}

}  // namespace

void write_nanovdb(const std::filesystem::path& file, std::span<const NanoVdbGrid> grids, NanoVdbCodec codec) {
  OutputFile output(file);
  try {
    std::vector<nanovdb::GridHandle<>> handles;
    for (const NanoVdbGrid& grid : grids) handles.push_back(build_as(grid));
    nanovdb::io::writeGrids(output.stream(), handles, static_cast<nanovdb::io::Codec>(codec));
  } catch (const std::exception& error) { throw Error(ExitCode::kOutput, {file.string()}, error.what()); }
  output.commit();
}

}  // namespace sheaf
