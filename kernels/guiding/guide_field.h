// The guide: spatial cells, each with a mixture that models incident light. It learns from successive training passes.
// The same records in the same order give the same guide, for any number of threads.
//
// A cell is a leaf of the tree of its side; see GuideView. It is split if a pass yields more than `split_records`
// records for it, so cells are smaller where more is known, as in Mueller, Gross and Novak, "Practical Path Guiding for
// Efficient Light-Transport Simulation", 2017.
#pragma once

#include "kernels/guiding/fit_mixture.h"
#include "kernels/guiding/guide_view.h"

#include <cstddef>

namespace sheaf {

class GuideField {
 public:
  GuideField();

  /// Trains the guide with the records of a pass's tasks, in the order of the tasks.
  void train(const std::vector<std::vector<GuideRecord>>& tasks, std::size_t split_records);

  /// Valid until the next call of train(), or until the guide is moved.
  GuideView view() const;
  /// Mean of GuideRecord::found for each row of the view's mixtures; -1: unknown. Valid as long as the view.
  std::span<const float> means() const { return means_; }
  /// Number of cells of all sides.
  std::size_t cells() const { return cells_.size(); }

 private:
  /// A cell, which is a leaf of a tree.
  struct Cell {
    int depth;  ///< number of levels above the leaf
    /// index of its node: in the table, or if `depth` > kGuideTopBits in children_
    std::uint32_t node;
    GuideSums sums;
    GuideMixture mixture;
    double found, vertices;  ///< sum of GuideRecord::found, and number of vertices
  };
  struct Span {
    std::size_t begin, end;
  };

  void fit_cube(const std::vector<std::vector<GuideRecord>>& tasks);
  std::vector<Span> sort_records(const std::vector<std::vector<GuideRecord>>& tasks);
  void split_cells(std::vector<Span>& spans, std::size_t split_records);
  std::size_t partition(std::size_t cell, const Span& span);
  void split(std::size_t cell);
  void put(std::uint32_t cell);
  void fit(std::size_t cell, const Span& span);

  std::vector<GuideRecord> records_;
  std::vector<Cell> cells_;
  std::vector<GuideMixture> mixtures_;  ///< of the cells, from row 1 on
  std::vector<float> means_;
  std::vector<std::uint32_t> roots_, children_;
  Vec3f low_{};
  float scale_ = 0;
};

}  // namespace sheaf
