// Training of the guide: sorts records into cells, splits cells, and fits their mixtures.
#include "kernels/guiding/guide_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace sheaf {

namespace {

/// Maximum number of groups of tasks whose records are sorted in parallel.
constexpr std::size_t kSortGroups = 64;
/// Factor on the earlier passes' vertices in a mean, and minimum number of vertices for a mean.
constexpr double kMeanMemory = 0.5, kMinVertices = 16;

/// Normal of the surfaces of a side; 0 for media.
Vec3f axis_of(std::uint32_t side) {
  const float sign = (side & 1u) != 0 ? -1.0f : 1.0f;
  if (side == kGuideMedia) return {0, 0, 0};
  return {side < 2 ? sign : 0.0f, side / 2 == 1 ? sign : 0.0f, side / 2 == 2 ? sign : 0.0f};
}

/// The bit of the Morton code that separates the halves of a cell at this depth.
std::uint32_t half_bit(int depth) { return 1u << (kGuideBits - 1 - depth); }

template <class F> void for_each_parallel(std::size_t count, std::size_t grain, F&& f) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [&f](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) f(i);
                    });
}

}  // namespace

GuideField::GuideField() : mixtures_(1), means_(1, -1.0f) {}

GuideView GuideField::view() const {
  return {mixtures_.data(), roots_.empty() ? nullptr : roots_.data(), children_.data(), means_.data(), low_, scale_};
}

/// Fits the cube to all vertices of the first pass, and creates a cell per side.
void GuideField::fit_cube(const std::vector<std::vector<GuideRecord>>& tasks) {
  Vec3f low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (const auto& task : tasks)
    for (const GuideRecord& r : task) {
      low = {std::min(low.x, r.p.x), std::min(low.y, r.p.y), std::min(low.z, r.p.z)};
      high = {std::max(high.x, r.p.x), std::max(high.y, r.p.y), std::max(high.z, r.p.z)};
    }
  if (!(low.x <= high.x)) return;
  low_ = low;
  scale_ = static_cast<float>(1 << (kGuideBits / 3)) / std::max(max_component(high - low) * 1.0001f, 1e-20f);
  roots_.resize(std::size_t{kGuideSides} << kGuideTopBits);
  children_.resize(2);
  for (std::uint32_t side = 0; side < kGuideSides; ++side) {
    cells_.push_back({0, side << kGuideTopBits, {}, first_mixture(axis_of(side)), 0, 0});
    put(side);
  }
}

/// Points the tree nodes of a cell to it.
void GuideField::put(std::uint32_t cell) {
  const Cell& p = cells_[cell];
  const std::uint32_t leaf = kGuideLeaf | (cell + 1);
  if (p.depth > kGuideTopBits) {
    children_[p.node] = leaf;
    return;
  }
  std::fill_n(roots_.begin() + p.node, std::size_t{1} << (kGuideTopBits - p.depth), leaf);
}

/// Sorts the records of all tasks by cell; within a cell they keep their order. Returns the range of each cell.
std::vector<GuideField::Span> GuideField::sort_records(const std::vector<std::vector<GuideRecord>>& tasks) {
  if (cells_.empty()) fit_cube(tasks);
  std::vector<Span> spans(cells_.size(), {0, 0});
  if (cells_.empty()) return spans;
  // Count the records of successive groups of tasks in each cell
  const std::size_t cells = cells_.size(), groups = std::min(tasks.size(), kSortGroups);
  const auto for_each_in_group = [&](std::size_t group, auto&& f) {
    for (std::size_t i = tasks.size() * group / groups; i < tasks.size() * (group + 1) / groups; ++i)
      for (const GuideRecord& r : tasks[i]) f(r, group * cells + (r.row() == 0 ? r.side() : r.row() - 1));
  };
  std::vector<std::size_t> first_of_cell(groups * cells);
  for_each_parallel(groups, 1, [&](std::size_t group) {
    for_each_in_group(group, [&](const GuideRecord&, std::size_t group_cell) { ++first_of_cell[group_cell]; });
  });
  // Reserve the ranges
  std::size_t end = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    spans[cell].begin = end;
    for (std::size_t group = 0; group < groups; ++group) end += std::exchange(first_of_cell[group * cells + cell], end);
    spans[cell].end = end;
  }
  // Copy the records to them
  records_.resize(end);
  for_each_parallel(groups, 1, [&](std::size_t group) {
    for_each_in_group(group,
                      [&](const GuideRecord& r, std::size_t group_cell) { records_[first_of_cell[group_cell]++] = r; });
  });
  return spans;
}

