// Allocates the queues of a wave in its arena, and derives its capacity from the size of the L2 cache.
#include "kernels/wave/wave.h"

#include "kernels/bsdf/list.h"

#include <unistd.h>

#include <algorithm>

namespace sheaf {

namespace {

template <template <class> class Record> std::size_t state_bytes(const SlotTable<Record>&, int paths) {
  return SlotTable<Record>::bytes(paths);
}
std::size_t state_bytes(const float*, int paths) {
  return static_cast<std::size_t>(paths) * sizeof(float) + kSimdAlignment;
}

template <template <class> class Record> void bind_state(SlotTable<Record>& rows, Arena& arena, int paths) {
  rows.bind(arena, paths);
}
void bind_state(float*& words, Arena& arena, int paths) {
  words = arena.take<float>(static_cast<std::size_t>(paths));
  std::fill_n(words, paths, 0.0f);
}

std::size_t wave_bytes(int paths, const WaveNeeds& needs) {
  std::size_t bytes = static_cast<std::size_t>(paths) + kSimdAlignment;  // sort_keys
  bytes += kSlotLists * SlotList::bytes(paths);
  const PathPool pool;
  PathPool::for_each_state(pool, needs, [&](const auto& state, bool needed) {
    if (needed) bytes += state_bytes(state, paths);
  });
  const ShadingColumns columns;
  ShadingColumns::for_each(columns, paths, needs, [&](const auto& soa, int rows, int count) {
    if (count > 0) bytes += soa.bytes(rows, count);
  });
  return bytes;
}

/// Words of the longest closure among the scene's materials, rounded up to 4, as closures are copied by four words.
int longest_closure(const SceneView& scene) {
  int longest = 0;
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    const auto k = static_cast<int>(kind);
    const bool present = scene.materials.buckets.begin[k] != scene.materials.buckets.begin[k + 1];
    if (present) longest = std::max(longest, (kLeafCount<Bsdf> + 3) / 4 * 4);
  });
  return longest;
}

}  // namespace

WaveNeeds WaveNeeds::of(const StageContext& context) {
  const SceneView& scene = context.scene;
  WaveNeeds needs;
  needs.spectral = scene.color == ColorMode::kSpectral;
  needs.times = scene.motion.any();
  needs.transparency = scene.needs_transmittance;
  needs.distance = needs.transparency || context.integrator.hide_emitters;
  needs.textures = false;
  needs.candidates = !context.integrator.traits().connects_photons();
  needs.reservoirs = needs.candidates && context.candidates > 1;
  needs.light_cuts = needs.candidates && shares_light_cut(context);
  needs.candidate_moments = false;
  needs.raster_positions = !needs.candidates;
  needs.guides = guides_directions(context);
  needs.chains = context.connects_caustics();
  needs.segments = connects_segments(context);
  for (const std::uint32_t flags : scene.materials.buckets.kind_flags)
    needs.textures = needs.textures || (flags & (kNeedsUv | kMapped)) != 0;
  needs.counted_lights = std::min(scene.lights.count, kMaxReportedLights);
  needs.closure_words = longest_closure(scene);
  return needs;
}

WaveNeeds WaveNeeds::with_candidate_moments(const StageContext& context) {
  StageContext compared = context;
  compared.start_candidate_comparison();
  WaveNeeds needs = of(compared);
  needs.candidate_moments = true;
  return needs;
}

Wave::Wave(int path_count, const WaveNeeds& what)
    : capacity(path_count), needs(what), arena(wave_bytes(path_count, what)) {
  PathPool::for_each_state(*this, needs, [&](auto& state, bool needed) {
    if (needed) bind_state(state, arena, path_count);
  });
  for (SlotList PathPool::*list : kLists) (this->*list).bind(arena, path_count);
  sort_keys = arena.take<std::uint8_t>(static_cast<std::size_t>(path_count));
  ShadingColumns::for_each(*this, path_count, needs, [&](auto& soa, int rows, int count) {
    if (count > 0) soa.bind(arena, rows, count);
  });
  for (int slot = path_count - 1; slot >= 0; --slot) free.push(static_cast<Slot>(slot));
  stats.lights.resize(needs.counted_lights);
}

std::size_t Wave::bytes_per_path(const WaveNeeds& needs) {
  return (wave_bytes(8192, needs) - wave_bytes(4096, needs)) / 4096;
}

int Wave::default_capacity(const WaveNeeds& needs) {
  long l2 = 0;
#if defined(_SC_LEVEL2_CACHE_SIZE)
  l2 = sysconf(_SC_LEVEL2_CACHE_SIZE);
#endif
  if (l2 <= 0) l2 = 512 * 1024;
  const long paths = l2 / 2 / static_cast<long>(bytes_per_path(needs)) / 64 * 64;
  return static_cast<int>(std::clamp(paths, 256l, 4096l));
}

Float4 limited_indirect(const Wave& wave, Slot slot, const Float4& found, int scatterings) noexcept {
  if (static_cast<int>(wave.paths.row(slot).depth()) + scatterings < 2) return found;
  const float sum = total(found);
  return sum > wave.max_indirect ? found * (wave.max_indirect / sum) : found;
}

}  // namespace sheaf
