// Adds radiance to paths. This is the only entry point for radiance; the limit on indirect light and light groups hook
// in here.
#pragma once

#include "core/color/float4.h"
#include "core/simd/simd_rows.h"
#include "core/soa/lane_array.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Adds `found`, per spectral lane, to the radiance of one path, and to the group of its light if there are light
/// groups. `light`: row of the light, or kNone. `scatterings`: how often the path scatters from its current ray on
/// until it reaches the light, 0 if the ray itself finds the light. Other data of the path is available by its slot.
SHEAF_INLINE void add_radiance(Wave& wave, Slot slot, Float4 found, std::uint32_t light, int scatterings) {
  if (wave.max_indirect < kInfinity) [[unlikely]]
    found = limited_indirect(wave, slot, found, scatterings);
  if (wave.light_groups) [[unlikely]]
    add_to_light_group(wave, slot, found, light);
  Spectrum4& radiance = wave.radiance.row(slot).radiance;
  radiance = to_spectrum(Float4(radiance) + found);
}

/// Same for the lanes set in `lanes`, whose rays have found the lights.
template <class L>
SHEAF_INLINE void add_radiance(Wave& wave, const Slot* slots, std::uint32_t lanes, const Spectrum<L>& found,
                               typename L::Uint light) {
  alignas(kSimdAlignment) float values[L::width][4];
  float* rows[L::width];
  for (int lane = 0; lane < L::width; ++lane) rows[lane] = values[lane];
  const typename L::Float words[4] = {found.c0, found.c1, found.c2, found.c3};
  store_rows4(rows, words, L::width);
  const LaneArray<typename L::Uint> lights(light);
  for_each_lane(lanes, [&](int lane) SHEAF_LAMBDA_INLINE {
    add_radiance(wave, slots[lane], Float4::load(values[lane]), lights[lane], 0);
  });
}

/// Sets the alpha of the path's sample to 0: its ray left the scene without hitting anything visible.
SHEAF_INLINE void mark_transparent(Wave& wave, Slot slot) { wave.radiance.row(slot).task_sample |= kTransparent; }

}  // namespace sheaf
