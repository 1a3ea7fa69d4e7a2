#include "scene/compile/load_volume.h"

#include "scene/formats/nanovdb.h"
#include "scene/formats/vol_file.h"

namespace sheaf {

namespace {

BrickGrid load_vol(const GridVolumeDescription& description) {
  const DenseVolume volume = read_vol(description.file, description.use_grid_bbox);
  BrickGrid grid = make_dense_grid(volume.channels, volume.size, volume.values, border_of(description.wrap));
  grid.grid_to_local = volume.grid_to_local;
  return grid;
}

/// Tiles of a sparse file stand for any number of voxels, but bricks take memory for each 8^3: so much per byte of the
/// file, on top of what any file may take, is far more than volumes need whose voxels are there.
constexpr std::size_t kMostPerByte = 512, kAlways = std::size_t{64} << 20;

BrickGrid load_nanovdb(const GridVolumeDescription& description) {
  const SparseVolume volume = read_nanovdb(description.file, description.grid);
  BrickGrid grid = make_sparse_grid(volume.voxels, kAlways + kMostPerByte * volume.stored_bytes);
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
      return description.format == GridVolumeDescription::Format::kNanoVdb ? load_nanovdb(description)
                                                                           : load_vol(description);
    } catch (const SceneError& error) {
      if (std::string_view(error.what()).starts_with(file + ":")) throw;
      throw SceneError({file}, error.what());
    }
  } catch (const SceneError& error) { throw SceneError(where, error.what()); }
}

}  // namespace sheaf
