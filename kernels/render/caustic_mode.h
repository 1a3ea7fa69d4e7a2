// Sampling of light that mirrors and glass focus onto other surfaces.
#pragma once

namespace sheaf {

/// Sampling of caustics by camera paths.
enum class CausticMode {
  kSampled,   ///< by sampling BSDFs and the guide
  kManifold,  ///< by manifold next-event estimation, instead of BSDF sampling
};

}  // namespace sheaf
