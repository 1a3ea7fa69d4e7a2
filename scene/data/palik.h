// Metals and other solids of Palik's handbook, which extend those of scene/data/metals.cpp.
#pragma once

#include "scene/data/metals.h"

namespace sheaf {

/// A named material with its samples; see find_metal().
struct NamedMetal {
  const char* name;
  std::span<const MetalSample> samples;
};

/// Returns all materials in alphabetical order.
std::span<const NamedMetal> palik_metals();

}  // namespace sheaf
