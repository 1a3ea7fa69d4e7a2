#include "scene/xml/linear_gamma.h"

namespace sheaf {

bool read_linear_gamma(Properties& p) {
  const float gamma = p.number("gamma", -1);
  constexpr float kLow = 2.15f, kHigh = 2.25f;
  if (gamma > kLow && gamma < kHigh) {
    p.context().note(p.where(), fmt::format("{} '{}' has 'gamma' 2.2, rendered as sRGB", p.element().name, p.type()));
  } else if (gamma != 1 && gamma != -1 && gamma != 0) {
    p.report_at("gamma", fmt::format("is {}, expected 1 (linear) or -1 (sRGB)", gamma), SceneErrorCode::kOutOfRange);
  }
  return gamma == 1;
}

}  // namespace sheaf
