// The passes: each a source of paths, the stages in order, and a sink.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Runs the context's task to its end: of a camera task every sample is in its buffer afterwards, of a light task every
/// photon has ended.
using Pass = void (*)(const StageContext& context, Wave& wave);

/// Light along paths from the camera.
template <class L> void run_path_pass(const StageContext& context, Wave& wave);

/// Light along paths from the lights.
template <class L> void run_light_pass(const StageContext& context, Wave& wave);

/// Photons along paths from the lights, to be stored.
template <class L> void run_photon_pass(const StageContext& context, Wave& wave);

/// Pictures of the first surface, for debugging.
template <class L> void run_debug_pass(const StageContext& context, Wave& wave);

/// Seconds from a timestamp() to now.
inline double seconds_since(std::uint64_t start) {
  return static_cast<double>(timestamp() - start) * seconds_per_tick();
}

/// The pass from the camera that an integrator asks for.
template <class L> Pass camera_pass_of(IntegratorKind kind) {
  return transports_light(kind) ? run_path_pass<L> : run_debug_pass<L>;
}

}  // namespace sheaf
