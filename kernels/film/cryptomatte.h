// Layers of object and material ids: the index of the id that covers most of a pixel, and Cryptomatte mattes with
// smooth edges. Implements Friedman and Jones, "Fully Automatic ID Mattes with Support for Motion Blur and
// Transparency", SIGGRAPH 2015 posters, after Psyop's specification 1.2.0.
#pragma once

#include "core/image/image.h"
#include "kernels/film/aovs.h"
#include "kernels/film/film.h"
#include "scene/tables/scene_names.h"

#include <array>
#include <optional>
#include <span>
#include <utility>

namespace sheaf {

/// Maximum number of ids that a pixel stores: those with the largest coverage.
inline constexpr int kCryptomatteRanks = 6;

/// Number of kinds of names: 0 is objects, 1 is materials.
inline constexpr std::size_t kNameKinds = 2;

/// 32-bit MurmurHash3 (Appleby 2011) with seed 0.
std::uint32_t murmur_hash3_32(std::string_view bytes);

/// Cryptomatte id of a name: its hash as the bits of a float. One exponent bit is flipped if the float would be
/// denormal, infinite or NaN.
std::uint32_t cryptomatte_id(std::string_view name);

/// Header attributes of the Cryptomatte layers in `aovs`, as pairs of name and value.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(AovSet aovs, const SceneNames& names);

/// Appends the layers of AovSource::kSurfaceId to the film's image.
void add_id_layers(AovSet aovs, const SceneNames& names, const Film& film, Image& image);

/// Channel indices of the id layers of one kind of name; -1 if absent.
struct IdChannels {
  IdChannels(const Image& image, std::size_t kind);
  bool any() const { return number >= 0 || ranks[0] >= 0; }

  int number = -1;
  std::array<int, 2 * kCryptomatteRanks> ranks;  ///< Cryptomatte: id and coverage of each rank
};

/// Maximum number of ids per pixel that an image of part of the samples stores.
inline constexpr int kPartRanks = 8;
/// Maximum number of names: floats represent larger indices inexactly.
inline constexpr float kMaxNames = 1 << 24;

/// Appends the layers that merging needs to an image of part of the samples. For each kind of name in `aovs` these are
/// the weight of samples that hit nothing, and the 1-based indices and weights of names.
void add_part_ids(AovSet aovs, const SceneNames& names, const Film& film, Image& image);

/// Reads the layers of add_part_ids().
class PartIds {
 public:
  PartIds(const Image& image, std::size_t kind);
  /// Whether the image has these layers.
  bool any() const { return !channels_.empty(); }
  /// Adds a pixel's weights to `names`, with 0-based indices. Returns false for invalid indices.
  bool add(const float* pixel, IdCoverage& names) const;

 private:
  std::vector<int> channels_;
};

/// Writes the id layers of one kind into a zeroed pixel. `ids`: Cryptomatte id of each name. Returns false if a name
/// has no id.
bool put_ids(const IdCoverage& names, const IdChannels& channels, std::span<const float> ids, float* pixel);

/// Header attributes of images of part of the samples: the Cryptomatte ids by name index, as pairs of name and value.
std::vector<std::pair<std::string, std::string>> part_id_attributes(AovSet aovs, const SceneNames& names);
/// Name of the attribute for one kind.
std::string part_id_attribute(std::size_t kind);
/// Parses the value of such an attribute; returns nothing if it is malformed.
std::optional<std::vector<float>> ids_from_attribute(std::string_view text);

}  // namespace sheaf
