// AOVs (arbitrary output variables) and their only list. The command-line option with its help text, the film layout,
// the channels of samples and the types in files derive from it.
#pragma once

#include "kernels/film/film_layout.h"

#include <array>
#include <cstdint>

namespace sheaf {

/// Position of an AOV in kAovList; see aov_named().
enum class Aov : std::uint32_t {};

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
  std::string_view name;  ///< on the command line
  /// Channel names in the image; unused ones are empty. For Cryptomatte, the first of several channels.
  std::array<std::string_view, 3> channels;
  AovSource source;
  PixelType type;
  std::string_view description;  ///< contents, a phrase
  bool has_variance = false;     ///< with the AOV "variance", its channels have variances too
  Aov aov{};                     ///< position in the list, which sets it
};

/// The list. Values in [-1, 1] are stored as 16-bit floats. Values that may be large, or small like variances, are
/// stored as 32-bit floats.
inline constexpr auto kAovList = [] {
  using S = AovSource;
  using P = PixelType;
  auto list = std::to_array<AovEntry>({
      {"albedo", {"albedo.R", "albedo.G", "albedo.B"}, S::kVertex, P::kHalf, "directional albedo in [0, 1]", true},
      {"normal", {"N.X", "N.Y", "N.Z"}, S::kVertex, P::kHalf, "shading normal in world space, facing the camera", true},
      {"geometric_normal",
       {"Ng.X", "Ng.Y", "Ng.Z"},
       S::kVertex,
       P::kHalf,
       "geometric normal in world space, facing the camera"},
      {"position", {"P.X", "P.Y", "P.Z"}, S::kVertex, P::kFloat, "position in world space"},
      {"depth", {"Z"}, S::kVertex, P::kFloat, "depth along the optical axis; distance for cameras without one", true},
      {"uv", {"uv.U", "uv.V"}, S::kVertex, P::kFloat, "texture coordinates before the texture's transform"},
      {"motion", {"forward.u", "forward.v"}, S::kVertex, P::kFloat, "motion on the film over the shutter, pixels"},
      {"material_id", {"materialId"}, S::kSurfaceId, P::kFloat, "number of the dominant material, 0 for none"},
      {"object_id", {"objectId"}, S::kSurfaceId, P::kFloat, "number of the dominant object, 0 for none"},
      {"cryptomatte_material", {"CryptoMaterial00.r"}, S::kSurfaceId, P::kFloat, "materials with their coverage"},
      {"cryptomatte_object", {"CryptoObject00.r"}, S::kSurfaceId, P::kFloat, "objects with their coverage"},
      {"sample_count", {"sampleCount"}, S::kFilm, P::kFloat, "samples taken in the pixel; always present"},
      {"variance", {"variance.R", "variance.G", "variance.B"}, S::kFilm, P::kFloat, "variance of the pixel's mean"},
      {"half", {"half.R", "half.G", "half.B"}, S::kFilm, P::kFloat, "image of one half of the samples"},
  });
  for (std::size_t i = 0; i < list.size(); ++i) list[i].aov = static_cast<Aov>(i);
  return list;
}();

/// The AOV of that name. A name that is not in the list does not compile.
consteval Aov aov_named(std::string_view name) {
  for (const AovEntry& entry : kAovList)
    if (entry.name == name) return entry.aov;
  throw "no AOV has this name";
}

constexpr const AovEntry& entry_of(Aov aov) { return kAovList[static_cast<std::size_t>(aov)]; }

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
  static_assert(kAovList.size() <= 32);
  std::uint32_t bits_ = 0;
};

/// Parses a comma-separated list of names; "all" adds all AOVs. Throws Error (usage) for an unknown name.
AovSet aovs_from_names(std::string_view names);

/// A list of all AOVs for help texts, a line each: name, contents and channels.
std::string aov_descriptions();

/// Unique layer names for light groups: "light_" + the group's name, with "_" for dots and control characters, at most
/// 200 bytes of the name. Duplicates get the suffix "_2", "_3" and so on. Names that are valid already keep their name.
std::vector<std::string> light_group_layers(const std::vector<std::string>& light_groups);

/// The channels R, G, B and A, then the AOVs, then R, G and B of each light group's layer. `with_variances`: R, G and B
/// get variances, and with the AOV "variance" also the AOVs that support them.
FilmLayout film_layout(AovSet aovs, bool with_variances, const std::vector<std::string>& light_groups = {});

/// Offsets of each AOV of AovSource::kVertex in a sample.
class AovChannels {
 public:
  AovChannels() { first_.fill(-1); }
  AovChannels(const FilmLayout& layout, AovSet aovs);

  /// Index of the AOV's first channel; -1 if the AOV is absent.
  int operator[](Aov aov) const { return first_[static_cast<std::size_t>(aov)]; }
  /// Whether samples have a SurfaceSample.
  bool has_surfaces() const { return has_surfaces_; }
  /// Whether samples carry any AOV.
  bool any() const;

 private:
  std::array<int, kAovList.size()> first_;
  bool has_surfaces_ = false;
};

/// The subset of an image's channels that files store as 16-bit floats.
std::vector<std::string> half_channels(const std::vector<std::string>& channels);

}  // namespace sheaf
