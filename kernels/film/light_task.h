// What only passes that start at the lights need: which photons a worker emits, how far it has come, and what they
// have sent to the camera.
#pragma once

#include "kernels/film/splat.h"
#include "kernels/photons/photon.h"
#include "kernels/photons/photon_beam.h"
#include "kernels/wave/path_state.h"

#include <algorithm>
#include <cassert>
#include <vector>

namespace sheaf {

/// PathState::pixel of photons, to which the upper half of a photon's number is added; the lower half is their
/// sample. No pixel of a film has such a number.
inline constexpr std::uint32_t kPhotonPixel = 0x80000000u;

/// Photons that one worker emits in one go. The photon_rays stage is their source, splat or store_photons their sink.
class LightTask {
 public:
  /// Begins the photons [first, first + count). Film positions outside of `bounds` don't count.
  void begin(std::uint64_t first, int count, const SplatFilter::Bounds& bounds) {
    first_ = first;
    total_ = count;
    emitted_ = 0;
    stores_ = false;
    film_bounds = bounds;
    splats.clear();
  }
  /// Begins photons [first, first + count) that are to be stored.
  void begin(std::uint64_t first, int count, PhotonKind kind) {
    begin(first, count, SplatFilter::Bounds{});
    stores_ = true;
    kind_ = kind;
    arrived = 0;
    stored.clear();
    beams.clear();
  }

  int total() const { return total_; }            ///< photons
  int left() const { return total_ - emitted_; }  ///< photons that were not emitted yet
  int emitted() const { return emitted_; }        ///< the next photon, counted from the task's first
  std::uint64_t next() const { return first_ + static_cast<std::uint64_t>(emitted_); }  ///< the same of all photons
  void advance() {
    assert(left() > 0);
    ++emitted_;
  }

  /// What was stored, in the order of photons and their vertices.
  std::vector<Photon> sorted_photons() const { return sorted(stored); }
  std::vector<PhotonBeam> sorted_beams() const { return sorted(beams); }
  /// Puts the splats into the order of photons and their vertices, which does not depend on the wave's size.
  void sort_splats() {
    std::sort(splats.begin(), splats.end(), [](const Splat& a, const Splat& b) { return a.order < b.order; });
  }

  SplatFilter::Bounds film_bounds{};  ///< film positions that count
  std::vector<Splat> splats;
  std::vector<Photon> stored;
  std::vector<PhotonBeam> beams;
  std::uint64_t arrived = 0;  ///< photons' vertices where one might have been stored, if only of another kind

  /// Whether photons are stored, and not seen by the camera.
  bool stores_photons() const { return stores_; }
  /// Whether photons are stored where media scatter them.
  bool stores_in_media() const { return stores_ && kind_ == PhotonKind::kVolume; }
  /// Whether photons are to be stored that come to a surface with this history, RayFlags.
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
  /// Whether photons end where they are scattered, but for what is specular.
  bool ends_at_scattering() const { return stores_ && kind_ == PhotonKind::kCaustic; }

 private:
  /// Each photon's are stored in their order: they only have to be counted.
  template <class Item> std::vector<Item> sorted(const std::vector<Item>& items) const {
    std::vector<std::uint32_t> place(static_cast<std::size_t>(total_) + 1);
    for (const Item& item : items) ++place[(item.order >> kVertexBits) + 1];
    for (std::size_t i = 1; i < place.size(); ++i) place[i] += place[i - 1];
    std::vector<Item> sorted(items.size());
    for (const Item& item : items) sorted[place[item.order >> kVertexBits]++] = item;
    return sorted;
  }

  bool stores_ = false;
  PhotonKind kind_ = PhotonKind::kAll;
  std::uint64_t first_ = 0;
  int total_ = 0, emitted_ = 0;
};

}  // namespace sheaf
