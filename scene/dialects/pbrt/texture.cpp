// The pbrt dialect: textures. Constant expressions are evaluated here; all others become bitmaps, checkerboards and
// mixes.
#include "scene/dialects/pbrt/noise.h"
#include "scene/dialects/pbrt/reader.h"

#include "core/color/color.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sheaf::pbrt {

namespace {

constexpr int kMaxNesting = 16;

TextureDescription& texture_at(Reader& reader, TextureId id) {
  return reader.description.textures.at(static_cast<std::size_t>(id));
}

const SpectrumDescription* constant_of(const SpectrumInput& input) { return std::get_if<SpectrumDescription>(&input); }

/// Conversions between scalar and color textures.
SpectrumInput as_spectrum(const ScalarInput& input) {
  if (const float* value = std::get_if<float>(&input)) return SpectrumDescription::constant(*value);
  return std::get<TextureId>(input);
}
ScalarInput as_scalar(const SpectrumInput& input) {
  const SpectrumDescription* constant = constant_of(input);
  if (constant == nullptr) return std::get<TextureId>(input);
  if (const auto* rgb = std::get_if<SpectrumDescription::Rgb>(&constant->value)) return luminance(rgb->value);
  const auto* value = std::get_if<SpectrumDescription::Constant>(&constant->value);
  return value != nullptr ? value->value : 0.0f;
}

/// Reads the inputs of a texture as colors or as numbers.
struct Source {
  Parameters& p;
  bool colors;

