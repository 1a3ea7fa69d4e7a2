// The options of `sheaf render`.
#pragma once

#include "core/name_table.h"
#include "core/spectrum.h"
#include "scene/tables/render_settings.h"
#include "tools/checkpointing.h"
#include "tools/options.h"
#include "tools/preview.h"
#include "tools/read_options.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// Values of --color and --filter-mode.
inline constexpr NameTable<ColorMode> kColorModes{{{"rgb", ColorMode::kRgb}, {"spectral", ColorMode::kSpectral}}};
inline constexpr NameTable<FilterMode> kFilterModes{
    {{"weighted", FilterMode::kWeighted}, {"importance", FilterMode::kImportance}}};

/// The options as given.
struct RenderArguments {
  std::string scene;
  std::vector<std::string> outputs;
  std::optional<std::uint32_t> spp, seed;
  std::optional<int> max_depth, rr_depth, candidates;
  std::vector<int> crop;  ///< empty or x0, y0, x1, y1
  std::string color, integrator, sampler, filter_mode, light_sampler, medium_estimator, stats, size, aovs, denoiser,
      samples;
  std::optional<float> scale, noise_target, time_limit;
  std::optional<float> step_size;
  int threads = 0, wave_size = 0, spectral_bins = 0, replicates = 0;
  bool no_timestamps = false, quiet = false, watertight = false, guiding = false, light_groups = false,
       full_floats = false;
  CheckpointArguments checkpoint;
  PreviewArguments preview;
  ReadArguments read;
};

/// Adds the subcommand with all of its options, but without an action. `arguments` must live as long as `program`.
Command add_render_options(Command& program, RenderArguments& arguments);

}  // namespace sheaf
