// Light task: the photons that one worker emits, the index of the next photon, and the splats, photons and beams that
// they create.
#pragma once

#include "kernels/film/splat.h"
#include "kernels/photons/photon.h"
#include "kernels/photons/photon_beam.h"
#include "kernels/wave/path_state.h"

#include <algorithm>
#include <cassert>
#include <vector>

namespace sheaf {

/// PathState::pixel of photons is this value plus the upper half of the photon's number; PathState::sample is the lower
/// half. No pixel of a film has such an index.
inline constexpr std::uint32_t kPhotonPixel = 0x80000000u;

/// Photons that one worker emits in one go. The source is the photon_rays stage, the sink is the splat or store_photons
/// stage.
class LightTask {
 public:
  /// Begins light tracing of photons [first, first + count). Film positions outside `bounds` are ignored.
  void begin(std::uint64_t first, int count, const SplatFilter::Bounds& bounds) {
    first_ = first;
    total_ = count;
    emitted_ = 0;
    stores_ = false;
    film_bounds = bounds;
    splats.clear();
  }
  /// Begins photons [first, first + count) for a photon map of this kind.
  void begin(std::uint64_t first, int count, PhotonKind kind) {
    begin(first, count, SplatFilter::Bounds{});
    stores_ = true;
    kind_ = kind;
    arrived = 0;
    stored.clear();
    beams.clear();
  }

  int total() const { return total_; }            ///< number of photons
  int left() const { return total_ - emitted_; }  ///< photons not emitted yet
  int emitted() const { return emitted_; }        ///< index of the next photon within the task
  /// Index of the next photon among all photons.
  std::uint64_t next() const { return first_ + static_cast<std::uint64_t>(emitted_); }
  void advance() {
    assert(left() > 0);
    ++emitted_;
  }

  /// Stored photons, sorted by photon and vertex.
  std::vector<Photon> sorted_photons() const { return sorted(stored); }
  std::vector<PhotonBeam> sorted_beams() const { return sorted(beams); }
  /// Sorts the splats by photon and vertex, which makes their order independent of the wave's size.
  void sort_splats() {
    std::sort(splats.begin(), splats.end(), [](const Splat& a, const Splat& b) { return a.order < b.order; });
  }

  SplatFilter::Bounds film_bounds{};  ///< accepted film positions
  std::vector<Splat> splats;
  std::vector<Photon> stored;
  std::vector<PhotonBeam> beams;
  std::uint64_t arrived = 0;  ///< photon vertices that could store a photon, possibly of another kind

  /// Whether photons are stored instead of connected to the camera.
  bool stores_photons() const { return stores_; }
  /// Whether photons are stored at scattering events in media.
  bool stores_in_media() const { return stores_ && kind_ == PhotonKind::kVolume; }
  /// Whether a photon with this history (RayFlags) is stored when it hits a surface.
  bool stores(std::uint32_t flags) const {
    const std::uint32_t history = flags & (kRayDiffuse | kRaySpecular);
    switch (kind_) {
      case PhotonKind::kAll:
        return true;
      case PhotonKind::kAllButCaustic:
        return history != kRaySpecular;
      case PhotonKind::kIndirect:
        return history != 0;
      case PhotonKind::kDiffuse:
        return (history & kRayDiffuse) != 0;
      case PhotonKind::kCaustic:
        return history == kRaySpecular;
      case PhotonKind::kVolume:
        return false;
    }
    return false;
  }
  /// Whether photons end at the first non-specular scattering event.
  bool ends_at_scattering() const { return stores_ && kind_ == PhotonKind::kCaustic; }

 private:
  /// Counting sort by photon: the items of each photon are already in order.
  template <class Item> std::vector<Item> sorted(const std::vector<Item>& items) const {
    std::vector<std::uint32_t> starts(static_cast<std::size_t>(total_) + 1);
    for (const Item& item : items) ++starts[(item.order >> kVertexBits) + 1];
    for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
    std::vector<Item> sorted(items.size());
    for (const Item& item : items) sorted[starts[item.order >> kVertexBits]++] = item;
    return sorted;
  }

  bool stores_ = false;
  PhotonKind kind_ = PhotonKind::kAll;
  std::uint64_t first_ = 0;
  int total_ = 0, emitted_ = 0;
};

}  // namespace sheaf
