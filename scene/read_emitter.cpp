#include "scene/read_emitter.h"

namespace sheaf {

EnvmapDescription read_envmap(Properties& p) {
  EnvmapDescription map;
  map.file = p.file("filename");
  map.scale = p.number("scale", 1, kNotNegative);
  map.to_world = p.transform("to_world");
  map.mis_compensation = p.boolean("mis_compensation", false);
  return map;
}

void check_direction(Properties& p, const char* name, Vec3f direction) {
  const float squared = length_squared(direction);
  if (!(squared > 0.0f) || !is_finite(squared)) p.fail_at(name, "has no length");
}

}  // namespace sheaf
