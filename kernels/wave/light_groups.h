// Light groups: the contribution of each group of lights, collected in a layer of its own besides the path's radiance.
#pragma once

#include "core/color/spectral_sensor.h"

#include <cstddef>
#include <cstdint>

namespace sheaf {

/// Channels of the groups in a task's samples. Each sample holds red, green and blue (linear Rec.709) of the first
/// group, then of the next.
struct LightGroupSink {
  float* first = nullptr;                         ///< red of the first group in the first sample
  std::size_t stride = 0;                         ///< floats from one sample to the next
  const std::uint16_t* group_of_light = nullptr;  ///< by row of LightView::rows
  std::uint16_t other = 0;                        ///< group of radiance that has no row
  ColorMode color = ColorMode::kRgb;
  const SensorCurves* sensor = nullptr;  ///< in spectral mode
};

}  // namespace sheaf
