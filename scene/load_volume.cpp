#include "scene/load_volume.h"

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
      throw SceneError({description.file.string()}, "NanoVDB files are not read yet");
    }
    return read_vol(description.file, border_of(description.wrap), description.use_grid_bbox);
  } catch (const SceneError& error) { throw SceneError(where, error.what()); }
}

}  // namespace sheaf
