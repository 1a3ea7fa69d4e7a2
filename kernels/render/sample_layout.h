// The samples of a render, derived from its options: pixels, samples per pixel, replicates, and the channels of the
// film.
#pragma once

#include "core/image/pixel_rect.h"
#include "kernels/film/camera_task.h"
#include "kernels/film/film.h"
#include "kernels/render/render.h"
#include "kernels/render/sample_division.h"

namespace sheaf {

/// See RenderOptions for the meaning of the settings.
struct SampleLayout : SampleDivision {
  PixelRect crop;  ///< pixels of the image
  /// Pixels that are sampled: the crop, and surrounding pixels whose samples contribute to it.
  PixelRect sampled;
  int reach = 0;                                  ///< distance up to which samples contribute to other pixels, pixels
  const FilterWeights* filter_weights = nullptr;  ///< optional: see SensorView::filter_weights
  SampledFrame frame;
  std::uint32_t rays = 1;  ///< gather rays per camera sample, each counted as a sample of its own
  bool adapts = false;     ///< adaptive sampling
  VarianceUnit unit = VarianceUnit::kReplicate;
  bool has_variances = false;
  std::vector<std::string> light_groups;  ///< names of the groups with layers
  /// Index of each light's group, by row of LightView::rows; only with groups.
  std::vector<std::uint16_t> group_of_light;

  Film make_film(const Scene& scene, const RenderOptions& options) const;
};

/// Throws Error (usage) for options that the scene cannot be rendered with.
SampleLayout make_sample_layout(const Scene& scene, const RenderOptions& options);

}  // namespace sheaf
