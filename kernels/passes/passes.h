// The passes. Each connects a source of paths, a schedule of stages and a sink.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Runs the task of the context to its end. Afterwards every sample of a camera task is in its buffer, and every photon
/// of a light task has ended.
using Pass = void (*)(const StageContext& context, Wave& wave);

/// Path tracing from the camera.
template <class L> void run_path_pass(const StageContext& context, Wave& wave);

/// Light tracing from the lights to the camera.
template <class L> void run_light_pass(const StageContext& context, Wave& wave);

/// Tracing of photons that are stored in photon maps.
template <class L> void run_photon_pass(const StageContext& context, Wave& wave);

/// Debug images of the first surface.
template <class L> void run_debug_pass(const StageContext& context, Wave& wave);

/// Seconds since a timestamp().
inline double seconds_since(std::uint64_t start) {
  return static_cast<double>(timestamp() - start) * seconds_per_tick();
}

/// The pass from the camera for an integrator.
template <class L> Pass camera_pass_of(IntegratorKind kind) {
  return transports_light(kind) ? run_path_pass<L> : run_debug_pass<L>;
}

}  // namespace sheaf
