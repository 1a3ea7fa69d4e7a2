// Integrators that depend only on shapes, not on materials and lights: ambient occlusion and average visibility.
#pragma once

#include "core/io/name_table.h"
#include "scene/content/description.h"

namespace sheaf {

/// The quantity that such an integrator computes.
enum class Visibility {
  kAmbientOcclusion,  ///< cosine-weighted visibility of the sky; 0 where the camera ray misses
  kAverage            ///< fraction of the hemisphere without a near occluder; 1 where the camera ray misses
};
/// Names of these integrators; `ambientocclusion` is pbrt's.
inline constexpr NameTable<Visibility> kVisibilityIntegrators{{{"ao", Visibility::kAmbientOcclusion},
                                                               {"ambientocclusion", Visibility::kAmbientOcclusion},
                                                               {"av", Visibility::kAverage}}};

/// Makes all shapes white, diffuse and non-emissive, removes media and all lights. Removes null interfaces, except
/// those in groups. `two_sided`: back sides are white, too.
void make_white(Description& description, bool two_sided);

/// Modifies the scene such that its image is what the integrator computes. The average visibility is weighted uniformly
/// over the hemisphere around the normal, and considers occluders closer than `length` (m). Call it after the scene is
/// read.
void apply_visibility_integrator(Visibility visibility, float length, bool two_sided, Description& description);

}  // namespace sheaf
