#include "scene/compile/textures/mip_levels.h"

#include "scene/textures/bitmap.h"
#include "scene/textures/list.h"
#include "scene/textures/mip_texels.h"

#include <map>
#include <utility>

namespace sheaf {

namespace {

/// Adds to `found` the rows of a texture and of those that it combines.
void add_textures(const TextureTables& textures, std::uint32_t row, std::vector<bool>& found) {
  if (found[row]) return;
  found[row] = true;
  for (const std::uint32_t input : textures.rows[row].used_inputs()) add_textures(textures, input, found);
}

/// Rows of bilinear images that are used as reflectances only.
std::vector<std::uint32_t> reflectance_images(const MaterialTables& materials, const TextureTables& textures) {
  std::vector<bool> colors(textures.rows.size()), others(textures.rows.size());
  for (const TextureBinding& binding : materials.bindings) {
    const bool is_color = binding.role == TextureRole::kReflectance && binding.words == 4;
    // Scalar lookups ignore mip levels
    if (is_color || binding.words == 4 || binding.role == TextureRole::kBurleyLuminance)
      add_textures(textures, binding.texture, is_color ? colors : others);
  }
  for (const NormalMapRow& map : materials.normal_maps) add_textures(textures, map.texture, others);
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < textures.rows.size(); ++i) {
    const TextureRow& row = textures.rows[i];
    if (!colors[i] || others[i] || row.kind != kTextureKind<BitmapDescription>) continue;
    const auto bitmap = row.data<BitmapRow>();
    if (bitmap.filter == TextureFilter::kBilinear && std::max(bitmap.width, bitmap.height) > 1) rows.push_back(i);
  }
  return rows;
}

}  // namespace

std::function<void()> add_mip_levels(const MaterialTables& materials, TextureTables& textures) {
  // Textures that read the same texels in the same way share their levels
  std::map<std::pair<std::uint32_t, TexelFormat>, std::uint32_t> with_levels;
  std::vector<std::shared_ptr<MipLevels>> to_fill;
  for (const std::uint32_t i : reflectance_images(materials, textures)) {
    auto bitmap = textures.rows[i].data<BitmapRow>();
    const auto index = static_cast<std::uint32_t>(textures.images.size());
    const auto [known, is_new] = with_levels.try_emplace({bitmap.image, bitmap.format}, index);
    if (is_new) {
      const std::shared_ptr<TiledImage> image = textures.tiled_images[bitmap.image];
      std::shared_ptr<MipLevels>& levels = bitmap.format == image->format ? image->mip_levels : image->srgb_mip_levels;
      if (!levels) levels = place_levels(*image, bitmap.format);
      textures.images.push_back({image->tiles.data(), levels->levels.data(), levels->tiles.data(), levels.get()});
      textures.tiled_images.push_back(image);
      to_fill.push_back(levels);
    }
    bitmap.image = known->second;
    textures.rows[i].set_data(bitmap);
  }
  return [to_fill = std::move(to_fill)] {
    for (const std::shared_ptr<MipLevels>& levels : to_fill) fill_coarse_levels(*levels);
  };
}

}  // namespace sheaf
