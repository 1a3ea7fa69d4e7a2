// Training samples for the guide: the direction sampled at each vertex, and the light that arrived from there.
#pragma once

#include "core/color/float4.h"
#include "kernels/guiding/candidate_moments.h"
#include "kernels/guiding/guide_view.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// A direction sampled at a vertex.
struct GuideVertex {
  Vec3f p;                  ///< vertex position, world space
  std::uint32_t direction;  ///< octahedral, world space
  float over_beta;          ///< 1 / the path's throughput before the vertex, summed over lanes
  float bsdf_pdf;           ///< pdf of the direction by BSDF sampling, 1/sr
  std::uint32_t side;       ///< see guide_side()
  std::uint32_t path;       ///< sample of the task
};

/// The same with the light that arrived from the direction.
struct GuideRecord {
  Vec3f p;
  std::uint32_t direction;
  /// Estimated light that arrived from the direction and was scattered, over the pdf of the direction.
  float weight;
  float bsdf_pdf;
  std::uint32_t row_and_side;  ///< row of the vertex's mixture, above three bits of GuideVertex::side
  float found;                 ///< light that this path itself has found

  std::uint32_t row() const { return row_and_side >> 3; }
  std::uint32_t side() const { return row_and_side & 7u; }
};

/// The training samples of one task.
class TrainingSamples {
 public:
  /// Maximum number of recorded vertices per path.
  static constexpr std::uint32_t kMaxVertices = 32;

  /// Begins a task of `paths` camera samples.
  void begin(int paths) {
    open_.clear();
    radiance_.assign(static_cast<std::size_t>(paths), 0.0f);
    squared_radiance_.clear();
    vertices_ = {};
  }
  /// Adds the next vertex of a path. `before`: radiance of the path when it left the vertex, summed over lanes.
  void add(const GuideVertex& vertex, float before) { open_.push_back({vertex, before}); }
  /// Ends a path, with its final radiance.
  void finish(std::uint32_t path, float radiance) { radiance_[path] = radiance; }

  /// If the pass compares light candidates: ends a path, with PathMoments::radiance and `excess`.
  void finish_moments(std::uint32_t path, const Spectrum4& radiance, const Spectrum4& excess) {
    squared_radiance_.resize(radiance_.size());
    squared_radiance_[path] = to_spectrum(Float4(radiance) * Float4(radiance) + Float4(excess));
  }
  /// Likewise counts vertices that sample lights, and those that would have a shadow ray with kCandidateCounts[i]
  /// candidates.
  void count_vertices(int i, int vertices, int with_shadow_rays) {
    vertices_.sampled += i == 0 ? static_cast<std::uint64_t>(vertices) : 0u;
    vertices_.shadow_rays[static_cast<std::size_t>(i)] += static_cast<std::uint64_t>(with_shadow_rays);
  }

  /// Vertices that sample lights, and shadow rays for each of kCandidateCounts.
  struct Vertices {
    std::uint64_t sampled = 0;
    std::array<std::uint64_t, std::size(kCandidateCounts)> shadow_rays{};
  };
  const Vertices& vertices() const { return vertices_; }
  /// Estimates of the squared radiance of each path, for each of kCandidateCounts; empty unless they are compared.
  const std::vector<Spectrum4>& squared_radiance() const { return squared_radiance_; }
  /// Radiance of each path, lanes added up.
  const std::vector<float>& radiance() const { return radiance_; }
  /// All records, by path and then by vertex, independent of the order in which waves have added them. `means`: mean of
  /// GuideRecord::found for each row of the guide's mixtures; negative or missing: unknown.
  ///
  /// The light from a direction is estimated by the path's radiance at the next vertex, including light sampling, plus
  /// the mean of the light found beyond it. This has much less variance than the remainder of a single path.
  std::vector<GuideRecord> records(const GuideView& guide, std::span<const float> means) const;

 private:
  struct Open {
    GuideVertex vertex;
    float before;
  };
  std::vector<Open> sorted() const;

  std::vector<Open> open_;
  std::vector<float> radiance_;  ///< per path
  std::vector<Spectrum4> squared_radiance_;
  Vertices vertices_;
};

}  // namespace sheaf
