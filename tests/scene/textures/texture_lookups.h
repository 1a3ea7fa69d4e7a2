// Lookups of textures for tests: queries at random positions, and SIMD against scalar results.
#pragma once

#include "core/sampling/rng.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/textures/texture_lookup.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/records_testing.h"

#include <algorithm>
#include <cstdint>
#include <functional>

namespace sheaf::texture_lookups {

/// The `i`-th number of a stream of random numbers.
inline float uniform(std::uint32_t i, std::uint32_t stream) { return random4<Scalar>(stream, i, 0, 0).x; }

inline TextureView view_of(const TextureTables& textures) {
  TextureView view;
  view.rows = textures.rows.data();
  view.images = textures.images.data();
  view.grids = textures.grid_rows.data();
  return view;
}

inline TextureQuery<Scalar> query_at(float u, float v) { return {{u, v}, 0, 0, 0, 0}; }

/// Random positions in [-2, 3]^2.
inline TextureQuery<Scalar> random_query(std::uint32_t i) {
  return query_at(5 * uniform(i, 2) - 2, 5 * uniform(i, 3) - 2);
}

/// The queries of all lanes.
inline TextureQuery<Wide> wide_query(const std::function<TextureQuery<Scalar>(int)>& lane_query) {
  return {
      {wide_floats([&](int k) { return lane_query(k).uv.x; }), wide_floats([&](int k) { return lane_query(k).uv.y; })},
      wide_uints([&](int k) { return lane_query(k).shape; }),
      wide_uints([&](int k) { return lane_query(k).primitive; }),
      wide_floats([&](int k) { return lane_query(k).b1; }),
      wide_floats([&](int k) { return lane_query(k).b2; }),
      wide_record<Vec3>([&](int k) { return lane_query(k).p; }),
      wide_record<Vec2>([&](int k) { return lane_query(k).footprint; }),
      wide_record<Vec2>([&](int k) { return lane_query(k).footprint_axis; })};
}

/// Largest difference between SIMD and scalar lookups of a texture. They are equal except where the compiler fuses a
/// product and a sum, which slopes amplify by the size of the image.
struct LaneDifference {
  double value = 0, slope = 0;
};

inline LaneDifference compare_lanes(const TextureView& view, std::uint32_t texture,
                                    const std::function<TextureQuery<Scalar>(int)>& lane_query) {
  const TextureQuery<Wide> query = wide_query(lane_query);
  const Spectrum<Wide> color = lookup_texture<Wide>(view, texture, query);
  const WideFloat scalar = lookup_scalar<Wide>(view, texture, query);
  const Vec2<Wide> gradient = lookup_scalar_gradient<Wide>(view, texture, query);
  LaneDifference d;
  for (int k = 0; k < kWidth; ++k) {
    const TextureQuery<Scalar> q = lane_query(k);
    const Spectrum4 c = lookup_texture<Scalar>(view, texture, q);
    const Vec2f g = lookup_scalar_gradient<Scalar>(view, texture, q);
    d.value =
        std::max({d.value, difference(color.c0[k], c.c0), difference(color.c1[k], c.c1), difference(color.c2[k], c.c2),
                  difference(color.c3[k], c.c3), difference(scalar[k], lookup_scalar<Scalar>(view, texture, q))});
    d.slope = std::max({d.slope, difference(gradient.x[k], g.x), difference(gradient.y[k], g.y)});
  }
  return d;
}

inline bool lanes_agree(const TextureView& view, std::uint32_t texture,
                        const std::function<TextureQuery<Scalar>(int)>& lane_query) {
  const LaneDifference d = compare_lanes(view, texture, lane_query);
  return d.value < 1e-6 && d.slope < 2e-5;
}

}  // namespace sheaf::texture_lookups
