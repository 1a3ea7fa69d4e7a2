// Names of materials in files, and reading by name.
#pragma once

#include "scene/materials/reading.h"

#include <span>

namespace sheaf {

/// A name of a material in files, and the function that reads its properties.
struct BsdfPlugin {
  const char* name;
  MaterialModel (*read)(Properties& p, const BsdfDialect& dialect);
};

/// Reads the plugin of an object. Names in `own`, those of the dialect, take precedence over those of the models
/// (kPlugins). The caller finishes `p`. Throws SceneError, also for unknown plugins.
MaterialModel read_bsdf_plugin(Properties& p, const BsdfDialect& dialect, std::span<const BsdfPlugin> own);

/// All names of models in files (kPlugins), in alphabetical order.
std::span<const BsdfPlugin> bsdf_plugins();

}  // namespace sheaf
