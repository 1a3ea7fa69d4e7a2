// The list of the lookups of all kinds of textures, in the order of scene/textures/list.h.
#pragma once

#include "scene/textures/list.h"
#include "scene/textures/lookups/bitmap.h"
#include "scene/textures/lookups/checkerboard.h"
#include "scene/textures/lookups/constant.h"
#include "scene/textures/lookups/grid.h"
#include "scene/textures/lookups/mesh_attribute.h"
#include "scene/textures/lookups/mix.h"
#include "scene/textures/lookups/volume.h"
#include "scene/textures/lookups/wireframe.h"

#include <type_traits>

namespace sheaf {

/// A list of lookups, as types.
template <TextureLookups... Textures> struct TextureList {
  using Kinds = TextureKindList<typename Textures::Description...>;

  /// Calls f.operator()<Texture>() for the kind.
  template <class F> static SHEAF_INLINE auto with(TextureKind kind, F&& f) { return with<F, Textures...>(kind, f); }

 private:
  template <class F, class Texture, class... More> static SHEAF_INLINE auto with(TextureKind kind, F& f) {
    if constexpr (sizeof...(More) > 0)
      if (kind != kTextureKind<typename Texture::Description>) return with<F, More...>(kind, f);
    return f.template operator()<Texture>();
  }
};

/// The lookups of all kinds.
using Textures = TextureList<ConstantTexture,       //
                             BitmapTexture,         //
                             CheckerboardTexture,   //
                             GridTexture,           //
                             MeshAttributeTexture,  //
                             VolumeTexture,         //
                             MixTexture,            //
                             WireframeTexture>;
static_assert(std::is_same_v<Textures::Kinds, TextureKinds>, "the list must match that of scene/textures/list.h");

}  // namespace sheaf
