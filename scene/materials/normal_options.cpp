#include "scene/materials/normal_options.h"

#include "scene/xml/properties.h"

namespace sheaf {

NormalOptions NormalOptions::read(Properties& p) {
  NormalOptions result;
  result.fix_invalid_normals = p.boolean("flip_invalid_normals", true);
  result.soften_terminator = p.boolean("use_shadowing_function", true);
  return result;
}

}  // namespace sheaf
