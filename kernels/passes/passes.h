// Running a pass: a source of paths, the stages in order, and a sink.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Runs the context's task to its end by the stages that take part in StageContext::pass. Afterwards every sample of a
/// camera task is in its buffer, and every photon of a light task has ended.
template <class L> void run_pass(const StageContext& context, Wave& wave);

/// Seconds since a timestamp().
inline double seconds_since(std::uint64_t start) {
  return static_cast<double>(timestamp() - start) * seconds_per_tick();
}

}  // namespace sheaf
