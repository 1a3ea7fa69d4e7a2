// What is decided before a render's first ray: which pixels and samples are taken, in which sets, and what the film is
// made of.
#pragma once

#include "core/pixel_rect.h"
#include "kernels/film/camera_task.h"
#include "kernels/film/film.h"
#include "kernels/film/sample_range.h"
#include "kernels/passes/render.h"

namespace sheaf {

/// See RenderOptions for what they mean.
struct SamplePlan {
  PixelRect crop;    ///< pixels of the picture
  PixelRect wanted;  ///< pixels that are sampled: the crop, and those around from which samples reach into it
  int reach = 0;     ///< pixels
  SampledFrame frame;
  std::uint32_t rays = 1;               ///< gather rays of each camera sample, which count as samples of their own
  std::uint32_t spp = 0;                ///< samples per pixel
  std::uint32_t replicate_samples = 0;  ///< per pixel, of each replicate
  std::uint32_t half_samples = 0;       ///< per pixel, of the first half
  SampleRange range;                    ///< of `spp` samples, those that are taken
  bool adapts = false;                  ///< adaptive sampling
  VarianceUnit unit = VarianceUnit::kReplicate;
  bool has_variances = false;
  std::vector<std::string> light_groups;  ///< names of those that have layers

  Film make_film(const Scene& scene, const RenderOptions& options) const;
};

/// `transport`: the scene's integrator. Throws Error (usage) for what cannot be rendered so.
SamplePlan make_sample_plan(const Scene& scene, const RenderOptions& options, const IntegratorDescription& transport);

}  // namespace sheaf
