// Metals and other solids of Palik's handbook, beside those of scene/data/metals.cpp.
#pragma once

#include "scene/data/metals.h"

namespace sheaf {

/// A material that scenes may name, and its samples; see find_metal().
struct NamedMetal {
  const char* name;
  std::span<const MetalSample> samples;
};

/// All of them, in order of the alphabet.
std::span<const NamedMetal> palik_metals();

}  // namespace sheaf
