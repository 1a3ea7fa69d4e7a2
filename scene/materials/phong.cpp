#include "scene/materials/phong.h"

#include "scene/materials/reading.h"

namespace sheaf {

PhongDescription PhongDescription::read(Properties& p, const BsdfDialect&) {
  PhongDescription result;
  read_declared(p, result);
  limit_energy(p, result.diffuse_reflectance, result.specular_reflectance);
  return result;
}

}  // namespace sheaf
