// Options that bump and normal maps share.
#pragma once

#include "scene/tables/material.h"

namespace sheaf {

class Properties;

/// Treatment of mapped normals.
struct NormalOptions {
  bool fix_invalid_normals = true;  ///< mirror normals that face away from the viewer at the unmapped normal
  bool soften_terminator = true;    ///< soften the shadow terminator (Estevez et al. 2019)

  static NormalOptions read(Properties& p);
  /// Bits of NormalMapRow::flags.
  std::uint32_t flags() const {
    return (fix_invalid_normals ? NormalMapRow::kFixInvalid : 0u) | (soften_terminator ? NormalMapRow::kSoften : 0u);
  }
};

}  // namespace sheaf
