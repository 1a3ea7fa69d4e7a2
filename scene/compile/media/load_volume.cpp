#include "scene/compile/media/load_volume.h"

#include "core/io/file_cache.h"
#include "scene/compile/media/build_brick_grid.h"
#include "scene/formats/sparse_volume.h"
#include "scene/formats/vol_file.h"

#include <algorithm>

namespace sheaf {

namespace {

BrickGrid load_vol(const GridVolumeDescription& description) {
  const DenseVolume volume = read_vol(description.file, description.use_grid_bbox);
  BrickGrid grid = make_dense_grid(volume.channels, volume.size, volume.values, border_of(description.wrap));
  grid.grid_to_local = volume.grid_to_local;
  return grid;
}

/// The volume padded with a voxel of zeros on all sides, which is not part of its box.
BrickGrid with_zeros_around(const DenseVolume& volume) {
  std::array<int, 3> size;
  for (std::size_t axis = 0; axis < 3; ++axis) size[axis] = volume.size[axis] + 2;
  const auto at = [&](int x, int y, int z, const std::array<int, 3>& in) {
    const std::size_t row = static_cast<std::size_t>(z) * static_cast<std::size_t>(in[1]) + static_cast<std::size_t>(y);
    return (row * static_cast<std::size_t>(in[0]) + static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(volume.channels);
  };
  std::vector<float> values(at(0, 0, size[2], size));
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      std::copy_n(volume.values.data() + at(0, y, z, volume.size), at(volume.size[0], 0, 0, volume.size),
                  values.data() + at(1, y + 1, z + 1, size));
  BrickGrid grid = make_dense_grid(volume.channels, size, values, GridBorder::kClamp);
  grid.voxel_min = {1, 1, 1};
  grid.voxel_max = volume.size;
  grid.grid_to_local = volume.grid_to_local * Transform::translate({-1, -1, -1});
  return grid;
}

BrickGrid load_made(const GridVolumeDescription& description) {
  const DenseVolume& volume = *description.made;
  if (volume.ends_at_zero) return with_zeros_around(volume);
  BrickGrid grid = make_dense_grid(volume.channels, volume.size, volume.values, border_of(description.wrap));
  grid.grid_to_local = volume.grid_to_local;
  return grid;
}

/// Memory limit for sparse files. Tiles of such a file may represent any number of voxels, but each brick takes memory.
/// The limit per byte of the file, plus a constant, is far above the needs of volumes with explicit voxels.
constexpr std::size_t kMaxPerByte = 512, kAlways = std::size_t{64} << 20;

BrickGrid load_sparse(const GridVolumeDescription& description) {
  const SparseVolume volume = read_sparse_volume(description.file, description.grid);
  BrickGrid grid = make_sparse_grid(volume.voxels, kAlways + kMaxPerByte * volume.stored_bytes);
  grid.grid_to_local = volume.grid_to_local;
  return grid;
}

}  // namespace

GridBorder border_of(GridVolumeDescription::Wrap wrap) {
  switch (wrap) {
    case GridVolumeDescription::Wrap::kRepeat:
      return GridBorder::kRepeat;
    case GridVolumeDescription::Wrap::kMirror:
      return GridBorder::kMirror;
    default:
      return GridBorder::kClamp;
  }
}

BrickGrid load_volume(const GridVolumeDescription& description, const SourceLocation& where) {
  const std::string file = description.file.string();
  try {
    try {
      switch (description.format) {
        case GridVolumeDescription::Format::kInMemory:
          return load_made(description);
        case GridVolumeDescription::Format::kSparse:
          return cached(description.file, "sparse " + description.grid, [&] { return load_sparse(description); });
        default: {
          const std::string options = description.use_grid_bbox ? "vol with box " : "vol ";
          return cached(description.file, options + std::to_string(static_cast<int>(description.wrap)),
                        [&] { return load_vol(description); });
        }
      }
    } catch (const SceneError& error) {
      if (file.empty() || error.where().file.string() == file) throw;
      throw SceneError({file}, error);
    }
  } catch (const SceneError& error) { throw SceneError(where, error); }
}

BrickGridRow place_grid(const BrickGrid& grid, const Transform& to_world, const GridVolumeDescription& description,
                        const SourceLocation& where) {
  try {
    return make_brick_grid_row(grid, to_world, description.filter);
  } catch (const SceneError& error) {
    const std::string file = description.file.string();
    throw SceneError(where, file.empty() ? error : SceneError({file}, error));
  }
}

PlacedGrid describe_grid(const BrickGrid& grid, const Transform& to_world, const GridVolumeDescription& description,
                         const SourceLocation& where) {
  PlacedGrid placed;
  placed.name = description.file.string();
  if (!description.grid.empty()) placed.name += ", " + description.grid;
  placed.where = where;
  placed.channels = grid.channels;
  placed.bytes = grid.bytes();
  if (grid.is_empty()) return placed;
  for (std::size_t axis = 0; axis < 3; ++axis) placed.size[axis] = grid.voxel_max[axis] - grid.voxel_min[axis] + 1;
  const Bounds3f local = grid.voxel_box();
  placed.box = Bounds3f::empty();
  for (int i = 0; i < 8; ++i) placed.box.grow(to_world.point(local.corner(i)));
  return placed;
}

}  // namespace sheaf
