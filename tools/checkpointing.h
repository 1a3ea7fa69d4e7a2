// Checkpoints of a render from the command line: when they are written, and what a render must be to go on from one.
#pragma once

#include "kernels/passes/render.h"
#include "tools/options.h"

#include <atomic>

namespace sheaf {

/// The options.
struct CheckpointArguments {
  std::string file;
  double every = 60;  ///< seconds
  bool resume = false;
};

void add_checkpoint_options(Command& command, CheckpointArguments& arguments);

/// Throws Error (exit code 2) where the options make no sense together, and where the file is there and is not to be
/// resumed from.
void check_checkpoint(const CheckpointArguments& arguments);

/// All that decides over a picture's bits: the options given, but for those that say how the run goes and where its
/// results are put; the files that the scene is made of; the version, and the instruction set.
RenderSettings render_settings(const std::vector<std::pair<std::string, std::string>>& given,
                               const std::vector<std::filesystem::path>& files);

/// Writes checkpoints of one render.
class Checkpointer {
 public:
  Checkpointer(const CheckpointArguments& arguments, RenderSettings settings);

  /// What to go on from; nothing where the render is to begin. Throws Error (exit code 5).
  std::optional<RenderState> resumed() const;
  /// Whether a checkpoint is due. May be called by several threads at once.
  bool is_due() const;
  /// Writes one, if there is to be one. Says what went wrong if it cannot be written: the render goes on.
  void save(const RenderState& state);
  /// Whether the last one is written, or none is wanted.
  bool is_saved() const { return is_saved_; }

 private:
  CheckpointArguments arguments_;
  RenderSettings settings_;
  std::atomic<double> last_;  ///< seconds on the steady clock
  bool is_saved_ = true;
};

}  // namespace sheaf
