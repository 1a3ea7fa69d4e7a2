// Compiles the textures of a description.
#pragma once

#include "scene/compile/compile.h"
#include "scene/tables/texture.h"

#include <map>
#include <span>

namespace sheaf {

/// Loads every image, once per way of reading it, and makes the rows. Appends the volume grids to `grids`, unless it is
/// null. Reports errors at the texture's location, and makes it gray (`errors` null: throws): an image that is missing,
/// broken, too large, has unknown channels or non-finite values; for textures nested too deep or in a cycle; for a
/// transform that is not finite; and for grids like load_volume().
TextureTables compile_textures(const std::vector<TextureDescription>& textures,
                               std::vector<PlacedGrid>* grids = nullptr, ErrorSink* errors = nullptr);

/// What becomes of a texture that cannot be compiled, for messages, and its row.
inline constexpr const char* kGraySubstitute = "the texture is gray";
TextureRow gray_texture_row();

/// Warnings about textures that are bound as reflectances and have texels or colors outside [0, 1]: location, image,
/// number of texels, and range. Mixes are not checked.
std::vector<std::string> clamped_texel_warnings(const std::vector<TextureDescription>& descriptions,
                                                const TextureTables& textures,
                                                std::span<const TextureBinding> bindings);

/// Collects the attributes of all meshes that textures use.
class AttributeTable {
 public:
  /// `names` is TextureTables::attribute_names; other attributes are dropped.
  explicit AttributeTable(std::vector<std::string> names) : names_(std::move(names)) {}

  /// Whether a texture uses this attribute.
  bool wants(const std::string& name) const;
  /// Whether the attribute, given by its index in `names`, was added for the shape.
  bool has(std::uint32_t shape, std::uint32_t name) const { return added_.count({name, shape}) > 0; }

  /// Adds an attribute of the shape, whose triangles are [first_triangle, first_triangle + triangle_count) of
  /// GeometryView::triangles. Calls may come in any order. Face attributes have one value per remaining triangle.
  /// Throws SceneError at `where` for wrong sizes, non-finite values, a name without the prefix "vertex_" or "face_",
  /// or a duplicate name.
  void add(std::uint32_t shape, std::uint32_t first_triangle, std::uint32_t triangle_count, std::uint32_t vertex_count,
           const Mesh::Attribute& attribute, const SourceLocation& where);

  /// Removes the attributes of a shape.
  void remove(std::uint32_t shape);

  /// Lays out the table for shapes [0, shape_count). Call once, after all add().
  void finish(std::uint32_t shape_count);

  /// After finish(): shape_count entries per name.
  const std::vector<AttributeEntry>& entries() const { return entries_; }
  /// After finish(): all values, with padding.
  const std::vector<float>& values() const { return values_; }

 private:
  std::vector<std::string> names_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, AttributeEntry> added_;  ///< by name and shape
  std::vector<AttributeEntry> entries_;
  std::vector<float> values_;
};

}  // namespace sheaf
