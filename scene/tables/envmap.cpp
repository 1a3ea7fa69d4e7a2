#include "scene/tables/envmap.h"

#include <algorithm>

namespace sheaf {

std::uint16_t envmap_code(float value) {
  constexpr std::uint32_t kHalfStep = 1u << 12, kMin = 1u << 10, kMax = 0xffffu;
  // Rounds to nearest, ties to even.
  const std::uint32_t bits = float_bits(std::min(value, 2.0f) * 0x1p-64f);
  const std::uint32_t code = (bits + kHalfStep - 1 + (bits >> 13 & 1u)) >> 13;
  return static_cast<std::uint16_t>(code < kMin ? 0u : std::min(code, kMax));
}

EnvmapView Envmap::view() const {
  EnvmapView v{columns.data(), spectra.data(), quantiles.data(), rows.data(), tables.data(), width,
               height,         unit,           offset,           {}};
  std::copy(std::begin(to_map), std::end(to_map), v.to_map);
  return v;
}

}  // namespace sheaf
