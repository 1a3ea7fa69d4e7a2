// Estimates from training passes whether path guiding is worth its cost.
#pragma once

#include "kernels/training/compared_pass.h"

#include <cstddef>

namespace sheaf {

/// Number of training passes whose samples are compared. Only the first one is unguided.
inline constexpr std::size_t kComparedPasses = 3;

/// Efficiency of guiding: (error x rays without guiding) / (error x rays with guiding).
struct GuidingGain {
  double ratio = 1;           ///< above 1: guiding lowers the error at equal cost
  double standard_error = 0;  ///< of the logarithm of `ratio`

  /// Whether the ratio is above 1 by twice its standard error, and by at least a quarter.
  bool is_significant() const;
  /// Whether more training may make it significant.
  bool is_promising() const;
};

/// Estimates the gain. The error is the geometric mean of the squared error and of the squared error relative to the
/// brightness of the surroundings, each without the worst 0.1 % or 0.5 % of the pixels, whichever makes the gain
/// smaller. It is estimated from half the squared difference of the means of a pixel's two sets. A guided ray counts as
/// 1.2 rays. The passes may differ in size. The standard error is that of the jackknife (Efron and Stein 1981). The
/// ratio is 1 if a pass holds no light.
GuidingGain guiding_gain(const ComparedPass& unguided, const ComparedPass& guided);

}  // namespace sheaf
