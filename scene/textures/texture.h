// What a kind of textures declares. scene/textures/list.h lists the kinds; scene/textures/lookups/lookup.h states the
// interface of their lookups.
//
// A kind is a struct XDescription in scene/textures/<name>.h that holds the parameters as a file gives them, with their
// defaults, and declares
//   kDomain        what it is looked up by, besides its inputs
//   kPlugins       its names in files of the dialects of Mitsuba and Nori: an array, or kNoTexturePlugins
//   read(p)        reads the properties; with kPlugins only
//   fields()       all parameters
//   colors()       the colours between which it varies. Scaling them scales the texture.
//   kShowsColors   with colors() only: whether each of them shows on a part of the surface
//   scale_by(by)   without colors() only: multiplies the texture's values
//   make_row(row)  makes the row, with the functions of the TextureRowBuilder
//   (scene/compile/textures/texture_row_builder.h)
// read() and make_row() are templates, because the headers of readers and of the builder come after the list. A row's
// data is a struct of at most kTexturePayloadBytes; it may have up to kMaxTextureInputs inputs.
//
// A kind that omits something does not compile.
#pragma once

#include "core/io/error.h"
#include "scene/description/inputs.h"
#include "scene/tables/texture.h"

#include <array>
#include <concepts>
#include <span>
#include <string>
#include <string_view>
#include <tuple>

namespace sheaf {

class Properties;
class TextureRowBuilder;

/// What a texture is looked up by, besides its inputs.
enum class TextureDomain {
  kNothing,  ///< nothing: it is constant, or varies by its inputs alone
  kUv,       ///< uv, transformed by TextureDescription::to_uv
  kImage,    ///< as kUv; v = 0 is the edge of the image that the dialect says
  kMesh,     ///< a point on a triangle: values stored with meshes
  kPoint,    ///< the position in world space
};

/// TextureRow::needs for a domain.
constexpr std::uint8_t needs_of(TextureDomain domain) {
  if (domain == TextureDomain::kMesh) return kTextureNeedsMesh;
  return domain == TextureDomain::kPoint ? kTextureNeedsPoint : 0;
}

/// Whether a name can be that of a mesh attribute.
inline bool is_attribute_name(std::string_view name) {
  return name.starts_with("vertex_") || name.starts_with("face_");
}

/// Throws the error of the TextureRowBuilder `row` if it cannot.
void check_attribute_name(const auto& row, const std::string& name) {
  if (!is_attribute_name(name))
    throw row.error("'" + name + "' is not a mesh attribute (expected a name that begins with 'vertex_' or 'face_')");
}

/// kPlugins of a kind that only one dialect can write.
inline constexpr std::array<const char*, 0> kNoTexturePlugins{};

namespace texture_detail {

template <class Description> constexpr bool has_plugins() {
  return !std::span<const char* const>(Description::kPlugins).empty();
}
template <class Description> constexpr bool has_colors() {
  return std::tuple_size_v<decltype(Description::colors(std::declval<Description&>()))> > 0;
}

}  // namespace texture_detail

/// The requirements on a kind that the compiler can check; see above.
template <class Description>
concept CompleteTexture = requires(Description& texture, const Description& same, TextureRowBuilder& row) {
  { Description::kDomain } -> std::convertible_to<TextureDomain>;
  { Description::kPlugins } -> std::convertible_to<std::span<const char* const>>;
  Description::fields(same);
  Description::colors(same);
  Description::colors(texture);
  same.make_row(row);
}
&&texture_detail::has_plugins<Description>() == requires(Properties& p) {
  { Description::read(p) } -> std::same_as<Description>;
}
&&texture_detail::has_colors<Description>() == requires {
  { Description::kShowsColors } -> std::convertible_to<bool>;
}
&&texture_detail::has_colors<Description>() != requires(Description& texture) { texture.scale_by(1.0f); };

}  // namespace sheaf
