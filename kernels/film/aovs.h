// AOVs (arbitrary output variables) and their only list. The command-line option, the film layout, the files and the
// table in docs/layers.md derive from it.
#pragma once

#include "kernels/film/film_layout.h"

#include <array>
#include <cstdint>

namespace sheaf {

/// All AOVs that a user can request.
enum class Aov : std::uint32_t {
  kAlbedo,
  kNormal,
  kGeometricNormal,
  kPosition,
  kDepth,
  kUv,
  kMaterialId,
  kObjectId,
  kCryptomatteMaterial,
  kCryptomatteObject,
  kSampleCount,
  kVariance,
  kHalf,
  kCount
};
inline constexpr std::size_t kAovCount = static_cast<std::size_t>(Aov::kCount);

/// Origin of a layer.
enum class AovSource : std::uint8_t {
  kVertex,     ///< first surface of each camera path; averaged over samples like colors
  kSurfaceId,  ///< ids of those surfaces; not averaged, see kernels/film/cryptomatte.h
  kFilm,       ///< statistics that the film keeps of its samples
};

/// Storage type of a channel in a file.
enum class PixelType : std::uint8_t { kHalf, kFloat };

/// Properties of one AOV.
struct AovEntry {
  Aov aov;
  std::string_view name;  ///< on the command line
  /// Channel names in the image; unused ones are empty. For Cryptomatte, the first of several channels.
  std::array<std::string_view, 3> channels;
  AovSource source;
  PixelType type;
  bool has_variance;  ///< with Aov::kVariance, its channels have variances too
};

/// The list, in the order of Aov. Values in [-1, 1] are stored as 16-bit floats. Values that may be large, or small
/// like variances, are stored as 32-bit floats.
inline constexpr std::array<AovEntry, kAovCount> kAovList = {{
    {Aov::kAlbedo, "albedo", {"albedo.R", "albedo.G", "albedo.B"}, AovSource::kVertex, PixelType::kHalf, true},
    {Aov::kNormal, "normal", {"N.X", "N.Y", "N.Z"}, AovSource::kVertex, PixelType::kHalf, true},
    {Aov::kGeometricNormal, "geometric_normal", {"Ng.X", "Ng.Y", "Ng.Z"}, AovSource::kVertex, PixelType::kHalf, false},
    {Aov::kPosition, "position", {"P.X", "P.Y", "P.Z"}, AovSource::kVertex, PixelType::kFloat, false},
    {Aov::kDepth, "depth", {"Z"}, AovSource::kVertex, PixelType::kFloat, true},
    {Aov::kUv, "uv", {"uv.U", "uv.V"}, AovSource::kVertex, PixelType::kFloat, false},
    {Aov::kMaterialId, "material_id", {"materialId"}, AovSource::kSurfaceId, PixelType::kFloat, false},
    {Aov::kObjectId, "object_id", {"objectId"}, AovSource::kSurfaceId, PixelType::kFloat, false},
    {Aov::kCryptomatteMaterial,
     "cryptomatte_material",
     {"CryptoMaterial00.r"},
     AovSource::kSurfaceId,
     PixelType::kFloat,
     false},
    {Aov::kCryptomatteObject,
     "cryptomatte_object",
     {"CryptoObject00.r"},
     AovSource::kSurfaceId,
     PixelType::kFloat,
     false},
    {Aov::kSampleCount, "sample_count", {"sampleCount"}, AovSource::kFilm, PixelType::kFloat, false},
    {Aov::kVariance,
     "variance",
     {"variance.R", "variance.G", "variance.B"},
     AovSource::kFilm,
     PixelType::kFloat,
     false},
    {Aov::kHalf, "half", {"half.R", "half.G", "half.B"}, AovSource::kFilm, PixelType::kFloat, false},
}};
static_assert(
    [] {
      for (std::size_t i = 0; i < kAovCount; ++i)
        if (static_cast<std::size_t>(kAovList[i].aov) != i || kAovList[i].name.empty()) return false;
      return true;
    }(),
    "the list follows the enumeration");

/// A set of requested AOVs.
class AovSet {
 public:
  constexpr AovSet() = default;
  constexpr AovSet(std::initializer_list<Aov> aovs) {
    for (const Aov aov : aovs) insert(aov);
  }
  constexpr void insert(Aov aov) { bits_ |= 1u << static_cast<std::uint32_t>(aov); }
  constexpr bool contains(Aov aov) const { return (bits_ >> static_cast<std::uint32_t>(aov) & 1u) != 0; }
  constexpr bool operator==(const AovSet&) const = default;
  /// Whether any AOV of the set has this source.
  constexpr bool contains(AovSource source) const {
    for (const AovEntry& entry : kAovList)
      if (entry.source == source && contains(entry.aov)) return true;
    return false;
  }

 private:
  std::uint32_t bits_ = 0;
};

/// Parses a comma-separated list of names; "all" adds all AOVs. Throws Error (usage) for an unknown name.
AovSet aovs_from_names(std::string_view names);

/// Unique layer names for light groups: "light_" + the group's name, with "_" for dots and control characters, at most
/// 200 bytes of the name. Duplicates get the suffix "_2", "_3" and so on. Names that are valid already keep their name.
std::vector<std::string> light_group_layers(const std::vector<std::string>& light_groups);

/// The channels R, G, B and A, then the AOVs, then R, G and B of each light group's layer. `with_variances`: R, G and B
/// get variances, and with Aov::kVariance also the AOVs that support them.
FilmLayout film_layout(AovSet aovs, bool with_variances, const std::vector<std::string>& light_groups = {});

/// Index of the first channel of each AOV of AovSource::kVertex in a sample; -1 if the AOV is absent.
struct AovChannels {
  int albedo = -1, normal = -1, geometric_normal = -1, position = -1, depth = -1, uv = -1;
  bool surfaces = false;  ///< samples have a SurfaceSample

  AovChannels() = default;
  AovChannels(const FilmLayout& layout, AovSet aovs);
  /// Whether samples carry any AOV.
  bool any() const {
    return surfaces || albedo >= 0 || normal >= 0 || geometric_normal >= 0 || position >= 0 || depth >= 0 || uv >= 0;
  }
};

/// The subset of an image's channels that files store as 16-bit floats.
std::vector<std::string> half_channels(const std::vector<std::string>& channels);

}  // namespace sheaf
