// Checkpoints of `sheaf render`: when to write them, and the settings that a resumed render must share with them.
#pragma once

#include "kernels/render/render.h"
#include "tools/options/options.h"

#include <atomic>

namespace sheaf {

/// Command-line options for checkpoints.
struct CheckpointArguments {
  std::string file;
  double every = 60;  ///< interval, s
  bool resume = false;
};

void add_checkpoint_options(Command& command, CheckpointArguments& arguments);

/// Throws Error (exit code 2) if the options contradict each other, or if the file exists and --resume is not given.
void check_checkpoint(const CheckpointArguments& arguments);

/// All settings that determine the image's bits: the options given, except those that are only_for_run(); the files of
/// the scene; Sheaf's version; and the instruction set.
RecordedSettings recorded_settings(const std::vector<GivenOption>& given,
                                   const std::vector<std::filesystem::path>& files);

/// The settings with which `resumed` continues, if there is a checkpoint: with the number of replicates that it needs.
/// `file`: the checkpoint, for messages. `note`: receives a note for the user, or an empty string. A checkpoint of few
/// samples that do not begin the new render is dropped. Throws Error (exit code 5) if a checkpoint of more samples does
/// not.
RenderSettings continued_settings(const RenderSettings& settings, const std::string& file,
                                  std::optional<RenderState>& resumed, std::string& note);

/// Writes the checkpoints of one render.
class Checkpointer {
 public:
  Checkpointer(const CheckpointArguments& arguments, RecordedSettings settings);

  /// State to resume from; nothing if the render starts anew. Throws Error (exit code 5).
  std::optional<RenderState> resumed() const;
  /// Whether a checkpoint is due. Thread-safe.
  bool is_due() const;
  /// Writes a checkpoint if the user asked for them. If that fails, prints the error and lets the render continue.
  void save(const RenderState& state);
  /// Whether the last checkpoint was written, or none was requested.
  bool is_saved() const { return is_saved_; }

 private:
  CheckpointArguments arguments_;
  RecordedSettings settings_;
  std::atomic<double> last_;  ///< time of the last checkpoint, s on the steady clock
  bool is_saved_ = true;
};

}  // namespace sheaf
