#include "scene/textures/constant_map.h"

#include "scene/textures/list.h"

namespace sheaf {

TextureId texture_showing(const SpectrumInput& input, const SourceLocation& where, ReadContext& context) {
  if (const auto* id = std::get_if<TextureId>(&input)) return *id;
  TextureDescription texture;
  texture.model = ConstantTextureDescription{std::get<SpectrumDescription>(input)};
  texture.where = where;
  std::vector<TextureDescription>& textures = context.texture_list;
  textures.push_back(std::move(texture));
  return static_cast<TextureId>(textures.size() - 1);
}

}  // namespace sheaf
