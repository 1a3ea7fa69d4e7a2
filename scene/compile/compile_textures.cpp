// Compiles textures: loads each image once, checks references, and lays out mesh attributes.
#include "scene/compile/compile_textures.h"

#include "core/color.h"
#include "core/large_pages.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/load_volume.h"
#include "scene/compile/texture_image.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

namespace sheaf {

namespace {

class TextureCompiler {
 public:
  explicit TextureCompiler(const std::vector<TextureDescription>& textures)
      : textures_(textures), depths_(textures.size(), 0) {
    out_.rows.resize(textures.size());
  }

  TextureTables run() {
    for (std::size_t i = 0; i < textures_.size(); ++i) {
      const TextureDescription& texture = textures_[i];
      check(texture);
      TextureRow row;
      std::copy(texture.to_uv.begin(), texture.to_uv.end(), row.to_uv);
      std::visit([&](const auto& model) { make(row, model, texture); }, texture.model);
      out_.rows[i] = row;
    }
    for (std::size_t i = 0; i < textures_.size(); ++i) depth(i);
    join_images();
    place_grids();
    return std::move(out_);
  }

 private:
  static constexpr int kInProgress = -1;

  static SceneError error(const TextureDescription& texture, const std::string& message) {
    return {texture.where, (texture.id.empty() ? "texture: " : "texture '" + texture.id + "': ") + message};
  }

  static void check(const TextureDescription& texture) {
    for (const float entry : texture.to_uv)
      if (!std::isfinite(entry)) throw error(texture, "the transform of its coordinates is not finite");
  }

  void make(TextureRow& row, const BitmapDescription& bitmap, const TextureDescription& texture) {
    row.kind = TextureKind::kBitmap;
    const std::size_t index = image(bitmap, texture);
    const TiledImage& tiled = images_[index];
    TexelFormat format = tiled.format;
    if (format == TexelFormat::kByte1 && !bitmap.raw) format = TexelFormat::kSrgbByte1;
    if (format == TexelFormat::kByte4 && !bitmap.raw) format = TexelFormat::kSrgbByte4;
    row.bitmap = {static_cast<std::uint32_t>(index),
                  tiled.tiles_per_row,
                  tiled.width,
                  tiled.height,
                  bitmap.wrap_u,
                  bitmap.wrap_v,
                  bitmap.filter,
                  format};
  }

  void make(TextureRow& row, const CheckerboardDescription& board, const TextureDescription& texture) {
    row.kind = TextureKind::kCheckerboard;
    row.checkerboard = {{input(board.color0, texture), input(board.color1, texture)}, 0};
  }

  void make(TextureRow& row, const GridTextureDescription& grid, const TextureDescription& texture) {
    if (!(grid.line_width >= 0)) throw error(texture, "'line_width' is negative or not a number");
    row.kind = TextureKind::kGrid;
    row.checkerboard = {{input(grid.color0, texture), input(grid.color1, texture)}, grid.line_width};
  }

  void make(TextureRow& row, const MixTextureDescription& mix, const TextureDescription& texture) {
    row.kind = TextureKind::kMix;
    const float* number = std::get_if<float>(&mix.amount);
    const SpectrumInput amount = number != nullptr ? SpectrumInput(SpectrumDescription::constant(*number))
                                                   : SpectrumInput(std::get<TextureId>(mix.amount));
    row.mix = {{input(mix.color0, texture), input(mix.color1, texture)}, input(amount, texture)};
  }

  void make(TextureRow& row, const MeshAttributeDescription& attribute, const TextureDescription& texture) {
    if (!attribute.name.starts_with("vertex_") && !attribute.name.starts_with("face_")) {
      throw error(texture, "'" + attribute.name +
                               "' is not a mesh attribute (expected a name that begins with 'vertex_' or 'face_')");
    }
    if (!std::isfinite(attribute.scale)) throw error(texture, "'scale' is not finite");
    row.kind = TextureKind::kMeshAttribute;
    row.attribute = {name_index(attribute.name), attribute.scale};
  }

  void make(TextureRow& row, const WireframeDescription& frame, const TextureDescription& texture) {
    if (!(frame.line_width >= 0)) throw error(texture, "'line_width' is negative or not a number");
    if (!(frame.step_width >= 0 && frame.step_width <= 1)) throw error(texture, "'step_width' is not within [0, 1]");
    row.kind = TextureKind::kWireframe;
    const bool relative = frame.line_width == 0;
    const float outer = relative ? 1.0f : frame.line_width;
    row.wireframe = {{input(frame.interior, texture), input(frame.edge, texture)},
                     name_index(relative ? kRelativeEdgeDistances : kEdgeDistances),
                     outer * (1 - frame.step_width),
                     outer};
  }

