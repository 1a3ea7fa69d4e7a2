#include "scene/description/filter_check.h"

#include <cstdio>

namespace sheaf {

void check_filter_radius(double radius, const SourceLocation& where) {
  if (radius > 0 && radius <= kMaxFilterRadius) return;
  char message[160];
  std::snprintf(message, sizeof(message),
                "the reconstruction filter has a radius of %g pixels, expected one above 0 and at most %g", radius,
                kMaxFilterRadius);
  throw SceneError(where, message);
}

}  // namespace sheaf
