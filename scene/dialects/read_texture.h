// Textures that both dialects spell alike: pictures, checkerboards, mesh attributes.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Where (0, 0) of the uv plane lies in a picture.
enum class PictureOrigin { kUpperLeft, kLowerLeft };

/// Reads a plugin into `texture`, with its properties from `p`, which the caller finishes. False if the plugin is none
/// of shared_texture_names(). Throws SceneError.
bool read_shared_texture(Properties& p, PictureOrigin origin, TextureDescription& texture);

/// The plugins that read_shared_texture() knows, in order of the alphabet.
const std::vector<std::string>& shared_texture_names();

/// What was read from an element before, or null.
const SpectrumInput* find_read_texture(const XmlElement& element, const ReadContext& context);
/// Appends a texture with the place and id of its element, which is then read.
TextureId add_texture(Properties& p, TextureDescription texture);

/// The texture that stands for `texture` where a number is wanted: itself, but in the scenes of Mitsuba 2 and 3 a
/// checkerboard with its two values exchanged, as those renderers look numbers up.
TextureId scalar_texture(TextureId texture, ReadContext& context);

/// The texture of an input; for a constant, a new texture that shows it everywhere.
TextureId texture_showing(const SpectrumInput& input, const SourceLocation& where, ReadContext& context);

/// Whether `gamma` of Mitsuba 0.6 takes the integers of an image file as linear values (1), not as sRGB (-1, 0 and,
/// with a note, 2.2). Throws SceneError for other values.
bool read_linear_gamma(Properties& p);

/// The file, filter and wrapping of a picture.
BitmapDescription read_bitmap(Properties& p);
/// Turns a map of uv into one to a picture whose v axis points down.
std::array<float, 6> flipped(const std::array<float, 6>& to_uv);

}  // namespace sheaf
