// Columns of vertices, light candidates and shadow rays, which the stages between a hit and the next ray process in
// order.
#pragma once

#include "core/soa/soa.h"
#include "kernels/guiding/candidate_moments.h"
#include "kernels/lights/light_tree.h"
#include "kernels/wave/path_state.h"
#include "kernels/wave/wave_needs.h"
#include "scene/materials/list.h"

namespace sheaf {

/// Vertices of one closure kind: the slots sorted[slot_begin .. slot_begin + count). Their rows start at
/// `column_begin`, a multiple of kWidth.
struct VertexRun {
  int slot_begin = 0, count = 0, column_begin = 0;
};

/// Vertices by closure kind and material, their light candidates, and shadow rays.
struct ShadingColumns {
  std::uint8_t* sort_keys = nullptr;
  VertexRun runs[kClosureKinds];
  Soa<VertexItem> vertices;
  Soa<TexturedItem> textured;               ///< WaveNeeds::textures
  Soa<ClosureItem> closures;                ///< as many words as WaveNeeds::closure_words
  Soa<LightCandidate> candidates;           ///< WaveNeeds::candidates
  Soa<ReservoirItem> reservoirs;            ///< WaveNeeds::reservoirs
  Soa<CandidateWeights> candidate_weights;  ///< WaveNeeds::candidate_moments
  Soa<LightTreeCut> light_cuts;             ///< WaveNeeds::light_cuts
  Soa<RasterPosition> raster_positions;     ///< WaveNeeds::raster_positions
  Soa<GuideCell> guide_cells;               ///< WaveNeeds::guides
  Soa<ShadowItem> shadows;
  Soa<TransmittanceItem> transmittances;  ///< WaveNeeds::transparency
  int shadow_count = 0;                   ///< rows of `shadows` and `transmittances`

  /// Number of rows of columns with one row per vertex: the run of each kind starts at a register boundary.
  static constexpr int vertex_capacity(int paths) { return paths + kClosureKinds * kWidth; }

  /// Calls f(columns, number of rows, number of columns needed) for each.
  template <class Columns, class F> static void for_each(Columns& c, int paths, const WaveNeeds& needs, F&& f) {
    const int rows = vertex_capacity(paths);
    const auto all = [](bool needed, int columns) { return needed ? columns : 0; };
    f(c.vertices, rows, kLeafCount<VertexItem>);
    f(c.textured, rows, all(needs.textures, kLeafCount<TexturedItem>));
    f(c.closures, rows, needs.closure_words);
    f(c.candidates, rows, all(needs.candidates, kLeafCount<LightCandidate>));
    f(c.reservoirs, rows, all(needs.reservoirs, kLeafCount<ReservoirItem>));
    f(c.candidate_weights, rows, all(needs.candidate_moments, kLeafCount<CandidateWeights>));
    f(c.light_cuts, rows, all(needs.light_cuts, kLeafCount<LightTreeCut>));
    f(c.raster_positions, rows, all(needs.raster_positions, kLeafCount<RasterPosition>));
    f(c.guide_cells, rows, all(needs.guides, kLeafCount<GuideCell>));
    const int shadow_rays = needs.segments ? 2 * paths : paths;
    f(c.shadows, shadow_rays, kLeafCount<ShadowItem>);
    f(c.transmittances, shadow_rays, all(needs.transparency, kLeafCount<TransmittanceItem>));
  }
};

}  // namespace sheaf
