// How paths find light that mirrors and glass focus onto other surfaces.
#pragma once

namespace sheaf {

/// How camera paths find caustics.
enum class CausticMode {
  kSampled,   ///< by sampling BSDFs and the guide
  kManifold,  ///< by manifold next-event estimation, in place of BSDF sampling
};

}  // namespace sheaf