  /// Index of an attribute in the list of attributes in use, to which it is added if necessary.
  std::uint32_t name_index(const std::string& name) {
    std::vector<std::string>& names = out_.attribute_names;
    const auto found = std::find(names.begin(), names.end(), name);
    const auto index = static_cast<std::uint32_t>(found - names.begin());
    if (found == names.end()) names.push_back(name);
    return index;
  }

  void make(TextureRow& row, const VolumeTextureDescription& volume, const TextureDescription& texture) {
    if (!std::isfinite(volume.scale)) throw error(texture, "'scale' is not finite");
    row.kind = TextureKind::kVolume;
    row.volume = {static_cast<std::uint32_t>(out_.grids.size()), volume.scale};
    try {
      out_.grids.push_back(load_volume(volume.grid, texture.where));
    } catch (const SceneError& problem) { throw at_place(texture.where, problem); }
    if (out_.grids.back().is_empty()) out_.warnings.push_back(volume.grid.file.string() + ": the grid is empty");
    grids_of_.push_back(&texture);
  }

  /// Row of a colour; makes a row for constants.
  std::uint32_t input(const SpectrumInput& value, const TextureDescription& texture) {
    if (const auto* id = std::get_if<TextureId>(&value)) {
      const auto index = static_cast<std::uint32_t>(*id);
      if (index >= textures_.size()) throw error(texture, "refers to a texture that does not exist");
      return index;
    }
    const Vec3f rgb = unbounded_rgb(std::get<SpectrumDescription>(value));
    TextureRow row;
    const bool grey = rgb.x == rgb.y && rgb.y == rgb.z;
    row.constant = {{rgb.x, rgb.y, rgb.z}, grey ? rgb.x : luminance(rgb)};
    out_.rows.push_back(row);
    return static_cast<std::uint32_t>(out_.rows.size() - 1);
  }

  /// Index in images_. Byte images without a colour transform are shared between raw and decoded use; float images are
  /// not.
  std::size_t image(const BitmapDescription& bitmap, const TextureDescription& texture) {
    if (bitmap.made) return made_image(bitmap, texture);
    std::error_code ignored;
    std::filesystem::path file = std::filesystem::weakly_canonical(bitmap.file, ignored);
    if (ignored) file = bitmap.file;
    const auto known = index_of_.find({file, bitmap.raw, bitmap.change});
    if (known != index_of_.end()) return known->second;
    try {
      images_.push_back(load_tiled_image(bitmap.file, bitmap.raw, bitmap.change));
    } catch (const SceneError& problem) { throw error(texture, problem.what()); }
    const std::size_t index = images_.size() - 1;
    for (const bool raw : {false, true})
      if (raw == bitmap.raw || holds_bytes(images_[index].format)) index_of_[{file, raw, bitmap.change}] = index;
    return index;
  }

  /// The same for an image in memory.
  std::size_t made_image(const BitmapDescription& bitmap, const TextureDescription& texture) {
    const auto [known, is_new] = index_of_made_.insert({{bitmap.made.get(), bitmap.change}, images_.size()});
    if (is_new) images_.push_back(tile_image(*bitmap.made, bitmap.change, texture.where));
    return known->second;
  }

  /// Nesting depth of combined textures from here on; `outside` is the number of enclosing ones.
  int depth(std::size_t i, int outside = 0) {
    const std::vector<std::uint32_t> children = children_of(out_.rows[i]);
    if (children.empty()) return 0;
    if (depths_[i] == kInProgress) throw error(textures_[i], "contains itself");
    if (depths_[i] == 0) {
      if (outside == kMaxTextureDepth) throw too_deep(i);
      depths_[i] = kInProgress;
      int deepest = 0;
      for (const std::uint32_t child : children)
        if (child < textures_.size()) deepest = std::max(deepest, depth(child, outside + 1));
      depths_[i] = deepest + 1;
    }
    if (outside + depths_[i] > kMaxTextureDepth) throw too_deep(i);
    return depths_[i];
  }

  SceneError too_deep(std::size_t i) const {
    return error(textures_[i], "more than " + std::to_string(kMaxTextureDepth) + " nested checkerboards and mixes");
  }

  /// Copies tiles and frees their memory progressively, so that the tiles exist only once.
  static void move_tiles(std::vector<TexelTile>& from, TexelTile* to) {
    constexpr std::size_t kBlock = std::size_t{32} << 14;  // tiles, 32 MiB
    for (std::size_t begin = 0; begin < from.size(); begin += kBlock) {
      const std::size_t count = std::min(kBlock, from.size() - begin);
      std::copy_n(&from[begin], count, to + begin);
      release_pages(&from[begin], count * sizeof(TexelTile));
    }
    from = {};
  }

