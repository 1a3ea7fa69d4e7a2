// Reading of the textures that the Nori and Mitsuba dialects write alike.
#pragma once

#include "scene/textures/constant_map.h"
#include "scene/xml/find_plugin.h"

namespace sheaf {

/// Corner of an image at uv = (0, 0).
enum class ImageOrigin { kUpperLeft, kLowerLeft };

/// Reads a plugin into `texture`. Its properties come from `p`, which the caller finishes. Throws SceneError.
using TexturePluginReader = void (*)(Properties& p, ImageOrigin origin, TextureDescription& texture);

/// A texture plugin.
struct TexturePlugin {
  const char* name;
  TexturePluginReader read;
};

/// The names of all kinds of textures in files (kPlugins), in alphabetical order.
std::span<const TexturePlugin> texture_plugins();

/// Returns the texture read earlier from this element, or null.
const SpectrumInput* find_read_texture(const XmlElement& element, const ReadContext& context);
/// Appends a texture with the location and id of its element, and records that the element is read.
TextureId add_texture(Properties& p, TextureDescription texture);

/// Returns the texture that replaces `texture` for scalar parameters. It is the same, except that Mitsuba 2 and 3
/// exchange the two values of a checkerboard in scalar lookups.
TextureId scalar_texture(TextureId texture, ReadContext& context);

/// Converts a uv transform to one for an image whose v axis points down.
std::array<float, 6> flipped(const std::array<float, 6>& to_uv);

}  // namespace sheaf
