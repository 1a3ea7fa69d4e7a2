#include "scene/compile/textures/texture_row_builder.h"

#include "core/image/image.h"
#include "scene/compile/media/load_volume.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Estimated peak memory for reading an image, in bytes. Readers check large images themselves.
double reading_bytes(const BitmapDescription& bitmap) {
  if (bitmap.made) return static_cast<double>(bitmap.made->pixel_count() * sizeof(float) * 4);
  constexpr double kPerByte = 60;  // JPEG at 1 bit per pixel: the pixels and their tiles
  if (bitmap.encoded) return kPerByte * static_cast<double>(bitmap.encoded->bytes.size());
  std::error_code failure;
  const std::uintmax_t size = std::filesystem::file_size(bitmap.file, failure);
  if (failure) return 0;
  // The headers of large files give a better estimate: the pixels, and tiles of up to four values per pixel
  constexpr double kLarge = 1 << 20, kCopies = 2.5;
  const auto by_size = kPerByte * static_cast<double>(size);
  if (static_cast<double>(size) < kLarge) return by_size;
  const double values = stored_image_bytes(bitmap.file);
  return values > 0 ? std::min(by_size, kCopies * values) : by_size;
}

}  // namespace

SceneError TextureTableBuilder::error(const TextureDescription& texture, const std::string& message,
                                      SceneErrorCode code) {
  const std::string title = texture.id.empty() ? "texture" : fmt::format("texture '{}'", texture.id);
  return SceneError(texture.where, fmt::format("{}: {}", title, message), code).about(title);
}

std::uint32_t TextureTableBuilder::row_of(const SpectrumInput& input, const TextureDescription& texture) {
  if (const auto* id = std::get_if<TextureId>(&input)) {
    const auto index = static_cast<std::uint32_t>(*id);
    if (index >= textures_.size()) throw error(texture, "refers to a texture that does not exist");
    return index;
  }
  TextureRow row;
  row.kind = kTextureKind<ConstantTextureDescription>;
  row.set_data(constant_row(std::get<SpectrumDescription>(input)));
  out_.rows.push_back(row);
  return static_cast<std::uint32_t>(out_.rows.size() - 1);
}

PlacedImage TextureTableBuilder::image(const BitmapDescription& bitmap, const TextureDescription& texture) {
  const std::size_t index = image_index(bitmap, texture);
  const TiledImage& image = *out_.tiled_images[index];
  return {static_cast<std::uint32_t>(index), image.tiles_per_row, image.width, image.height, image.format};
}

TextureTableBuilder::TextureTableBuilder(const std::vector<TextureDescription>& textures) : textures_(textures) {
  out_.rows.resize(textures.size());
  read_images_ahead();
}

TextureTableBuilder::ImageKey TextureTableBuilder::key_of(const BitmapDescription& bitmap) {
  ImageKey key{{}, bitmap.made.get(), bitmap.is_linear(), bitmap.channel, bitmap.change};
  if (bitmap.encoded && !bitmap.made) key.memory = bitmap.encoded.get();
  if (key.memory == nullptr) {
    std::error_code ignored;
    key.file = std::filesystem::weakly_canonical(bitmap.file, ignored);
    if (ignored) key.file = bitmap.file;
  }
  return key;
}

void TextureTableBuilder::read_images_ahead() {
  std::vector<ReadAhead<std::shared_ptr<TiledImage>>::Job> jobs;
  for (const TextureDescription& texture : textures_) {
    const auto* bitmap = std::get_if<BitmapDescription>(&texture.model);
    if (bitmap == nullptr) continue;
    // Byte images serve linear and decoded use: read one of the two
    ImageKey key = key_of(*bitmap);
    key.linear = !key.linear;
    if (job_of_.count(key) > 0) continue;
    key.linear = !key.linear;
    if (job_of_.try_emplace(key, jobs.size()).second)
      jobs.push_back({[bitmap, &texture] { return load(*bitmap, texture); }, reading_bytes(*bitmap)});
  }
  ahead_.emplace(std::move(jobs), read_ahead_bytes());
}

/// Index in TextureTables::images. Byte images without a color transform are shared between linear and decoded use;
/// float images are not.
std::size_t TextureTableBuilder::image_index(const BitmapDescription& bitmap, const TextureDescription& texture) {
  ImageKey key = key_of(bitmap);
  const auto known = index_of_.find(key);
  if (known != index_of_.end()) return known->second;
  const auto job = job_of_.find(key);
  const std::shared_ptr<TiledImage> image = job != job_of_.end() ? ahead_->take(job->second) : load(bitmap, texture);
  const std::size_t index = out_.images.size();
  out_.images.push_back({image->tiles.data()});
  out_.tiled_images.push_back(image);
  const bool is_shared = bitmap.made || holds_bytes(image->format);
  for (const bool linear : {false, true})
    if (linear == bitmap.is_linear() || is_shared) {
      key.linear = linear;
      index_of_[key] = index;
    }
  return index;
}

std::shared_ptr<TiledImage> TextureTableBuilder::load(const BitmapDescription& bitmap,
                                                      const TextureDescription& texture) {
  if (bitmap.made) return load_tiled_image(bitmap, texture.where);
  try {
    return load_tiled_image(bitmap, texture.where);
  } catch (const SceneError& problem) { throw error(texture, problem.what(), problem.code()); }
}

std::uint32_t TextureTableBuilder::grid(const GridVolumeDescription& grid, const TextureDescription& texture) {
  try {
    out_.grids.push_back(load_volume(grid, texture.where));
  } catch (const SceneError& problem) { throw at_location(texture.where, problem); }
  if (out_.grids.back().is_empty()) out_.warnings.push_back(grid.file.string() + ": the grid is empty");
  grids_.push_back({&grid, &texture});
  return static_cast<std::uint32_t>(grids_.size() - 1);
}

std::uint32_t TextureTableBuilder::attribute(const std::string& name) {
  std::vector<std::string>& names = out_.attribute_names;
  const auto found = std::find(names.begin(), names.end(), name);
  const auto index = static_cast<std::uint32_t>(found - names.begin());
  if (found == names.end()) names.push_back(name);
  return index;
}

TextureTables TextureTableBuilder::finish(std::vector<PlacedGrid>* grids) {
  for (std::size_t i = 0; i < out_.grids.size(); ++i) {
    const GridVolumeDescription& from = *grids_[i].description;
    const SourceLocation& where = grids_[i].texture->where;
    out_.grid_rows.push_back(place_grid(out_.grids[i], from.to_world, from, where));
    if (grids != nullptr) grids->push_back(describe_grid(out_.grids[i], from.to_world, from, where));
  }
  return std::move(out_);
}

}  // namespace sheaf
