// The list of all kinds of textures. From it derive TextureKind, TextureDescription::model, the names in files with
// their readers, the rows, and the list of lookups in scene/textures/lookups/list.h.
#pragma once

#include "scene/textures/bitmap.h"
#include "scene/textures/checkerboard.h"
#include "scene/textures/constant.h"
#include "scene/textures/direction.h"
#include "scene/textures/grid.h"
#include "scene/textures/mesh_attribute.h"
#include "scene/textures/mix.h"
#include "scene/textures/opacity.h"
#include "scene/textures/product.h"
#include "scene/textures/threshold.h"
#include "scene/textures/uv_set.h"
#include "scene/textures/volume.h"
#include "scene/textures/wireframe.h"

#include <algorithm>
#include <string>
#include <type_traits>
#include <variant>

namespace sheaf {

/// A list of kinds of textures.
template <CompleteTexture... Descriptions> struct TextureKindList {
  static constexpr std::size_t kCount = sizeof...(Descriptions);
  using Model = std::variant<Descriptions...>;

  /// The position of a kind.
  template <class Description> static consteval TextureKind kind_of() {
    static_assert((int{std::is_same_v<Description, Descriptions>} + ...) == 1, "a kind must be listed once");
    constexpr bool kMatches[] = {std::is_same_v<Description, Descriptions>...};
    return static_cast<TextureKind>(std::find(kMatches, kMatches + kCount, true) - kMatches);
  }
  /// Calls f.operator()<Description>() for each kind.
  template <class F> static void for_each(F&& f) { (f.template operator()<Descriptions>(), ...); }
};

/// All kinds of textures, in the order of TextureKind.
using TextureKinds = TextureKindList<ConstantTextureDescription,   //
                                     BitmapDescription,            //
                                     CheckerboardDescription,      //
                                     GridTextureDescription,       //
                                     MeshAttributeDescription,     //
                                     VolumeTextureDescription,     //
                                     MixTextureDescription,        //
                                     WireframeDescription,         //
                                     ProductTextureDescription,    //
                                     ThresholdTextureDescription,  //
                                     OpacityTextureDescription,    //
                                     DirectionTextureDescription,  //
                                     UvSetTextureDescription>;

/// The TextureKind of a kind, such as kTextureKind<BitmapDescription>.
template <class Description> inline constexpr TextureKind kTextureKind = TextureKinds::kind_of<Description>();

/// A texture of any kind.
using TextureModel = TextureKinds::Model;

/// A texture of a scene.
struct TextureDescription {
  TextureModel model;
  /// Rows of the 2x3 matrix that maps the surface's uv to the texture's: u' = m[0] u + m[1] v + m[2]. (0, 0) is the
  /// lower left corner of an image.
  std::array<float, 6> to_uv{1, 0, 0, 0, 1, 0};
  std::string id;  ///< name for messages; may be empty
  SourceLocation where;
};

/// Calls f(color) for each of the colors between which a texture varies.
template <class F> void for_each_color(TextureModel& model, F&& f) {
  std::visit(
      [&]<class Description>(Description& texture) {
        std::apply([&](auto&... color) { (f(color), ...); }, Description::colors(texture));
      },
      model);
}

/// The model with its values multiplied by `by`. `scaled_color` returns the product of a SpectrumInput.
template <class ScaledColor> TextureModel scaled_texture(TextureModel model, float by, ScaledColor&& scaled_color) {
  for_each_color(model, [&](SpectrumInput& color) { color = scaled_color(color); });
  std::visit(
      [&](auto& texture) {
        if constexpr (requires { texture.scale_by(by); }) texture.scale_by(by);
      },
      model);
  return model;
}

/// The domain of a texture's lookup.
inline TextureDomain domain_of(const TextureModel& model) {
  return std::visit([]<class Description>(const Description&) { return Description::kDomain; }, model);
}

}  // namespace sheaf
