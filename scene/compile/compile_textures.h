// Textures of a description as rows and texels of tables.
#pragma once

#include "scene/tables/texture.h"

#include <map>
#include <span>

namespace sheaf {

/// Loads every picture, once for each way of reading it, and makes the rows. Throws SceneError at the texture's place
/// in the scene file for a picture that is missing, broken, too large, of channels without a meaning, or that has
/// values that are not finite; for checkerboards nested too deep or in each other; and for a transform that is not
/// finite; and for grids as load_volume() does.
CompiledTextures compile_textures(const std::vector<TextureDescription>& textures);

/// A warning for each texture some of whose texels or colours are above 1 or below 0 and are taken for reflectances by
/// one of the bindings: its place, the picture, how many texels, and their range. Of mixed textures nothing is said.
std::vector<std::string> clamped_texel_warnings(const std::vector<TextureDescription>& descriptions,
                                                const CompiledTextures& textures,
                                                std::span<const TextureBinding> bindings);

/// Names of what wireframes read, which no file can give an attribute: see WireframeRow::first_entry.
inline constexpr const char *kEdgeDistances = "face_ edge distances",
                            *kRelativeEdgeDistances = "face_ relative edge distances";

/// The rows that a texture shows parts of: of a checkerboard its colours.
std::vector<std::uint32_t> children_of(const TextureRow& row);

/// Gathers the attributes of all meshes that some texture reads.
class AttributeTable {
 public:
  /// `names` is CompiledTextures::attribute_names; others are not kept.
  explicit AttributeTable(std::vector<std::string> names) : names_(std::move(names)) {}

  /// Whether a texture reads this attribute.
  bool wants(const std::string& name) const;
  /// Whether the attribute, by its index in `names`, was added for the shape.
  bool has(std::uint32_t shape, std::uint32_t name) const { return added_.count({name, shape}) > 0; }

  /// Adds an attribute of the shape, whose triangles are [first_triangle, first_triangle + triangle_count) of
  /// SceneView::triangles; in any order. Face attributes must have been left with as many values as triangles are.
  /// Throws SceneError at `where` if sizes don't agree, a value is not finite, the name begins neither with "vertex_"
  /// nor with "face_", or the shape has an attribute of this name already.
  void add(std::uint32_t shape, std::uint32_t first_triangle, std::uint32_t triangle_count, std::uint32_t vertex_count,
           const Mesh::Attribute& attribute, const SourceLocation& where);

  /// Lays out the table for shapes [0, shape_count) and points the rows of `textures` into it. To be called once, last.
  void finish(std::uint32_t shape_count, CompiledTextures& textures);

  /// After finish(): entries, shape_count for each name.
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
