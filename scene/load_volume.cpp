#include "scene/load_volume.h"

#include "scene/nanovdb.h"
#include "scene/vol_file.h"

namespace sheaf {

namespace {

GridBorder border_of(GridVolumeDescription::Wrap wrap) {
  switch (wrap) {
    case GridVolumeDescription::Wrap::kRepeat: return GridBorder::kRepeat;
    case GridVolumeDescription::Wrap::kMirror: return GridBorder::kMirror;
    default: return GridBorder::kClamp;
  }
}

}  // namespace

BrickGrid load_volume(const GridVolumeDescription& description, const SourceLocation& where) {
  try {
    if (description.format == GridVolumeDescription::Format::kNanoVdb) {
      return read_nanovdb(description.file, description.grid);
    }
    return read_vol(description.file, border_of(description.wrap), description.use_grid_bbox);
  } catch (const SceneError& error) { throw SceneError(where, error.what()); }
}

}  // namespace sheaf
