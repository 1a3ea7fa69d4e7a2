// Mean of a light's texture, for its power.
#pragma once

#include "scene/textures/texture_lookup.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

/// Default number of points for means of textures.
inline constexpr int kMeanPoints = 4096;

/// Point i of an additive recurrence over the unit square (Roberts, "The Unreasonable Effectiveness of Quasirandom
/// Sequences", 2018).
inline Vec2f spread_point(int i) {
  constexpr double kX = 0.7548776662466927, kY = 0.5698402909980532;
  const double x = 0.5 + kX * i, y = 0.5 + kY * i;
  return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

/// Rounds a fraction of one, so that values that differ only by rounding errors become equal keys.
inline std::uint32_t rounded_fraction(float fraction) {
  return static_cast<std::uint32_t>(std::lround(fraction * 0x1p16f));
}

/// Weighted mean of texture values, clamped to 0 as lights do.
class TextureMean {
 public:
  TextureMean(const SceneView& scene, std::uint32_t texture) : scene_(scene), texture_(texture) {}

  void add(const TextureQuery<Scalar>& query, double w) {
    const Spectrum4 value = lookup_texture<Scalar>(scene_.textures, texture_, query);
    r_ += w * std::max(value.c0, 0.0f);
    g_ += w * std::max(value.c1, 0.0f);
    b_ += w * std::max(value.c2, 0.0f);
    weight_ += w;
  }
  Vec3f value() const {
    const double scale = weight_ > 0.0 ? 1.0 / weight_ : 0.0;
    return {static_cast<float>(r_ * scale), static_cast<float>(g_ * scale), static_cast<float>(b_ * scale)};
  }

 private:
  const SceneView& scene_;
  std::uint32_t texture_;
  double r_ = 0, g_ = 0, b_ = 0, weight_ = 0;
};

}  // namespace sheaf
