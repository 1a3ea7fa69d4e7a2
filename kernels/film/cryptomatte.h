// Layers that tell objects and materials apart: the number of the one that covers most of a pixel, and Cryptomatte
// (Friedman and Jones, "Fully Automatic ID Mattes with Support for Motion Blur and Transparency", SIGGRAPH 2015
// posters; Psyop's specification 1.2.0), from which programs cut out each of them with smooth edges.
#pragma once

#include "core/image.h"
#include "kernels/film/aovs.h"
#include "kernels/film/film.h"
#include "scene/tables/scene_names.h"

#include <array>
#include <optional>
#include <span>
#include <utility>

namespace sheaf {

/// Names that a pixel can tell, at most: those that cover most of it.
inline constexpr int kCryptomatteRanks = 6;

/// Kinds of name: objects, then materials.
inline constexpr std::size_t kNameKinds = 2;

/// MurmurHash3 for 32 bits (Appleby 2011), with the seed 0.
std::uint32_t murmur_hash3_32(std::string_view bytes);

/// What stands for a name: its hash as the bits of a float, one of them turned over where these would be no normal
/// number.
std::uint32_t cryptomatte_id(std::string_view name);

/// The header's attributes for the layers of Cryptomatte among `aovs`: pairs of name and value.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(AovSet aovs, const SceneNames& names);

/// Appends the layers of AovSource::kSurfaceId to the film's picture.
void add_id_layers(AovSet aovs, const SceneNames& names, const Film& film, Image& image);

/// Where a picture has the layers of one kind of name; -1: it has none.
struct IdChannels {
  IdChannels(const Image& image, std::size_t kind);
  bool any() const { return number >= 0 || ranks[0] >= 0; }

  int number = -1;
  std::array<int, 2 * kCryptomatteRanks> ranks;  ///< of Cryptomatte: for each rank id and share
};

/// Names of a pixel that a picture of some of its samples tells, at most.
inline constexpr int kPartRanks = 8;
/// Numbers of names are exact up to here.
inline constexpr float kMaxNames = 1 << 24;

/// Appends to a picture of some of the samples what joining it with those of the others needs: for each kind of name
/// that `aovs` speak of the weight of samples on nothing, and the numbers and weights of names.
void add_part_ids(AovSet aovs, const SceneNames& names, const Film& film, Image& image);

/// Reads the layers of add_part_ids().
class PartIds {
 public:
  PartIds(const Image& image, std::size_t kind);
  /// Whether the picture has them.
  bool any() const { return !channels_.empty(); }
  /// Adds what a pixel tells to `names`, whose entries are by number, counted from 0. False for numbers that cannot be.
  bool add(const float* pixel, IdCoverage& names) const;

 private:
  std::vector<int> channels_;
};

/// Writes the layers of one kind, which hold zeros, from such sums. `ids`: by number, for Cryptomatte. False where
/// there is none for a name.
bool put_ids(const IdCoverage& names, const IdChannels& channels, std::span<const float> ids, float* pixel);

/// What the headers of such pictures say of Cryptomatte's ids by number: pairs of name and value.
std::vector<std::pair<std::string, std::string>> part_id_attributes(AovSet aovs, const SceneNames& names);
/// The name of the attribute for one kind.
std::string part_id_attribute(std::size_t kind);
/// The ids that its value says; nothing for what it cannot be.
std::optional<std::vector<float>> ids_from_attribute(std::string_view text);

}  // namespace sheaf
