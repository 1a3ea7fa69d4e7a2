#include "kernels/wave.h"

#include <unistd.h>

#include <algorithm>

namespace sheaf {

namespace {

constexpr int kSlotLists = 9;

/// Columns of surface items: every kind's run begins at a whole register.
int item_capacity(int paths) { return paths + kClosureKinds * kWidth; }

std::size_t wave_bytes(int paths) {
  const auto each = static_cast<std::size_t>(paths);
  return Groups<RayState>::bytes(paths) + Groups<HitState>::bytes(paths) + Groups<ThroughputState>::bytes(paths) +
         Groups<RadianceState>::bytes(paths) + Groups<ProbabilityState>::bytes(paths) +
         kSlotLists * SlotList::bytes(paths) + each * (1 + 2 * sizeof(float)) + 3 * kSimdAlignment +
         Soa<SurfaceItem>::bytes(item_capacity(paths)) + Soa<TexturedItem>::bytes(item_capacity(paths)) +
         Soa<ClosureItem>::bytes(item_capacity(paths)) + Soa<LightCandidate>::bytes(item_capacity(paths)) +
         Soa<ReservoirItem>::bytes(item_capacity(paths)) + Soa<ShadowItem>::bytes(paths) +
         Soa<TransmittanceItem>::bytes(paths);
}

}  // namespace

Wave::Wave(int paths) : capacity(paths), arena(wave_bytes(paths)) {
  rays.bind(arena, paths);
  hits.bind(arena, paths);
  throughput.bind(arena, paths);
  radiance.bind(arena, paths);
  probabilities.bind(arena, paths);
  for (SlotList* list : {&free, &active, &medium, &miss, &emitter, &composite, &surface, &finished, &sorted})
    list->bind(arena, paths);
  heroes = arena.take<float>(static_cast<std::size_t>(paths));
  std::fill_n(heroes, paths, 0.0f);
  travelled = arena.take<float>(static_cast<std::size_t>(paths));
  sort_keys = arena.take<std::uint8_t>(static_cast<std::size_t>(paths));
  items.bind(arena, item_capacity(paths));
  textured.bind(arena, item_capacity(paths));
  closures.bind(arena, item_capacity(paths));
  candidates.bind(arena, item_capacity(paths));
  reservoirs.bind(arena, item_capacity(paths));
  shadows.bind(arena, paths);
  transmittances.bind(arena, paths);
  for (int slot = paths - 1; slot >= 0; --slot) free.push(static_cast<Slot>(slot));
}

std::size_t Wave::bytes_per_path() { return (wave_bytes(8192) - wave_bytes(4096)) / 4096; }

int Wave::default_capacity() {
  long l2 = 0;
#if defined(_SC_LEVEL2_CACHE_SIZE)
  l2 = sysconf(_SC_LEVEL2_CACHE_SIZE);
#endif
  if (l2 <= 0) l2 = 512 * 1024;
  const long paths = l2 / 2 / static_cast<long>(bytes_per_path()) / 64 * 64;
  return static_cast<int>(std::clamp(paths, 256l, 4096l));
}

void Wave::begin(const TileSamples& tile, FilmSample* samples, SpectralSample* spectra, int bins) {
  assert(free.size() == capacity);
  task = tile;
  task_samples = samples;
  task_spectra = spectra;
  spectral_bins = bins;
  next_sample = 0;
}

}  // namespace sheaf
