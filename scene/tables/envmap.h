// Environment maps: radiance by direction from a picture, with tables to sample it in proportion to its brightness.
//
// Node (i, j) of W columns and H rows lies at u = (i + 1/2) / W, which goes round, and v = j / (H - 1) of the unit
// square; u is the longitude, atan2(x, -z) / 2 pi, and v the polar angle from +y, over pi, in the map's space. Radiance
// and density are bilinear in between. In spectral mode a node's radiance is a scale times a shape that is at most 1;
// each of the two is bilinear, and radiance their product, as scene files in Mitsuba's format are meant. Between nodes
// of one shape, so between greys, that is the same.
#pragma once

#include "core/vec.h"

#include <vector>

namespace sheaf {

/// What kernels see of an environment map.
struct EnvmapView {
  /// Row by row from +y, four floats to a node: radiance in R, G and B, and the density of sampling at the node, per
  /// unit of the square.
  const float* nodes = nullptr;
  /// Spectral mode: c0, c1, c2 and scale of each node's ScaledSigmoid, to be multiplied by D65.
  const float* spectra = nullptr;
  /// H - 1 cells of rows: the probability of all before it, and 1 at the end.
  const float* marginal = nullptr;
  /// For each row of nodes, W + 1 sums: the integral of the density from the first node's u on, in units of 1 / W.
  const float* conditional = nullptr;
  std::uint32_t width = 0, height = 0;  ///< W >= 1, H >= 2
  float to_map[9] = {};                 ///< rows of the orthogonal matrix from world space
};

/// Owns the tables of an environment map.
struct Envmap {
  std::vector<float> nodes, spectra, marginal, conditional;
  std::uint32_t width = 0, height = 0;
  float to_map[9] = {};
  Vec3f mean{};  ///< radiance averaged over all directions; zero: the map is black, or there is none

  EnvmapView view() const;
  std::size_t bytes() const {
    return (nodes.capacity() + spectra.capacity() + marginal.capacity() + conditional.capacity()) * sizeof(float);
  }
};

}  // namespace sheaf
