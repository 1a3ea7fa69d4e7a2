// Further layers of the picture (AOVs), and the one list of them: the option, what films are made of, files and the
// table in docs/layers.md derive from it.
#pragma once

#include "kernels/film/film_layout.h"

#include <array>
#include <cstdint>

namespace sheaf {

/// All further layers that can be asked for.
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

/// Where a layer comes from.
enum class AovSource : std::uint8_t {
  kVertex,     ///< the first surface of each path from the camera: a mean over samples, as colours are
  kSurfaceId,  ///< which surfaces those are: not a mean, see kernels/film/cryptomatte.h
  kFilm,       ///< what the film knows of its samples
};

/// How a channel is stored in a file.
enum class PixelType : std::uint8_t { kHalf, kFloat };

/// One of the layers.
struct AovEntry {
  Aov aov;
  std::string_view name;  ///< as it is asked for
  /// In the picture; empty ones are none. Of Cryptomatte the first of several.
  std::array<std::string_view, 3> channels;
  AovSource source;
  PixelType type;
  bool has_variance;  ///< with Aov::kVariance its channels have variances too
};

/// The list, in the order of Aov. What is in [-1, 1] is stored with 16 bits; what may be large, or small as variances
/// are, with 32.
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

/// Layers that are asked for.
class AovSet {
 public:
  constexpr AovSet() = default;
  constexpr AovSet(std::initializer_list<Aov> aovs) {
    for (const Aov aov : aovs) insert(aov);
  }
  constexpr void insert(Aov aov) { bits_ |= 1u << static_cast<std::uint32_t>(aov); }
  constexpr bool contains(Aov aov) const { return (bits_ >> static_cast<std::uint32_t>(aov) & 1u) != 0; }
  constexpr bool operator==(const AovSet&) const = default;
  /// Whether any comes from there.
  constexpr bool contains(AovSource source) const {
    for (const AovEntry& entry : kAovList)
      if (entry.source == source && contains(entry.aov)) return true;
    return false;
  }

 private:
  std::uint32_t bits_ = 0;
};

/// The layers of a list of names with commas between; "all": all of them. Throws Error (usage) for an unknown name.
AovSet aovs_from_names(std::string_view names);

/// The layers of groups of lights, each name once: "light_" + the group's name, without dots, and where that is taken
/// with a number behind it. Names that need no change keep theirs.
std::vector<std::string> light_group_layers(const std::vector<std::string>& light_groups);

/// R, G, B and A and the layers; then for each group of lights its light_group_layers(). `with_variances`: of R, G and
/// B, and with Aov::kVariance of layers that can have some.
FilmLayout film_layout(AovSet aovs, bool with_variances, const std::vector<std::string>& light_groups = {});

/// Where a sample has the layers of AovSource::kVertex: for each its first channel, -1 where it is not there.
struct AovChannels {
  int albedo = -1, normal = -1, geometric_normal = -1, position = -1, depth = -1, uv = -1;
  bool surfaces = false;  ///< samples have SurfaceSamples

  AovChannels() = default;
  AovChannels(const FilmLayout& layout, AovSet aovs);
  /// Whether there are any.
  bool any() const {
    return surfaces || albedo >= 0 || normal >= 0 || geometric_normal >= 0 || position >= 0 || depth >= 0 || uv >= 0;
  }
};

/// Those of a picture's channels that a file is to store with 16 bits.
std::vector<std::string> half_channels(const std::vector<std::string>& channels);

}  // namespace sheaf