/// Moves the records of the second half of a cell behind those of the first half; both keep their order. Returns where
/// the second half begins.
std::size_t GuideField::partition(std::size_t cell, const Span& span) {
  const std::uint32_t bit = half_bit(cells_[cell].depth);
  const GuideView guide = view();
  std::vector<GuideRecord> upper;
  std::size_t middle = span.begin;
  for (std::size_t i = span.begin; i < span.end; ++i) {
    if ((guide_code<Scalar>(guide, records_[i].p) & bit) != 0)
      upper.push_back(records_[i]);
    else
      records_[middle++] = records_[i];
  }
  std::copy(upper.begin(), upper.end(), records_.begin() + static_cast<std::ptrdiff_t>(middle));
  return middle;
}

/// Splits a cell whose records are partitioned. Appends the second half to the cells.
void GuideField::split(std::size_t cell) {
  // Divide the statistics between the halves.
  halve(cells_[cell].sums);
  cells_[cell].found *= 0.5, cells_[cell].vertices *= 0.5;
  const int depth = ++cells_[cell].depth;
  Cell other = cells_[cell];
  // Create the nodes.
  if (depth > kGuideTopBits) {
    const auto pair = static_cast<std::uint32_t>(children_.size());
    if (depth == kGuideTopBits + 1)
      roots_[cells_[cell].node] = pair / 2;
    else
      children_[cells_[cell].node] = pair / 2;
    children_.resize(pair + 2);
    cells_[cell].node = pair;
    other.node = pair + 1;
  } else {
    other.node += 1u << (kGuideTopBits - depth);
  }
  const auto second = static_cast<std::uint32_t>(cells_.size());
  cells_.push_back(other);
  put(static_cast<std::uint32_t>(cell));
  put(second);
}

/// Splits cells until none holds more than `split_records` records. Keeps `spans` up to date.
void GuideField::split_cells(std::vector<Span>& spans, std::size_t split_records) {
  std::vector<std::size_t> large(cells_.size()), middles;
  std::iota(large.begin(), large.end(), std::size_t{0});
  while (true) {
    std::erase_if(large, [&](std::size_t cell) {
      return spans[cell].end - spans[cell].begin <= split_records || cells_[cell].depth >= kGuideBits;
    });
    if (large.empty()) return;
    const std::size_t count = large.size();
    middles.resize(count);
    for_each_parallel(count, 1, [&](std::size_t i) { middles[i] = partition(large[i], spans[large[i]]); });
    for (std::size_t i = 0; i < count; ++i) {
      split(large[i]);
      spans.push_back({middles[i], spans[large[i]].end});
      spans[large[i]].end = middles[i];
      large.push_back(spans.size() - 1);
    }
  }
}

void GuideField::fit(std::size_t cell, const Span& span) {
  Cell& p = cells_[cell];
  const auto records = std::span(records_).subspan(span.begin, span.end - span.begin);
  if (!records.empty()) fit_mixture(records, p.mixture, p.sums);
  p.found *= kMeanMemory, p.vertices *= kMeanMemory;
  for (const GuideRecord& r : records) p.found += double{r.found};
  p.vertices += static_cast<double>(records.size());
  mixtures_[cell + 1] = p.mixture;
  if (p.vertices > kMinVertices) means_[cell + 1] = static_cast<float>(p.found / p.vertices);
}

void GuideField::train(const std::vector<std::vector<GuideRecord>>& tasks, std::size_t split_records) {
  std::vector<Span> spans = sort_records(tasks);
  split_cells(spans, split_records);
  mixtures_.resize(cells_.size() + 1);
  means_.assign(cells_.size() + 1, -1.0f);
  for_each_parallel(cells_.size(), 1, [&](std::size_t i) { fit(i, spans[i]); });
}

}  // namespace sheaf
