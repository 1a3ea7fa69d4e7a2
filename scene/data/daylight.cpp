#include "scene/data/daylight.h"

#include "scene/data/daylight_tables.h"

namespace sheaf::daylight_data {

static_assert(std::size(kSkyShape) == kTurbidities * 2 * kControlPoints * 3 * kSkyParameters);
static_assert(std::size(kSkyRadiance) == kTurbidities * 2 * kControlPoints * 3);
static_assert(std::size(kSunRadiance) == kTurbidities * kSunPieces * kSunWavelengths * kSunOrder);
static_assert(std::size(kLimbDarkening) == kSunWavelengths * kLimbOrder);

std::span<const float> sky_shape() { return kSkyShape; }
std::span<const float> sky_radiance() { return kSkyRadiance; }
std::span<const float> sun_radiance() { return kSunRadiance; }
std::span<const float> limb_darkening() { return kLimbDarkening; }

}  // namespace sheaf::daylight_data
