#include "scene/compile/geometry/sample_height_field.h"

#include "core/color/color.h"
#include "scene/formats/height_field.h"
#include "scene/spectra/spectrum_rgb.h"
#include "scene/textures/texture_lookup.h"

#include <cmath>

namespace sheaf {

Mesh sample_height_field(const HeightFieldShape& field, const TextureTables& textures) {
  if (field.width < 2 || field.height < 2 || std::size_t(field.width) > kMaxHeights / std::size_t(field.height))
    throw SceneError(fmt::format("a height field of {} x {} points (expected at least 2 x 2 and at most {})",
                                 field.width, field.height, kMaxHeights));
  // Check the texture
  Heights heights{static_cast<std::size_t>(field.width), static_cast<std::size_t>(field.height), {}};
  const auto* texture = std::get_if<TextureId>(&field.texture);
  const std::uint8_t needs = texture != nullptr ? textures.rows.at(static_cast<std::uint32_t>(*texture)).needs : 0;
  if (needs != 0)
    throw SceneError(fmt::format("the texture of a height field depends on {} (expected one that depends only on uv)",
                                 (needs & kTextureNeedsMesh) != 0 ? "meshes" : "the position"));
  // Evaluate it at the centers of the cells
  const float constant =
      texture != nullptr ? 0.0f : luminance(unbounded_rgb(std::get<SpectrumDescription>(field.texture)));
  const TextureView view{textures.rows.data(), textures.images.data()};
  heights.z.reserve(heights.width * heights.height);
  for (int y = 0; y < field.height; ++y)
    for (int x = 0; x < field.width; ++x) {
      TextureQuery<Scalar> query{};
      query.uv = {(static_cast<float>(x) + 0.5f) / static_cast<float>(field.width),
                  (static_cast<float>(y) + 0.5f) / static_cast<float>(field.height)};
      const float value =
          texture != nullptr ? lookup_scalar<Scalar>(view, static_cast<std::uint32_t>(*texture), query) : constant;
      heights.z.push_back(field.scale * value);
      if (!std::isfinite(heights.z.back())) throw SceneError("the texture of a height field is not finite everywhere");
    }
  return make_height_field(heights, field.smooth);
}

}  // namespace sheaf