  SpectrumInput find(const char* name, float default_value) const {
    const SpectrumInput standard = SpectrumDescription::constant(default_value);
    if (colors) return find_spectrum_input(p, name, Use::kUnbounded).value_or(standard);
    const std::optional<ScalarInput> number = find_scalar_input(p, name);
    return number ? as_spectrum(*number) : standard;
  }
};

/// Reads uscale, vscale, udelta and vdelta.
std::array<float, 6> read_mapping(Parameters& p) {
  const std::string mapping = p.string("mapping", "uv");
  if (mapping != "uv") {
    p.unsupported(fmt::format("the mapping '{}'", mapping), "rendered with the texture coordinates of the surface");
    p.ignore({"v1", "v2", "udelta", "vdelta", "uscale", "vscale"});
    return {1, 0, 0, 0, 1, 0};
  }
  return {p.number("uscale", 1), 0, p.number("udelta", 0), 0, p.number("vscale", 1), p.number("vdelta", 0)};
}

/// Reads the encoding of an image: "sRGB", "linear" or "gamma" with an exponent. pbrt honors it for PNG only; its
/// other integer formats are always sRGB.
void read_encoding(Parameters& p, BitmapDescription& bitmap) {
  const bool png = is_png(bitmap.file);
  const std::string encoding = p.string("encoding", "sRGB");
  bitmap.raw = png && encoding == "linear";
  if (encoding == "sRGB") return;
  if (!png && may_hold_integers(bitmap.file))
    p.reader().note(p.where(), p.title() + ": 'encoding' ignored: pbrt honors it for PNG files only, others are sRGB");
  if (encoding == "linear") return;
  const bool is_gamma = encoding.starts_with("gamma ");
  const float gamma = is_gamma ? std::strtof(encoding.c_str() + std::string_view("gamma ").size(), nullptr) : 0.0f;
  if (!(gamma > 0.0f && std::isfinite(gamma)))
    p.fail_at("encoding", fmt::format("is '{}', expected sRGB, linear, or gamma and an exponent", encoding));
  if (!png) return;
  if (bitmap.change.invert) return p.unsupported("'invert' of an image with another encoding", "rendered as sRGB");
  // Apply the scale before the power.
  bitmap.raw = true;
  bitmap.change.exponent = gamma;
  bitmap.change.scale = std::pow(bitmap.change.scale, 1 / gamma);
}

TextureWrap read_wrap(Parameters& p) {
  const std::string wrap = p.string("wrap", "repeat");
  if (wrap == "repeat") return TextureWrap::kRepeat;
  if (wrap != "clamp") p.unsupported(fmt::format("wrap '{}', expected repeat or clamp", wrap), "rendered as clamp");
  return TextureWrap::kClamp;
}

SpectrumInput read_image(Parameters& p, const Source& source) {
  BitmapDescription bitmap;
  bitmap.file = p.file("filename");
  bitmap.wrap_u = bitmap.wrap_v = read_wrap(p);
  bitmap.change.scale = p.number("scale", 1);
  bitmap.change.invert = p.boolean("invert", false);
  read_encoding(p, bitmap);
  if (p.string("filter", "bilinear") == "point") bitmap.filter = TextureFilter::kNearest;
  p.ignore({"maxanisotropy"});
  if (!source.colors) bitmap.made = scalar_image(bitmap);
  TextureDescription texture;
  texture.model = std::move(bitmap);
  texture.to_uv = read_mapping(p);
  texture.where = p.where();
  return append(p.reader(), std::move(texture));
}

SpectrumInput read_checkerboard(Parameters& p, const Source& source) {
  CheckerboardDescription board{source.find("tex1", 1), source.find("tex2", 0)};
  if (p.integer("dimension", 2, 2, 3) == 3) {
    p.unsupported("a checkerboard in three dimensions", "rendered as its first texture");
    return board.color0;
  }
  TextureDescription texture;
  texture.model = std::move(board);
  texture.to_uv = read_mapping(p);
  for (float& entry : texture.to_uv) entry *= 0.5f;  // Sheaf's squares are half as large
  texture.where = p.where();
  return append(p.reader(), std::move(texture));
}

SpectrumInput add_mix(Parameters& p, const SpectrumInput& first, const SpectrumInput& second,
                      const ScalarInput& amount) {
  TextureDescription texture;
  texture.model = MixTextureDescription{first, second, amount};
  texture.where = p.where();
  return append(p.reader(), std::move(texture));
}

SpectrumInput read_scale(Parameters& p, const Source& source) {
  const SpectrumInput texture = source.find("tex", 1);
  const ScalarInput scale = find_scalar_input(p, "scale").value_or(1.0f);
  std::optional<SpectrumInput> product;
  if (const float* number = std::get_if<float>(&scale)) {
    product = scaled_input(p.reader(), texture, *number);
  } else if (const SpectrumDescription* constant = constant_of(texture)) {
    // A gray constant times a scalar texture.
    if (const auto* gray = std::get_if<SpectrumDescription::Constant>(&constant->value))
      product = scaled_input(p.reader(), as_spectrum(scale), gray->value);
    const auto* rgb = std::get_if<SpectrumDescription::Rgb>(&constant->value);
    if (rgb != nullptr && rgb->value.x == rgb->value.y && rgb->value.y == rgb->value.z)
      product = scaled_input(p.reader(), as_spectrum(scale), rgb->value.x);
  }
  return product ? *product : add_mix(p, SpectrumDescription::constant(0), texture, scale);
}

/// Returns (1 - t) a + t b of constants; nullopt for spectra that are not colors or grays.
std::optional<SpectrumDescription> mixed(const SpectrumDescription& a, const SpectrumDescription& b, float t) {
  using S = SpectrumDescription;
  const auto rgb_of = [](const S& s) -> std::optional<Vec3f> {
    if (const auto* rgb = std::get_if<S::Rgb>(&s.value)) return rgb->value;
    if (const auto* gray = std::get_if<S::Constant>(&s.value)) return Vec3f{gray->value, gray->value, gray->value};
    return std::nullopt;
  };
  const std::optional<Vec3f> first = rgb_of(a), second = rgb_of(b);
  if (!first || !second) return std::nullopt;
  const Vec3f sum = *first * (1 - t) + *second * t;
  if (std::holds_alternative<S::Constant>(a.value) && std::holds_alternative<S::Constant>(b.value))
    return S::constant(sum.x);
  return S::rgb(sum.x, sum.y, sum.z);
}

SpectrumInput read_mix(Parameters& p, const Source& source) {
  SpectrumInput first = source.find("tex1", 0), second = source.find("tex2", 1);
  const ScalarInput amount = find_scalar_input(p, "amount").value_or(0.5f);
  const float* t = std::get_if<float>(&amount);
  if (t != nullptr && *t == 0.0f) return first;
  if (t != nullptr && *t == 1.0f) return second;
  if (t != nullptr && constant_of(first) != nullptr && constant_of(second) != nullptr)
    if (std::optional<SpectrumDescription> sum = mixed(*constant_of(first), *constant_of(second), *t)) return *sum;
  return add_mix(p, first, second, amount);
}

/// Adds a texture that rises from 0 to 1 across the unit square along the mapped u, or v if `upwards`.
TextureId add_ramp(Parameters& p, const std::array<float, 6>& mapping, bool upwards) {
  auto ends = std::make_shared<Image>(2, 1, std::vector<std::string>{"Y"});
  ends->data = {0, 1};
  BitmapDescription bitmap;
  bitmap.made = std::move(ends);
  bitmap.wrap_u = bitmap.wrap_v = TextureWrap::kClamp;
  TextureDescription ramp;
  ramp.model = std::move(bitmap);
  ramp.where = p.where();
  const float* row = mapping.data() + (upwards ? 3 : 0);
  ramp.to_uv = {0.5f * row[0], 0.5f * row[1], 0.5f * row[2] + 0.25f, 0, 0, 0.5f};
  return append(p.reader(), std::move(ramp));
}

SpectrumInput read_bilerp(Parameters& p, const Source& source) {
  const SpectrumInput v00 = source.find("v00", 0), v01 = source.find("v01", 1);
  const SpectrumInput v10 = source.find("v10", 0), v11 = source.find("v11", 1);
  const std::array<float, 6> mapping = read_mapping(p);
  const TextureId across = add_ramp(p, mapping, false), up = add_ramp(p, mapping, true);
  return add_mix(p, add_mix(p, v00, v10, across), add_mix(p, v01, v11, across), up);
}

/// Returns pbrt's "dots" as an image: about half of the unit cells around integer coordinates contain a disk, displaced
/// by noise within its cell. The pattern repeats after 256 cells.
std::shared_ptr<const Image> dots_image() {
  constexpr int kCells = 256, kTexels = 8, kSide = kCells * kTexels;  // kTexels: texels per cell side
  constexpr double kRadius = 0.35, kFarthest = 0.5 - kRadius;
  auto image = std::make_shared<Image>(kSide, kSide, std::vector<std::string>{"Y"});
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      if (!(noise(i + 0.5, j + 0.5, 0.5) > 0)) continue;
      const double s = i + kFarthest * noise(i + 1.5, j + 2.8, 0.5), t = j + kFarthest * noise(i + 4.5, j + 9.8, 0.5);
      for (int k = 0; k < kTexels * kTexels; ++k) {
        const int x = i * kTexels - kTexels / 2 + k % kTexels, y = j * kTexels - kTexels / 2 + k / kTexels;
        const double distance = std::hypot((x + 0.5) / kTexels - s, (y + 0.5) / kTexels - t);
        const double inside = std::clamp((kRadius - distance) * kTexels + 0.5, 0.0, 1.0);
        image->at((x + kSide) % kSide, kSide - 1 - (y + kSide) % kSide, 0) = static_cast<float>(inside);
      }
    }
  return image;
}

