// The path pass: the order of the stages.
#pragma once

#include "kernels/wave.h"

namespace sheaf {

/// Runs the wave's task (Wave::begin) to its end: every camera sample is in the sample buffer afterwards.
template <class L> void run_path_pass(const SceneView& scene, Wave& wave);

}  // namespace sheaf
