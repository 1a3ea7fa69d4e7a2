// The interface that every phase function implements.
//
// A phase function scatters in a medium as a BSDF does on a surface, and has Closure, kIsSpecular, kIsAnisotropic,
// evaluate() and sample() of kernels/bsdf/bsdf.h. There is no normal: the z axis of the frame is wo, so wo is
// (0, 0, 1), and forward scattering has wi near -wo. f_cos is the phase function without a cosine. It is the same in
// all four lanes and equals the pdf with which sample() returns wi, so the sample weight is 1. The albedo belongs to
// the medium. If a phase function depends on world-space directions (microflakes), the stage surface_inputs writes its
// parameters for each vertex, relative to the vertex frame.
#pragma once

#include "core/sampling/sampler.h"
#include "kernels/phase/scattering.h"
#include "scene/materials/model.h"

namespace sheaf {

/// Whether a BSDF is a phase function.
template <class Bsdf> inline constexpr bool kIsPhaseFunction = Bsdf::Closure::kInfo.is_phase;

}  // namespace sheaf
