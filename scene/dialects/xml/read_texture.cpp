// Textures shared by the Nori and Mitsuba dialects.
#include "scene/dialects/xml/read_texture.h"

#include "scene/description.h"
#include "scene/xml/read_declared.h"

#include <algorithm>
#include <cstring>

namespace sheaf {

namespace {

std::array<float, 6> from_transform(const Transform& transform) {
  const auto& m = transform.matrix().m;
  auto entry = [&](std::size_t i, std::size_t j) { return static_cast<float>(m[i][j]); };
  return {entry(0, 0), entry(0, 1), entry(0, 3), entry(1, 0), entry(1, 1), entry(1, 3)};
}

/// Reads `to_uv`, or the scales and offsets of Mitsuba before 2.
std::array<float, 6> read_to_uv(Properties& p) {
  const bool given = p.has("to_uv");
  const std::array<float, 6> to_uv = from_transform(p.transform("to_uv"));
  for (const char* name : {"uscale", "vscale", "uvscale", "uoffset", "voffset"})
    if (p.has(name) && given) p.report_conflict(name, "'to_uv'");
  if (given) return to_uv;
  const float both = p.number("uvscale", 1);
  const float u_scale = p.number("uscale", both), v_scale = p.number("vscale", both);
  return {u_scale, 0, p.number("uoffset", 0), 0, v_scale, p.number("voffset", 0)};
}

/// Reads a texture of one kind.
template <class Description> void read_as(Properties& p, ImageOrigin origin, TextureDescription& texture) {
  constexpr TextureDomain kDomain = Description::kDomain;
  texture.model = read_model<Description>(p, SpectrumRole::kIor);
  if (kDomain == TextureDomain::kUv || kDomain == TextureDomain::kImage) texture.to_uv = read_to_uv(p);
  if (kDomain == TextureDomain::kImage && origin == ImageOrigin::kUpperLeft) texture.to_uv = flipped(texture.to_uv);
}

std::vector<TexturePlugin> make_plugins() {
  std::vector<TexturePlugin> table;
  TextureKinds::for_each([&]<class Description>() {
    if constexpr (Description::kPlugins.size() > 0)
      for (const char* name : Description::kPlugins) table.push_back({name, read_as<Description>});
  });
  std::sort(table.begin(), table.end(),
            [](const TexturePlugin& a, const TexturePlugin& b) { return std::strcmp(a.name, b.name) < 0; });
  return table;
}

}  // namespace

std::array<float, 6> flipped(const std::array<float, 6>& to_uv) {
  return {to_uv[0], to_uv[1], to_uv[2], -to_uv[3], -to_uv[4], 1 - to_uv[5]};
}

std::span<const TexturePlugin> texture_plugins() {
  static const std::vector<TexturePlugin> kTable = make_plugins();
  return kTable;
}

const SpectrumInput* find_read_texture(const XmlElement& element, const ReadContext& context) {
  const auto it = context.textures.find(&element);
  return it != context.textures.end() ? &it->second : nullptr;
}

TextureId add_texture(Properties& p, TextureDescription texture) {
  p.reject_unused();
  texture.where = p.where();
  if (const std::string* id = p.element().find_attribute("id")) texture.id = *id;
  std::vector<TextureDescription>& textures = p.context().description.textures;
  textures.push_back(std::move(texture));
  const auto index = static_cast<TextureId>(textures.size() - 1);
  p.context().textures.emplace(&p.element(), index);
  return index;
}

TextureId scalar_texture(TextureId texture, ReadContext& context) {
  std::vector<TextureDescription>& textures = context.description.textures;
  const auto* squares = std::get_if<CheckerboardDescription>(&textures.at(static_cast<std::size_t>(texture)).model);
  if (!context.exchanges_checkerboards || squares == nullptr) return texture;
  if (const auto known = context.scalar_textures.find(texture); known != context.scalar_textures.end())
    return known->second;
  CheckerboardDescription exchanged{squares->color1, squares->color0};
  for (SpectrumInput* value : {&exchanged.color0, &exchanged.color1})
    if (const auto* nested = std::get_if<TextureId>(value)) *value = scalar_texture(*nested, context);
  TextureDescription copy = textures.at(static_cast<std::size_t>(texture));
  copy.model = exchanged;
  textures.push_back(std::move(copy));
  const auto index = static_cast<TextureId>(textures.size() - 1);
  context.scalar_textures.emplace(texture, index);
  return index;
}

}  // namespace sheaf
