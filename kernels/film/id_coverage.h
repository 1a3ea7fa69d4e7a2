// Coverage of a pixel by surfaces, from which object and material id layers are computed.
#pragma once

#include <cstdint>
#include <vector>

namespace sheaf {

/// Sum of the weights of a pixel's samples on each surface. There are few surfaces per pixel, usually one. Sums depend
/// on the order in which weights are added, but not on the weights of other surfaces added in between.
class IdCoverage {
 public:
  static constexpr std::uint32_t kNothing = 0xffffffffu;
  struct Entry {
    std::uint32_t shape = kNothing;  ///< row of GeometryView::shapes; kNothing: samples that hit no surface
    double weight = 0;
  };

  void add(std::uint32_t shape, double weight) {
    for (Entry& entry : entries_)
      if (entry.shape == shape) {
        entry.weight += weight;
        return;
      }
    entries_.push_back({shape, weight});
  }
  void add(const IdCoverage& other) {
    for (const Entry& entry : other.entries_) add(entry.shape, entry.weight);
  }
  /// Appends an entry; its surface must not be present yet.
  void append(const Entry& entry) { entries_.push_back(entry); }
  /// In order of first occurrence.
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
};

}  // namespace sheaf
