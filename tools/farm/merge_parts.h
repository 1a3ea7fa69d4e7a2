// Merging of the parts of an image, which are tiles or ranges of samples.
#pragma once

#include "tools/job/parts.h"

#include <functional>
#include <vector>

namespace sheaf {

struct MergeOptions {
  std::vector<int> crop;     ///< the merged region in pixels: x0, y0, x1, y1; empty: the frame
  bool incomplete = false;   ///< accept missing pixels and samples
  bool full_floats = false;  ///< store all layers as 32-bit floats
};

/// A part, and the function that reads its image.
struct MergeSource {
  PartFile header;
  std::function<Image()> read;
};

struct MergedImage {
  Image image;
  ExrMetadata metadata;
  bool has_denoised = false;    ///< parts have layers denoised.R/G/B, which the merged image lacks
  bool interrupted = false;     ///< parts are of interrupted renders
  double sampled_fraction = 1;  ///< fraction of the samples that the parts have
};

/// Merges the parts, which may come in any order. Throws SceneError if they do not belong together or, unless
/// `incomplete`, if some are missing; Error (exit code 2) for an impossible crop or without parts.
MergedImage merge_parts(const std::vector<MergeSource>& sources, const MergeOptions& options);

}  // namespace sheaf
