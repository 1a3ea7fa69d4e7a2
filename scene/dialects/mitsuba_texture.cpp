// The Mitsuba dialect: textures.
#include "scene/dialects/mitsuba.h"
#include "scene/dialects/read_spectrum.h"
#include "scene/dialects/read_texture.h"
#include "scene/dialects/read_volume.h"

#include <algorithm>

namespace sheaf::mitsuba {

namespace {

/// A volume on a surface, as long as it is the same everywhere: textures know uv alone.
SpectrumDescription read_constant(Properties& p) {
  const auto value = find_constant_volume(p, "volume", SpectrumRole::kIor, {});
  if (!value) p.fail("needs a <volume> of the name 'volume'");
  p.finish();
  return *value;
}

}  // namespace

SpectrumInput texture_of(const XmlElement& element, ReadContext& context) {
  if (const SpectrumInput* known = find_read_texture(element, context)) return *known;
  const std::vector<std::string>& plain = spectrum_plugins();
  if (std::find(plain.begin(), plain.end(), element.attribute("type")) != plain.end())
    return read_spectrum(element, context);
  Properties p(element, context);
  if (p.type() == "volume") return read_constant(p);
  TextureDescription texture;
  if (!read_shared_texture(p, PictureOrigin::kUpperLeft, texture)) {
    std::vector<std::string> known = shared_texture_names();
    known.insert(known.end(), plain.begin(), plain.end());
    known.emplace_back("volume");
    p.fail_plugin(known);
  }
  return add_texture(p, std::move(texture));
}

}  // namespace sheaf::mitsuba
