// Values on a regular grid, for media and volume textures.
#pragma once

#include "core/math/transform.h"
#include "scene/description/motion.h"
#include "scene/tables/interpolation.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace sheaf {

struct DenseVolume;

/// Values on a regular grid in a file or in memory, interpolated in between.
struct GridVolumeDescription {
  enum class Format {
    /// Mitsuba's format: dense, one or three channels. Fills the unit cube, or with `use_grid_bbox` the file's box.
    kVol,
    kSparse,    ///< NanoVDB or OpenVDB; placed by the map in the file; zero outside
    kInMemory,  ///< `made`; placed by DenseVolume::grid_to_local
  };
  /// kVol: values outside the grid.
  enum class Wrap { kClamp, kRepeat, kMirror };
  std::filesystem::path file;  ///< resolved path
  Format format = Format::kVol;
  std::string grid;    ///< kSparse: name of the grid; empty: the first in the file
  Transform to_world;  ///< from the space that `format` defines
  bool use_grid_bbox = false;
  /// Stretch the grid over the bounding box of the shapes that contain the medium; ignores to_world.
  bool fit_to_shape = false;
  GridFilter filter = GridFilter::kTrilinear;
  Wrap wrap = Wrap::kClamp;
  bool raw = false;                              ///< three channels are data, not colors
  std::shared_ptr<const DenseVolume> made = {};  ///< kInMemory
  std::optional<MotionId> motion = {};           ///< media only; see MediumDescription
};

}  // namespace sheaf
