// Compiles textures: makes their rows, checks references, and lays out mesh attributes.
#include "scene/compile/textures/compile_textures.h"

#include "scene/compile/textures/texture_row_builder.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace sheaf {

namespace {

/// Checks the nesting of textures. Makes those gray that cannot be looked up.
class NestingCheck {
 public:
  /// `rows`: first those of `textures`.
  NestingCheck(const std::vector<TextureDescription>& textures, std::vector<TextureRow>& rows, ErrorSink* errors)
      : textures_(textures), rows_(rows), errors_(errors), depths_(textures.size(), 0) {}

  /// Reports a texture that contains itself or is nested too deep. Adds the needs of its inputs to those of each
  /// texture.
  void run() {
    for (std::size_t i = 0; i < textures_.size(); ++i) depth(i);
    for (const std::size_t i : broken_) rows_[i] = gray_texture_row();
  }

 private:
  static constexpr int kInProgress = -1;

  /// Nesting depth of combined textures from here on; `outside` is the number of enclosing ones.
  int depth(std::size_t i, int outside = 0) {
    TextureRow& row = rows_[i];
    if (row.input_count == 0) return 0;
    if (broken_.contains(i)) return 0;
    if (depths_[i] == kInProgress) return drop(i, TextureTableBuilder::error(textures_[i], "contains itself"));
    if (depths_[i] == 0) {
      if (outside == kMaxTextureDepth) return drop(i, too_deep(i));
      depths_[i] = kInProgress;
      int deepest = 0;
      for (const std::uint32_t input : row.used_inputs()) {
        if (input < textures_.size()) deepest = std::max(deepest, depth(input, outside + 1));
        row.needs |= rows_[input].needs;
      }
      depths_[i] = deepest + 1;
    }
    if (outside + depths_[i] > kMaxTextureDepth) return drop(i, too_deep(i));
    return depths_[i];
  }

  /// Reports an error of a texture, whose row becomes that of a constant. Returns its depth.
  int drop(std::size_t i, const SceneError& error) {
    report_to(errors_, error, kGraySubstitute);
    broken_.insert(i);
    return 0;
  }

  SceneError too_deep(std::size_t i) const {
    return TextureTableBuilder::error(textures_[i], fmt::format("more than {} nested textures", kMaxTextureDepth));
  }

  const std::vector<TextureDescription>& textures_;
  std::vector<TextureRow>& rows_;
  ErrorSink* errors_;
  std::vector<int> depths_;
  std::set<std::size_t> broken_;
};

/// Makes the row of a texture. Throws SceneError.
TextureRow compile_row(const TextureDescription& texture, std::size_t index, TextureTableBuilder& tables) {
  for (const float entry : texture.to_uv)
    if (!std::isfinite(entry))
      throw TextureTableBuilder::error(texture, "the transform of its coordinates is not finite");
  TextureRowCompiler builder(tables, texture, static_cast<std::uint32_t>(index));
  return std::visit([&](const auto& model) { return builder.row(model); }, texture.model);
}

}  // namespace

TextureRow gray_texture_row() {
  TextureRow row;
  row.kind = kTextureKind<ConstantTextureDescription>;
  row.set_data(constant_row(SpectrumDescription::constant(0.5f)));
  return row;
}

TextureTables compile_textures(const std::vector<TextureDescription>& textures, std::vector<PlacedGrid>* grids,
                               ErrorSink* errors) {
  TextureTableBuilder tables(textures);
  for (std::size_t i = 0; i < textures.size(); ++i) {
    TextureRow row;
    try {
      row = compile_row(textures[i], i, tables);
    } catch (const SceneError& error) {
      report_to(errors, error, kGraySubstitute);
      row = gray_texture_row();
    }
    tables.rows()[i] = row;
  }
  NestingCheck(textures, tables.rows(), errors).run();
  return tables.finish(grids);
}

void AttributeTable::remove(std::uint32_t shape) {
  std::erase_if(added_, [&](const auto& added) { return added.first.second == shape; });
}

bool AttributeTable::wants(const std::string& name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

void AttributeTable::add(std::uint32_t shape, std::uint32_t first_triangle, std::uint32_t triangle_count,
                         std::uint32_t vertex_count, const Mesh::Attribute& attribute, const SourceLocation& where) {
  const auto fail = [&](const std::string& what) {
    return SceneError(where, fmt::format("mesh attribute '{}' {}", attribute.name, what));
  };
  const bool per_face = attribute.name.starts_with("face_");
  if (!per_face && !attribute.name.starts_with("vertex_")) throw fail("begins neither with 'vertex_' nor with 'face_'");
  if (attribute.channels != 1 && attribute.channels != 3) {
    throw fail(fmt::format("has {} channels (expected 1 or 3)", attribute.channels));
  }
  const auto channels = static_cast<std::uint32_t>(attribute.channels);
  const std::size_t expected = std::size_t{per_face ? triangle_count : vertex_count} * channels;
  if (attribute.values.size() != expected) {
    throw fail(fmt::format("has {} values (expected {})", attribute.values.size(), expected));
  }
  if (!std::all_of(attribute.values.begin(), attribute.values.end(), [](float v) { return std::isfinite(v); })) {
    throw fail("has values that are not finite");
  }
  const auto found = std::find(names_.begin(), names_.end(), attribute.name);
  if (found == names_.end() || triangle_count == 0) return;
  const auto name = static_cast<std::uint32_t>(found - names_.begin());
  constexpr std::size_t kMaxValues = 0xffffffffu;
  if (values_.size() > kMaxValues - expected) throw fail("has too many values for all attributes together");
  const AttributeEntry entry{static_cast<std::uint32_t>(values_.size()),
                             channels | (per_face ? AttributeEntry::kPerFace : 0u), first_triangle, triangle_count};
  if (!added_.insert({{name, shape}, entry}).second) throw fail("appears twice");
  values_.insert(values_.end(), attribute.values.begin(), attribute.values.end());
}

void AttributeTable::finish(std::uint32_t shape_count) {
  constexpr std::size_t kMaxEntries = std::size_t{1} << 30;
  if (names_.size() * shape_count > kMaxEntries) throw SceneError("too many shapes for so many mesh attributes");
  entries_.assign(names_.size() * shape_count, {});
  for (const auto& [key, entry] : added_) entries_[std::size_t{key.first} * shape_count + key.second] = entry;
  values_.insert(values_.end(), 3, 0.0f);
}

}  // namespace sheaf