SpectrumInput read_dots(Parameters& p, const Source& source) {
  static const std::shared_ptr<const Image> dots = dots_image();
  const SpectrumInput inside = source.find("inside", 1), outside = source.find("outside", 0);
  BitmapDescription bitmap;
  bitmap.made = dots;
  TextureDescription texture;
  texture.model = std::move(bitmap);
  texture.to_uv = read_mapping(p);
  for (float& entry : texture.to_uv) entry /= 256;
  texture.where = p.where();
  return add_mix(p, outside, inside, append(p.reader(), std::move(texture)));
}

SpectrumInput read_constant(Parameters&, const Source& source) { return source.find("value", 1); }

/// Reads an unsupported texture; reports `instead`, the replacement.
SpectrumInput replaced(Parameters& p, SpectrumInput input, const char* instead) {
  p.ignore({"octaves", "roughness", "scale", "variation", "filename", "encoding", "mapping", "uscale", "vscale",
            "udelta", "vdelta", "v1", "v2"});
  p.unsupported("textures of this kind", instead);
  return input;
}

/// Reads an unsupported texture as its mean.
SpectrumInput read_gray(Parameters& p, const Source&) {
  return replaced(p, SpectrumDescription::constant(0.5f), "rendered as a gray of 0.5");
}

SpectrumInput read_direction_mix(Parameters& p, const Source& source) {
  const SpectrumInput first = source.find("tex1", 0);
  p.ignore({"tex2", "dir"});
  return replaced(p, first, "rendered as its first texture");
}

constexpr NameTable<SpectrumInput (*)(Parameters&, const Source&)> kTextures{{{"bilerp", read_bilerp},
                                                                              {"checkerboard", read_checkerboard},
                                                                              {"constant", read_constant},
                                                                              {"directionmix", read_direction_mix},
                                                                              {"dots", read_dots},
                                                                              {"fbm", read_gray},
                                                                              {"imagemap", read_image},
                                                                              {"marble", read_gray},
                                                                              {"mix", read_mix},
                                                                              {"ptex", read_gray},
                                                                              {"scale", read_scale},
                                                                              {"windy", read_gray},
                                                                              {"wrinkled", read_gray}}};

/// Returns a copy of the input with its constants and images modified, also those that other textures combine. Returns
/// nullopt for textures of other kinds, or if `change_bitmap` returns false.
template <class ChangeConstant, class ChangeBitmap>
std::optional<SpectrumInput> changed_input(Reader& reader, const SpectrumInput& input,
                                           const ChangeConstant& change_constant, const ChangeBitmap& change_bitmap,
                                           int depth) {
  if (const SpectrumDescription* constant = constant_of(input)) return change_constant(*constant);
  TextureDescription copy = texture_at(reader, std::get<TextureId>(input));
  if (depth > kMaxNesting) throw SceneError(copy.where, "textures are nested deeper than 16 levels");
  const auto change = [&](const SpectrumInput& nested) {
    return changed_input(reader, nested, change_constant, change_bitmap, depth + 1);
  };
  if (auto* bitmap = std::get_if<BitmapDescription>(&copy.model)) {
    if (!change_bitmap(*bitmap)) return std::nullopt;
    return append(reader, std::move(copy));
  }
  if (auto* constant = std::get_if<ConstantTextureDescription>(&copy.model)) return change_constant(constant->value);
  bool has_colors = false, all_change = true;
  for_each_color(copy.model, [&](SpectrumInput& color) {
    const std::optional<SpectrumInput> changed = change(color);
    if (changed) color = *changed;
    has_colors = true;
    all_change = all_change && changed;
  });
  if (!has_colors || !all_change) return std::nullopt;
  return append(reader, std::move(copy));
}

}  // namespace

