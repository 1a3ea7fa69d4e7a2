// Adds radiance to the channels of its light group, converted to linear Rec.709 and weighted by the pixel filter.
#include "kernels/wave/light_groups.h"

#include "kernels/wave/path_wavelengths.h"

#include <cmath>

namespace sheaf {

void add_to_light_group(Wave& wave, Slot slot, const Float4& found, std::uint32_t light) noexcept {
  const LightGroupSink& groups = *wave.light_groups;
  const RadianceState<Scalar>& path = wave.radiance.row(slot);
  const std::size_t group = light == kNone ? groups.other : groups.group_of_light[light];
  float* const out = groups.first + (path.task_sample & ~kTransparent) * groups.stride + 3 * group;
  const Spectrum4 radiance = to_spectrum(found);
  Vec3f rgb{radiance.c0, radiance.c1, radiance.c2};
  if (groups.color == ColorMode::kSpectral) {
    const Wavelengths<Scalar> wavelengths = sample_wavelengths<Scalar>(std::fabs(wave.wavelength_samples[slot]));
    rgb = radiance_to_rgb<Scalar>(*groups.sensor, wavelengths, radiance);
  }
  out[0] += rgb.x * path.weight;
  out[1] += rgb.y * path.weight;
  out[2] += rgb.z * path.weight;
}

}  // namespace sheaf
