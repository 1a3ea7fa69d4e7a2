// Converts recorded vertices to training samples for the guide.
#include "kernels/guiding/guide_record.h"

namespace sheaf {

namespace {

/// Replaces NaN, values of 1e30 and more, and negative values that stem from rounding errors by 0.
float usable(float weight) { return weight > 0 && weight < 1e30f ? weight : 0.0f; }

}  // namespace

/// Counting sort by path; the vertices of each path are already in order.
std::vector<TrainingSamples::Open> TrainingSamples::sorted() const {
  std::vector<std::uint32_t> begin(radiance_.size() + 1);
  for (const Open& open : open_) ++begin[open.vertex.path + 1];
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<Open> sorted(open_.size());
  for (const Open& open : open_) sorted[begin[open.vertex.path]++] = open;
  return sorted;
}

std::vector<GuideRecord> TrainingSamples::records(const GuideView& guide, std::span<const float> means) const {
  const std::vector<Open> vertices = sorted();
  std::vector<GuideRecord> out(vertices.size());
  float mean_ahead = -1;  // of the next vertex
  for (std::size_t i = vertices.size(); i-- > 0;) {
    const auto& [v, before] = vertices[i];
    const float found = usable((radiance_[v.path] - before) * v.over_beta);
    const std::uint32_t row = guide_row<Scalar>(guide, v.side, guide_code<Scalar>(guide, v.p));
    out[i] = {v.p, v.direction, found, v.bsdf_pdf, row << 3 | v.side, found};
    if (i + 1 < vertices.size() && vertices[i + 1].vertex.path == v.path && mean_ahead >= 0) {
      const auto& [next, next_before] = vertices[i + 1];
      out[i].weight = usable((next_before - before) * v.over_beta + v.over_beta / next.over_beta * mean_ahead);
    }
    mean_ahead = row < means.size() ? means[row] : -1;
  }
  return out;
}

}  // namespace sheaf
