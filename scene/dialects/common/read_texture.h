// Textures shared by the Nori and Mitsuba dialects: bitmaps, checkerboards, mesh attributes.
#pragma once

#include "scene/xml/constant_texture.h"
#include "scene/xml/properties.h"

namespace sheaf {

/// Corner of an image at uv = (0, 0).
enum class ImageOrigin { kUpperLeft, kLowerLeft };

/// Reads a plugin into `texture`. Its properties come from `p`, which the caller finishes. Throws SceneError.
using TexturePluginReader = void (*)(Properties& p, ImageOrigin origin, TextureDescription& texture);

/// Readers of texture plugins.
extern const NameTable<TexturePluginReader> kSharedTextures;

/// Returns the texture read earlier from this element, or null.
const SpectrumInput* find_read_texture(const XmlElement& element, const ReadContext& context);
/// Appends a texture with the location and id of its element, and records that the element is read.
TextureId add_texture(Properties& p, TextureDescription texture);

/// Returns the texture that replaces `texture` for scalar parameters. It is the same, except that Mitsuba 2 and 3
/// exchange the two values of a checkerboard in scalar lookups.
TextureId scalar_texture(TextureId texture, ReadContext& context);

/// Reads file, filter and wrap mode of a bitmap.
BitmapDescription read_bitmap(Properties& p);
/// Converts a uv transform to one for an image whose v axis points down.
std::array<float, 6> flipped(const std::array<float, 6>& to_uv);

}  // namespace sheaf
