// The scripts that `sheaf farm` writes, for bash and Slurm.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sheaf {

/// A picture, or an animation of several, that the jobs of a cluster render part by part. Paths are absolute.
struct Farm {
  std::string program;         ///< sheaf
  std::string working_folder;  ///< that names among the options are meant from
  std::string folder;          ///< for scripts, and for what parts are made of
  std::string scene;
  std::vector<std::string> options;  ///< of render, the same for all parts
  std::string part_option;           ///< of render, which takes each of
  std::vector<std::string> part_values;
  std::vector<std::string> merge_options;
  /// Names of pictures to write, what stands before the number of the frame and what stands behind it.
  std::vector<std::pair<std::string, std::string>> outputs;
  bool has_frames = false;  ///< else there is one picture
  int first_frame = 0, last_frame = 0;
  std::vector<std::string> sbatch_options;        ///< of parts
  std::vector<std::string> sbatch_merge_options;  ///< of what joins them
  int most_restarts = 100;
};

/// A word that the shell takes as it is, whatever it holds.
std::string shell_quoted(std::string_view word);

/// Renders the part SLURM_ARRAY_TASK_ID of the frame that is its argument, and goes on where it was stopped.
std::string render_script(const Farm& farm);
/// Joins the parts of the frame that is its argument.
std::string merge_script(const Farm& farm);
/// Submits both: `render` and `merge` are their files.
std::string submit_script(const Farm& farm, const std::string& render, const std::string& merge);

}  // namespace sheaf
