// Sun and sky emitters of the Mitsuba dialect.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf::mitsuba {

/// Whether a plugin is one of daylight_names().
bool is_daylight(const std::string& type);

/// sky, sun, sunsky and timed_sunsky.
const std::vector<std::string>& daylight_names();

/// Returns the lights of a sun and sky emitter. `y_is_up`: coordinates of releases before 2 (+y up, +x east, -z north);
/// otherwise +z is up, +x south and +y west. The caller finishes `p`. Throws SceneError.
std::vector<LightDescription> read_daylight(Properties& p, bool y_is_up);

}  // namespace sheaf::mitsuba
