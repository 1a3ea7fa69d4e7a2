// What the passes that train the guide write down: at every vertex the direction that was sampled, and in the end how
// much light came from there.
#pragma once

#include "core/vec.h"

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// A direction sampled at a vertex.
struct GuideRecord {
  Vec3f p;                  ///< where, world space
  std::uint32_t direction;  ///< octahedral, world space
  float weight;             ///< light that came from there and was scattered on, over the density; above 0
  float bsdf_pdf;           ///< density of the direction had the BSDF been sampled, per steradian
  std::uint32_t side;       ///< see guide_side()
  std::uint32_t path;       ///< sample of the task
};

/// The records of one task.
class GuideLog {
 public:
  /// Vertices of a path that are written down.
  static constexpr std::uint32_t kMostVertices = 32;

  /// Begins a task of `paths` camera samples.
  void begin(int paths) {
    open_.clear();
    radiance_.assign(static_cast<std::size_t>(paths), 0.0f);
  }
  /// A vertex. `record.weight`: one over the path's throughput there; `before`: the sum over the lanes of the radiance
  /// that the path had found before it went on.
  void add(const GuideRecord& record, float before) { open_.push_back({record, before}); }
  /// The path has ended, with so much radiance.
  void finish(std::uint32_t path, float radiance) { radiance_[path] = radiance; }
  /// The directions from which light has come, path by path and vertex by vertex, whatever the order in which waves
  /// have worked on them.
  std::vector<GuideRecord> records() const {
    std::vector<std::uint32_t> begin(radiance_.size() + 1);
    for (const Open& open : open_) begin[open.record.path + 1] += weight_of(open) > 0 ? 1 : 0;
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    std::vector<GuideRecord> sorted(begin.back());
    for (const Open& open : open_) {
      const float weight = weight_of(open);
      if (!(weight > 0)) continue;
      GuideRecord& out = sorted[begin[open.record.path]++];
      out = open.record;
      out.weight = weight;
    }
    return sorted;
  }

 private:
  struct Open {
    GuideRecord record;
    float before;
  };
  /// 0 where nothing came, or what came is not a number.
  float weight_of(const Open& open) const {
    const float weight = (radiance_[open.record.path] - open.before) * open.record.weight;
    return weight > 0 && weight < 1e30f ? weight : 0.0f;
  }

  std::vector<Open> open_;
  std::vector<float> radiance_;  ///< of each path
};

}  // namespace sheaf
