// The sun and the sky of the Mitsuba dialect.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf::mitsuba {

/// Whether a plugin is one of daylight_names().
bool is_daylight(const std::string& type);

/// sky, sun, sunsky and timed_sunsky.
const std::vector<std::string>& daylight_names();

/// The lights that such an emitter consists of. `y_is_up`: its space is that of releases before 2, where +y is up, +x
/// east and -z north; later +z is up, +x south and +y west. The caller finishes `p`. Throws SceneError.
std::vector<LightDescription> read_daylight(Properties& p, bool y_is_up);

}  // namespace sheaf::mitsuba