  /// Joins all tiles in one table. Changes the rows' first_tile from the image's index to the index of its first tile.
  void join_images() {
    std::vector<std::size_t> first(images_.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      first[i] = count;
      count += images_[i].tiles.size();
    }
    if (count >= std::size_t{1} << 32) throw SceneError("the scene's textures take more than 256 GiB");
    out_.tile_count = count + 1;
    out_.tiles = std::make_unique_for_overwrite<TexelTile[]>(out_.tile_count);
    prefer_large_pages(out_.tiles.get(), out_.tile_count * sizeof(TexelTile));
    for (std::size_t i = 0; i < images_.size(); ++i) { move_tiles(images_[i].tiles, &out_.tiles[first[i]]); }
    out_.tiles[count] = {};
    for (TextureRow& row : out_.rows)
      if (row.kind == TextureKind::kBitmap)
        row.bitmap.first_tile = static_cast<std::uint32_t>(first[row.bitmap.first_tile]);
  }

  /// Makes the grids' rows, which point into the grids. Call after all grids have been added.
  void place_grids() {
    for (std::size_t i = 0; i < out_.grids.size(); ++i) {
      const GridVolumeDescription& from = std::get<VolumeTextureDescription>(grids_of_[i]->model).grid;
      out_.grid_rows.push_back(place_grid(out_.grids[i], from.to_world, from, grids_of_[i]->where));
    }
  }

  const std::vector<TextureDescription>& textures_;
  std::vector<const TextureDescription*> grids_of_;  ///< per grid
  std::vector<int> depths_;
  std::vector<TiledImage> images_;
  std::map<std::tuple<std::filesystem::path, bool, BitmapDescription::ColorTransform>, std::size_t> index_of_;
  std::map<std::pair<const Image*, BitmapDescription::ColorTransform>, std::size_t> index_of_made_;
  TextureTables out_;
};

}  // namespace

TextureTables compile_textures(const std::vector<TextureDescription>& textures) {
  return TextureCompiler(textures).run();
}

std::vector<std::uint32_t> children_of(const TextureRow& row) {
  switch (row.kind) {
    case TextureKind::kCheckerboard:
    case TextureKind::kGrid:
      return {row.checkerboard.child[0], row.checkerboard.child[1]};
    case TextureKind::kWireframe:
      return {row.wireframe.child[0], row.wireframe.child[1]};
    case TextureKind::kMix:
      return {row.mix.child[0], row.mix.child[1], row.mix.amount};
    default:
      return {};
  }
}

bool AttributeTable::wants(const std::string& name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

void AttributeTable::add(std::uint32_t shape, std::uint32_t first_triangle, std::uint32_t triangle_count,
                         std::uint32_t vertex_count, const Mesh::Attribute& attribute, const SourceLocation& where) {
  const auto fail = [&](const std::string& what) {
    return SceneError(where, "mesh attribute '" + attribute.name + "' " + what);
  };
  const bool per_face = attribute.name.starts_with("face_");
  if (!per_face && !attribute.name.starts_with("vertex_")) throw fail("begins neither with 'vertex_' nor with 'face_'");
  if (attribute.channels != 1 && attribute.channels != 3) {
    throw fail("has " + std::to_string(attribute.channels) + " channels (expected 1 or 3)");
  }
  const auto channels = static_cast<std::uint32_t>(attribute.channels);
  const std::size_t expected = std::size_t{per_face ? triangle_count : vertex_count} * channels;
  if (attribute.values.size() != expected) {
    throw fail("has " + std::to_string(attribute.values.size()) + " values (expected " + std::to_string(expected) +
               ")");
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

void AttributeTable::finish(std::uint32_t shape_count, TextureTables& textures) {
  constexpr std::size_t kMaxEntries = std::size_t{1} << 30;
  if (names_.size() * shape_count > kMaxEntries) throw SceneError("too many shapes for so many mesh attributes");
  entries_.assign(names_.size() * shape_count, {});
  for (const auto& [key, entry] : added_) entries_[std::size_t{key.first} * shape_count + key.second] = entry;
  values_.insert(values_.end(), 3, 0.0f);
  for (TextureRow& row : textures.rows)
    if (row.kind == TextureKind::kMeshAttribute)
      row.attribute.first_entry *= shape_count;
    else if (row.kind == TextureKind::kWireframe)
      row.wireframe.first_entry *= shape_count;
}

}  // namespace sheaf
