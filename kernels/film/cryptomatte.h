// Layers that tell objects and materials apart: the number of the one that covers most of a pixel, and Cryptomatte
// (Friedman and Jones, "Fully Automatic ID Mattes with Support for Motion Blur and Transparency", SIGGRAPH 2015
// posters; Psyop's specification 1.2.0), from which programs cut out each of them with smooth edges.
#pragma once

#include "core/image.h"
#include "kernels/film/aovs.h"
#include "kernels/film/film.h"
#include "scene/tables/scene_names.h"

#include <utility>

namespace sheaf {

/// Names that a pixel can tell, at most: those that cover most of it.
inline constexpr int kCryptomatteRanks = 6;

/// MurmurHash3 for 32 bits (Appleby 2011), with the seed 0.
std::uint32_t murmur_hash3_32(std::string_view bytes);

/// What stands for a name: its hash as the bits of a float, one of them turned over where these would be no normal
/// number.
std::uint32_t cryptomatte_id(std::string_view name);

/// The header's attributes for the layers of Cryptomatte among `aovs`: pairs of name and value.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(AovSet aovs, const SceneNames& names);

/// Appends the layers of AovSource::kSurfaceId to the film's picture.
void add_id_layers(AovSet aovs, const SceneNames& names, const Film& film, Image& image);

}  // namespace sheaf
