// The Mitsuba dialect: textures.
#include "scene/dialects/mitsuba.h"
#include "scene/dialects/read_spectrum.h"
#include "scene/dialects/read_texture.h"

#include <algorithm>

namespace sheaf::mitsuba {

SpectrumInput texture_of(const XmlElement& element, ReadContext& context) {
  if (const SpectrumInput* known = find_read_texture(element, context)) return *known;
  const std::vector<std::string>& plain = spectrum_plugins();
  if (std::find(plain.begin(), plain.end(), element.attribute("type")) != plain.end())
    return read_spectrum(element, context);
  Properties p(element, context);
  TextureDescription texture;
  if (!read_shared_texture(p, PictureOrigin::kUpperLeft, texture)) {
    std::vector<std::string> known = shared_texture_names();
    known.insert(known.end(), plain.begin(), plain.end());
    p.fail_plugin(known);
  }
  return add_texture(p, std::move(texture));
}

}  // namespace sheaf::mitsuba
