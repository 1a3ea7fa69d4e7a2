// Building of rows of the texture table from the parameters of a texture.
#pragma once

#include "core/io/read_ahead.h"
#include "scene/compile/compile.h"
#include "scene/compile/textures/texture_image.h"
#include "scene/textures/list.h"

#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace sheaf {

/// An image in the table of tiles.
struct PlacedImage {
  std::uint32_t first_tile;  ///< into TextureView::tiles
  std::uint32_t tiles_per_row;
  std::uint32_t width, height;  ///< texels
  TexelFormat format;           ///< bytes are kByte1 or kByte4, decoded or not
};

/// The tables of textures while they are filled. Functions throw SceneError at the texture on whose behalf they act.
class TextureTableBuilder {
 public:
  /// Starts reading the images of the textures, which must outlive the object.
  explicit TextureTableBuilder(const std::vector<TextureDescription>& textures);

  static SceneError error(const TextureDescription& texture, const std::string& message);

  /// Rows of the textures, followed by those of constants.
  std::vector<TextureRow>& rows() { return out_.rows; }
  /// Row of a texture, or of a constant, which is added.
  std::uint32_t row_of(const SpectrumInput& input, const TextureDescription& texture);
  /// Loads an image, once per way of reading it.
  PlacedImage image(const BitmapDescription& bitmap, const TextureDescription& texture);
  /// Loads a grid; returns its index in TextureView::grids.
  std::uint32_t grid(const GridVolumeDescription& grid, const TextureDescription& texture);
  /// Index of an attribute in TextureTables::attribute_names, to which it is added if necessary.
  std::uint32_t attribute(const std::string& name);
  /// Says that the meshes on which a row is used must have the attribute.
  void require_attribute(std::uint32_t row, std::uint32_t attribute) {
    out_.required_attributes.emplace_back(row, attribute);
  }

  /// Completes the tables; appends the grids to `grids` unless it is null. Call once, last.
  TextureTables finish(std::vector<PlacedGrid>* grids);

 private:
  /// The source of an image, and the way of reading it.
  struct ImageKey {
    std::filesystem::path file;    ///< canonical path; empty for images in memory
    const void* memory = nullptr;  ///< BitmapDescription::made or encoded
    bool linear = false;           ///< BitmapDescription::is_linear()
    BitmapDescription::Channel channel = BitmapDescription::Channel::kColor;
    BitmapDescription::ColorTransform change = {};
    friend auto operator<=>(const ImageKey&, const ImageKey&) = default;
  };
  struct LoadedImage {
    TiledImage image;
    std::size_t first_tile;
  };
  struct Grid {
    const GridVolumeDescription* description;
    const TextureDescription* texture;
  };

  /// The key of an image in a file or in memory.
  static ImageKey key_of(const BitmapDescription& bitmap);
  void read_images_ahead();
  std::size_t image_index(const BitmapDescription& bitmap, const TextureDescription& texture);
  static TiledImage load(const BitmapDescription& bitmap, const TextureDescription& texture);
  std::size_t add_image(TiledImage image);
  void join_images();

  const std::vector<TextureDescription>& textures_;
  std::vector<LoadedImage> images_;
  std::size_t tile_count_ = 0;
  std::map<ImageKey, std::size_t> index_of_;
  std::map<ImageKey, std::size_t> job_of_;  ///< of the images that are read ahead and not taken yet
  std::optional<ReadAhead<TiledImage>> ahead_;
  std::vector<Grid> grids_;
  TextureTables out_;
};

/// Builds the row of a texture. The functions are those that make_row() of a kind of textures uses.
class TextureRowBuilder {
 public:
  /// `index`: of the texture in the description.
  TextureRowBuilder(TextureTableBuilder& tables, const TextureDescription& texture, std::uint32_t index)
      : tables_(tables), texture_(texture), index_(index) {}

  /// An error at the texture.
  SceneError error(const std::string& message) const { return TextureTableBuilder::error(texture_, message); }

  /// Sets the data of the row.
  template <class Data> void set(const Data& data) { row_.set_data(data); }
  /// Adds textures or constants to the inputs of the row.
  template <class... Inputs> void add_inputs(const Inputs&... inputs) {
    static_assert(sizeof...(Inputs) <= kMaxTextureInputs, "a row has no room for so many inputs");
    ((row_.inputs[row_.input_count++] = tables_.row_of(as_color(inputs), texture_)), ...);
  }
  PlacedImage load_image(const BitmapDescription& bitmap) { return tables_.image(bitmap, texture_); }
  /// Index of a grid in TextureView::grids.
  std::uint32_t load_grid(const GridVolumeDescription& grid) { return tables_.grid(grid, texture_); }
  /// Index of a mesh attribute in TextureTables::attribute_names, which the compiler computes for every mesh.
  std::uint32_t attribute(const std::string& name) { return tables_.attribute(name); }
  /// The same for an attribute from files. It is an error if no mesh with the texture has it.
  std::uint32_t require_attribute(const std::string& name) {
    const std::uint32_t attribute = tables_.attribute(name);
    tables_.require_attribute(index_, attribute);
    return attribute;
  }

  /// The row of a model. Its `needs` are those of the model alone, without its inputs.
  template <class Description> TextureRow row(const Description& model) {
    row_.kind = kTextureKind<Description>;
    row_.needs = needs_of(Description::kDomain);
    std::copy(texture_.to_uv.begin(), texture_.to_uv.end(), row_.to_uv);
    model.make_row(*this);
    return row_;
  }

 private:
  static const SpectrumInput& as_color(const SpectrumInput& input) { return input; }
  static SpectrumInput as_color(const ScalarInput& input) {
    if (const float* number = std::get_if<float>(&input)) return SpectrumDescription::constant(*number);
    return std::get<TextureId>(input);
  }

  TextureTableBuilder& tables_;
  const TextureDescription& texture_;
  std::uint32_t index_;
  TextureRow row_;
};

}  // namespace sheaf