TextureId append(Reader& reader, TextureDescription texture) {
  reader.description.textures.push_back(std::move(texture));
  return static_cast<TextureId>(reader.description.textures.size() - 1);
}

TextureId add_bitmap(Reader& reader, BitmapDescription bitmap, const SourceLocation& where) {
  TextureDescription texture;
  texture.model = std::move(bitmap);
  texture.where = where;
  return append(reader, std::move(texture));
}

std::optional<SpectrumInput> scaled_input(Reader& reader, const SpectrumInput& input, float by) {
  if (by == 1.0f) return input;
  const auto scale_bitmap = [by](BitmapDescription& bitmap) {
    if (bitmap.change.invert || bitmap.change.exponent != 1.0f || by < 0.0f) return false;
    bitmap.change.scale *= by;
    return true;
  };
  return changed_input(
      reader, input, [by](const SpectrumDescription& constant) { return scaled(constant, by); }, scale_bitmap, 0);
}

std::optional<SpectrumInput> base_input(Reader& reader, const SpectrumInput& input, const LayeredBase& base) {
  const auto change_constant = [&](const SpectrumDescription& constant) {
    using S = SpectrumDescription;
    S out = constant;
    const auto change = [&](float& value) { value = base.albedo(value); };
    if (auto* gray = std::get_if<S::Constant>(&out.value)) change(gray->value);
    if (auto* rgb = std::get_if<S::Rgb>(&out.value)) change(rgb->value.x), change(rgb->value.y), change(rgb->value.z);
    if (auto* table = std::get_if<S::Table>(&out.value))
      std::for_each(table->values.begin(), table->values.end(), change);
    return out;
  };
  const auto change_bitmap = [&](BitmapDescription& bitmap) {
    if (bitmap.made) {
      bitmap.made = base_image(bitmap, base);
    } else {
      std::shared_ptr<const Image>& known = reader.base_images[{bitmap.file, bitmap.raw, bitmap.change, base}];
      if (!known) known = base_image(bitmap, base);
      bitmap.made = known;
    }
    if (bitmap.made) bitmap.change = {};
    return true;
  };
  return changed_input(reader, input, change_constant, change_bitmap, 0);
}

std::optional<ScalarInput> root_of(Reader& reader, const ScalarInput& input) {
  if (const float* value = std::get_if<float>(&input)) return std::sqrt(std::max(*value, 0.0f));
  TextureDescription copy = texture_at(reader, std::get<TextureId>(input));
  if (auto* bitmap = std::get_if<BitmapDescription>(&copy.model)) {
    bitmap->change.exponent *= 0.5f;
  } else if (auto* board = std::get_if<CheckerboardDescription>(&copy.model)) {
    if (constant_of(board->color0) == nullptr || constant_of(board->color1) == nullptr) return std::nullopt;
    const auto root = [&](const SpectrumInput& color) { return as_spectrum(*root_of(reader, as_scalar(color))); };
    *board = {root(board->color0), root(board->color1)};
  } else {
    return std::nullopt;
  }
  return append(reader, std::move(copy));
}

void read_texture(Reader& reader, const std::string& name, const std::string& kind, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("Texture '{}' ({})", name, entity.type), entity.where, std::move(entity.parameters));
  const bool colors = kind == "spectrum";
  if (!colors && kind != "float")
    throw SceneError(entity.where,
                     fmt::format("Texture '{}' is of the kind '{}', expected float or spectrum", name, kind));
  if (colors ? reader.spectrum_textures.contains(name) : reader.float_textures.contains(name))
    throw SceneError(entity.where, fmt::format("a second texture '{}' of the kind {}", name, kind));
  const std::size_t first = reader.description.textures.size();
  const SpectrumInput input = plugin(kTextures, "texture", entity.type, entity.where)(p, Source{p, colors});
  p.reject_unused();
  for (std::size_t i = first; i < reader.description.textures.size(); ++i)
    if (reader.description.textures[i].id.empty()) reader.description.textures[i].id = name;
  if (colors)
    reader.spectrum_textures.emplace(name, input);
  else
    reader.float_textures.emplace(name, as_scalar(input));
}

}  // namespace sheaf::pbrt
