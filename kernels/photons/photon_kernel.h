// Kernels for density estimation with photons.
#pragma once

#include "core/simd/simd.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// 2D kernel times pi r^2, as a function of the squared distance over r^2 in [0, 1].
template <class L> SHEAF_INLINE Float<L> photon_kernel(PhotonKernel kind, Float<L> squared) {
  using F = Float<L>;
  switch (kind) {
    case PhotonKernel::kDisc:
      return F(1.0f);
    case PhotonKernel::kCone:
      return F(3.0f) * (F(1.0f) - sqrt(squared));
    case PhotonKernel::kEpanechnikov:
      return F(2.0f) * (F(1.0f) - squared);
  }
  return F(1.0f);
}

/// 1D kernel across a beam times 2 r, as a function of the squared distance over r^2 in [0, 1].
template <class L> SHEAF_INLINE Float<L> beam_kernel(PhotonKernel kind, Float<L> squared) {
  using F = Float<L>;
  switch (kind) {
    case PhotonKernel::kDisc:
      return F(1.0f);
    case PhotonKernel::kCone:
      return F(2.0f) * (F(1.0f) - sqrt(squared));
    case PhotonKernel::kEpanechnikov:
      return F(1.5f) * (F(1.0f) - squared);
  }
  return F(1.0f);
}

}  // namespace sheaf
