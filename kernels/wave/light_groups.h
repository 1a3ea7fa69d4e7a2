// Where light goes that paths find, besides their radiance: to the layer of the group that its light belongs to.
#pragma once

#include "core/spectral_sensor.h"

#include <cstddef>
#include <cstdint>

namespace sheaf {

/// The groups' channels in a task's samples. A sample's are red, green and blue (linear Rec.709) of the first group,
/// then of the next.
struct LightGroupSink {
  float* first = nullptr;                         ///< the first group's red in the first sample; null: no groups
  std::size_t stride = 0;                         ///< floats from one sample to the next
  const std::uint16_t* group_of_light = nullptr;  ///< by row of SceneView::lights
  std::uint16_t other = 0;                        ///< the group of light that comes from no row
  const SensorCurves* sensor = nullptr;           ///< spectral mode
};

}  // namespace sheaf
