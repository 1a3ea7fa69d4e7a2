// The declarations of a kind of textures. scene/textures/list.h lists the kinds; scene/textures/lookups/lookup.h states
// the interface of their lookups.
//
// A kind is a struct XDescription in scene/textures/<name>.h that holds the parameters as a file gives them, with their
// defaults, and declares
//   kDomain        what it is looked up by, besides its inputs
//   kPlugins       its names in files of the dialects of Mitsuba and Nori: an array, or kNoPlugins
//   kParameters    with kPlugins only: the names of its parameters (scene/description/parameter_names.h), or
//   read(p)        reads them, in scene/textures/<name>.cpp
//   fields()       all parameters
//   colors()       the colors between which it varies. Scaling them scales the texture.
//   kShowsColors   with colors() only: whether each of them shows on a part of the surface
//   scale_by(by)   without colors() only: multiplies the texture's values
//   make_row(row)  makes the row
// A row's data is a struct of at most kTexturePayloadBytes; it may have up to kMaxTextureInputs inputs.
//
// A kind that omits something does not compile.
#pragma once

#include "core/io/error.h"
#include "scene/description/parameter_names.h"
#include "scene/tables/texture.h"

#include <concepts>
#include <span>
#include <string>
#include <string_view>
#include <tuple>

namespace sheaf {

class Properties;
struct BitmapDescription;
struct GridVolumeDescription;

/// The domain of a texture's lookup, besides its inputs.
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

/// An image in the table of images.
struct PlacedImage {
  std::uint32_t index;  ///< into TextureView::images
  std::uint32_t tiles_per_row;
  std::uint32_t width, height;  ///< texels
  TexelFormat format;           ///< bytes are kByte1 or kByte3, decoded or not
};

/// Builds the row of one texture. The scene compiler derives from it, since rows refer to tables that it fills. All
/// functions throw SceneError at the texture.
class TextureRowBuilder {
 public:
  TextureRowBuilder(const TextureRowBuilder&) = delete;
  TextureRowBuilder& operator=(const TextureRowBuilder&) = delete;

  /// Sets the data of the row.
  template <class Data> void set(const Data& data) { row_.set_data(data); }
  /// Adds textures or constants to the inputs of the row.
  template <class... Inputs> void add_inputs(const Inputs&... inputs) {
    static_assert(sizeof...(Inputs) <= kMaxTextureInputs, "a row has no room for so many inputs");
    ((row_.inputs[row_.input_count++] = row_of(as_color(inputs))), ...);
  }
  /// Loads an image, once per way of reading it.
  virtual PlacedImage load_image(const BitmapDescription& bitmap) = 0;
  /// Loads a grid; returns its index in TextureView::grids.
  virtual std::uint32_t load_grid(const GridVolumeDescription& grid) = 0;
  /// Index of a mesh attribute in TextureTables::attribute_names, which the compiler computes for every mesh.
  virtual std::uint32_t attribute(const std::string& name) = 0;
  /// The same for an attribute from files. It is an error if no mesh with the texture has it.
  virtual std::uint32_t require_attribute(const std::string& name) = 0;

  /// An error at the texture.
  virtual SceneError error(const std::string& message) const = 0;
  void expect_finite(float value, const char* name) const;
  void expect_attribute_name(const std::string& name) const;

 protected:
  TextureRowBuilder() = default;
  ~TextureRowBuilder() = default;
  /// The row of a texture, or of a constant, which is added.
  virtual std::uint32_t row_of(const SpectrumInput& input) = 0;

  TextureRow row_;

 private:
  static const SpectrumInput& as_color(const SpectrumInput& input) { return input; }
  static SpectrumInput as_color(const ScalarInput& input);
};

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
&&texture_detail::has_plugins<Description>() == (DeclaresParameters<Description> ||
                                                 requires(Properties & p) {
                                                   { Description::read(p) } -> std::same_as<Description>;
                                                 }) &&
    texture_detail::has_colors<Description>() == requires {
  { Description::kShowsColors } -> std::convertible_to<bool>;
}
&&texture_detail::has_colors<Description>() != requires(Description& texture) { texture.scale_by(1.0f); };

}  // namespace sheaf
