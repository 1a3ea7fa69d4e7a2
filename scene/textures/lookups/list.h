// The lookups of all kinds of textures: LookupOf of each kind in scene/textures/list.h. CMake collects their headers.
#pragma once

#include "scene/textures/list.h"
#include "scene/textures/lookups/all_headers.h"
#include "scene/textures/lookups/lookup.h"

namespace sheaf {

namespace lookup_detail {

/// Whether a kind has valid lookups.
template <class Description>
concept Implemented = TextureLookups<typename LookupOf<Description>::Type> &&
    std::same_as<typename LookupOf<Description>::Type::Description, Description>;

template <class List> struct TextureList;
template <class... Descriptions> struct TextureList<TextureKindList<Descriptions...>> {
  static_assert(
      (Implemented<Descriptions> && ...),
      "a kind in scene/textures/list.h has no lookups: no header begins a line with 'template <> struct LookupOf<'");

  /// Calls f.operator()<Texture>() for the kind.
  template <class F> static SHEAF_INLINE auto with(TextureKind kind, F&& f) {
    return with<F, Descriptions...>(kind, f);
  }

 private:
  template <class F, class Description, class... More> static SHEAF_INLINE auto with(TextureKind kind, F& f) {
    if constexpr (sizeof...(More) > 0)
      if (kind != kTextureKind<Description>) return with<F, More...>(kind, f);
    return f.template operator()<typename LookupOf<Description>::Type>();
  }
};

}  // namespace lookup_detail

/// The lookups of all kinds.
using Textures = lookup_detail::TextureList<TextureKinds>;

}  // namespace sheaf
