// What the passes that train the guide write down: at every vertex the direction that was sampled, and in the end how
// much light came from there.
#pragma once

#include "kernels/guiding/guide_view.h"

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// A direction sampled at a vertex.
struct GuideVertex {
  Vec3f p;                  ///< where, world space
  std::uint32_t direction;  ///< octahedral, world space
  float over_beta;          ///< one over the path's throughput before it was scattered, lanes added up
  float bsdf_pdf;           ///< density of the direction had the BSDF been sampled, per steradian
  std::uint32_t side;       ///< see guide_side()
  std::uint32_t path;       ///< sample of the task
};

/// The same once it is known what came of it.
struct GuideRecord {
  Vec3f p;
  std::uint32_t direction;
  /// Light that came from there and was scattered on, over the direction's density: an estimate of it.
  float weight;
  float bsdf_pdf;
  std::uint32_t row_and_side;  ///< row of the mixture that the vertex had, above three bits of GuideVertex::side
  float found;                 ///< what the path itself has found of that light

  std::uint32_t row() const { return row_and_side >> 3; }
  std::uint32_t side() const { return row_and_side & 7u; }
};

/// The vertices of one task's paths.
class TrainingSamples {
 public:
  /// Vertices of a path that are written down.
  static constexpr std::uint32_t kMaxVertices = 32;

  /// Begins a task of `paths` camera samples.
  void begin(int paths) {
    open_.clear();
    radiance_.assign(static_cast<std::size_t>(paths), 0.0f);
  }
  /// A vertex, after those that the path has met before. `before`: the radiance that the path had found when it went
  /// on, lanes added up.
  void add(const GuideVertex& vertex, float before) { open_.push_back({vertex, before}); }
  /// The path has ended, with so much radiance.
  void finish(std::uint32_t path, float radiance) { radiance_[path] = radiance; }

  /// All of them, path by path and vertex by vertex, whatever the order in which waves have worked on them. `means`: of
  /// each row of the guide's mixtures the mean of GuideRecord::found; less than 0, or none: not known.
  ///
  /// What came from a direction is estimated by what the path found at the next vertex, light sampling and all, and by
  /// the mean of what was found from there on; that has far less noise than the rest of one path has.
  std::vector<GuideRecord> records(const GuideView& guide, std::span<const float> means) const;

 private:
  struct Open {
    GuideVertex vertex;
    float before;
  };
  std::vector<Open> sorted() const;

  std::vector<Open> open_;
  std::vector<float> radiance_;  ///< of each path
};

}  // namespace sheaf
