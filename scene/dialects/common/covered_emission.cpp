#include "scene/dialects/common/covered_emission.h"

#include "scene/description/scaled_spectrum.h"

#include <algorithm>

namespace sheaf {

CoveredEmission covered_emission(Description& description, SpectrumInput radiance, MaterialId material) {
  const MaterialDescription& surface = description.materials[static_cast<std::size_t>(material)];
  const auto* mask = std::get_if<MaskDescription>(&surface.model);
  if (mask == nullptr) return {std::move(radiance), {}};
  const auto* spectrum = std::get_if<SpectrumDescription>(&radiance);
  const float* constant = std::get_if<float>(&mask->opacity);
  if (constant != nullptr && !(*constant > 0.0f)) return {};
  if (constant != nullptr && spectrum != nullptr) return {scaled(*spectrum, std::min(*constant, 1.0f)), {}};
  TextureDescription texture;
  OpacityTextureDescription covered;
  if (spectrum == nullptr) covered.color = radiance;
  covered.opacity = mask->opacity;
  texture.model = std::move(covered);
  texture.id = surface.id;
  texture.where = surface.where;
  description.textures.push_back(std::move(texture));
  const auto id = static_cast<TextureId>(description.textures.size() - 1);
  if (spectrum == nullptr) return {id, {}};
  return {std::move(radiance), id};
}

}  // namespace sheaf
