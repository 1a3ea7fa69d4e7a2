// The passes: each a source of paths, the stages in order, and a sink.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Runs the context's camera task to its end: every sample is in its buffer afterwards.
using Pass = void (*)(const StageContext& context, Wave& wave);

/// Light along paths from the camera.
template <class L> void run_path_pass(const StageContext& context, Wave& wave);

/// Pictures of the first surface, for debugging.
template <class L> void run_debug_pass(const StageContext& context, Wave& wave);

/// The pass that an integrator asks for.
template <class L> Pass pass_of(IntegratorKind kind) {
  return kind == IntegratorKind::kPath ? run_path_pass<L> : run_debug_pass<L>;
}

}  // namespace sheaf
