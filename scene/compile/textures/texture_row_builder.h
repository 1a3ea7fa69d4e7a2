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

/// The tables of textures while they are filled. Functions throw SceneError at the texture on whose behalf they act.
class TextureTableBuilder {
 public:
  /// Starts reading the images of the textures, which must outlive the object.
  explicit TextureTableBuilder(const std::vector<TextureDescription>& textures);

  static SceneError error(const TextureDescription& texture, const std::string& message,
                          SceneErrorCode code = SceneErrorCode::kInvalid);

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
  struct Grid {
    const GridVolumeDescription* description;
    const TextureDescription* texture;
  };

  /// The key of an image in a file or in memory.
  static ImageKey key_of(const BitmapDescription& bitmap);
  void read_images_ahead();
  std::size_t image_index(const BitmapDescription& bitmap, const TextureDescription& texture);
  static std::shared_ptr<TiledImage> load(const BitmapDescription& bitmap, const TextureDescription& texture);

  const std::vector<TextureDescription>& textures_;
  std::map<ImageKey, std::size_t> index_of_;  ///< in TextureTables::images
  std::map<ImageKey, std::size_t> job_of_;    ///< of the images that are read ahead and not taken yet
  std::optional<ReadAhead<std::shared_ptr<TiledImage>>> ahead_;
  std::vector<Grid> grids_;
  TextureTables out_;
};

/// Builds the row of a texture in the tables.
class TextureRowCompiler final : public TextureRowBuilder {
 public:
  /// `index`: of the texture in the description.
  TextureRowCompiler(TextureTableBuilder& tables, const TextureDescription& texture, std::uint32_t index)
      : tables_(tables), texture_(texture), index_(index) {}

  SceneError error(const std::string& message) const override { return TextureTableBuilder::error(texture_, message); }
  PlacedImage load_image(const BitmapDescription& bitmap) override { return tables_.image(bitmap, texture_); }
  std::uint32_t load_grid(const GridVolumeDescription& grid) override { return tables_.grid(grid, texture_); }
  std::uint32_t attribute(const std::string& name) override { return tables_.attribute(name); }
  std::uint32_t require_attribute(const std::string& name) override {
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
  std::uint32_t row_of(const SpectrumInput& input) override { return tables_.row_of(input, texture_); }

  TextureTableBuilder& tables_;
  const TextureDescription& texture_;
  std::uint32_t index_;
};

}  // namespace sheaf
