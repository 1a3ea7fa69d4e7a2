#include "scene/tables/envmap.h"

#include <algorithm>

namespace sheaf {

EnvmapView Envmap::view() const {
  EnvmapView v{nodes.data(), spectra.data(), marginal.data(), conditional.data(), width, height, {}};
  std::copy(std::begin(to_map), std::end(to_map), v.to_map);
  return v;
}

}  // namespace sheaf
