// The bash scripts for Slurm that `sheaf farm` writes.
#pragma once

#include "tools/farm/frame_names.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// An image or an animation that the jobs of a cluster render in parts. Paths are absolute.
struct Farm {
  std::string program;         ///< the sheaf executable
  std::string working_folder;  ///< base of relative paths in the options
  std::string folder;          ///< for scripts, parts, checkpoints and logs
  std::string scene;
  std::vector<std::string> options;  ///< of `sheaf render`, the same for all parts
  std::string part_option;           ///< option of `sheaf render` that takes each of part_values
  std::vector<std::string> part_values;
  std::vector<std::string> merge_options;
  std::vector<FrameName> outputs;  ///< images to write
  bool has_frames = false;         ///< false: a single image
  FrameRange frames;
  /// A glTF file is rendered at frame / frame_rate seconds. Empty: other scenes, whose parameter `frame` is defined.
  std::optional<float> frame_rate;
  std::string denoiser;                           ///< of the merged image; empty: it is not denoised
  std::vector<std::string> denoise_options;       ///< of `sheaf denoise`
  std::vector<std::string> sbatch_options;        ///< for the parts
  std::vector<std::string> sbatch_merge_options;  ///< for merging
  int max_restarts = 100;
};

/// Script that renders or resumes part SLURM_ARRAY_TASK_ID of the frame in its first argument.
std::string render_script(const Farm& farm);
/// Script that merges the parts of the frame in its first argument.
std::string merge_script(const Farm& farm);
/// Script that submits both jobs. `render` and `merge` are the files of their scripts.
std::string submit_script(const Farm& farm, const std::string& render, const std::string& merge);

}  // namespace sheaf
