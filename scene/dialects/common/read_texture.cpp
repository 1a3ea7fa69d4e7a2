// Textures shared by the Nori and Mitsuba dialects.
#include "scene/dialects/common/read_texture.h"

#include "scene/dialects/common/read_spectrum.h"
#include "scene/xml/linear_gamma.h"

namespace sheaf {

namespace {

/// Returns the name under which a property is present, or the first name. Throws SceneError if there are several.
const char* only_name(Properties& p, std::initializer_list<const char*> names) {
  const char* found = nullptr;
  for (const char* name : names) {
    if (!p.has(name)) continue;
    if (found != nullptr) p.fail_at(name, "is set together with '" + std::string(found) + "', expected one of them");
    found = name;
  }
  return found != nullptr ? found : *names.begin();
}

TextureFilter read_bitmap_filter(Properties& p) {
  static constexpr NameTable<TextureFilter> kFilters{{{"bilinear", TextureFilter::kBilinear},
                                                      {"nearest", TextureFilter::kNearest},
                                                      {"trilinear", TextureFilter::kBilinear},
                                                      {"ewa", TextureFilter::kBilinear}}};
  const char* name = only_name(p, {"filter_type", "filter", "interpolation"});
  const TextureFilter filter = p.choice(name, kFilters, TextureFilter::kBilinear);
  if (const std::string given = p.string(name, "bilinear"); given != kFilters.name_of(filter))
    p.context().note(p.where(), "texture '" + p.type() + "' has the filter '" + given + "', rendered as 'bilinear'");
  return filter;
}

TextureWrap read_wrap(Properties& p, std::initializer_list<const char*> names, TextureWrap default_value) {
  static constexpr NameTable<TextureWrap> kWraps{
      {{"repeat", TextureWrap::kRepeat}, {"mirror", TextureWrap::kMirror}, {"clamp", TextureWrap::kClamp}}};
  return p.choice(only_name(p, names), kWraps, default_value);
}

/// Whether integers are linear values: `raw`, or `gamma` of Mitsuba before 2.
bool read_raw(Properties& p) {
  const bool raw = p.boolean("raw", false);
  if (!p.has("gamma")) return raw;
  if (p.has("raw")) p.fail_at("gamma", "is set together with 'raw', expected one of them");
  return read_linear_gamma(p);
}

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
    if (p.has(name) && given) p.fail_at(name, "is set together with 'to_uv', expected one of them");
  if (given) return to_uv;
  const float both = p.number("uvscale", 1);
  const float u_scale = p.number("uscale", both), v_scale = p.number("vscale", both);
  return {u_scale, 0, p.number("uoffset", 0), 0, v_scale, p.number("voffset", 0)};
}

void read_checkerboard(Properties& p, ImageOrigin, TextureDescription& texture) {
  CheckerboardDescription board;
  board.color0 = p.spectrum_input("color0", board.color0, SpectrumRole::kIor);
  board.color1 = p.spectrum_input("color1", board.color1, SpectrumRole::kIor);
  texture.model = std::move(board);
  texture.to_uv = read_to_uv(p);
}

void read_grid(Properties& p, ImageOrigin, TextureDescription& texture) {
  GridTextureDescription grid;
  grid.color0 = p.spectrum_input("color0", grid.color0, SpectrumRole::kIor);
  grid.color1 = p.spectrum_input("color1", grid.color1, SpectrumRole::kIor);
  grid.line_width = p.number("line_width", grid.line_width, kNotNegative);
  texture.model = std::move(grid);
  texture.to_uv = read_to_uv(p);
}

void read_wireframe(Properties& p, ImageOrigin, TextureDescription& texture) {
  WireframeDescription frame;
  frame.interior = p.spectrum_input("interior_color", frame.interior, SpectrumRole::kIor);
  frame.edge = p.spectrum_input("edge_color", frame.edge, SpectrumRole::kIor);
  frame.line_width = p.number("line_width", frame.line_width, kNotNegative);
  frame.step_width = p.number("step_width", frame.step_width, kUnitInterval);
  texture.model = std::move(frame);
}

void read_mesh_attribute(Properties& p, ImageOrigin, TextureDescription& texture) {
  const std::string name = p.required_string("name");
  if (!name.starts_with("vertex_") && !name.starts_with("face_"))
    p.fail_at("name", "is " + in_quotes(name) + ", expected a name that begins with vertex_ or face_");
  texture.model = MeshAttributeDescription{name, p.number("scale", 1)};
}

void read_vertex_colors(Properties&, ImageOrigin, TextureDescription& texture) {
  texture.model = MeshAttributeDescription{"vertex_color"};
}

void read_bitmap_texture(Properties& p, ImageOrigin origin, TextureDescription& texture) {
  texture.model = read_bitmap(p);
  texture.to_uv = read_to_uv(p);
  if (origin == ImageOrigin::kUpperLeft) texture.to_uv = flipped(texture.to_uv);
}

}  // namespace

BitmapDescription read_bitmap(Properties& p) {
  BitmapDescription bitmap;
  bitmap.file = p.file("filename");
  bitmap.filter = read_bitmap_filter(p);
  const TextureWrap both = read_wrap(p, {"wrap_mode", "wrap"}, TextureWrap::kRepeat);
  bitmap.wrap_u = read_wrap(p, {"wrap_mode_u"}, both);
  bitmap.wrap_v = read_wrap(p, {"wrap_mode_v"}, both);
  bitmap.raw = read_raw(p);
  if (p.has("channel")) p.fail_at("channel", "is not supported: all channels of the image are read");
  p.ignore({"format", "accel", "cache", "max_anisotropy"});
  return bitmap;
}

std::array<float, 6> flipped(const std::array<float, 6>& to_uv) {
  return {to_uv[0], to_uv[1], to_uv[2], -to_uv[3], -to_uv[4], 1 - to_uv[5]};
}

constexpr NameTable<TexturePluginReader> kSharedTextures{{{"bitmap", read_bitmap_texture},
                                                          {"checkerboard", read_checkerboard},
                                                          {"gridtexture", read_grid},
                                                          {"mesh_attribute", read_mesh_attribute},
                                                          {"vertexcolors", read_vertex_colors},
                                                          {"wireframe", read_wireframe}}};

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
