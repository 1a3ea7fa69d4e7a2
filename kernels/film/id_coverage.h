// Which surfaces a pixel sees, and how much of it each of them covers.
#pragma once

#include <cstdint>
#include <vector>

namespace sheaf {

/// The sum of the weights of a pixel's samples on each surface: few, most often one. Sums depend on the order in which
/// weights are added, but not on what is added of other surfaces in between.
class IdCoverage {
 public:
  static constexpr std::uint32_t kNothing = 0xffffffffu;
  struct Entry {
    std::uint32_t shape = kNothing;  ///< row of SceneView::shapes; or samples that met no surface
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
  /// One of a surface that is not there yet.
  void append(const Entry& entry) { entries_.push_back(entry); }
  /// In the order in which they were met first.
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
};

}  // namespace sheaf
