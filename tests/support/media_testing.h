// Media for tests: scenes built in memory, and grid files.
#pragma once

#include "tests/support/tiny_scenes.h"

#include <cstring>
#include <fstream>
#include <functional>

namespace sheaf {

inline MediumId add_medium(Description& d, MediumDescription medium) {
  d.media.push_back(std::move(medium));
  return static_cast<MediumId>(d.media.size() - 1);
}

/// A homogeneous medium of gray extinction `sigma_t`, 1/m, and single-scattering albedo `albedo`.
inline MediumDescription fog(float sigma_t, float albedo) {
  MediumDescription m;
  m.coefficients =
      ExtinctionAlbedoDescription{SpectrumDescription::constant(sigma_t), SpectrumDescription::constant(albedo)};
  return m;
}

inline PhaseId add_phase(Description& d, float g) {
  d.phases.push_back({HenyeyGreensteinDescription{g}, {}});
  return static_cast<PhaseId>(d.phases.size() - 1);
}

/// Fills a shape with a medium and makes its surface a null interface.
inline ShapeDescription& fill(Description& d, ShapeDescription& shape, MediumId medium) {
  shape.material = add_material(d, NullDescription{});
  shape.interior = medium;
  return shape;
}

/// Writes a Mitsuba grid of `n`^3 voxels with `channels` values each. `value` receives the voxel center in the unit
/// cube and the channel.
inline std::filesystem::path write_vol(const std::filesystem::path& file, int n, int channels,
                                       const std::function<float(Vec3f, int)>& value) {
  std::ofstream out(file, std::ios::binary);
  const auto put = [&](auto v) { out.write(reinterpret_cast<const char*>(&v), sizeof(v)); };
  out.write("VOL\x03", 4);
  put(std::int32_t{1});
  for (int i = 0; i < 3; ++i) put(std::int32_t{n});
  put(std::int32_t{channels});
  for (const float x : {0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f}) put(x);
  const auto center = [n](int i) { return (static_cast<float>(i) + 0.5f) / static_cast<float>(n); };
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int c = 0; c < channels; ++c) put(value({center(x), center(y), center(z)}, c));
  return file;
}

/// A grid volume from a .vol file, by default over the unit cube.
inline GridVolumeDescription vol(const std::filesystem::path& file, const Transform& to_world = {}) {
  GridVolumeDescription grid;
  grid.file = file;
  grid.to_world = to_world;
  return grid;
}

}  // namespace sheaf
