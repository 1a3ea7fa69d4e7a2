#include "scene/textures/constant.h"

#include "core/color/color.h"
#include "scene/spectra/spectrum_rgb.h"

namespace sheaf {

ConstantRow constant_row(const SpectrumDescription& value) {
  const Vec3f rgb = unbounded_rgb(value);
  const bool gray = rgb.x == rgb.y && rgb.y == rgb.z;
  return {{rgb.x, rgb.y, rgb.z}, gray ? rgb.x : luminance(rgb)};
}

}  // namespace sheaf
