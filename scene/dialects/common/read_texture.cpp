// Textures shared by the Nori and Mitsuba dialects.
#include "scene/dialects/common/read_texture.h"

#include "scene/dialects/common/read_spectrum.h"

namespace sheaf {

namespace {

struct Choice {
  std::string name;   ///< name of the property
  std::string value;  ///< value in the file
};

/// Returns the string property that is present under one of the names. Throws SceneError for several.
std::optional<Choice> find_choice(Properties& p, std::initializer_list<const char*> names) {
  std::optional<Choice> found;
  for (const char* name : names) {
    const std::optional<std::string> value = p.find_string(name);
    if (value && found) p.fail_at(name, "is given beside '" + found->name + "', expected one or the other");
    if (value) found = Choice{name, *value};
  }
  return found;
}

TextureFilter read_bitmap_filter(Properties& p) {
  const std::optional<Choice> filter = find_choice(p, {"filter_type", "filter", "interpolation"});
  if (!filter || filter->value == "bilinear") return TextureFilter::kBilinear;
  if (filter->value == "nearest") return TextureFilter::kNearest;
  if (filter->value != "trilinear" && filter->value != "ewa")
    p.fail_at(filter->name.c_str(), "is " + in_quotes(filter->value) + ", expected nearest or bilinear");
  p.context().note(p.where(),
                   "texture '" + p.type() + "' asks for the filter '" + filter->value + "'; it is filtered bilinearly");
  return TextureFilter::kBilinear;
}

TextureWrap read_wrap(Properties& p, std::initializer_list<const char*> names, TextureWrap default_value) {
  const std::optional<Choice> wrap = find_choice(p, names);
  if (!wrap) return default_value;
  if (wrap->value == "repeat") return TextureWrap::kRepeat;
  if (wrap->value == "mirror") return TextureWrap::kMirror;
  if (wrap->value == "clamp") return TextureWrap::kClamp;
  p.fail_at(wrap->name.c_str(), "is " + in_quotes(wrap->value) + ", expected repeat, mirror or clamp");
}

/// Whether integers are linear values: `raw`, or `gamma` of Mitsuba before 2.
bool read_raw(Properties& p) {
  const bool raw = p.boolean("raw", false);
  if (!p.has("gamma")) return raw;
  if (p.has("raw")) p.fail_at("gamma", "is given beside 'raw', expected one or the other");
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
    if (p.has(name) && given) p.fail_at(name, "is given beside 'to_uv', expected one or the other");
  if (given) return to_uv;
  const float both = p.number("uvscale", 1);
  const float u_scale = p.number("uscale", both), v_scale = p.number("vscale", both);
  return {u_scale, 0, p.number("uoffset", 0), 0, v_scale, p.number("voffset", 0)};
}

CheckerboardDescription read_checkerboard(Properties& p) {
  CheckerboardDescription board;
  board.color0 = p.spectrum_input("color0", board.color0, SpectrumRole::kIor);
  board.color1 = p.spectrum_input("color1", board.color1, SpectrumRole::kIor);
  return board;
}

GridTextureDescription read_grid(Properties& p) {
  GridTextureDescription grid;
  grid.color0 = p.spectrum_input("color0", grid.color0, SpectrumRole::kIor);
  grid.color1 = p.spectrum_input("color1", grid.color1, SpectrumRole::kIor);
  grid.line_width = p.number("line_width", grid.line_width, kNotNegative);
  return grid;
}

WireframeDescription read_wireframe(Properties& p) {
  WireframeDescription frame;
  frame.interior = p.spectrum_input("interior_color", frame.interior, SpectrumRole::kIor);
  frame.edge = p.spectrum_input("edge_color", frame.edge, SpectrumRole::kIor);
  frame.line_width = p.number("line_width", frame.line_width, kNotNegative);
  frame.step_width = p.number("step_width", frame.step_width, kUnitInterval);
  return frame;
}

MeshAttributeDescription read_mesh_attribute(Properties& p) {
  const std::optional<std::string> name = p.find_string("name");
  if (!name) p.fail("needs the string 'name'");
  if (!name->starts_with("vertex_") && !name->starts_with("face_"))
    p.fail_at("name", "is " + in_quotes(*name) + ", expected a name that begins with vertex_ or face_");
  return {*name, p.number("scale", 1)};
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
  if (p.has("channel")) p.fail_at("channel", "is not supported: a picture is read with all its channels");
  p.ignore({"format", "accel", "cache", "max_anisotropy"});
  return bitmap;
}

std::array<float, 6> flipped(const std::array<float, 6>& to_uv) {
  return {to_uv[0], to_uv[1], to_uv[2], -to_uv[3], -to_uv[4], 1 - to_uv[5]};
}

bool read_linear_gamma(Properties& p) {
  const float gamma = p.number("gamma", -1);
  constexpr float kLow = 2.15f, kHigh = 2.25f;
  if (gamma > kLow && gamma < kHigh) {
    p.context().note(p.where(), p.element().name + " '" + p.type() + "' has a gamma of 2.2; the curve of sRGB is used");
  } else if (gamma != 1 && gamma != -1 && gamma != 0) {
    p.fail_at("gamma", "is " + std::to_string(gamma) + ", expected 1 (linear) or -1 (sRGB)");
  }
  return gamma == 1;
}

const std::vector<std::string>& shared_texture_names() {
  static const std::vector<std::string> kNames = {"bitmap",         "checkerboard", "gridtexture",
                                                  "mesh_attribute", "vertexcolors", "wireframe"};
  return kNames;
}

bool read_shared_texture(Properties& p, PictureOrigin origin, TextureDescription& texture) {
  if (p.type() == "bitmap") {
    texture.model = read_bitmap(p);
    texture.to_uv = read_to_uv(p);
    if (origin == PictureOrigin::kUpperLeft) texture.to_uv = flipped(texture.to_uv);
  } else if (p.type() == "checkerboard") {
    texture.model = read_checkerboard(p);
    texture.to_uv = read_to_uv(p);
  } else if (p.type() == "gridtexture") {
    texture.model = read_grid(p);
    texture.to_uv = read_to_uv(p);
  } else if (p.type() == "vertexcolors") {
    texture.model = MeshAttributeDescription{"vertex_color"};
  } else if (p.type() == "wireframe") {
    texture.model = read_wireframe(p);
  } else if (p.type() == "mesh_attribute") {
    texture.model = read_mesh_attribute(p);
  } else {
    return false;
  }
  return true;
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

TextureId texture_showing(const SpectrumInput& input, const SourceLocation& where, ReadContext& context) {
  if (const auto* id = std::get_if<TextureId>(&input)) return *id;
  TextureDescription texture;
  texture.model = CheckerboardDescription{input, input};
  texture.where = where;
  std::vector<TextureDescription>& textures = context.description.textures;
  textures.push_back(std::move(texture));
  return static_cast<TextureId>(textures.size() - 1);
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
