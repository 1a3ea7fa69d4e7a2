// Images: reading, and the row.
#include "scene/textures/bitmap.h"

#include "core/image/image.h"
#include "scene/xml/linear_gamma.h"
#include "scene/xml/properties.h"
#include "scene/xml/read_arrays.h"

namespace sheaf {

namespace {

/// Returns the name under which a property is present, or the first name. Reports further ones.
const char* only_name(Properties& p, std::initializer_list<const char*> names) {
  const char* found = nullptr;
  for (const char* name : names) {
    if (!p.has(name)) continue;
    if (found != nullptr)
      p.report_conflict(name, fmt::format("'{}'", found));
    else
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
    p.context().note(p.where(),
                     fmt::format("texture '{}' has the filter '{}', rendered as 'bilinear'", p.type(), given));
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
  if (!p.has("raw")) return read_linear_gamma(p);
  p.report_conflict("gamma", "'raw'");
  return raw;
}

BitmapDescription::Channel read_channel(Properties& p) {
  using Channel = BitmapDescription::Channel;
  static constexpr NameTable<Channel> kChannels{{{"all", Channel::kColor},
                                                 {"r", Channel::kRed},
                                                 {"g", Channel::kGreen},
                                                 {"b", Channel::kBlue},
                                                 {"a", Channel::kAlpha}}};
  return p.choice("channel", kChannels, Channel::kColor);
}

}  // namespace

BitmapDescription BitmapDescription::read(Properties& p) {
  BitmapDescription bitmap;
  bitmap.filter = read_bitmap_filter(p);
  const TextureWrap both = read_wrap(p, {"wrap_mode", "wrap"}, TextureWrap::kRepeat);
  bitmap.wrap_u = read_wrap(p, {"wrap_mode_u"}, both);
  bitmap.wrap_v = read_wrap(p, {"wrap_mode_v"}, both);
  bitmap.raw = read_raw(p);
  if (p.find_array("data") != nullptr) {
    bitmap.made = std::make_shared<const Image>(read_image_array(p, "data", bitmap.raw));
  } else {
    bitmap.file = p.file("filename");
  }
  bitmap.channel = read_channel(p);
  p.ignore({"format", "accel", "cache", "max_anisotropy"});
  return bitmap;
}

void BitmapDescription::make_row(TextureRowBuilder& row) const {
  const PlacedImage image = row.load_image(*this);
  TexelFormat format = image.format;
  if (format == TexelFormat::kByte1 && !is_linear()) format = TexelFormat::kSrgbByte1;
  if (format == TexelFormat::kByte3 && !is_linear()) format = TexelFormat::kSrgbByte3;
  row.set(BitmapRow{image.index, image.tiles_per_row, image.width, image.height, wrap_u, wrap_v, filter, format});
}

}  // namespace sheaf
