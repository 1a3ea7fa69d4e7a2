// The guide: places, and for each the mixture of where light comes from. It learns from one training pass after the
// other; the same records in the same order make the same guide, however many threads there are.
//
// A place is a leaf of the tree of its side (see GuideView), and is halved once a pass has told more of it than
// `split_records`, so that places are the smaller the more is known of them, as in Mueller, Gross and Novak, "Practical
// Path Guiding for Efficient Light-Transport Simulation", 2017.
#pragma once

#include "kernels/guiding/fit_mixture.h"
#include "kernels/guiding/guide_view.h"

#include <cstddef>

namespace sheaf {

class GuideField {
 public:
  GuideField();

  /// Takes in what the tasks of a pass have told, in their order.
  void learn(const std::vector<std::vector<GuideRecord>>& tasks, std::size_t split_records);

  /// Valid until the guide learns more, or is moved.
  GuideView view() const;
  /// Of each row of the view's mixtures the mean of GuideRecord::found; -1: not known. Valid as the view is.
  std::span<const float> means() const { return means_; }
  /// Places of all sides.
  std::size_t places() const { return places_.size(); }

 private:
  /// A leaf.
  struct Place {
    int depth;           ///< levels above it
    std::uint32_t node;  ///< where its node stands: in the table, or if `depth` > kGuideTopBits in children_
    GuideSums sums;
    GuideMixture mixture;
    double found, vertices;  ///< sum of GuideRecord::found over how many vertices
  };
  struct Span {
    std::size_t begin, end;
  };

  void place_cube(const std::vector<std::vector<GuideRecord>>& tasks);
  std::vector<Span> sort_records(const std::vector<std::vector<GuideRecord>>& tasks);
  void split(std::size_t place, std::vector<Span>& spans, std::size_t split_records);
  void put(std::uint32_t place);
  void fit(std::size_t place, const Span& span);

  std::vector<GuideRecord> records_;
  std::vector<Place> places_;
  std::vector<GuideMixture> mixtures_;  ///< of the places, from row 1 on
  std::vector<float> means_;
  std::vector<std::uint32_t> roots_, children_;
  Vec3f low_{};
  float scale_ = 0;
};

}  // namespace sheaf
